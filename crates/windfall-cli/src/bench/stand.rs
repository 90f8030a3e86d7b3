//! A forest and a canvas to be measured.

use crate::gpu::Gpu;
use anyhow::Context;
use std::collections::BTreeMap;
use std::time::Instant;
use windfall_gpu::{
    Canvas, CountLeaves, Falls, FrameStats, GpuForest, LeafCounts, Renderer, Target, View,
};
use windfall_scenes::Stage;

pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// What frames are drawn on.
pub struct Easel {
    pub renderer: Renderer,
    canvas: Canvas,
    picture: wgpu::TextureView,
}

/// What a frame took.
pub struct Measured {
    /// From the first call to the end of all work on the GPU, milliseconds.
    pub wall: f64,
    /// Of that until everything was submitted.
    pub cpu: f64,
    /// Timestamps of the passes, milliseconds.
    pub gpu: BTreeMap<String, f64>,
    pub stats: FrameStats,
    /// What the GPU counted.
    pub counts: LeafCounts,
}

impl Easel {
    pub fn new(gpu: &Gpu, (width, height): (u32, u32)) -> Self {
        let renderer = Renderer::new(&gpu.device, FORMAT);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Self {
            canvas: renderer.canvas(&gpu.device, width, height),
            picture: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            renderer,
        }
    }

    pub fn forest(&self, gpu: &Gpu, stage: &Stage, falls: &Falls) -> GpuForest {
        let (trees, forest) = (&stage.trees, &stage.forest);
        GpuForest::with_falls(&gpu.device, &gpu.queue, &self.renderer, trees, forest, falls)
    }

    /// Draws a frame and waits for it.
    pub fn frame(
        &self,
        gpu: &mut Gpu,
        forest: &GpuForest,
        view: &View,
    ) -> anyhow::Result<Measured> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let target = Target { canvas: &self.canvas, picture: &self.picture };
        let stats =
            self.renderer.render(&gpu.queue, &mut encoder, &gpu.profiler, forest, view, target);
        gpu.profiler.resolve_queries(&mut encoder);
        let count = CountLeaves::encode(&gpu.device, &mut encoder, forest);
        gpu.queue.submit([encoder.finish()]);
        let cpu = start.elapsed().as_secs_f64() * 1e3;
        gpu.profiler.end_frame().context("timers")?;
        gpu.wait()?;
        let wall = start.elapsed().as_secs_f64() * 1e3;
        count.map();
        gpu.wait()?;
        let counts = count.take().context("the counts did not arrive")??;
        Ok(Measured { wall, cpu, counts, gpu: gpu.pass_times(), stats })
    }
}
