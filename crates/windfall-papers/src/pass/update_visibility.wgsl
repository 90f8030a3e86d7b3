// Leaf occlusion: the visibility state of each active leaf in this frame; one fragment a leaf.

// A state per leaf (visibility.wgsl), then the numbers of tested and of skipped leaves.
@group(1) @binding(0) var<storage, read_write> states: array<atomic<u32>>;

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

@fragment
fn update(@builtin(position) at: vec4<f32>) -> @location(0) vec4<u32> {
    let leaf = u32(at.y) * BLOCK_SIZE + u32(at.x);
    let state = next_state(atomicLoad(&states[leaf]), leaf);
    atomicStore(&states[leaf], state);
    let action = action_of(state);
    if action != DRAW {
        atomicAdd(&states[arrayLength(&states) - select(1u, 2u, action == TEST)], 1u);
    }
    return vec4(action);
}
