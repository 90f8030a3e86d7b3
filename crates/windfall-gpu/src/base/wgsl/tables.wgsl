// Path tables and terrain as one list of vectors, in the texture table_texels, which the pass declares:
// what every leaf reads at another place is cheaper from a texture than from a buffer.

fn table(i: u32) -> vec4<u32> {
    return textureLoad(table_texels, vec2(i % TABLE_WIDTH, i / TABLE_WIDTH), 0);
}

struct PathSample {
    // Displacement from the sample to which laps return.
    place: vec3<f32>,
    // Not quite of unit length.
    orientation: vec4<f32>,
}

// A path, the joint that it laps by, and where it begins (windfall_core::path::Flight). Each path stands
// in the table once for each joint, as playback on the way to that joint reads it.
struct Flight {
    first_sample: u32,
    start: u32,
    // Samples from there on after which it has left its twig behind.
    soft: u32,
    from_sample: u32,
    to_sample: u32,
    // Displacement of one lap; x and z are turned back by half of the lap's turn, and divided by the
    // sine of that.
    lap: vec3<f32>,
    // Samples per second.
    rate: f32,
    // From the start to the sample to which laps return.
    lead: vec3<f32>,
    // Half of a lap's turn about Y, 2^-32 turns.
    half_turn: u32,
}

// Lowest height up to a sample, from the one to which laps return.
fn path_low(i: u32) -> f32 {
    return bitcast<f32>(table(fall.low_table + i / 4u)[i % 4u]);
}

fn flight_of(i: u32) -> Flight {
    let at = fall.flight_table + 4u * i;
    let a = table(at);
    let b = bitcast<vec4<f32>>(table(at + 1u));
    let c = table(at + 2u);
    let soft = a.y >> 20u;
    return Flight(a.x, a.y & 0xfffffu, select(soft, 0x7fffffffu, soft == 0xfffu), a.z, a.w, b.xyz, b.w, bitcast<vec3<f32>>(c.xyz), c.w);
}

// Lowest height up to the start, and up to the joint.
fn flight_lows(i: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(table(fall.flight_table + 4u * i + 3u).xy);
}

// Bounds of the speed downwards and along, m/s.
fn flight_speeds(i: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(table(fall.flight_table + 4u * i + 3u).zw);
}

fn ground_sample(i: u32) -> f32 {
    return bitcast<f32>(table(fall.ground_table + i / 4u)[i % 4u]);
}
