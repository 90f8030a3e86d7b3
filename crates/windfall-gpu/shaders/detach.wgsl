// How many leaves have left each visible tree.

@group(1) @binding(0) var<uniform> fall: FallFrame;
@group(1) @binding(1) var<storage, read_write> visible: array<TreeInstance>;
@group(1) @binding(2) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(64)
fn detach(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= fall.tree_count {
        return;
    }
    let tree = visible[id.x];
    let detached = detached_by(fall.time, tree.seed, tree.delay, tree.gust_phase, tree.leaf_count);
    visible[id.x].detached = detached;
    if id.x < fall.visible_count {
        atomicAdd(&counters[5u * fall.bin_count + 4u], tree.leaf_count - detached);
    }
}
