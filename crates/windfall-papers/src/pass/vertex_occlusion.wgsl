// Strategy "vertex" with leaf occlusion.

@vertex
fn watched(in: FallingVertex, @builtin(instance_index) place: u32) -> Varyings {
    return watched_leaf(falling_vertex(in), place);
}

@vertex
fn tested(in: FallingVertex, @builtin(instance_index) place: u32) -> Counted {
    return counted_leaf(falling_vertex(in), place);
}
