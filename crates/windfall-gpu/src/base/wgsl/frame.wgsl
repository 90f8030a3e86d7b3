@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var sky_table: texture_2d<f32>;
@group(0) @binding(4) var sky_picture: texture_2d<f32>;
@group(0) @binding(5) var sky_sampler: sampler;
// A hash table of the leaves that a program has thrown. The first vector: its size, a power of two, less one. Then
// key of the tree, leaf, when it detaches, 1; 0 at the end of an empty place.
@group(0) @binding(6) var<storage, read> scripted: array<vec4<u32>>;
// Fractal noise about 0.5 in red, noise of one frequency in green; it repeats after NOISE_CELLS cells.
@group(0) @binding(7) var noise_tile: texture_2d<f32>;
@group(0) @binding(8) var noise_sampler: sampler;

// A triangle that covers the picture, at the far end of depth.
fn covering_triangle(index: u32) -> vec4<f32> {
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// When a program has thrown the leaf, seconds since the shedding began; later than anything if it has not.
fn scripted_detach(tree: u32, leaf: u32) -> f32 {
    let mask = scripted[0].x;
    var at = hash(tree, leaf);
    for (var tries = 0u; tries <= mask; tries++) {
        let entry = scripted[1u + (at & mask)];
        if entry.w == 0u {
            break;
        }
        if entry.x == tree && entry.y == leaf {
            return bitcast<f32>(entry.z);
        }
        at += 1u;
    }
    return NEVER;
}

const NEVER: f32 = 1e30;

// What tells a tree from all others: its own key, and its place.
fn scripted_key(tree_seed: u32, position: vec3<f32>) -> u32 {
    let at = bitcast<vec3<u32>>(position);
    return hash(hash(hash(tree_seed, at.x), at.y), at.z);
}
