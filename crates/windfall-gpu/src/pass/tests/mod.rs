//! The shipped shaders against their CPU references.

mod hosts;
mod light;
mod lists;
mod loose;
mod projections;
mod quads;

use crate::scene::falls::Bin;
use crate::view::state::ViewBuffers;
use crate::{
    Falls, Forest, Moment, Options, Picture, Recording, Renderer, TreeId, TreeModel, View,
    ViewState,
};
use glam::DVec3;
use std::sync::OnceLock;
use windfall_core::forest::Forest as Placed;
use windfall_core::tree::Tree;

/// A device and a renderer of pictures: one for all tests.
struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
}

impl Gpu {
    fn get() -> &'static Self {
        static GPU: OnceLock<Gpu> = OnceLock::new();
        GPU.get_or_init(|| {
            let (device, queue) = windfall_testing::device();
            let options = Options::picture(wgpu::TextureFormat::Rgba8UnormSrgb);
            Self { renderer: Renderer::new(&device, &options).unwrap(), device, queue }
        })
    }

    fn read(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        windfall_testing::read(&self.device, &self.queue, buffer)
    }

    fn words(&self, buffer: &wgpu::Buffer) -> Vec<u32> {
        bytemuck::pod_collect_to_vec(&self.read(buffer))
    }
}

/// A forest and a view of it, whose buffers are looked into.
struct Watched {
    forest: Forest,
    ids: Vec<TreeId>,
    models: Vec<TreeModel>,
    state: ViewState,
}

impl Watched {
    fn new(gpu: &Gpu, origin: DVec3, trees: &[Tree], placed: &Placed, falls: Falls) -> Self {
        let upload = |tree: &Tree| TreeModel::new(&gpu.device, &gpu.queue, tree).unwrap();
        Self::of_models(gpu, origin, trees.iter().map(upload).collect(), placed, falls)
    }

    fn of_models(
        gpu: &Gpu,
        origin: DVec3,
        models: Vec<TreeModel>,
        placed: &Placed,
        falls: Falls,
    ) -> Self {
        let mut forest = Forest::new(&gpu.device, origin, placed.terrain.clone(), falls).unwrap();
        let ids = forest.plant(&models, &placed.instances).unwrap();
        Self { state: gpu.renderer.view(&forest), forest, ids, models }
    }

    /// Records a picture of a moment, and returns it.
    fn record(
        &mut self,
        gpu: &Gpu,
        time: f64,
        view: &View,
        size: (u32, u32),
    ) -> (wgpu::CommandEncoder, wgpu::Texture) {
        let targets = gpu.renderer.targets(size.0, size.1).unwrap();
        let texture = windfall_testing::picture(&gpu.device, size);
        let output = &texture.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(&gpu.queue, &mut encoder);
        let Self { forest, state, .. } = self;
        gpu.renderer.advance(&mut recording, forest, Moment::of(time, view)).unwrap();
        let picture = Picture { targets: &targets, output, layers: &mut [] };
        gpu.renderer.render(&mut recording, forest, state, view, picture).unwrap();
        (encoder, texture)
    }

    /// Draws a picture of a moment.
    fn draw(&mut self, gpu: &Gpu, time: f64, view: &View, size: (u32, u32)) -> wgpu::Texture {
        let (encoder, texture) = self.record(gpu, time, view, size);
        gpu.queue.submit([encoder.finish()]);
        texture
    }

    /// Draws small leaves as meshes from now on.
    fn without_quads(&mut self, gpu: &Gpu, view: &View) {
        self.draw(gpu, 0.0, view, (8, 8));
        self.state.buffers.as_mut().unwrap().quads = None;
    }

    fn buffers(&self) -> &ViewBuffers {
        self.state.buffers.as_ref().unwrap()
    }

    fn bins(&self) -> &[Bin] {
        &self.forest.buffers().unwrap().loose.streams.bins
    }
}
