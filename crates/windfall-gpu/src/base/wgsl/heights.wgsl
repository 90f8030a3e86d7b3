// Heights of the terrain: samples along a side, metres between them, then the samples row by row.
@group(1) @binding(0) var<storage, read> terrain: array<f32>;

fn last_sample() -> i32 {
    return i32(terrain[0]) - 1;
}

// The sample at a place of the grid, that of its rim beyond it.
fn height_sample(at: vec2<i32>) -> f32 {
    let last = last_sample();
    let there = clamp(at, vec2(0), vec2(last));
    return terrain[2 + there.y * (last + 1) + there.x];
}

fn terrain_height(at: vec2<f32>) -> f32 {
    let last = f32(last_sample());
    let p = clamp(at / terrain[1] + last * 0.5, vec2(0.0), vec2(last));
    let low = min(floor(p), vec2(last - 1.0));
    let first = vec2<i32>(low);
    let f = p - low;
    let a = height_sample(first);
    let b = height_sample(first + vec2(1, 0));
    let c = height_sample(first + vec2(0, 1));
    let d = height_sample(first + vec2(1, 1));
    // The two triangles that are drawn.
    return select(d + (c - d) * (1.0 - f.x) + (b - d) * (1.0 - f.y), a + (b - a) * f.x + (c - a) * f.y, f.x + f.y <= 1.0);
}
