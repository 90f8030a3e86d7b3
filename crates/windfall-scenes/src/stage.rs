//! From a scene to what the renderer takes. A scene's choices become the renderer's types here alone.

use crate::{
    CameraKey, Culling, Elimination, EventEntry, LandingSearch, QualityPreset, Scene, Source,
    Strategy, TreeEntry,
};
use glam::{DVec2, DVec3, Vec2};
use windfall_core::forest::{Forest, KeepOut, Placement, Terrain};
use windfall_core::rng::hash;
use windfall_core::shed::Shedding;
use windfall_core::simplify::{PruneOrder, Simplification};
use windfall_core::tree::Tree;
use windfall_core::wind::Wind;
use windfall_core::{InputError, InputErrorKind};
use windfall_gpu::{Camera, DebugView, Falls, Light, Sky, Trail, View};
use windfall_papers::LeafOcclusion;
use windfall_tree::{GrowOptions, ImportOptions, Species, set_prune_order};

/// A scene with its models grown or read and its trees placed.
#[derive(Debug, Clone)]
pub struct Stage {
    /// The tree models.
    pub trees: Vec<Tree>,
    /// The terrain and the instances of those models.
    pub forest: Forest,
    /// How their leaves fall.
    pub falls: Falls,
    /// Phase of autumn, 0 late summer to 1 bare.
    pub season: f32,
    /// Where the poses of falling leaves are computed.
    pub strategy: Strategy,
    /// When landed leaves become static geometry.
    pub elimination: Elimination,
    /// Leaves that [`Elimination::Progressive`] tests in a frame.
    pub elimination_per_frame: u32,
    /// How leaves in the air that are not seen are skipped for some frames, if they are.
    pub leaf_occlusion: Option<LeafOcclusion>,
    /// Who looks for the place where a leaf lands.
    pub landing_search: LandingSearch,
    /// Leaves that detach at a moment of their own.
    pub events: Vec<EventEntry>,
}

impl Stage {
    /// Checks the scene's events against the trees that were planted. `file` is the scene's name in
    /// errors.
    ///
    /// # Errors
    ///
    /// The first event of a tree or leaf that there is not.
    pub fn check(&self, file: &str) -> Result<(), InputError> {
        for (i, event) in self.events.iter().enumerate() {
            self.check_event(event).map_err(|cause| {
                let place = format!("events[{i}]");
                InputError::new(file, place, InputErrorKind::OutOfRange, cause)
            })?;
        }
        Ok(())
    }

    pub(crate) fn check_event(&self, event: &EventEntry) -> Result<(), String> {
        let EventEntry { tree, leaf, .. } = *event;
        let Some(planted) = self.forest.instances.get(tree as usize) else {
            let count = self.forest.instances.len();
            return Err(format!("tree {tree} is not one of the {count} of the forest, from 0"));
        };
        let count = self.trees[planted.model as usize].foliage.leaves.len();
        if leaf as usize >= count {
            return Err(format!("leaf {leaf} is not one of the {count} of tree {tree}, from 0"));
        }
        Ok(())
    }
}

/// A model of a scene, and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Model<'a> {
    /// A tree that is grown.
    Species {
        /// The species.
        species: Species,
        /// Its seed.
        seed: u32,
        /// How it is grown.
        options: GrowOptions,
    },
    /// A tree that is read.
    File {
        /// The file, as the scene names it.
        file: &'a str,
        /// How it is read.
        options: ImportOptions,
    },
}

impl Scene {
    /// Grows and places the scene's trees, one after the other. `read` is asked for the models of files, with the name
    /// as the scene gives it. Whether the events are of these trees, [`Stage::check`] says.
    ///
    /// A program that loads trees at the same time, or from a cache, makes them of [`Scene::models`], and then
    /// [`Scene::place`] places them.
    ///
    /// # Errors
    ///
    /// Those of `read`.
    ///
    /// # Panics
    ///
    /// If the scene would not pass [`Scene::check`].
    pub fn build<E>(
        &self,
        mut read: impl FnMut(&str, &TreeEntry) -> Result<Tree, E>,
    ) -> Result<Stage, E> {
        let mut trees = Vec::new();
        for (entry, model) in self.models_of_entries() {
            trees.push(match model {
                Model::Species { species, seed, options } => species.grow_as(seed, &options),
                Model::File { file, options } => {
                    let mut tree = read(file, &self.trees[entry])?;
                    if let Some(height) = options.height {
                        tree.set_height(height);
                    }
                    if let Some((order, seed)) = options.prune_order {
                        set_prune_order(&mut tree.foliage, order, seed);
                    }
                    tree
                }
            });
        }
        Ok(self.place(trees))
    }

