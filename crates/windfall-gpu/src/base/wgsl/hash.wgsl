// The counter-based hash of windfall_core::rng.

fn mix_bits(x0: u32) -> u32 {
    var x = (x0 ^ (x0 >> 16u)) * 0x21f0aaadu;
    x = (x ^ (x >> 15u)) * 0xd35a2d97u;
    return x ^ (x >> 15u);
}

fn hash(key: u32, counter: u32) -> u32 {
    return mix_bits(mix_bits(key + 0x9e3779b9u) ^ (counter * 0x85ebca6bu));
}

fn unit(h: u32) -> f32 {
    return f32(h >> 8u) * (1.0 / 16777216.0);
}

// The tile of noise at a place in cells of its lattice, as a pixel so wide sees it. Seeds are places far from each other.
fn noise_at(at: vec2<f32>, width: f32, seed: u32) -> vec2<f32> {
    let place = at / NOISE_CELLS + f32(seed) * vec2(0.618034, 0.754878);
    let level = log2(max(width * (1.4 * NOISE_SIDE / NOISE_CELLS), 1.0));
    return textureSampleLevel(noise_tile, noise_sampler, place, level).rg;
}

// Noise in [0, 1), smooth between the points of a lattice.
fn value_noise2(at: vec2<f32>, seed: u32) -> f32 {
    return noise_at(at, 0.0, seed).g;
}

// Four octaves that fade out where one pixel (width, in lattice units) holds a whole wave.
fn fractal_noise2(at: vec2<f32>, width: f32, seed: u32) -> f32 {
    return noise_at(at, width, seed).r - 0.5;
}

// How grassy the ground is, 0 to 1: patches of a few metres with ragged edges.
fn ground_growth(at: vec2<f32>, width: f32) -> f32 {
    let patches = fractal_noise2(at * 0.062, width * 0.062, 21u) + 0.75 * fractal_noise2(at * 0.31, width * 0.31, 25u);
    return smoothstep(-0.10, 0.22, patches + frame.grassy);
}
