//! Drives the renderer for measurements: timed frames, and frames that are read back as images.

use crate::image::LinearImage;
use anyhow::Context;
use std::collections::BTreeMap;
use std::time::Instant;
use windfall_gpu::{
    Capture, Options, PictureTargets, Recording, Renderer, TreeModel, View, ViewState,
};
use windfall_host::device::Gpu;
use windfall_scenes::{PlantedStage, Stage, StageCounts};

/// Format of the color targets.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Uploads the tree models of a stage, for [`PlantedView::new`].
pub fn upload_models(gpu: &Gpu, stage: &Stage) -> anyhow::Result<Vec<TreeModel>> {
    let models = stage.trees.iter().map(|tree| TreeModel::new(&gpu.device, &gpu.queue, tree));
    Ok(models.collect::<Result<_, _>>()?)
}

/// A stage on the GPU, and what its view keeps.
pub struct PlantedView {
    pub stage: PlantedStage,
    state: ViewState,
}

impl PlantedView {
    /// Plants the trees of a stage. `models` are those of the stage; several stages may share them.
    pub fn new(
        gpu: &Gpu,
        renderer: &Renderer,
        stage: &Stage,
        models: &[TreeModel],
    ) -> anyhow::Result<Self> {
        let stage = stage.plant(&gpu.device, models.to_vec())?;
        Ok(Self { state: renderer.view(&stage.forest), stage })
    }

    /// Uploads the tree models of a stage and plants them.
    pub fn upload(gpu: &Gpu, renderer: &Renderer, stage: &Stage) -> anyhow::Result<Self> {
        Self::new(gpu, renderer, stage, &upload_models(gpu, stage)?)
    }

    /// Records a frame at `time`, seconds.
    fn record(
        &mut self,
        gpu: &Gpu,
        renderer: &Renderer,
        encoder: &mut wgpu::CommandEncoder,
        (time, view): (f64, &View),
        to: (&PictureTargets, &wgpu::TextureView),
    ) -> anyhow::Result<()> {
        let mut recording = Recording { queue: &gpu.queue, encoder, timing: gpu.timing() };
        Ok(self.stage.render(renderer, &mut recording, &mut self.state, (time, view), to)?)
    }
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
    targets: PictureTargets,
    color: wgpu::TextureView,
}

/// Cost and content of a frame. Times are milliseconds.
pub struct FrameMeasurement {
    /// Wall clock from the first call to the end of all work on the GPU.
    pub wall_ms: f64,
    /// Wall clock from the first call to the submission.
    pub cpu_ms: f64,
    /// GPU timestamps by pass; `"frame"` is the sum of the passes.
    pub gpu_ms: BTreeMap<String, f64>,
    /// Trees and leaves.
    pub counts: StageCounts,
}

impl FrameMeasurement {
    /// GPU timestamps of some passes together; NaN without timestamps.
    pub fn passes_ms(&self, names: &[&str]) -> f64 {
        names.iter().map(|&name| self.gpu_ms.get(name).copied().unwrap_or(f64::NAN)).sum()
    }
}

impl Harness {
    pub fn new(gpu: &Gpu, size: (u32, u32)) -> anyhow::Result<Self> {
        let renderer = Renderer::new(&gpu.device, &Options::picture(COLOR_FORMAT))?;
        let texture = color_texture(gpu, size, wgpu::TextureUsages::empty());
        Ok(Self {
            targets: renderer.targets(size.0, size.1)?,
            color: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            renderer,
        })
    }

    /// Uploads a stage for this renderer; see [`PlantedView::upload`].
    pub fn upload(&self, gpu: &Gpu, stage: &Stage) -> anyhow::Result<PlantedView> {
        PlantedView::upload(gpu, &self.renderer, stage)
    }

    /// Plants a stage for this renderer; see [`PlantedView::new`].
    pub fn plant(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        models: &[TreeModel],
    ) -> anyhow::Result<PlantedView> {
        PlantedView::new(gpu, &self.renderer, stage, models)
    }

    /// Draws a frame at `time`, seconds, and waits for it.
    pub fn measure(
        &self,
        gpu: &mut Gpu,
        planted: &mut PlantedView,
        (time, view): (f64, &View),
    ) -> anyhow::Result<FrameMeasurement> {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let to = (&self.targets, &self.color);
        planted.record(gpu, &self.renderer, &mut encoder, (time, view), to)?;
        gpu.profiler.resolve_queries(&mut encoder);
        let counts = planted
            .stage
            .count(&gpu.device, &mut encoder, &planted.state)
            .context("nothing was drawn")?;
        gpu.queue.submit([encoder.finish()]);
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        gpu.profiler.end_frame().context("timers")?;
        gpu.wait()?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        // Reading the counts back is not a part of the frame.
        counts.map();
        gpu.wait()?;
        let counts = counts.take().context("the counts did not arrive")??;
        Ok(FrameMeasurement { wall_ms, cpu_ms, gpu_ms: gpu.pass_times(), counts })
    }
}

/// Render targets of one size, whose frames are read back as images.
pub struct ImageTarget {
    /// In pixels of the render targets.
    size: (u32, u32),
    /// Side of the squares of pixels that are averaged.
    supersampling: u32,
    targets: PictureTargets,
    color: wgpu::Texture,
}

impl ImageTarget {
    /// Images of `size`, drawn with `supersampling` times the width and the height and averaged.
    pub fn new(
        gpu: &Gpu,
        renderer: &Renderer,
        size: (u32, u32),
        supersampling: u32,
    ) -> anyhow::Result<Self> {
        let size = (size.0 * supersampling, size.1 * supersampling);
        let color = color_texture(gpu, size, wgpu::TextureUsages::COPY_SRC);
        let targets = renderer.targets(size.0, size.1)?;
        Ok(Self { size, supersampling, targets, color })
    }

    /// Draws a frame at `time`, seconds, waits for it and reads it back.
    pub fn render(
        &self,
        gpu: &mut Gpu,
        renderer: &Renderer,
        planted: &mut PlantedView,
        (time, view): (f64, &View),
    ) -> anyhow::Result<LinearImage> {
        let color = self.color.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let to = (&self.targets, &color);
        planted.record(gpu, renderer, &mut encoder, (time, view), to)?;
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
