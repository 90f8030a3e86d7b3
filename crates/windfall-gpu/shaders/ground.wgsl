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

// What the floor is made of at a place: colour, and height for its own small shadows.
struct Floor {
    color: vec3<f32>,
    height: f32,
}

// Old leaves on the floor, one in a cell of a jittered grid; later layers lie over earlier ones.
fn litter(at: vec2<f32>, width: f32, under: Floor, covered: f32) -> Floor {
    let browns = array<vec3<f32>, 5>(
        vec3(0.205, 0.095, 0.030), vec3(0.330, 0.165, 0.040), vec3(0.120, 0.062, 0.032),
        vec3(0.260, 0.100, 0.025), vec3(0.380, 0.230, 0.060),
    );
    let mean = vec3(0.225, 0.115, 0.034);
    var top = under;
    for (var layer = 0u; layer < 3u; layer++) {
        let p = at * (1.0 - 0.13 * f32(layer)) + vec2(7.3, 3.1) * f32(layer);
        let cell = floor(p);
        for (var j = -1; j <= 1; j++) {
            for (var i = -1; i <= 1; i++) {
                let c = vec2<u32>(vec2<i32>(cell) + vec2(i, j));
                let key = hash(hash(11u + layer, c.x), c.y);
                if unit(hash(key, 5u)) > covered {
                    continue;
                }
                let center = vec2(f32(i), f32(j)) + vec2(unit(key), unit(hash(key, 1u)));
                let angle = unit(hash(key, 2u)) * 2.0 * PI;
                let d = (p - cell) - center;
                let along = cos(angle) * d.x + sin(angle) * d.y;
                let across = cos(angle) * d.y - sin(angle) * d.x;
                // A leaf: pointed at both ends, its rim a little torn.
                let half_length = 0.40 + 0.22 * unit(hash(key, 6u));
                let s = along / half_length;
                let breadth = half_length * 0.55 * (1.0 - s * s) * (1.0 + 0.15 * sin(along * 40.0));
                let edge = (breadth - abs(across)) / max(width, 0.02);
                if abs(s) < 1.0 && edge > 0.0 {
                    let rib = 1.0 - smoothstep(0.0, 0.03 + width, abs(across));
                    let shade = 0.65 + 0.75 * unit(hash(key, 4u));
                    // Darker where it lies under the next, lighter along the rib.
                    let color = browns[hash(key, 3u) % 5u] * shade * (0.80 + 0.25 * rib + 0.20 * across / half_length);
                    top.color = mix(top.color, color, min(edge, 1.0));
                    top.height = mix(top.height, 0.3 * f32(layer + 1u), min(edge, 1.0));
                }
            }
        }
    }
    // Smaller than a pixel, leaves are their mean.
    let blur = smoothstep(0.25, 0.9, width);
    let share = 1.0 - pow(1.0 - 0.42 * covered, 3.0);
    let far = mix(under.color, mean, share);
    return Floor(mix(top.color, far, blur), mix(top.height, 0.3, blur));
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
    let grains = fractal_noise2(at * 31.0, width * 31.0, 23u);
    // Blades of grass: noise stretched along a slowly turning direction.
    let lean = 6.0 * fractal_noise2(at * 0.35, width * 0.35, 25u);
    let along = vec2(cos(lean), sin(lean));
    let blades = value_noise2(vec2(dot(at, along) * 14.0, dot(at, vec2(-along.y, along.x)) * 70.0), 26u) - 0.5;
    let blades_seen = 1.0 - smoothstep(0.005, 0.02, width);
    let grass = vec3(0.075, 0.098, 0.028) * (1.0 + 1.1 * fine + 0.6 * grains + 1.2 * blades * blades_seen)
        + vec3(0.035, 0.022, 0.0) * smoothstep(-0.1, 0.3, patches + fine);
    let earth = vec3(0.080, 0.054, 0.033) * (1.0 + 0.9 * fine + 1.2 * grains);
    let grassy = smoothstep(-0.05, 0.12, patches + 0.5 * fine);
    let under = Floor(mix(earth, grass, grassy), 0.0);
    let drifts = fractal_noise2(at * 0.19 + 40.0, width * 0.19, 24u) + 0.35 * fine;
    let covered = mix(0.12, 0.9, smoothstep(-0.2, 0.18, drifts)) * mix(1.0, 0.55, grassy);
    let cover = litter(at * 9.0, width * 9.0, under, covered);
    let normal = normalize(in.normal);
    let sun = max(dot(normal, frame.sun_direction), 0.0);
    // Rough ground darkens itself, the more the lower the light.
    let cavity = 0.72 + 0.35 * cover.height + 0.5 * grains;
    let light = frame.sun_color * sun / PI * sun_visibility(in.world, 2.0) + ambient(normal) * 0.85;
    return vec4(through_air(cover.color * light * clamp(cavity, 0.4, 1.3), in.world), 1.0);
}
