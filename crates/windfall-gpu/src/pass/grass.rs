//! Grass about the camera.

use super::{
    Shaders,
    draw::{Draw, DrawTarget},
    ground::GroundMesh,
};

/// Cells along a side of the square about the camera, rings of such squares, and vertices of a tuft
/// (`shaders/grass.wgsl`: `SIDE`, `ring`, three times `BLADES`).
const SIDE: u32 = 128;
const RINGS: u32 = 2;
const VERTICES: u32 = 15;

pub(crate) struct Grass {
    pipeline: wgpu::RenderPipeline,
    pub layout: wgpu::BindGroupLayout,
}

impl Grass {
    pub fn new(shaders: &Shaders<'_>) -> Self {
        let layout = shaders.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("grass"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let pipeline = shaders.pipeline(&Draw {
            label: "grass",
            source: include_str!("../../shaders/grass.wgsl"),
            groups: &[&layout],
            buffers: &[],
            cull: None,
            vertex: "vertex",
            fragment: Some("fragment"),
            target: DrawTarget::Radiance,
            constants: &[],
        });
        Self { pipeline, layout }
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, ground: &GroundMesh) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(1, &ground.heights, &[]);
        pass.draw(0..VERTICES, 0..RINGS * SIDE * SIDE);
    }
}
