// Strategy "vertex" (VB 6, first): every vertex poses its leaf.

struct FallingVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    // FallingLeaf.
    @location(3) origin_detach: vec4<f32>,
    @location(4) landing: vec4<f32>,
    @location(5) numbers: vec4<f32>,
    @location(6) rotations: vec4<u32>,
    @location(7) keys: vec4<u32>,
}

@vertex
fn falling(in: FallingVertex) -> Varyings {
    return falling_vertex(in);
}

fn falling_vertex(in: FallingVertex) -> Varyings {
    let leaf = active_leaf(in.origin_detach, in.landing, in.numbers, in.rotations, in.keys);
    return posed(in.position.xyz, in.normal.xyz, in.uv, leaf);
}
