// Small leaves have no texture coordinates: the same word holds the vector to the leaf's middle, where it is lit.

// Metres; longer vectors are clamped per component.
const MIDDLE_REACH: f32 = 0.5;

// `flatness` is the length of the leaf's mean normal.
fn pack_middle(to_middle: vec3<f32>, flatness: f32) -> u32 {
    return pack4x8snorm(vec4(to_middle / MIDDLE_REACH, flatness));
}

fn unpack_middle(packed: u32) -> vec4<f32> {
    let middle = unpack4x8snorm(packed);
    return vec4(middle.xyz * MIDDLE_REACH, middle.w);
}
