// Strategy "vertex-buffer": draws the vertices that vertex_buffer.wgsl has posed.

struct BufferVertex {
    @location(0) world: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) color: vec4<f32>,
    @location(3) look: u32,
    // As packed by vertex_buffer.wgsl.
    @location(4) uv: u32,
}

@vertex
fn read_vertex(in: BufferVertex) -> Varyings {
    return buffer_vertex(in);
}

fn buffer_vertex(in: BufferVertex) -> Varyings {
    let normal = from_octahedral(in.normal);
    if lit_at_vertices {
        let middle = unpack_middle(in.uv);
        return loose_varyings(in.world, in.world + middle.xyz, normal * middle.w, vec2(0.0), in.color, in.look);
    }
    return loose_varyings(in.world, in.world, normal, unpack2x16float(in.uv), in.color, in.look);
}
