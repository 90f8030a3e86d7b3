// Strategy "fragment" (VB 6.1): a fragment poses a leaf; the vertex shader of fragment_draw.wgsl reads the result.

@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return covering_triangle(index);
}

struct LeafTexel {
    // Position and scale; then the other half of a LooseLeaf.
    @location(0) position_scale: vec4<f32>,
    @location(1) rest: vec4<u32>,
}

@fragment
fn pose(@builtin(position) at: vec4<f32>) -> LeafTexel {
    let pixel = vec2<u32>(at.xy);
    let leaf = leaf_of_texels(pixel.y * BLOCK_SIZE + pixel.x);
    return LeafTexel(
        vec4(leaf.position, leaf.scale),
        vec4(leaf.orientation_xy, leaf.orientation_zw, leaf.color, leaf.look),
    );
}
