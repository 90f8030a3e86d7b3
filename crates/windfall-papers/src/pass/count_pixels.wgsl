// Leaf occlusion (VB 5): counts the visible pixels of tested leaves once the scene is drawn. Fragments compare depth
// themselves: early depth tests do not apply to fragments that only store.

@group(3) @binding(1) var<storage, read_write> states: array<atomic<u32>>;
@group(3) @binding(2) var depths: texture_depth_multisampled_2d;

struct Counted {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) material: u32,
    // Index of its state.
    @location(2) @interpolate(flat) leaf: u32,
}

// Counts a pixel if the leaf is visible in one of its samples; `slope` is the change of its depth over a pixel.
fn count(in: Counted, slope: f32) {
    let at = vec2<i32>(in.clip.xy);
    var farthest = 1.0;
    for (var i = 0; i < 4; i++) {
        farthest = min(farthest, textureLoad(depths, at, i));
    }
    // Atomics on one word are serialized: stop at enough pixels.
    let depth = in.clip.z * 1.0001 + slope;
    if depth >= farthest && (atomicLoad(&states[in.leaf]) & COUNTED) < enough_pixels {
        atomicAdd(&states[in.leaf], 1u);
    }
}

@fragment
fn count_solid(in: Counted) {
    count(in, fwidth(in.clip.z));
}

@fragment
fn count_masked(in: Counted) {
    let slope = fwidth(in.clip.z);
    let surface = surface_of(in.material);
    let alpha = textureSample(pictures, picture_sampler, in.uv, max(surface.layer, 0)).a;
    var leaf: Varyings;
    leaf.clip = in.clip;
    leaf.material = in.material;
    if covered_samples(leaf, mask_share(surface, alpha, in.uv)) > 0u {
        count(in, slope);
    }
}
