// Leaf occlusion (VB 5): the visibility state of a leaf in the air, one word. A tested leaf is drawn and its visible
// pixels are counted. With enough pixels it is drawn untested until it is its turn again, so that one in so many of the
// leaves is tested in each frame; otherwise it is skipped for some frames, and tested then.

override one_in: u32 = 3u;
override skipped_frames: u32 = 3u;
override enough_pixels: u32 = 3u;
// Bits of the state: pixels counted by the test; frames until the next test (three bits); flags. 0 is an unknown leaf.
const COUNTED: u32 = 0xffffffu;
const FRAMES: u32 = 24u;
const HIDDEN: u32 = 0x08000000u;
const TESTED: u32 = 0x10000000u;
const KNOWN: u32 = 0x20000000u;

// What a frame does with a leaf.
const DRAW: u32 = 0u;
const TEST: u32 = 1u;
const SKIP: u32 = 2u;

// The state in the next frame. `index` spreads the first tests over frames.
fn next_state(state: u32, index: u32) -> u32 {
    var frames = (state >> FRAMES) & 7u;
    var hidden = state & HIDDEN;
    if (state & KNOWN) == 0u {
        frames = index % one_in;
        hidden = 0u;
    } else if (state & TESTED) != 0u {
        let visible = (state & COUNTED) >= enough_pixels;
        frames = select(skipped_frames, one_in - 1u, visible);
        hidden = select(HIDDEN, 0u, visible);
    }
    if frames == 0u {
        return KNOWN | TESTED;
    }
    return KNOWN | hidden | ((frames - 1u) << FRAMES);
}

fn action_of(state: u32) -> u32 {
    if (state & TESTED) != 0u {
        return TEST;
    }
    return select(DRAW, SKIP, (state & HIDDEN) != 0u);
}

// Green for drawn, blue for tested, red for skipped leaves.
fn action_color(action: u32) -> vec3<f32> {
    let drawn_or_tested = select(vec3(0.05, 0.5, 0.08), vec3(0.05, 0.2, 0.9), action == TEST);
    return select(drawn_or_tested, vec3(0.9, 0.03, 0.03), action == SKIP);
}
