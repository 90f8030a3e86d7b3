// Strategy "cpu" with leaf occlusion.

@vertex
fn drawn(in: LitterVertex, @builtin(instance_index) leaf: u32) -> Varyings {
    return drawn_leaf(lying_vertex(in), leaf);
}

@vertex
fn tested(in: LitterVertex, @builtin(instance_index) leaf: u32) -> Counted {
    return tested_leaf(lying_vertex(in), leaf);
}
