// What a placed vertex of a leaf that is lit once has in place of texture coordinates.

// Metres: a middle that is farther is taken to be so far.
const MIDDLE_REACH: f32 = 0.5;

// The way to the leaf's middle, and how long its mean normal is.
fn pack_middle(way: vec3<f32>, flatness: f32) -> u32 {
    return pack4x8snorm(vec4(way / MIDDLE_REACH, flatness));
}

fn unpack_middle(packed: u32) -> vec4<f32> {
    let middle = unpack4x8snorm(packed);
    return vec4(middle.xyz * MIDDLE_REACH, middle.w);
}
