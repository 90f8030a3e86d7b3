// Strategy "compute": the leaves that are tested.

@vertex
fn loose_counted(in: LooseVertex, @location(7) slot: u32) -> Counted {
    return counted(loose_vertex(in), slot);
}
