//! From a scene to what the renderer takes.

use crate::{CameraKey, Scene, Source, TreeEntry};
use glam::{Vec2, Vec3};
use windfall_core::forest::{Forest, KeepOut, Placement, Terrain};
use windfall_core::rng::hash;
use windfall_core::shed::Shedding;
use windfall_core::simplify::PruneOrder;
use windfall_core::tree::Tree;
use windfall_core::tree::species::Species;
use windfall_core::wind::Wind;
use windfall_core::{InputError, InputErrorKind};
use windfall_gpu::{Camera, DetachEvent, Falls, Show, Sky, Trail, View};

/// A scene with its models grown or read and its trees placed.
#[derive(Debug, Clone)]
pub struct Stage {
    /// The tree models.
    pub trees: Vec<Tree>,
    /// The terrain and the instances of those models.
    pub forest: Forest,
    /// How their leaves fall.
    pub falls: Falls,
}

impl Stage {
    /// Checks the scene's events against the trees that were planted. `file` is the scene's name in
    /// errors.
    ///
    /// # Errors
    ///
    /// The first event of a tree or leaf that there is not, or of more than
    /// [`Falls::EVENT_TREES`] trees.
    pub fn check(&self, file: &str) -> Result<(), InputError> {
        self.falls.check_events(&self.trees, &self.forest).map_err(|error| {
            let place = format!("events[{}]", error.index);
            InputError::new(file, place, InputErrorKind::OutOfRange, error.cause)
        })
    }
}

impl Scene {
    /// Grows and places the scene's trees. `read` is asked for the models of files, with the name
    /// as the scene gives it. Whether the events are of these trees, [`Stage::check`] says.
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
        let mut weights = Vec::new();
        let prune_order = self.prune_order.parse().unwrap_or_default();
        for (i, entry) in self.trees.iter().enumerate() {
            let variants = match &entry.source {
                Source::Species(name) => {
                    let species = species(name);
                    let key = hash(self.seed, 0x7ee5 + i as u32);
                    (0..entry.variants).map(|v| species.grow(hash(key, v))).collect()
                }
                Source::File(name) => vec![read(name, entry)?],
            };
            for mut tree in variants {
                if let Some(height) = entry.height {
                    tree.set_height(height);
                }
                if let Some(name) = &entry.palette {
                    tree.foliage.palette = Some(species(name).params().palette);
                }
                // Models come in random order.
                if prune_order != PruneOrder::Random {
                    tree.foliage.set_prune_order(prune_order, hash(self.seed, 5));
                }
                weights.push(entry.weight / entry.variants as f32);
                trees.push(tree);
            }
        }
        let placement = Placement {
            trees: self.count,
            spacing: self.spacing.unwrap_or_else(|| default_spacing(&trees)),
            keep_out: self
                .keep_out
                .iter()
                .map(|k| KeepOut {
                    from: Vec2::from(k.from),
                    to: Vec2::from(k.to),
                    radius: k.radius,
                })
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
        let falls = self.falls(&trees);
        Ok(Stage { trees, forest: placement.place(terrain, &weights), falls })
    }

