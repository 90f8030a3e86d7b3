//! Draws moments of one stage, and reports on them.

use crate::linear::{Linear, LinearImage};
use anyhow::Context;
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Instant;
use windfall_gpu::{
    Capture, DebugView, FrameBudget, Layer, Light, PictureTargets, Recording, Renderer, SkyMap,
    SkyPicture, View, ViewState,
};
use windfall_host::device::Gpu;
use windfall_scenes::{PlantedStage, Stage};

/// Format of pictures.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// What `--json` prints of a frame.
#[derive(Serialize)]
pub struct FrameReport {
    frame: u32,
    time: f64,
    trees: u64,
    trees_visible: u64,
    trees_hidden: u64,
    leaves_total: u64,
    leaves_hanging_drawn: u64,
    leaves_falling: u64,
    leaves_falling_drawn: u64,
    leaves_landed: u64,
    leaves_eliminated: u64,
    leaves_checked: u64,
    leaves_tested: u32,
    leaves_skipped: u32,
    triangles_full: u64,
    triangles_drawn: u64,
    lambda_total: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    saving: Option<f32>,
    cpu_ms: f64,
    gpu_ms: BTreeMap<String, f64>,
}

/// Draws moments of one stage.
pub struct Pictures {
    renderer: Renderer,
    planted: PlantedStage,
    state: ViewState,
    targets: PictureTargets,
    texture: wgpu::Texture,
    sky: Option<SkyMap>,
    linear: Option<Linear>,
    budget: Option<FrameBudget>,
}

/// Most frames that are drawn before the first picture until a budget has settled.
const SETTLING: u32 = 40;
/// How little the saving changes in so many frames once it has.
const SETTLED: (f32, usize) = (0.01, 6);

impl Pictures {
    /// Uploads a stage. The renderer draws whole pictures of [`FORMAT`].
    pub fn new(
        gpu: &Gpu,
        renderer: Renderer,
        stage: &Stage,
        (width, height): (u32, u32),
        (sky, linear): (Option<&SkyPicture>, Option<Linear>),
    ) -> anyhow::Result<Self> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let sky = sky.map(|sky| SkyMap::new(device, queue, sky));
        let planted = stage.upload(device, queue)?;
        let state = renderer.view(&planted.forest);
        let targets = renderer.targets(width, height)?;
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = Capture::texture(device, size, FORMAT);
        Ok(Self { renderer, planted, state, targets, texture, sky, linear, budget: None })
    }

    /// From now on a frame should take so many milliseconds; `None`: it takes what it takes.
    pub fn hold(&mut self, budget: Option<f32>) {
        self.budget = budget.map(|ms| FrameBudget::new(ms * 1e-3));
    }

    /// Draws the moment of the first picture until the budget has settled.
    pub fn settle(&mut self, gpu: &mut Gpu, view: &View, time: f64) -> anyhow::Result<()> {
        let mut savings: Vec<f32> = Vec::new();
        for _ in 0..SETTLING {
            self.draw(gpu, view.clone(), (0, time))?;
            let Some(budget) = &self.budget else { return Ok(()) };
            savings.push(budget.saving());
            let last = &savings[savings.len().saturating_sub(SETTLED.1)..];
            let change = last.iter().fold(0.0f32, |most, s| most.max((s - budget.saving()).abs()));
            if last.len() == SETTLED.1 && change < SETTLED.0 {
                break;
            }
        }
        Ok(())
    }

    /// Draws a moment: pixels, linear radiance where it is wanted, and what was drawn.
    pub fn draw(
        &mut self,
        gpu: &mut Gpu,
        mut view: View,
        (frame, time): (u32, f64),
    ) -> anyhow::Result<(Vec<u8>, Option<LinearImage>, FrameReport)> {
        if let Light::Sky(_, map) = &mut view.light {
            map.clone_from(&self.sky);
        }
        if let Some(budget) = &self.budget {
            budget.apply(&mut view);
        }
        let saving = self.budget.as_ref().map(FrameBudget::saving);
        let start = Instant::now();
        let Self { renderer, planted, state, targets, texture, linear, .. } = self;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let output = texture.create_view(&Default::default());
        let mut recording =
            Recording { queue: &gpu.queue, encoder: &mut encoder, timing: gpu.timing() };
        let mut layers: Vec<&mut dyn Layer> = Vec::new();
        layers.extend(linear.as_mut().map(|layer| layer as &mut dyn Layer));
        let target = (&*targets, &output);
        planted.render_with(renderer, &mut recording, state, (time, &view), target, layers)?;
        let capture = Capture::encode(&gpu.device, &mut encoder, texture);
        let counts =
            planted.count(&gpu.device, &mut encoder, state).context("nothing was drawn")?;
        gpu.profiler.resolve_queries(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let cpu_ms = start.elapsed().as_secs_f64() * 1e3;
        gpu.profiler.end_frame().context("timers")?;
        if linear.as_ref().is_some_and(Linear::wants_ids) {
            // A submission of its own: the frame's uniforms are written before each.
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut recording = Recording::new(&gpu.queue, &mut encoder);
            let view = View { show: DebugView::Ids, ..view };
            let layers = linear.iter_mut().map(|layer| layer as &mut dyn Layer).collect();
            planted.render_with(renderer, &mut recording, state, (time, &view), target, layers)?;
            gpu.queue.submit([encoder.finish()]);
        }
        capture.map();
        counts.map();
        if let Some(linear) = linear {
            linear.map();
        }
        gpu.wait()?;
        let drawn_ms = start.elapsed().as_secs_f64() * 1e3;
        let counts = counts.take().context("the counts did not arrive")??;
        let rgba = capture.take().context("the picture did not arrive")??;
        let linear =
            linear.as_ref().map(|linear| linear.take().context("the radiance did not arrive"));
        let (totals, trees) = (planted.forest.totals(), counts.trees);
        let report = FrameReport {
            frame,
            time,
            trees: totals.trees,
            trees_visible: trees.visible,
            trees_hidden: trees.hidden,
            leaves_total: totals.leaves,
            leaves_hanging_drawn: trees.leaves_hanging,
            leaves_falling: counts.falling,
            leaves_falling_drawn: counts.falling_drawn,
            leaves_landed: counts.landed,
            leaves_eliminated: counts.eliminated,
            leaves_checked: counts.checked,
            leaves_tested: counts.tested,
            leaves_skipped: counts.skipped,
            triangles_full: totals.triangles,
            triangles_drawn: trees.triangles,
            lambda_total: trees.lambda_total(),
            saving,
            cpu_ms,
            gpu_ms: gpu.pass_times(),
        };
        if let Some(budget) = &mut self.budget {
            // By the GPU's clock where it has one.
            let ms = report.gpu_ms.get("frame").copied().unwrap_or(drawn_ms);
            budget.frame(ms as f32 * 1e-3);
        }
        Ok((rgba, linear.transpose()?, report))
    }
}
