// Strategy "vertex-buffer" with leaf occlusion.

@vertex
fn drawn(in: BufferVertex, @location(5) leaf: u32) -> Varyings {
    return drawn_leaf(buffer_vertex(in), leaf);
}

@vertex
fn tested(in: BufferVertex, @location(5) leaf: u32) -> Counted {
    return tested_leaf(buffer_vertex(in), leaf);
}
