// Paths, terrain and models as a texture, for strategies without storage buffers.

@group(2) @binding(0) var<uniform> fall: FallFrame;
@group(2) @binding(1) var table_texels: texture_2d<u32>;

fn table(i: u32) -> vec4<u32> {
    return textureLoad(table_texels, vec2(i & 1023u, i >> 10u), 0);
}
