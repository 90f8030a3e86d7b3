// Grass about the camera: tufts of blades on a grid of cells, whose places, sizes and bends are
// hashes of the cell. No buffer but the terrain's.

// Side, then the heights row by row.
@group(1) @binding(0) var<storage, read> terrain: array<f32>;

// Metres; the farther of the two rings has them three times as wide.
const CELL: f32 = 0.17;

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    // Of a blade that is thinner than a sample nothing can be interpolated: all but the last is its
    // own.
    @location(0) @interpolate(flat) root: vec3<f32>,
    @location(1) @interpolate(flat) color: vec3<f32>,
    @location(2) @interpolate(flat) normal: vec3<f32>,
    // Along the blade, 0 at the root.
    @location(3) along: f32,
}

fn terrain_height(at: vec2<f32>) -> f32 {
    let side = u32(terrain[0]);
    let last = f32(side - 1u);
    let p = clamp(at / terrain[1] + last * 0.5, vec2(0.0), vec2(last));
    let low = min(floor(p), vec2(last - 1.0));
    let first = 2u + u32(low.y) * side + u32(low.x);
    let f = p - low;
    let a = terrain[first];
    let b = terrain[first + 1u];
    let c = terrain[first + side];
    let d = terrain[first + side + 1u];
    // The two triangles that are drawn.
    return select(d + (c - d) * (1.0 - f.x) + (b - d) * (1.0 - f.y), a + (b - a) * f.x + (c - a) * f.y, f.x + f.y <= 1.0);
}

// Three vertices a blade: two at the root, one at the tip.
@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Varyings {
    var out: Varyings;
    out.clip = vec4(0.0, 0.0, -1.0, 1.0);
    let view = frame.world_from_clip * vec4(0.0, 0.0, 1.0, 1.0);
    let forward = normalize(view.xz / view.w - frame.eye.xz + vec2(1e-6, 0.0));
    let ring = instance / (SIDE * SIDE);
    let index = instance % (SIDE * SIDE);
    let wide = CELL * select(1.0, 3.0, ring == 1u);
    let half_side = 0.5 * f32(SIDE) * wide;
    let middle = frame.eye.xz + forward * (half_side * 0.86);
    let first = floor(middle / wide) - f32(SIDE / 2u);
    let cell = vec2<i32>(first) + vec2<i32>(i32(index % SIDE), i32(index / SIDE));
    let key = hash(hash(77u + ring, bitcast<u32>(cell.x)), bitcast<u32>(cell.y));
    let at = (vec2<f32>(cell) + vec2(unit(key), unit(hash(key, 1u)))) * wide;
    let away = distance(at, frame.eye.xz);
    // Towards the rim blades are fewer and smaller, and the next ring, or the ground's own grass,
    // takes over.
    let rim = (1.0 - smoothstep(0.5, 1.0, away / (half_side * 1.7)))
        * select(1.0, smoothstep(6.0, 14.0, away), ring == 1u);
    let lush = ground_growth(at, 0.0);
    if unit(hash(key, 2u)) > lush * (0.25 + 0.75 * rim) || rim <= 0.0 {
        return out;
    }
    let blade = vertex / 3u;
    let corner = vertex % 3u;
    let own = hash(key, 16u + blade);
    let angle = unit(own) * 2.0 * PI;
    let out_way = vec2(cos(angle), sin(angle));
    let across = vec2(-out_way.y, out_way.x);
    let tall = (0.05 + 0.15 * unit(hash(own, 1u)) * unit(hash(key, 3u)) + 0.03 * f32(ring)) * (0.6 + 0.5 * lush) * (0.35 + 0.65 * rim);
    let bend = tall * (0.25 + 0.7 * unit(hash(own, 2u)));
    let foot = at + out_way * (0.3 * wide) * unit(hash(own, 3u));
    let root = vec3(foot.x, terrain_height(foot) - 0.004, foot.y);
    // What is thinner than a pixel sparkles: far blades are fewer and wider.
    let thin = (0.0028 + 0.0022 * unit(hash(own, 4u))) * (1.0 + 0.10 * away);
    let across_view = vec3(frame.clip_from_world[0].y, frame.clip_from_world[1].y, frame.clip_from_world[2].y);
    let pixel = 2.0 * away / (frame.height * length(across_view));
    let thick = max(thin, 0.8 * pixel);
    if unit(hash(own, 7u)) * thick > thin {
        return out;
    }
    var p = root;
    var along = 0.0;
    if corner == 2u {
        let blown = vec3(0.0);
        p += vec3(out_way.x * bend, tall, out_way.y * bend);
        if frame.sway > 0.0 {
            let wind = wind_at(p);
            let beat = 0.6 + 0.4 * swing(p, vec3(0.6, 0.0, 0.5), 1.40625);
            let push = wind * min(0.02 * beat, 0.5 / max(length(wind), 1e-3)) * tall * 5.0;
            p += vec3(push.x, 0.0, push.y);
        }
        along = 1.0;
    } else {
        let sideways = across * select(-thick, thick, corner == 1u);
        p += vec3(sideways.x, 0.0, sideways.y);
    }
    let dry = smoothstep(-0.2, 0.3, fractal_noise2(at * 0.045, 0.0, 20u) + 0.6 * fractal_noise2(at * 1.15, 0.0, 27u));
    let straw = smoothstep(0.45, 1.0, unit(hash(own, 5u)) * 0.6 + 0.55 * dry);
    // Few stand for many: with less contrast, as leaves (SFS, equation 4).
    let contrast = sqrt(thin / thick);
    out.color = mix(mix(vec3(0.056, 0.078, 0.018), vec3(0.100, 0.112, 0.030), dry), vec3(0.240, 0.185, 0.085), mix(0.25 * dry, straw, contrast))
        * (1.0 + (0.6 * unit(hash(own, 6u)) - 0.3) * contrast);
    out.root = root;
    out.along = along;
    out.normal = normalize(vec3(out_way.x * 0.6, 1.0, out_way.y * 0.6));
    out.clip = frame.clip_from_world * vec4(p, 1.0);
    return out;
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let normal = in.normal;
    let along = select(0.5, in.along, in.along >= 0.0 && in.along <= 1.0); // not a number neither
    let sun = frame.sun_direction;
    let view = normalize(frame.eye - in.root);
    let reach = sun_visibility(in.root + vec3(0.0, 0.06, 0.0), vec3(0.0), in.clip.xy, min(frame.shadow_taps, 4u), 1.5);
    // Blades pass light as leaves do: brighter against the sun.
    let through = pow(max(-dot(view, sun), 0.0), 3.0);
    let lit = 0.55 * max(dot(normal, sun), 0.0) + 0.25 + 0.9 * through;
    let deep = mix(0.28, 1.0, along);
    let light = frame.sun_color * (reach * lit * mix(0.5, 1.0, along) / PI) + ambient(normal) * deep;
    return vec4(through_air(in.color * light, in.root), 1.0);
}
