const PI: f32 = 3.14159265;

// Radiance of the sky towards a direction, without the sun's disc.
fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    let up = max(direction.y, 0.0);
    let base = mix(frame.sky_horizon, frame.sky_zenith, pow(up, 0.6));
    let cosine = max(dot(direction, frame.sun_direction), 0.0);
    // Forward scattering around the sun.
    let glow = 0.30 * pow(cosine, 6.0) + 0.9 * pow(cosine, 60.0);
    return base + frame.sun_color * 0.055 * glow * (1.0 - 0.5 * up);
}

// Irradiance over pi of sky and ground on a surface with this normal.
fn ambient(normal: vec3<f32>) -> vec3<f32> {
    let sky = mix(frame.sky_horizon, frame.sky_zenith, 0.45);
    let up = 0.5 + 0.5 * normal.y;
    let towards_sun = 0.5 + 0.5 * dot(normal, frame.sun_direction);
    return mix(frame.ground_bounce, sky * 0.78, up) + frame.sun_color * 0.007 * towards_sun;
}

// What reaches the eye of light that leaves a point: the air takes some and adds its own.
fn through_air(radiance: vec3<f32>, position: vec3<f32>) -> vec3<f32> {
    let way = position - frame.eye;
    let distance = length(way);
    let kept = exp(-distance * frame.haze);
    let direction = way / max(distance, 1e-4);
    let air = sky_radiance(normalize(vec3(direction.x, max(direction.y, 0.02), direction.z)));
    return mix(air, radiance, kept);
}

// Share of the sun that reaches a point, softened over nine samples of bilinear comparison.
// `bias` is in texels of the cascade, towards the sun.
fn sun_visibility(position: vec3<f32>, bias: f32) -> f32 {
    let distance = length(position - frame.eye);
    if frame.shadow_ends.w == 0.0 || distance >= frame.shadow_ends.z {
        return 1.0;
    }
    let cascade = select(select(2u, 1u, distance < frame.shadow_ends.y), 0u, distance < frame.shadow_ends.x);
    let lifted = position + frame.sun_direction * frame.shadow_texels[cascade] * bias;
    let at = frame.shadow_from_world[cascade] * vec4(lifted, 1.0);
    let uv = at.xy * vec2(0.5, -0.5) + 0.5;
    let step = frame.shadow_texels.w * 1.2;
    var sum = 0.0;
    for (var j = -1; j <= 1; j++) {
        for (var i = -1; i <= 1; i++) {
            let offset = vec2(f32(i), f32(j)) * step;
            sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, uv + offset, cascade, at.z);
        }
    }
    // Far shadows fade into the light that is left without them.
    let fade = smoothstep(0.8 * frame.shadow_ends.z, frame.shadow_ends.z, distance);
    return mix(sum / 9.0, 0.75, fade);
}
