// From radiance to the picture: the Khronos PBR neutral curve (2024), which keeps the hue and
// saturation of what is not very bright.

@group(1) @binding(0) var radiance: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

fn neutral(linear: vec3<f32>) -> vec3<f32> {
    let start_compression = 0.8 - 0.04;
    let desaturation = 0.15;
    let low = min(linear.r, min(linear.g, linear.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    var color = linear - offset;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start_compression {
        return color;
    }
    let d = 1.0 - start_compression;
    let new_peak = 1.0 - d * d / (peak + d - start_compression);
    color *= new_peak / peak;
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color, vec3(new_peak), g);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let linear = textureLoad(radiance, vec2<i32>(at.xy), 0).rgb;
    return vec4(neutral(linear * frame.exposure), 1.0);
}
