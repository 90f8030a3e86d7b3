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

// Noise in [0, 1) on the integer lattice, smooth between.
fn value_noise2(at: vec2<f32>, seed: u32) -> f32 {
    let cell = floor(at);
    let f = at - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let i = vec2<u32>(vec2<i32>(cell));
    let a = unit(hash(hash(seed, i.x), i.y));
    let b = unit(hash(hash(seed, i.x + 1u), i.y));
    let c = unit(hash(hash(seed, i.x), i.y + 1u));
    let d = unit(hash(hash(seed, i.x + 1u), i.y + 1u));
    return mix(mix(a, b, s.x), mix(c, d, s.x), s.y);
}

// Four octaves that fade out where one pixel (width, in lattice units) holds a whole wave.
fn fractal_noise2(at: vec2<f32>, width: f32, seed: u32) -> f32 {
    var sum = 0.0;
    var amplitude = 0.5;
    var frequency = 1.0;
    for (var octave = 0u; octave < 4u; octave++) {
        let keep = 1.0 - smoothstep(0.3, 1.0, width * frequency);
        if keep <= 0.0 {
            break;
        }
        sum += amplitude * keep * (value_noise2(at * frequency, seed + octave) - 0.5);
        amplitude *= 0.5;
        frequency *= 2.07;
    }
    return sum;
}

// How grassy the ground is, 0 to 1: patches of a few metres with ragged edges.
fn ground_growth(at: vec2<f32>, width: f32) -> f32 {
    let patches = fractal_noise2(at * 0.062, width * 0.062, 21u) + 0.75 * fractal_noise2(at * 0.31, width * 0.31, 25u);
    return smoothstep(-0.10, 0.22, patches + frame.grassy);
}
