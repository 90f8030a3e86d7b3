// Groups of slots at rest: nothing changes in them. `work` keeps two vectors of each, behind the windows of the streams
// and a word a slot.

struct Rest {
    there: bool,
    // A sphere about the leaves' middles, and the largest factor on a shape.
    middle: vec3<f32>,
    radius: f32,
    scale: f32,
    // Leaves that lie there.
    leaves: u32,
    // How many entries of the stream may have detached before one comes into the group.
    until: u32,
}

fn rest_at(group: u32) -> u32 {
    return WINDOW * fall.stream_count + (fall.slot_count + 3u) / 4u + 2u * group;
}

fn rest_of(group: u32) -> Rest {
    let at = rest_at(group);
    let sphere = bitcast<vec4<f32>>(work[at]);
    let b = work[at + 1u];
    return Rest(b.y > 0u, sphere.xyz, sphere.w, bitcast<f32>(b.z), b.y, b.x);
}
