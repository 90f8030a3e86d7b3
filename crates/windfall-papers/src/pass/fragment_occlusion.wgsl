// Strategy "fragment" with leaf occlusion.

@vertex
fn watched(in: LookedUpVertex) -> Varyings {
    return watched_leaf(looked_up_vertex(in), in.leaf);
}

@vertex
fn tested(in: LookedUpVertex) -> Counted {
    return counted_leaf(looked_up_vertex(in), in.leaf);
}
