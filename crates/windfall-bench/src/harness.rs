//! Drives the renderer for measurements: timed frames, and frames that are read back as images.

use crate::image::LinearImage;
use anyhow::Context;
use std::collections::BTreeMap;
use std::time::Instant;
use windfall_gpu::{
    Canvas, Capture, CountLeaves, Falls, FrameStats, GpuForest, LeafCounts, Renderer, Target, View,
};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;

/// Format of the color targets.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Uploads the trees of a stage. `falls` takes the place of the stage's own.
pub fn upload(gpu: &Gpu, renderer: &Renderer, stage: &Stage, falls: &Falls) -> GpuForest {
    let (trees, forest) = (&stage.trees, &stage.forest);
    GpuForest::with_falls(&gpu.device, &gpu.queue, renderer, trees, forest, falls)
}

fn color_texture(
    gpu: &Gpu,
    (width, height): (u32, u32),
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("color target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// A renderer with render targets of one size, whose frames are timed.
pub struct Harness {
    pub renderer: Renderer,
    canvas: Canvas,
    color: wgpu::TextureView,
}

/// Cost and content of a frame. Times are milliseconds.
pub struct FrameMeasurement {
    /// Wall clock from the first call to the end of all work on the GPU.
    pub wall_ms: f64,
    /// Wall clock from the first call to the submission.
    pub cpu_ms: f64,
    /// GPU timestamps by pass.
    pub gpu_ms: BTreeMap<String, f64>,
    /// What the CPU counted.
    pub stats: FrameStats,
    /// What the GPU counted.
    pub counts: LeafCounts,
}

impl Harness {
    pub fn new(gpu: &Gpu, size: (u32, u32)) -> Self {
        let renderer = Renderer::new(&gpu.device, COLOR_FORMAT);
        let texture = color_texture(gpu, size, wgpu::TextureUsages::empty());
        Self {
            canvas: renderer.canvas(&gpu.device, size.0, size.1),
            color: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            renderer,
        }
    }

    /// Uploads the trees of a stage for this renderer; see [`upload`].
    pub fn upload(&self, gpu: &Gpu, stage: &Stage, falls: &Falls) -> GpuForest {
        upload(gpu, &self.renderer, stage, falls)
    }

    /// Draws a frame and waits for it.
    pub fn measure(
        &self,
        gpu: &mut Gpu,
        forest: &GpuForest,
        view: &View,
    ) -> anyhow::Result<FrameMeasurement> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let target = Target { canvas: &self.canvas, picture: &self.color };
        let stats =
            self.renderer.render(&gpu.queue, &mut encoder, &gpu.profiler, forest, view, target);
        gpu.profiler.resolve_queries(&mut encoder);
        let count = CountLeaves::encode(&gpu.device, &mut encoder, forest);
        gpu.queue.submit([encoder.finish()]);
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        gpu.profiler.end_frame().context("timers")?;
        gpu.wait()?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        // Reading the counts back is not a part of the frame.
        count.map();
        gpu.wait()?;
        let counts = count.take().context("the counts did not arrive")??;
        Ok(FrameMeasurement { wall_ms, cpu_ms, gpu_ms: gpu.pass_times(), stats, counts })
    }
}

/// Render targets of one size, whose frames are read back as images.
pub struct ImageTarget {
    /// In pixels of the render targets.
    size: (u32, u32),
    /// Side of the squares of pixels that are averaged.
    supersampling: u32,
    canvas: Canvas,
    color: wgpu::Texture,
}

impl ImageTarget {
    /// Images of `size`, drawn with `supersampling` times the width and the height and averaged.
    pub fn new(gpu: &Gpu, renderer: &Renderer, size: (u32, u32), supersampling: u32) -> Self {
        let size = (size.0 * supersampling, size.1 * supersampling);
        let color = color_texture(gpu, size, wgpu::TextureUsages::COPY_SRC);
        let canvas = renderer.canvas(&gpu.device, size.0, size.1);
        Self { size, supersampling, canvas, color }
    }

    /// Draws a frame, waits for it and reads it back.
    pub fn render(
        &self,
        gpu: &mut Gpu,
        renderer: &Renderer,
        forest: &GpuForest,
        view: &View,
    ) -> anyhow::Result<LinearImage> {
        let color = self.color.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let target = Target { canvas: &self.canvas, picture: &color };
        renderer.render(&gpu.queue, &mut encoder, &gpu.profiler, forest, view, target);
        let capture = Capture::encode(&gpu.device, &mut encoder, &self.color);
        gpu.profiler.resolve_queries(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.profiler.end_frame().context("timers")?;
        capture.map();
        gpu.wait()?;
        gpu.check()?;
        // Takes the frame's timers out of the profiler, which keeps a few frames only.
        gpu.pass_times();
        let rgba = capture.take().context("the picture did not arrive")??;
        Ok(LinearImage::of(&rgba, self.size).downsampled(self.supersampling))
    }
}