    fn falls(&self, trees: &[Tree]) -> Falls {
        let wind = self.wind;
        let mut falls = Falls {
            wind: Wind::new(
                wind.speed,
                wind.heading.to_radians(),
                wind.gustiness,
                hash(self.seed, 4),
            ),
            capacity: self.loose_leaves,
            strategy: self.strategy.parse().unwrap_or_default(),
            elimination: self.elimination.parse().unwrap_or_default(),
            leaf_occlusion: self.leaf_occlusion,
            events: self
                .events
                .iter()
                .map(|e| DetachEvent { instance: e.tree, leaf: e.leaf, time: e.time })
                .collect(),
            ..Falls::default()
        };
        falls.groups = trees.iter().map(|tree| falls.group_for(tree)).collect();
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

    /// The view at a moment. Times outside the camera's keys keep its first or last.
    pub fn view(&self, time: f32, terrain: &Terrain) -> View {
        let above = |(x, y, z): (f32, f32, f32)| Vec3::new(x, terrain.height(x, z) + y, z);
        let (eye, target, fov) = self.camera_at(time);
        View {
            camera: Camera {
                eye: above(eye),
                target: above(target),
                fov_y: fov.to_radians(),
                near: 0.1,
            },
            sky: Sky {
                sun_azimuth: self.sky.azimuth.to_radians(),
                sun_elevation: self.sky.elevation.to_radians(),
                turbidity: self.sky.turbidity,
                haze: self.sky.haze,
                clouds: self.sky.clouds,
                exposure: self.sky.exposure,
            },
            time,
            season: self.season,
            meadow: self.terrain.meadow,
            trails: self.trails(),
            shadows: self.shadows,
            show: Show::default(),
            detail: self.detail.simplification(),
            shadow_detail: self.shadow_detail.simplification(),
            culling: self.culling.parse().unwrap_or_default(),
            quality: self.quality.parse().unwrap_or_default(),
        }
    }

    fn trails(&self) -> [Trail; 4] {
        let mut trails = [Trail::default(); 4];
        for (trail, strip) in trails.iter_mut().zip(&self.trails) {
            let (from, to) = (Vec2::from(strip.from), Vec2::from(strip.to));
            *trail = Trail { from, to, radius: strip.radius };
        }
        trails
    }

    /// The moment of a frame, clamped to the scene's frames.
    pub fn frame_time(&self, frame: u32) -> f32 {
        frame.clamp(self.frames.0, self.frames.1) as f32 / self.fps
    }

    /// Catmull-Rom through the keys.
    fn camera_at(&self, time: f32) -> ((f32, f32, f32), (f32, f32, f32), f32) {
        let keys = &self.camera;
        let next = keys.partition_point(|k| k.time <= time).clamp(1, keys.len().max(2) - 1);
        let key = |i: usize| &keys[i.min(keys.len() - 1)];
        let (before, a, b, after) =
            (key(next.saturating_sub(2)), key(next - 1), key(next), key(next + 1));
        let span = b.time - a.time;
        let s = if span > 0.0 { ((time - a.time) / span).clamp(0.0, 1.0) } else { 0.0 };
        let along = |get: fn(&CameraKey) -> (f32, f32, f32)| {
            let [p, a, b, q] = [before, a, b, after].map(|k| Vec3::from(get(k)));
            let v = a * 2.0
                + (b - p) * s
                + (p * 2.0 - a * 5.0 + b * 4.0 - q) * s * s
                + (a * 3.0 - p - b * 3.0 + q) * s * s * s;
            (v * 0.5).into()
        };
        (along(|k| k.eye), along(|k| k.target), a.fov + (b.fov - a.fov) * s)
    }
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
    use crate::{CameraKey, EventEntry, Scene, named};
    use std::convert::Infallible;
    use windfall_core::forest::Terrain;
    use windfall_core::simplify::{PruneOrder, visible_areas};

    #[test]
    fn the_camera_passes_through_its_keys_and_stands_still_beyond_them() {
        let mut scene = named("autumn").unwrap();
        let key =
            |time, x| CameraKey { time, eye: (x, 2.0, 0.0), target: (x, 2.0, -5.0), fov: 40.0 + x };
        scene.camera = vec![key(1.0, 0.0), key(2.0, 4.0), key(4.0, 6.0)];
        let ground = Terrain::flat();
        for (time, x) in [(-5.0, 0.0), (1.0, 0.0), (2.0, 4.0), (4.0, 6.0), (99.0, 6.0)] {
            let camera = scene.view(time, &ground).camera;
            assert!((camera.eye.x - x).abs() < 1e-5, "{time}: {}", camera.eye);
            assert!((camera.fov_y.to_degrees() - 40.0 - x).abs() < 1e-3);
        }
        let middle = scene.view(1.5, &ground).camera.eye.x;
        assert!((1.0..3.0).contains(&middle), "{middle}");
    }

    #[test]
    fn the_prune_order_reaches_every_model() {
        let mut scene = named("lone-oak").unwrap();
        scene.count = 0;
        let build = |scene: &Scene| scene.build(|_, _| -> Result<_, Infallible> { unreachable!() });
        let random = build(&scene).unwrap();
        scene.prune_order = PruneOrder::Importance.to_string();
        let sorted = build(&scene).unwrap();
        for (random, sorted) in random.trees.iter().zip(&sorted.trees) {
            let [random, sorted] = [random, sorted]
                .map(|tree| visible_areas(&tree.foliage).is_sorted_by(|a, b| a >= b));
            assert!(sorted && !random);
        }
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
    }
}
