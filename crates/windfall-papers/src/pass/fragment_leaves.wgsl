// Strategy "fragment": draws the leaves that fragment_falls.wgsl has placed.

@group(2) @binding(0) var places: texture_2d<f32>;
@group(2) @binding(1) var rests: texture_2d<u32>;

struct LookedUpVertex {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) uv: vec2<f32>,
    @builtin(instance_index) leaf: u32,
}

@vertex
fn looked_up(in: LookedUpVertex) -> Varyings {
    return looked_up_vertex(in);
}

fn looked_up_vertex(in: LookedUpVertex) -> Varyings {
    let at = vec2(in.leaf & 255u, in.leaf >> 8u);
    let place = textureLoad(places, at, 0);
    let rest = textureLoad(rests, at, 0);
    let leaf = LooseLeaf(place.xyz, place.w, rest.x, rest.y, rest.z, rest.w);
    return posed(in.position.xyz, in.normal.xyz, in.uv, leaf);
}
