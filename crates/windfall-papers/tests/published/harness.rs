//! What the tests of this crate draw with: one device per test file.

use glam::{DVec3, Vec3};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use windfall_core::forest::Terrain;
use windfall_gpu::{
    Camera, Capture, Falls, Forest, Layer, Moment, Options, Picture, PictureTargets, Recording,
    Renderer, TreeModel, TreePlace, View, ViewState, wgpu,
};
use windfall_papers::{
    LeafOcclusion, ListOptions, PassOptions, PublishedFalls, PublishedPasses, Strategy,
};
use windfall_testing::{device, picture};

pub const SIZE: (u32, u32) = (256, 144);

pub struct Harness {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub renderer: Renderer,
    texture: wgpu::Texture,
    targets: PictureTargets,
    passes: Vec<[Arc<PublishedPasses>; 2]>,
}

pub static HARNESS: LazyLock<Harness> = LazyLock::new(|| {
    let (device, queue) = device();
    let texture = picture(&device, SIZE);
    let renderer = Renderer::new(&device, &Options::picture(texture.format())).unwrap();
    let passes = |strategy| {
        let plain = PassOptions::new(strategy);
        let occlusion = Some(LeafOcclusion::default());
        [plain, PassOptions { occlusion, ..plain }]
            .map(|options| Arc::new(PublishedPasses::new(&device, options)))
    };
    Harness {
        passes: Strategy::ALL.map(passes).to_vec(),
        targets: renderer.targets(SIZE.0, SIZE.1).unwrap(),
        renderer,
        texture,
        device,
        queue,
    }
});

/// One drawing at a time: there is one texture.
static TURN: Mutex<()> = Mutex::new(());

impl Harness {
    pub fn passes(&self, strategy: Strategy, leaf_occlusion: bool) -> &Arc<PublishedPasses> {
        let of_strategy = self.passes.iter().find(|p| p[0].strategy() == strategy).unwrap();
        &of_strategy[usize::from(leaf_occlusion)]
    }
}

/// A forest and a view of it, drawn by the renderer alone or by a strategy.
pub struct Stage {
    pub forest: Forest,
    state: ViewState,
    pub leaves: Option<PublishedFalls>,
}

/// A moment and a view.
#[derive(Clone)]
pub struct Shot {
    pub time: f64,
    pub season: f32,
    pub view: View,
}

/// Models on a terrain, with where their trees stand.
pub struct Scene {
    pub models: Vec<TreeModel>,
    pub terrain: Terrain,
    pub origin: DVec3,
    pub places: Vec<(usize, TreePlace)>,
    pub falls: Falls,
}

impl Scene {
    /// Drawn by the renderer's compute path.
    pub fn compute(&self) -> Stage {
        self.stage(self.falls.clone())
    }

    /// Drawn by a strategy.
    pub fn published(&self, passes: &Arc<PublishedPasses>, options: ListOptions) -> Stage {
        let options = ListOptions { capacity: self.falls.capacity, ..options };
        let mut stage = self.stage(Falls { capacity: 0, ..self.falls.clone() });
        stage.leaves = Some(PublishedFalls::new(passes, &stage.forest, options).unwrap());
        stage
    }

    fn stage(&self, falls: Falls) -> Stage {
        let Harness { device, renderer, .. } = &*HARNESS;
        let mut forest = Forest::new(device, self.origin, self.terrain.clone(), falls).unwrap();
        for (model, place) in &self.places {
            forest.insert(&self.models[*model], *place).unwrap();
        }
        Stage { state: renderer.view(&forest), forest, leaves: None }
    }
}

impl Stage {
    /// The view's state.
    pub fn state(&self) -> &ViewState {
        &self.state
    }

    /// RGBA, rows from the top.
    pub fn paint(&mut self, shot: &Shot) -> Vec<u8> {
        self.paint_with(shot, |_, _| ()).0
    }

    /// The same, with something recorded after the picture.
    pub fn paint_with<T>(
        &mut self,
        shot: &Shot,
        after: impl FnOnce(&Self, &mut wgpu::CommandEncoder) -> T,
    ) -> (Vec<u8>, T) {
        let Harness { device, queue, texture, .. } = &*HARNESS;
        let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let mut encoder = device.create_command_encoder(&Default::default());
        self.record(shot, &mut encoder);
        let recorded = after(self, &mut encoder);
        let capture = Capture::encode(device, &mut encoder, texture);
        queue.submit([encoder.finish()]);
        capture.map();
        (windfall_testing::wait(device, || capture.take()).unwrap(), recorded)
    }

    /// Records a picture.
    pub fn record(&mut self, shot: &Shot, encoder: &mut wgpu::CommandEncoder) {
        let Harness { queue, renderer, texture, targets, .. } = &*HARNESS;
        let Self { forest, state, leaves } = self;
        let output = &texture.create_view(&Default::default());
        let mut recording = Recording::new(queue, encoder);
        forest.set_season(shot.season).unwrap();
        renderer.advance(&mut recording, forest, Moment::of(shot.time, &shot.view)).unwrap();
        let mut layers: Vec<&mut dyn Layer> = Vec::new();
        layers.extend(leaves.as_mut().map(|leaves| leaves as &mut dyn Layer));
        let picture = Picture { targets, output, layers: &mut layers };
        renderer.render(&mut recording, forest, state, &shot.view, picture).unwrap();
    }
}

/// Uploads a tree.
pub fn upload(tree: &windfall_core::tree::Tree) -> TreeModel {
    TreeModel::new(&HARNESS.device, &HARNESS.queue, tree).unwrap()
}

pub fn camera(eye: [f32; 3], target: [f32; 3]) -> Camera {
    let [eye, target] = [eye, target].map(|p| Vec3::from(p).as_dvec3());
    Camera::look_at(eye, target, 0.8, 0.1)
}
