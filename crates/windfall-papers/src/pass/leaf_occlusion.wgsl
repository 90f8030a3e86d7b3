// Leaf occlusion (VB 5): counts the pixels that tested leaves show, when the picture is done. Fragments
// compare depths themselves: those that only store are not discarded by depth before they run.

@group(3) @binding(1) var<storage, read_write> sights: array<atomic<u32>>;
@group(3) @binding(2) var depths: texture_depth_multisampled_2d;

struct Counted {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) material: u32,
    // Of its word among the sights.
    @location(2) @interpolate(flat) place: u32,
}

fn counted(leaf: Varyings, place: u32) -> Counted {
    return Counted(leaf.clip, leaf.uv, leaf.material, place);
}

// Counts a pixel if the leaf is seen in one of its samples; `slope` is that of its depth.
fn count(in: Counted, slope: f32) {
    let at = vec2<i32>(in.clip.xy);
    var farthest = 1.0;
    for (var i = 0; i < 4; i++) {
        farthest = min(farthest, textureLoad(depths, at, i));
    }
    // A leaf that has enough needs no more: many pixels in one place take turns.
    let depth = in.clip.z * 1.0001 + slope;
    if depth >= farthest && (atomicLoad(&sights[in.place]) & PIXELS) < ENOUGH_PIXELS {
        atomicAdd(&sights[in.place], 1u);
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
    if covered_samples(in.material, mask_share(surface, alpha, in.uv)) > 0u {
        count(in, slope);
    }
}
