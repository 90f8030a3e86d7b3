// Strategy "vertex-buffer": draws the vertices that vertex_buffer_falls.wgsl has placed.

struct PlacedVertex {
    @location(0) world: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) color: vec4<f32>,
    @location(3) look: u32,
    @location(4) uv: vec2<f32>,
}

@vertex
fn placed(in: PlacedVertex) -> Varyings {
    return placed_vertex(in);
}

fn placed_vertex(in: PlacedVertex) -> Varyings {
    return loose_varyings(in.world, from_octahedral(in.normal), in.uv, in.color, in.look);
}
