// The forest floor.

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> Varyings {
    var out: Varyings;
    out.world = position;
    out.clip = frame.clip_from_world * vec4(position, 1.0);
    out.normal = normal;
    return out;
}

// Old leaves on the floor, one in a cell of a jittered grid: colour and how much of it is seen.
fn litter(at: vec2<f32>, width: f32) -> vec4<f32> {
    let browns = array<vec3<f32>, 4>(
        vec3(0.20, 0.085, 0.025), vec3(0.36, 0.17, 0.035), vec3(0.12, 0.06, 0.03), vec3(0.30, 0.10, 0.02),
    );
    let cell = floor(at);
    var nearest = 10.0;
    var color = browns[0];
    for (var j = -1; j <= 1; j++) {
        for (var i = -1; i <= 1; i++) {
            let c = vec2<u32>(vec2<i32>(cell) + vec2(i, j));
            let key = hash(hash(11u, c.x), c.y);
            let center = vec2(f32(i), f32(j)) + vec2(unit(key), unit(hash(key, 1u)));
            let angle = unit(hash(key, 2u)) * 2.0 * PI;
            let d = (at - cell) - center;
            let r = vec2(cos(angle) * d.x + sin(angle) * d.y, cos(angle) * d.y - sin(angle) * d.x);
            let away = length(r * vec2(1.0, 1.7));
            if away < nearest {
                nearest = away;
                color = browns[hash(key, 3u) & 3u] * (0.6 + 0.8 * unit(hash(key, 4u)));
            }
        }
    }
    let mean = vec3(0.22, 0.10, 0.028);
    let blur = smoothstep(0.2, 0.8, width);
    let seen = 1.0 - smoothstep(0.42, 0.5, nearest);
    return vec4(mix(color * mix(1.0, 0.7, nearest), mean, blur), mix(seen, 0.72, blur));
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let at = in.world.xz;
    // Size of a pixel on the ground: seen at a grazing angle it is long and thin; the mean of both
    // sides keeps the detail, and the fourfold samples keep it still.
    let dx = dpdx(at);
    let dy = dpdy(at);
    let width = sqrt(abs(dx.x * dy.y - dx.y * dy.x)) * 1.5;
    let patches = fractal_noise2(at * 0.11, width * 0.11, 21u);
    let fine = fractal_noise2(at * 3.1, width * 3.1, 22u);
    let grains = fractal_noise2(at * 23.0, width * 23.0, 23u);
    let grass = vec3(0.085, 0.115, 0.030) * (1.0 + 0.9 * fine + 0.9 * grains);
    let earth = vec3(0.095, 0.062, 0.036) * (1.0 + 0.7 * fine + 0.8 * grains);
    var albedo = mix(earth, grass, smoothstep(-0.12, 0.14, patches + 0.35 * fine));
    let leaves = litter(at * 11.0, width * 11.0);
    let covered = smoothstep(-0.22, 0.12, fractal_noise2(at * 0.19 + 40.0, width * 0.19, 24u) + 0.2 * fine);
    albedo = mix(albedo, leaves.rgb, leaves.a * mix(0.25, 0.95, covered));
    let normal = normalize(in.normal);
    let sun = max(dot(normal, frame.sun_direction), 0.0);
    let light = frame.sun_color * sun / PI * sun_visibility(in.world, 2.0) + ambient(normal) * 0.9;
    return vec4(through_air(albedo * light, in.world), 1.0);
}