    /// The scene's models: what [`Scene::place`] takes, in this order.
    ///
    /// # Panics
    ///
    /// If the scene would not pass [`Scene::check`].
    pub fn models(&self) -> Vec<Model<'_>> {
        self.models_of_entries().into_iter().map(|(_, model)| model).collect()
    }

    /// Each model, and the number of its entry.
    fn models_of_entries(&self) -> Vec<(usize, Model<'_>)> {
        // Models come in random order.
        let order = (self.prune_order != PruneOrder::Random).then_some(self.prune_order);
        let mut models = Vec::new();
        for (i, entry) in self.trees.iter().enumerate() {
            match &entry.source {
                Source::Species(name) => {
                    let species = species(name);
                    let key = hash(self.seed, 0x7ee5 + i as u32);
                    let options = GrowOptions {
                        height: entry.height,
                        prune_order: order.map(|order| (order, hash(self.seed, 5))),
                        ..GrowOptions::default()
                    };
                    models.extend((0..entry.variants).map(|variant| {
                        (i, Model::Species { species, seed: hash(key, variant), options })
                    }));
                }
                Source::File(file) => {
                    // The seed of baked trees, which need not be put in order again.
                    let options = ImportOptions {
                        prune_order: order.map(|order| (order, ImportOptions::PRUNE_SEED)),
                        ..entry.import_options()
                    };
                    models.push((i, Model::File { file, options }));
                }
            }
        }
        models
    }

    /// Places the scene's trees, which were made of [`Scene::models`].
    ///
    /// # Panics
    ///
    /// If the scene would not pass [`Scene::check`], or `trees` are not as many as the models.
    pub fn place(&self, mut trees: Vec<Tree>) -> Stage {
        let models = self.models_of_entries();
        assert_eq!(trees.len(), models.len(), "a tree for each model of the scene");
        let mut weights = Vec::new();
        for (tree, (entry, _)) in trees.iter_mut().zip(&models) {
            let entry = &self.trees[*entry];
            if let Some(name) = &entry.palette {
                tree.foliage.palette = Some(species(name).params().palette);
            }
            weights.push(entry.weight / entry.variants as f32);
        }
        let placement = Placement {
            trees: self.count,
            spacing: self.spacing.unwrap_or_else(|| default_spacing(&trees)),
            keep_out: self
                .keep_out
                .iter()
                .map(|k| KeepOut { from: on_ground(k.from), to: on_ground(k.to), radius: k.radius })
                .collect(),
            scale: self.scale,
            season_spread: self.season_spread,
            seed: hash(self.seed, 2),
        };
        let extent = (2.4 * placement.radius() + 120.0).ceil();
        let ground = self.terrain;
        let terrain = if ground.slope == (0.0, 0.0) {
            Terrain::rolling(extent, ground.relief, hash(self.seed, 3))
        } else {
            Terrain::slope(Vec2::from(ground.slope), extent)
        };
        Stage {
            trees,
            forest: placement.place(terrain, &weights),
            falls: self.falls(),
            season: self.season,
            strategy: self.strategy,
            elimination: self.elimination,
            elimination_per_frame: self.elimination_per_frame,
            leaf_occlusion: self.leaf_occlusion.then(|| self.leaf_occlusion_rules.into()),
            landing_search: self.landing_search,
            events: self.events.clone(),
        }
    }

    /// How leaves fall: the wind and shedding of the scene, and the built-in paths ([`Stage::fall_by`]).
    pub fn falls(&self) -> Falls {
        let wind = self.wind;
        let mut falls = Falls {
            wind: Wind::new(
                wind.speed,
                wind.heading.to_radians(),
                wind.gustiness,
                hash(self.seed, 4),
            ),
            capacity: self.loose_leaves,
            variation: self.variation.variation(),
            settings: self.fall.settings(),
            ..Falls::default()
        };
        if let Some(s) = self.shedding {
            falls.shedding = Shedding {
                start: s.start,
                duration: s.duration,
                peak: s.peak,
                tree_spread: s.tree_spread,
                burst: s.burst,
            };
        } else {
            (falls.shedding, falls.capacity) = (Shedding::never(), 0);
        }
        falls
    }

    /// The view at a moment. Times outside the camera's keys keep its first or last. A picture of the sky
    /// ([`crate::SkyEntry::picture`]) is for the caller to read: the second field of [`Light::Sky`].
    pub fn view(&self, time: f64, terrain: &Terrain) -> View {
        let above = |at: DVec3| {
            let ground = terrain.height(at.x as f32, at.z as f32);
            at + DVec3::Y * f64::from(ground)
        };
        let (eye, target, fov) = self.camera_at(time);
        let sky = Sky {
            sun_azimuth: self.sky.azimuth.to_radians(),
            sun_elevation: self.sky.elevation.to_radians(),
            turbidity: self.sky.turbidity,
            haze: self.sky.haze,
            clouds: self.sky.clouds,
            exposure: self.sky.exposure,
        };
        View {
            camera: Camera::look_at(above(eye), above(target), fov.to_radians(), 0.1),
            light: Light::Sky(sky, None),
            meadow: self.terrain.meadow,
            trails: self.trails(),
            transparent_sky: false,
            shadows: self.shadows,
            show: DebugView::default(),
            detail: self.detail,
            shadow_detail: self.shadow_detail,
            shadow_period: 1,
            culling: self.culling.into(),
            quality: self.quality_of_view(),
        }
    }

    /// What its pictures may cost: its preset, but for what it says by itself.
    pub fn quality_of_view(&self) -> windfall_gpu::Quality {
        let preset = windfall_gpu::Quality::from(self.quality);
        let ambient_occlusion = self.ambient_occlusion.unwrap_or(preset.ambient_occlusion);
        windfall_gpu::Quality { ambient_occlusion, ..preset }
    }

    fn trails(&self) -> [Trail; 4] {
        let mut trails = [Trail::default(); 4];
        for (trail, strip) in trails.iter_mut().zip(&self.trails) {
            *trail = Trail {
                from: on_ground(strip.from),
                to: on_ground(strip.to),
                radius: strip.radius,
            };
        }
        trails
    }

    /// The moment of a frame, clamped to the scene's frames, seconds.
    pub fn frame_time(&self, frame: u32) -> f64 {
        f64::from(frame.clamp(self.frames.0, self.frames.1)) / f64::from(self.fps)
    }

    /// Eye, target and field of view, degrees, with heights above the ground: Catmull-Rom through the
    /// keys.
    fn camera_at(&self, time: f64) -> (DVec3, DVec3, f32) {
        let keys = &self.camera;
        let next = keys.partition_point(|k| k.time <= time).clamp(1, keys.len().max(2) - 1);
        let key = |i: usize| &keys[i.min(keys.len() - 1)];
        let (before, a, b, after) =
            (key(next.saturating_sub(2)), key(next - 1), key(next), key(next + 1));
        let span = b.time - a.time;
        let s = if span > 0.0 { ((time - a.time) / span).clamp(0.0, 1.0) } else { 0.0 };
        let along = |get: fn(&CameraKey) -> (f64, f64, f64)| {
            let [p, a, b, q] = [before, a, b, after].map(|k| DVec3::from(get(k)));
            let v = a * 2.0
                + (b - p) * s
                + (p * 2.0 - a * 5.0 + b * 4.0 - q) * s * s
                + (a * 3.0 - p - b * 3.0 + q) * s * s * s;
            v * 0.5
        };
        (along(|k| k.eye), along(|k| k.target), a.fov + (b.fov - a.fov) * s as f32)
    }
}

