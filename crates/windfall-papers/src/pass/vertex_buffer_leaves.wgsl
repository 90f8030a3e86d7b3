// Strategy "vertex-buffer": draws the vertices that vertex_buffer_falls.wgsl has placed.

struct PlacedVertex {
    @location(0) world: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) color: vec4<f32>,
    @location(3) look: u32,
    // As vertex_buffer_falls.wgsl has packed it.
    @location(4) uv: u32,
}

@vertex
fn placed(in: PlacedVertex) -> Varyings {
    return placed_vertex(in);
}

fn placed_vertex(in: PlacedVertex) -> Varyings {
    let normal = from_octahedral(in.normal);
    if lit_at_vertices {
        let way = unpack_middle(in.uv);
        return loose_varyings(in.world, in.world + way.xyz, normal * way.w, vec2(0.0), in.color, in.look);
    }
    return loose_varyings(in.world, in.world, normal, unpack2x16float(in.uv), in.color, in.look);
}
