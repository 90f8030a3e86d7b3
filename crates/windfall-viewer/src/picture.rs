//! The forest's picture: drawn into a texture of its own, which the window shows.

use crate::app::Purpose;
use crate::load::{FORMAT, World};
use eframe::egui_wgpu::RenderState;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use windfall_gpu::{Capture, Light, PictureTargets, Recording, Renderer, Timing, View, ViewState};
use windfall_scenes::{StageCounts, StageReadback};

/// Textures of one size.
struct Target {
    size: (u32, u32),
    targets: PictureTargets,
    texture: wgpu::Texture,
    output: wgpu::TextureView,
}

/// Draws a world, a frame at a time, while the window goes on.
pub struct Picture {
    renderer: Renderer,
    state: Option<ViewState>,
    target: Option<Target>,
    id: Option<egui::TextureId>,
    busy: Arc<AtomicBool>,
    counts: Option<StageReadback>,
    /// What was drawn last, as far as it is known.
    pub latest: StageCounts,
    /// The moment of the counts that are waited for.
    counting: f64,
    capture: Option<(Capture, (u32, u32))>,
    took: Arc<Mutex<Option<f32>>>,
    /// Pictures drawn.
    pub frames: u64,
    #[cfg(not(target_arch = "wasm32"))]
    profiler: Option<windfall_gpu::wgpu_profiler::GpuProfiler>,
    /// Milliseconds of each pass of a recent frame.
    pub passes: Vec<(String, f64)>,
}

/// Pixels of a picture.
pub struct Pixels {
    /// Width and height.
    pub size: (u32, u32),
    /// Eight-bit sRGB with alpha.
    pub rgba: Vec<u8>,
}

/// What came back from the GPU.
pub struct Came {
    /// The moment of new counts.
    pub counted: Option<f64>,
    /// Pixels of a picture that is kept.
    pub pixels: Option<Pixels>,
    /// Seconds that a picture took.
    pub took: Option<f32>,
}

impl Picture {
    /// Without a world yet.
    pub fn new(renderer: Renderer, device: &wgpu::Device) -> Self {
        #[cfg(target_arch = "wasm32")]
        let _ = device;
        Self {
            renderer,
            state: None,
            target: None,
            id: None,
            busy: Arc::default(),
            counts: None,
            latest: StageCounts::default(),
            counting: 0.0,
            capture: None,
            took: Arc::default(),
            frames: 0,
            #[cfg(not(target_arch = "wasm32"))]
            profiler: timers(device),
            passes: Vec::new(),
        }
    }

    /// The world is another one.
    pub fn forget(&mut self) {
        self.state = None;
        self.counts = None;
    }

    /// Whether the last picture is not finished.
    pub fn is_busy(&self) -> bool {
        self.busy.load(Ordering::Acquire)
    }

    /// What egui shows.
    pub fn id(&self) -> Option<egui::TextureId> {
        self.id
    }

    /// Pixels of the picture that is shown.
    pub fn size(&self) -> Option<(u32, u32)> {
        self.target.as_ref().map(|target| target.size)
    }

