// Strategy "vertex" with leaf occlusion.

@vertex
fn drawn(in: FallingVertex, @builtin(instance_index) leaf: u32) -> Varyings {
    return drawn_leaf(falling_vertex(in), leaf);
}

@vertex
fn tested(in: FallingVertex, @builtin(instance_index) leaf: u32) -> Counted {
    return tested_leaf(falling_vertex(in), leaf);
}
