const PI: f32 = 3.14159265;

// Radiance of the sky towards a direction, without the sun's disc.
fn sky_radiance(direction: vec3<f32>) -> vec3<f32> {
    let up = max(direction.y, 0.0);
    let base = mix(frame.sky_horizon, frame.sky_zenith, pow(up, 0.45));
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
    return mix(frame.ground_bounce, sky * 0.62, up) + frame.sun_color * 0.007 * towards_sun;
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
