// Colour of a leaf in the season: phase of the palette, and brightness.

struct LeafSeason {
    phase: f32,
    brightness: f32,
}

// A leaf's own season; `key` is the hash of tree and shed rank, `ripe` how far it is ahead of the scene's.
fn season_of(key: u32, ripe: f32, spread: f32) -> LeafSeason {
    let own = (unit(hash(key, 10u)) + unit(hash(key, 12u)) - 1.0) * spread;
    let phase = clamp(frame.season + ripe + own, 0.0, 1.0);
    return LeafSeason(phase, 0.82 + 0.36 * unit(hash(key, 11u)));
}

// The top of the crown turns first; `high` is the leaf's height over the crown's centre in half
// crowns.
fn ripeness(season_offset: f32, high: f32) -> f32 {
    return season_offset + 0.12 * high;
}

// Branches have times of their own too: patches of the crown of about half of its size, `from_center`
// in half crowns.
fn branch_ripeness(tree_seed: u32, from_center: vec3<f32>) -> f32 {
    let a = dot(from_center, vec3(0.83, 0.55, -0.61)) + unit(hash(tree_seed, 14u));
    let b = dot(from_center, vec3(-0.97, 1.13, 0.86)) + unit(hash(tree_seed, 15u));
    return 0.09 * wave(a) + 0.07 * wave(b);
}

// Each tree and each leaf has its own time. A leaf is known by its shed rank, which is the same in every
// prune order.
fn leaf_season(tree_seed: u32, season_offset: f32, rank: u32, high: f32, spread: f32) -> LeafSeason {
    return season_of(hash(tree_seed, rank), ripeness(season_offset, high), spread);
}

// A unit vector as a point of the square -1..1 (Meyer et al. 2010, octahedral normals).
fn octahedral(n: vec3<f32>) -> vec2<f32> {
    let p = n.xz / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return select(folded, p, n.y >= 0.0);
}

fn from_octahedral(p: vec2<f32>) -> vec3<f32> {
    let y = 1.0 - abs(p.x) - abs(p.y);
    let t = max(-y, 0.0);
    let xz = p + select(vec2(t), vec2(-t), p >= vec2(0.0));
    return normalize(vec3(xz.x, y, xz.y));
}
