@group(0) @binding(0) var<uniform> frame: Frame;

// A triangle that covers the picture, at the far end of depth.
fn covering_triangle(index: u32) -> vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