/// Simplification of what casts shadows, where a scene says nothing of it.
pub(crate) fn shadow_detail() -> Simplification {
    View::SHADOW_DETAIL
}

impl From<Culling> for windfall_gpu::Culling {
    fn from(culling: Culling) -> Self {
        match culling {
            Culling::Off => Self::Off,
            Culling::ClipSpace => Self::ClipSpace,
            Culling::Sphere => Self::Sphere,
            Culling::Occlusion => Self::Occlusion,
        }
    }
}

impl From<QualityPreset> for windfall_gpu::Quality {
    fn from(preset: QualityPreset) -> Self {
        match preset {
            QualityPreset::Low => Self::LOW,
            QualityPreset::Medium => Self::MEDIUM,
            QualityPreset::High => Self::HIGH,
        }
    }
}

/// A place in x and z, as the models take it.
fn on_ground(place: (f64, f64)) -> Vec2 {
    DVec2::from(place).as_vec2()
}

fn species(name: &str) -> Species {
    name.parse().expect("a checked scene names only species that exist")
}

/// Crowns that touch: three quarters of their mean width.
fn default_spacing(trees: &[Tree]) -> f32 {
    let width = |tree: &Tree| {
        let (low, high) = tree.bounds();
        let size = high - low;
        0.5 * (size.x + size.z)
    };
    let mean = trees.iter().map(width).sum::<f32>() / trees.len().max(1) as f32;
    (0.75 * mean).max(0.5)
}

