//! Linear radiance, coverage, depth and leaves of a picture, for compositing.

use anyhow::{Context, Result};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer as ExrLayer, LayerAttributes,
    WritableImage, f16,
};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use windfall_gpu::{DebugView, Layer, LayerFrame, Light, Recording, SceneTextures};
use windfall_host::file::write_atomic;

/// Depth of pixels where there is only sky.
const FAR: f32 = 3.0e38;
/// Distance of the near plane, metres: that of the scenes' cameras.
const NEAR: f32 = 0.1;

/// A layer that keeps what is drawn before it is tone mapped: of the picture, and after that, where leaves are wanted, of
/// [`DebugView::Ids`].
pub struct Linear {
    colors: wgpu::ComputePipeline,
    ids: wgpu::ComputePipeline,
    settings: wgpu::Buffer,
    pixels: wgpu::Buffer,
    readback: wgpu::Buffer,
    mapped: Option<Receiver<Result<(), wgpu::BufferAsyncError>>>,
    device: wgpu::Device,
    size: (u32, u32),
    options: LinearOptions,
}

/// What is kept of a picture.
#[derive(Debug, Clone, Copy)]
pub struct LinearOptions {
    /// Without the sky.
    pub clear: bool,
    /// Which leaf is seen.
    pub ids: bool,
}

impl LinearOptions {
    /// Words of a pixel.
    fn words(self) -> usize {
        if self.ids { 5 } else { 3 }
    }
}

/// Radiance of a picture, premultiplied by its coverage, depth, and leaves if they are wanted.
pub struct LinearImage {
    size: (u32, u32),
    options: LinearOptions,
    /// Of each pixel two words of halves, one of depth; one of the leaf, one of its tree.
    words: Vec<u32>,
}

impl Linear {
    /// For pictures of a size.
    pub fn new(device: &wgpu::Device, size: (u32, u32), options: LinearOptions) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("linear.wgsl"));
        let pipeline = |entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("linear picture"),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let bytes = 4 * options.words() as u64 * u64::from(size.0) * u64::from(size.1);
        let of_gpu = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let of_cpu = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        Self {
            colors: pipeline("colors"),
            ids: pipeline("ids"),
            settings: buffer("linear settings", 16, uniform),
            pixels: buffer("linear pixels", bytes, of_gpu),
            readback: buffer("linear readback", bytes, of_cpu),
            mapped: None,
            device: device.clone(),
            size,
            options,
        }
    }

    /// Whether a picture of [`DebugView::Ids`] is wanted after the picture.
    pub fn wants_ids(&self) -> bool {
        self.options.ids
    }

    /// Asks for the pixels, once the frame is submitted.
    pub fn map(&mut self) {
        let (send, receive) = channel();
        self.readback.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody waits any more if the picture was given up.
            let _ = send.send(result);
        });
        self.mapped = Some(receive);
    }

    /// The picture, once the GPU is done.
    pub fn take(&self) -> Option<LinearImage> {
        self.mapped.as_ref()?.try_recv().ok()?.ok()?;
        let words = bytemuck::cast_slice(&self.readback.slice(..).get_mapped_range()).to_vec();
        self.readback.unmap();
        Some(LinearImage { size: self.size, options: self.options, words })
    }
}

impl Layer for Linear {
    fn prepare(&mut self, _: &mut Recording<'_>, _: &LayerFrame<'_>) {}

    fn draw(&self, _: &mut wgpu::RenderPass<'_>, _: &LayerFrame<'_>) {}

    fn draw_shadow(&self, _: &mut wgpu::RenderPass<'_>, _: &LayerFrame<'_>, _: usize) {}

    fn finish(
        &mut self,
        recording: &mut Recording<'_>,
        frame: &LayerFrame<'_>,
        scene: &SceneTextures<'_>,
    ) {
        let exposure = match &frame.view.light {
            Light::Sky(sky, _) => sky.exposure.exp2(),
            Light::Host(_) => 1.0,
        };
        let clear = f32::from(u8::from(self.options.clear));
        let settings = [exposure, NEAR, clear, self.options.words() as f32];
        recording.queue.write_buffer(&self.settings, 0, bytemuck::bytes_of(&settings));
        let ids = self.options.ids && frame.view.show == DebugView::Ids;
        let pipeline = if ids { &self.ids } else { &self.colors };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("linear picture"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(scene.radiance)),
                entry(1, wgpu::BindingResource::TextureView(scene.depth)),
                entry(2, self.pixels.as_entire_binding()),
                entry(3, self.settings.as_entire_binding()),
            ],
        });
        {
            let mut pass =
                recording.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(self.size.0.div_ceil(8), self.size.1.div_ceil(8), 1);
        }
        let bytes = self.pixels.size();
        recording.encoder.copy_buffer_to_buffer(&self.pixels, 0, &self.readback, 0, bytes);
    }

    fn reads_depth(&self) -> bool {
        true
    }
}

impl LinearImage {
    /// Writes an OpenEXR file, whole or not at all: linear colour in the primaries of BT.709 (R, G, B, premultiplied), A,
    /// Z, metres along the view, 3e38 where there is only sky; and `id.leaf` and `id.tree`, counted from 1, 0 where no leaf
    /// is nearest.
    pub fn save_exr(&self, path: &Path) -> Result<()> {
        let pixels = || self.words.chunks_exact(self.options.words());
        let halves = |word: usize, high: bool| {
            let half = |w: &[u32]| f16::from_bits((w[word] >> if high { 16 } else { 0 }) as u16);
            FlatSamples::F16(pixels().map(half).collect())
        };
        let depths = pixels().map(|w| f32::from_bits(w[2]).min(FAR)).collect();
        let mut channels = vec![
            AnyChannel::new("A", halves(1, true)),
            AnyChannel::new("B", halves(1, false)),
            AnyChannel::new("G", halves(0, true)),
            AnyChannel::new("R", halves(0, false)),
            AnyChannel::new("Z", FlatSamples::F32(depths)),
        ];
        if self.options.ids {
            let ids = |word: usize| FlatSamples::U32(pixels().map(|w| w[word]).collect());
            channels.push(AnyChannel::new("id.leaf", ids(3)));
            channels.push(AnyChannel::new("id.tree", ids(4)));
        }
        let layer = ExrLayer::new(
            (self.size.0 as usize, self.size.1 as usize),
            LayerAttributes::default(),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(channels.into_iter().collect()),
        );
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .to_buffered(&mut bytes)
            .context("cannot encode the EXR")?;
        write_atomic(path, |file| Ok(std::io::Write::write_all(file, bytes.get_ref())?))
    }
}
