// What finds grass and what draws it both know.

// Width of a cell, metres; the farther of the two rings has them three times as wide.
const CELL: f32 = 0.17;

// What the blades of a tuft have in common.
struct Tuft {
    at: vec2<f32>,
    key: u32,
    ring: u32,
    // How much grass grows here, and how much of it is left at this distance, 0 to 1.
    lush: f32,
    rim: f32,
    // 0 green to 1 straw.
    dry: f32,
}

// Half of the width of a blade, metres.
fn blade_width(own: u32, away: f32) -> f32 {
    return (0.0028 + 0.0022 * unit(hash(own, 4u))) * (1.0 + 0.10 * away);
}

// A pixel at a distance, metres.
fn pixel_at(away: f32) -> f32 {
    let across_view = vec3(frame.clip_from_world[0].y, frame.clip_from_world[1].y, frame.clip_from_world[2].y);
    return 2.0 * away / (frame.height * length(across_view));
}
