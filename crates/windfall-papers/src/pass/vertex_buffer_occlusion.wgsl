// Strategy "vertex-buffer" with leaf occlusion.

@vertex
fn watched(in: PlacedVertex, @location(5) place: u32) -> Varyings {
    return watched_leaf(placed_vertex(in), place);
}

@vertex
fn tested(in: PlacedVertex, @location(5) place: u32) -> Counted {
    return counted_leaf(placed_vertex(in), place);
}
