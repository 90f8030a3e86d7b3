// From radiance to the picture: the Khronos PBR neutral curve (2024), which keeps the hue and
// saturation of what is not very bright; without its toe, which takes a surface's Fresnel reflection
// off and would make the shade of a wood black.

@group(1) @binding(0) var radiance: texture_multisampled_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

fn neutral(color: vec3<f32>) -> vec3<f32> {
    let start_compression = 0.62;
    let desaturation = 0.15;
    let peak = max(color.r, max(color.g, color.b));
    if peak < start_compression {
        return color;
    }
    let d = 1.0 - start_compression;
    let new_peak = 1.0 - d * d / (peak + d - start_compression);
    let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3(new_peak), g);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    // The curve before the mean: of a leaf before a bright sky the edge would else be all sky as soon
    // as one sample is.
    var color = vec3(0.0);
    let samples = textureNumSamples(radiance);
    for (var i = 0u; i < samples; i++) {
        let linear = textureLoad(radiance, vec2<i32>(at.xy), i).rgb;
        if frame.show == SHOW_COVERAGE {
            color += linear;
        } else {
            color += max(neutral(linear * frame.exposure), vec3(0.0));
        }
    }
    color /= f32(samples);
    if frame.show == SHOW_COVERAGE {
        return vec4(color, 1.0);
    }
    // Half a step of the encoded picture either way breaks the bands that a smooth sky would have.
    let noise = (interleaved_noise(at.xy) - 0.5) / 255.0;
    return vec4(pow(max(pow(color, vec3(1.0 / 2.2)) + noise, vec3(0.0)), vec3(2.2)), 1.0);
}