    /// Records and submits a picture of `size` pixels. What comes back later: its pixels, if they are to be captured, and
    /// how long it took, if it is to be seen while things move.
    ///
    /// # Errors
    ///
    /// What the renderer cannot draw, in a sentence.
    pub fn draw(
        &mut self,
        render: &RenderState,
        world: &mut World,
        (time, view): (f64, &View),
        size: (u32, u32),
        (purpose, capture): (Purpose, bool),
    ) -> Result<(), String> {
        let device = &render.device;
        let begun = web_time::Instant::now();
        self.fit(render, size)?;
        let Self { renderer, state, target, .. } = self;
        let Some(Target { targets, output, texture, .. }) = target else { return Ok(()) };
        let state = state.get_or_insert_with(|| renderer.view(&world.planted.forest));
        let mut view = view.clone();
        if let Light::Sky(_, map) = &mut view.light {
            map.clone_from(&world.sky);
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        #[cfg(not(target_arch = "wasm32"))]
        let timing = self.profiler.as_ref().map_or(Timing::NONE, Timing::from);
        #[cfg(target_arch = "wasm32")]
        let timing = Timing::NONE;
        let mut recording = Recording { queue: &render.queue, encoder: &mut encoder, timing };
        world
            .planted
            .render(renderer, &mut recording, state, (time, &view), (targets, output))
            .map_err(|error| error.to_string())?;
        let counting = self.counts.is_none();
        if counting {
            self.counts = world.planted.count(device, &mut encoder, state);
            self.counting = time;
        }
        let fresh = self.capture.is_none() && capture;
        if fresh {
            self.capture = Some((Capture::encode(device, &mut encoder, texture), size));
        }
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(profiler) = &mut self.profiler {
            profiler.resolve_queries(&mut encoder);
        }
        render.queue.submit([encoder.finish()]);
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(profiler) = &mut self.profiler {
            let _ = profiler.end_frame();
        }
        if counting && let Some(counts) = &self.counts {
            counts.map();
        }
        if fresh && let Some((capture, _)) = &self.capture {
            capture.map();
        }
        self.busy.store(true, Ordering::Release);
        let busy = Arc::clone(&self.busy);
        let took = Arc::clone(&self.took);
        render.queue.on_submitted_work_done(move || {
            if purpose == Purpose::Moving {
                let seconds = begun.elapsed().as_secs_f32();
                *took.lock().unwrap_or_else(PoisonError::into_inner) = Some(seconds);
            }
            busy.store(false, Ordering::Release);
        });
        self.frames += 1;
        Ok(())
    }

    /// Takes what has come back from the GPU.
    pub fn collect(&mut self, render: &RenderState) -> Came {
        // In a browser this does nothing, and nothing is needed.
        let _ = render.device.poll(wgpu::PollType::Poll);
        let counted = match self.counts.as_ref().and_then(StageReadback::take) {
            None => None,
            Some(counts) => {
                self.counts = None;
                self.latest = counts.unwrap_or_default();
                Some(self.counting)
            }
        };
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(profiler) = &mut self.profiler
            && let Some(results) =
                profiler.process_finished_frame(render.queue.get_timestamp_period())
        {
            self.passes = passes(&results);
        }
        let pixels = self.capture.as_ref().and_then(|(capture, size)| {
            let rgba = capture.take()?;
            Some(rgba.map(|rgba| Pixels { size: *size, rgba }))
        });
        if pixels.is_some() {
            self.capture = None;
        }
        let took = self.took.lock().unwrap_or_else(PoisonError::into_inner).take();
        Came { counted, pixels: pixels.and_then(Result::ok), took }
    }

    /// Textures of this size.
    fn fit(&mut self, render: &RenderState, size: (u32, u32)) -> Result<(), String> {
        if self.target.as_ref().is_some_and(|target| target.size == size) {
            return Ok(());
        }
        let device = &render.device;
        let targets = self.renderer.targets(size.0, size.1).map_err(|error| error.to_string())?;
        let plain = wgpu::TextureFormat::Rgba8Unorm;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("forest"),
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[plain],
        });
        // egui works with sRGB values as they are stored.
        let shown = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(plain),
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        });
        let output = texture.create_view(&wgpu::TextureViewDescriptor {
            usage: Some(wgpu::TextureUsages::RENDER_ATTACHMENT),
            ..Default::default()
        });
        let filter = wgpu::FilterMode::Linear;
        let mut egui = render.renderer.write();
        match self.id {
            Some(id) => {
                egui.update_egui_texture_from_wgpu_texture(device, &shown, filter, id);
            }
            None => self.id = Some(egui.register_native_texture(device, &shown, filter)),
        }
        self.target = Some(Target { size, targets, texture, output });
        Ok(())
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn timers(device: &wgpu::Device) -> Option<windfall_gpu::wgpu_profiler::GpuProfiler> {
    use windfall_gpu::wgpu_profiler::{GpuProfiler, GpuProfilerSettings};
    device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then_some(())?;
    let settings = GpuProfilerSettings { enable_debug_groups: false, ..Default::default() };
    GpuProfiler::new(device, settings).ok()
}

/// Passes with their milliseconds; those of the same name together, in the order in which they ran.
#[cfg(not(target_arch = "wasm32"))]
fn passes(results: &[windfall_gpu::wgpu_profiler::GpuTimerQueryResult]) -> Vec<(String, f64)> {
    let mut passes: Vec<(String, f64)> = Vec::new();
    for result in results {
        let time = result.time.as_ref().map_or(0.0, |time| (time.end - time.start) * 1e3);
        match passes.iter_mut().find(|(label, _)| *label == result.label) {
            Some((_, sum)) => *sum += time,
            None => passes.push((result.label.clone(), time)),
        }
    }
    passes
}
