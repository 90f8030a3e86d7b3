// Strategy "vertex-buffer" (VB 6.2): a fragment poses one vertex of a leaf; its result is copied to a buffer and drawn
// as a vertex.

struct Region {
    @builtin(position) clip: vec4<f32>,
    // First texel of the region; vertices of a leaf; first leaf; where the shape is in the tables: twice that, plus 1
    // for small leaves.
    @location(0) @interpolate(flat) record: vec4<u32>,
}

@vertex
fn cover(@builtin(vertex_index) index: u32, @location(0) record: vec4<u32>) -> Region {
    return Region(covering_triangle(index), record);
}

struct VertexTexel {
    // Position, normal in octahedral coordinates.
    @location(0) place: vec4<u32>,
    // Colour; packed appearance; texture coordinates, or pack_middle for small leaves; index of the leaf.
    @location(1) rest: vec4<u32>,
}

@fragment
fn pose(in: Region) -> VertexTexel {
    let pixel = vec2<u32>(in.clip.xy);
    let i = pixel.y * VERTEX_ROW + pixel.x - in.record.x;
    let index = in.record.z + i / in.record.y;
    let leaf = leaf_of_texels(index);
    let corner = (in.record.w >> 1u) + 2u * (i % in.record.y);
    let position_u = bitcast<vec4<f32>>(table(corner));
    let normal_v = bitcast<vec4<f32>>(table(corner + 1u));
    let q = normalize(vec4(unpack2x16snorm(leaf.orientation_xy), unpack2x16snorm(leaf.orientation_zw)));
    let world = leaf.position + quat_rotate(q, position_u.xyz) * leaf.scale;
    let normal = octahedral(quat_rotate(q, normal_v.xyz));
    let uv = pack2x16float(vec2(position_u.w, normal_v.w));
    let to_middle = pack_middle(leaf.position - world, length(normal_v.xyz));
    return VertexTexel(
        vec4(bitcast<vec3<u32>>(world), pack2x16snorm(normal)),
        vec4(leaf.color, leaf.look, select(uv, to_middle, (in.record.w & 1u) == 1u), index),
    );
}
