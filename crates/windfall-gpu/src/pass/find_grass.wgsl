// Which grass a view draws: tufts of blades on a grid of cells about the camera, whose places, sizes and bends are hashes
// of the cell. What the blades of a tuft have in common is found here, once.

@group(2) @binding(0) var<storage, read_write> tufts: array<Tuft>;
// A blade: its tuft, times BLADES, and which of its blades.
@group(2) @binding(1) var<storage, read_write> blades: array<u32>;
// Arguments of the draw, then the tufts that were found.
@group(2) @binding(2) var<storage, read_write> found: array<atomic<u32>, 5>;

// Whether anything within `reach` of a point may be in the view.
fn in_view(p: vec3<f32>, reach: f32) -> bool {
    let m = transpose(frame.clip_from_world);
    let clip = frame.clip_from_world * vec4(p, 1.0);
    let margin = reach * vec2(length(m[0].xyz), length(m[1].xyz)) + reach * length(m[3].xyz);
    return all(abs(clip.xy) <= vec2(clip.w) + margin);
}

@compute @workgroup_size(BLOCK)
fn find(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = frame.world_from_clip * vec4(0.0, 0.0, 1.0, 1.0);
    let forward = normalize(view.xz / view.w - frame.eye.xz + vec2(1e-6, 0.0));
    let ring = id.x / (SIDE * SIDE);
    let index = id.x % (SIDE * SIDE);
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
        return;
    }
    // No blade is longer, or stands farther from the middle of its tuft.
    if !in_view(vec3(at.x, terrain_height(at), at.y), 0.3 + 0.3 * wide) {
        return;
    }
    // What is thinner than a pixel sparkles: far blades are fewer and wider.
    let pixel = pixel_at(away);
    var some = 0u;
    var which = 0u;
    for (var blade = 0u; blade < BLADES; blade++) {
        let own = hash(key, 16u + blade);
        let thin = blade_width(own, away);
        if unit(hash(own, 7u)) * max(thin, 0.8 * pixel) <= thin {
            which |= 1u << blade;
            some += 1u;
        }
    }
    if some == 0u {
        return;
    }
    let dry = smoothstep(-0.2, 0.3, fractal_noise2(at * 0.045, 0.0, 20u) + 0.6 * fractal_noise2(at * 1.15, 0.0, 27u));
    let place = atomicAdd(&found[4], 1u);
    tufts[place] = Tuft(at, key, ring, lush, rim, dry);
    var next = atomicAdd(&found[0], 3u * some) / 3u;
    for (var blade = 0u; blade < BLADES; blade++) {
        if (which & (1u << blade)) != 0u {
            blades[next] = place * BLADES + blade;
            next += 1u;
        }
    }
}