#[cfg(test)]
mod tests {
    use super::Model;
    use crate::{CameraKey, Culling, EventEntry, QualityPreset, Scene, Source, TreeEntry, named};
    use std::convert::Infallible;
    use windfall_core::forest::Terrain;
    use windfall_core::simplify::PruneOrder;
    use windfall_tree::prepare::visible_areas;
    use windfall_tree::{Species, set_prune_order};

    /// A scene with a camera that moves along x and looks along -z.
    fn moving(keys: &[(f64, f64)]) -> Scene {
        let mut scene = named("autumn").unwrap();
        let key = |&(time, x): &(f64, f64)| CameraKey {
            time,
            eye: (x, 2.0, 0.0),
            target: (x, 2.0, -5.0),
            fov: 40.0 + time as f32,
        };
        scene.camera = keys.iter().map(key).collect();
        scene
    }

    #[test]
    fn the_camera_passes_through_its_keys_and_stands_still_beyond_them() {
        let scene = moving(&[(1.0, 0.0), (2.0, 4.0), (4.0, 6.0)]);
        for (time, x, fov) in [
            (-5.0, 0.0, 41.0),
            (1.0, 0.0, 41.0),
            (2.0, 4.0, 42.0),
            (4.0, 6.0, 44.0),
            (99.0, 6.0, 44.0),
        ] {
            let (eye, target, degrees) = scene.camera_at(time);
            assert!((eye.x - x).abs() < 1e-9, "{time}: {eye}");
            assert!((target - eye).abs_diff_eq(glam::DVec3::new(0.0, 0.0, -5.0), 1e-9), "{target}");
            assert!((degrees - fov).abs() < 1e-4, "{time}: {degrees}");
        }
        let middle = scene.camera_at(1.5).0.x;
        assert!((1.0..3.0).contains(&middle), "{middle}");
    }

    /// The smallest step of `f32` is 8 mm at 100 km, and 62 ms at ten days.
    #[test]
    fn the_camera_moves_smoothly_a_hundred_kilometres_away_after_ten_days() {
        let scene = moving(&[(864_000.0, 99_000.0), (864_001.0, 99_000.001)]);
        // Two keys, each doubled beyond the ends: x = 1 mm (s + 3 s² - 2 s³) / 2.
        for (s, millimetres) in [(0.0, 0.0), (0.25, 0.203_125), (0.5, 0.5), (1.0, 1.0)] {
            let moved = scene.camera_at(864_000.0 + s).0.x - 99_000.0;
            assert!((moved * 1e3 - millimetres).abs() < 1e-6, "{s}: {moved}");
        }
    }

    #[test]
    fn the_camera_stands_on_the_ground() {
        let scene = moving(&[(0.0, 30.0)]);
        let slope = Terrain::slope(glam::Vec2::new(0.5, 0.0), 200.0);
        let height = f64::from(slope.height(30.0, 0.0));
        assert!(height > 5.0, "{height}");
        let view = scene.view(0.0, &slope);
        assert!((view.camera.eye.y - (height + 2.0)).abs() < 1e-4, "{}", view.camera.eye);
    }

    /// Twice: in the renderer for who uses it alone, here for who writes a scene.
    #[test]
    fn what_a_scene_leaves_out_is_the_renderers_default() {
        let scene = named("autumn").unwrap();
        assert_eq!(windfall_gpu::Culling::from(scene.culling), windfall_gpu::Culling::default());
        assert_eq!(windfall_gpu::Quality::from(scene.quality), windfall_gpu::Quality::default());
    }

