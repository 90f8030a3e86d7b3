// The list of active leaves as a texture: BLOCK_SIZE leaves a row, LEAF_TEXELS texels a leaf.

@group(1) @binding(0) var leaf_texels: texture_2d<u32>;

fn leaf_of_texels(index: u32) -> LooseLeaf {
    let at = vec2(LEAF_TEXELS * (index % BLOCK_SIZE), index / BLOCK_SIZE);
    let a = textureLoad(leaf_texels, at, 0);
    let b = textureLoad(leaf_texels, at + vec2(1u, 0u), 0);
    let c = textureLoad(leaf_texels, at + vec2(2u, 0u), 0);
    let d = textureLoad(leaf_texels, at + vec2(3u, 0u), 0);
    let e = textureLoad(leaf_texels, at + vec2(4u, 0u), 0);
    return active_leaf(bitcast<vec4<f32>>(a), bitcast<vec4<f32>>(b), bitcast<vec4<f32>>(c), d, e);
}
