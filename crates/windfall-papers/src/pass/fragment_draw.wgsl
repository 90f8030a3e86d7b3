// Strategy "fragment": draws the leaves that fragment.wgsl has posed.

@group(2) @binding(0) var positions: texture_2d<f32>;
@group(2) @binding(1) var rests: texture_2d<u32>;

struct PosedVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @builtin(instance_index) leaf: u32,
}

@vertex
fn read_pose(in: PosedVertex) -> Varyings {
    return posed_vertex(in);
}

fn posed_vertex(in: PosedVertex) -> Varyings {
    let at = vec2(in.leaf % BLOCK_SIZE, in.leaf / BLOCK_SIZE);
    let position_scale = textureLoad(positions, at, 0);
    let rest = textureLoad(rests, at, 0);
    let leaf = LooseLeaf(position_scale.xyz, position_scale.w, rest.x, rest.y, rest.z, rest.w);
    return posed(in.position.xyz, in.normal.xyz, in.uv, leaf);
}