    #[test]
    fn the_choices_of_a_scene_reach_the_renderer() {
        let mut scene = named("lone-oak").unwrap();
        (scene.culling, scene.quality) = (Culling::ClipSpace, QualityPreset::Low);
        (scene.detail.h, scene.shadow_detail.h) = (0.7, 0.6);
        scene.ambient_occlusion = Some(false);
        let view = scene.view(864_000.001, &Terrain::flat());
        assert_eq!(view.culling, windfall_gpu::Culling::ClipSpace);
        let low = windfall_gpu::Quality::LOW;
        assert_eq!(view.quality, windfall_gpu::Quality { ambient_occlusion: false, ..low });
        assert_eq!((view.detail.h, view.shadow_detail.h), (0.7, 0.6));
    }

    #[test]
    fn the_prune_order_reaches_every_model() {
        let mut scene = named("lone-oak").unwrap();
        scene.count = 0;
        let build = |scene: &Scene| scene.build(|_, _| -> Result<_, Infallible> { unreachable!() });
        scene.prune_order = PruneOrder::BlueNoise;
        let spread = build(&scene).unwrap();
        scene.prune_order = PruneOrder::Importance;
        let sorted = build(&scene).unwrap();
        for (spread, sorted) in spread.trees.iter().zip(&sorted.trees) {
            let [spread, sorted] = [spread, sorted]
                .map(|tree| visible_areas(&tree.foliage).is_sorted_by(|a, b| a >= b));
            assert!(sorted && !spread);
        }
    }

    #[test]
    fn trees_that_a_program_loads_itself_are_those_that_are_built() {
        let mut scene = named("lone-oak").unwrap();
        scene.trees[0].height = Some(5.0);
        let mut birch = TreeEntry::new(Source::Species("birch".into()));
        (birch.variants, birch.palette) = (1, Some("maple".into()));
        scene.trees.push(birch);
        scene.trees.push(TreeEntry::new(Source::File("a.glb".into())));
        scene.prune_order = PruneOrder::Importance;
        let of_file = Species::Aspen.grow_with(1, 50);
        let Ok(built) = scene.build(|file, _| -> Result<_, Infallible> {
            assert_eq!(file, "a.glb");
            Ok(of_file.clone())
        });
        let made = scene.models().into_iter().map(|model| match model {
            Model::Species { species, seed, options } => species.grow_as(seed, &options),
            Model::File { file, options } => {
                assert_eq!(file, "a.glb");
                let mut tree = of_file.clone();
                let (order, seed) = options.prune_order.unwrap();
                set_prune_order(&mut tree.foliage, order, seed);
                tree
            }
        });
        let placed = scene.place(made.collect());
        assert_eq!(built.trees.len(), scene.models().len());
        assert_eq!(format!("{:?}", placed.trees), format!("{:?}", built.trees));
        assert_eq!(placed.forest.instances, built.forest.instances);
        assert_eq!(
            placed.trees.iter().find(|tree| tree.name == "birch").unwrap().foliage.palette,
            Some(Species::Maple.params().palette)
        );
    }

    #[test]
    fn events_of_what_is_not_there_are_named() {
        let mut scene = named("lone-oak").unwrap();
        let event = |tree, leaf| EventEntry { tree, leaf, time: 1.0 };
        let check = |scene: &Scene| {
            let build = scene.build(|_, _| -> Result<_, Infallible> { unreachable!() });
            build.unwrap().check("s.ron").map_err(|e| e.to_string())
        };
        scene.events = vec![event(0, 5)];
        assert_eq!(check(&scene), Ok(()));
        scene.events.push(event(1, 5));
        let error = check(&scene).unwrap_err();
        assert!(error.starts_with("s.ron: events[1]: tree 1 is not one of the 1"), "{error}");
        scene.events[1] = event(0, 9_999_999);
        let error = check(&scene).unwrap_err();
        assert!(error.starts_with("s.ron: events[1]: leaf 9999999 is not"), "{error}");
    }

    #[test]
    fn frames_outside_the_scene_are_clamped() {
        let mut scene = named("autumn").unwrap();
        (scene.frames, scene.fps) = ((10, 20), 10.0);
        assert_eq!([0, 10, 15, 99].map(|f| scene.frame_time(f)), [1.0, 1.0, 1.5, 2.0]);
        // Ten days on, at a rate that `f32` has exactly.
        (scene.frames, scene.fps) = ((0, u32::MAX), 60.0);
        assert_eq!(scene.frame_time(51_840_001), 864_000.0 + 1.0 / 60.0);
    }
}
