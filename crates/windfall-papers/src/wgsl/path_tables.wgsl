// Paths, terrain and models for strategies without storage buffers.

@group(2) @binding(0) var<uniform> fall: FallFrame;
@group(2) @binding(1) var table_texels: texture_2d<u32>;
