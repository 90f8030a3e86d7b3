// Paths, terrain and models for strategies without storage buffers.

@group(2) @binding(0) var<uniform> fall: FallFrame;
@group(2) @binding(1) var table_texels: texture_2d<u32>;
// Path data as VB 3.3 has them, where the pass reads them: a texel a sample.
@group(2) @binding(2) var path_positions: texture_1d<f32>;
@group(2) @binding(3) var path_orientations: texture_1d<f32>;
