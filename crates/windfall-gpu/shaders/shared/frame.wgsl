@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var sky_table: texture_2d<f32>;
@group(0) @binding(4) var sky_picture: texture_2d<f32>;
@group(0) @binding(5) var sky_sampler: sampler;

// A triangle that covers the picture, at the far end of depth.
fn covering_triangle(index: u32) -> vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Frame.show: what leaves cover, white on black.
const SHOW_COVERAGE: u32 = 4u;
