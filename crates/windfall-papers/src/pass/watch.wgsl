// Leaf occlusion for the strategies without compute: what is to be done with each listed leaf in this
// frame; a fragment a leaf, 256 leaves a row.

// A word a leaf, as in shared/sight.wgsl; then how many are tested and how many are skipped.
@group(1) @binding(0) var<storage, read_write> words: array<atomic<u32>>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

@fragment
fn watch(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
    let place = u32(at.y) * 256u + u32(at.x);
    let sight = next_sight(atomicLoad(&words[place]), place);
    atomicStore(&words[place], sight);
    let what = done_with(sight);
    if what != SHOW {
        atomicAdd(&words[arrayLength(&words) - select(1u, 2u, what == TEST)], 1u);
    }
    return vec4(what);
}
