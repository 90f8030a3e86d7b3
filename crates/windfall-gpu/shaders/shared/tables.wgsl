// Path tables and terrain as one list of vectors, read through table(i), which the pass declares.
// Integers are stored as floats, exact below 2^24.

struct PathSample {
    // Displacement, and the lowest height so far.
    place: vec4<f32>,
    orientation: vec4<f32>,
}

struct PathRecord {
    first_sample: u32,
    first_start: u32,
    start_count: u32,
    first_joint: u32,
    joint_count: u32,
    rate: f32,
    fastest_down: f32,
    fastest_along: f32,
}

struct JointRecord {
    lap: vec3<f32>,
    half_turn: u32,
    from_sample: u32,
    to_sample: u32,
    blend_start: u32,
    tail: u32,
}

fn path_sample(i: u32) -> PathSample {
    return PathSample(table(2u * i), table(2u * i + 1u));
}

fn path_joint(i: u32) -> JointRecord {
    let a = table(fall.joint_table + 3u * i);
    let b = table(fall.joint_table + 3u * i + 1u);
    let c = table(fall.joint_table + 3u * i + 2u);
    return JointRecord(a.xyz, (u32(c.x) << 16u) | u32(c.y), u32(b.x), u32(b.y), u32(b.z), u32(b.w));
}

fn path_record(i: u32) -> PathRecord {
    let a = table(fall.record_table + 2u * i);
    let b = table(fall.record_table + 2u * i + 1u);
    return PathRecord(u32(a.x), u32(a.y), u32(a.z), u32(a.w), u32(b.x), b.y, b.z, b.w);
}

fn path_start(i: u32) -> u32 {
    return u32(table(fall.start_table + i / 4u)[i % 4u]);
}

fn path_group(i: u32) -> vec2<u32> {
    return vec2<u32>(table(fall.group_table + i).xy);
}

fn ground_sample(i: u32) -> f32 {
    return table(fall.ground_table + i / 4u)[i % 4u];
}
