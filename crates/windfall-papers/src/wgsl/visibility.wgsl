// Leaf occlusion (VB 5): the visibility state of a leaf in the air, one word. A tested leaf is drawn and its visible
// pixels are counted. With enough pixels it is drawn untested for two frames and tested again in the third, so that a
// third of the leaves is tested in each frame; otherwise it is skipped for three frames and tested in the fourth.

const ENOUGH_PIXELS: u32 = 3u;
// Bits of the state: pixels counted by the test; frames until the next test (two bits); flags. 0 is an unknown leaf.
const COUNTED: u32 = 0xffffffu;
const FRAMES: u32 = 24u;
const HIDDEN: u32 = 0x04000000u;
const TESTED: u32 = 0x08000000u;
const KNOWN: u32 = 0x10000000u;

// What a frame does with a leaf.
const DRAW: u32 = 0u;
const TEST: u32 = 1u;
const SKIP: u32 = 2u;

// The state in the next frame. `index` spreads the first tests over three frames.
fn next_state(state: u32, index: u32) -> u32 {
    var frames = (state >> FRAMES) & 3u;
    var hidden = state & HIDDEN;
    if (state & KNOWN) == 0u {
        frames = index % 3u;
        hidden = 0u;
    } else if (state & TESTED) != 0u {
        let visible = (state & COUNTED) >= ENOUGH_PIXELS;
        frames = select(3u, 2u, visible);
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
