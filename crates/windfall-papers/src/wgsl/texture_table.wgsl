// Where strategies without storage buffers find paths, terrain and models.

@group(2) @binding(0) var<uniform> fall: FallFrame;
@group(2) @binding(1) var table_texels: texture_2d<u32>;
