// Leaf occlusion (VB 5): what is known of whether a leaf in the air is seen, in a word. A leaf is tested:
// drawn, and its pixels counted. If they are enough, it is drawn in the next two frames and tested again
// in the third, so that a third of the leaves is tested in a frame; if not, it is skipped for three
// frames and tested in the fourth.

const ENOUGH_PIXELS: u32 = 3u;
// The word: pixels counted in the test; frames to come before the next test, two bits; flags. 0: nothing
// is known.
const PIXELS: u32 = 0xffffffu;
const FRAMES: u32 = 24u;
const HIDDEN: u32 = 0x04000000u;
const TESTED: u32 = 0x08000000u;
const KNOWN: u32 = 0x10000000u;

// What is done with a leaf in a frame.
const SHOW: u32 = 0u;
const TEST: u32 = 1u;
const SKIP: u32 = 2u;

// FallFrame.show: what is done with leaves by leaf occlusion.
const SHOW_OCCLUSION: u32 = 5u;

// The word of the next frame. `place` spreads the first tests over three frames.
fn next_sight(sight: u32, place: u32) -> u32 {
    var frames = (sight >> FRAMES) & 3u;
    var hidden = sight & HIDDEN;
    if (sight & KNOWN) == 0u {
        frames = place % 3u;
        hidden = 0u;
    } else if (sight & TESTED) != 0u {
        let seen = (sight & PIXELS) >= ENOUGH_PIXELS;
        frames = select(3u, 2u, seen);
        hidden = select(HIDDEN, 0u, seen);
    }
    if frames == 0u {
        return KNOWN | TESTED;
    }
    return KNOWN | hidden | ((frames - 1u) << FRAMES);
}

fn done_with(sight: u32) -> u32 {
    if (sight & TESTED) != 0u {
        return TEST;
    }
    return select(SHOW, SKIP, (sight & HIDDEN) != 0u);
}

// Green, blue, red.
fn occlusion_color(what: u32) -> vec3<f32> {
    var colors = array<vec3<f32>, 3>(vec3(0.05, 0.5, 0.08), vec3(0.05, 0.2, 0.9), vec3(0.9, 0.03, 0.03));
    return colors[what];
}
