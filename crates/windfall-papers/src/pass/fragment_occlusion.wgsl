// Strategy "fragment" with leaf occlusion.

@vertex
fn drawn(in: PosedVertex) -> Varyings {
    return drawn_leaf(posed_vertex(in), in.leaf);
}

@vertex
fn tested(in: PosedVertex) -> Counted {
    return tested_leaf(posed_vertex(in), in.leaf);
}
