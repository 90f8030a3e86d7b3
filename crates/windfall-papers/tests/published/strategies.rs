//! The published strategies draw the picture of the renderer's compute path, whatever was drawn before.

use crate::harness::{HARNESS, SIZE, Scene, Shot, camera, upload};
use glam::{DVec3, Vec2};
use std::sync::Arc;
use std::sync::LazyLock;
use windfall_core::forest::Terrain;
use windfall_core::path::PathSet;
use windfall_core::shed::Shedding;
use windfall_core::tree::{Image, Surface, Tree};
use windfall_core::wind::Wind;
use windfall_gpu::{DebugView, Falls, Forest, Light, Sky, TreeModel, TreePlace, View};
use windfall_papers::{
    Elimination, LandingSearch, ListOptions, PassOptions, PathData, PublishedError, PublishedFalls,
    PublishedPasses, Strategy,
};
use windfall_tree::Species;
use windfall_tree::prepare::simple_shapes;

/// Largest mean FLIP error of two pictures that are the same.
const SAME: f32 = 0.005;

/// Mean FLIP error, 0 for equal pictures to 1.
fn difference(a: &[u8], b: &[u8]) -> f32 {
    let image = |rgba: &[u8]| {
        let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        nv_flip::FlipImageRgb8::with_data(SIZE.0, SIZE.1, &rgb)
    };
    let error = nv_flip::flip(image(a), image(b), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    nv_flip::FlipPool::from_image(&error).mean()
}

/// A birch whose leaves are cards with a picture of a disc.
fn masked() -> Tree {
    let mut tree = Species::Birch.grow_with(4, 2000);
    let texel = |i: u32| {
        let (x, y) = ((i % 32) as f32 - 15.5, (i / 32) as f32 - 15.5);
        [200, 140, 40, if x.hypot(y) < 15.0 { 255 } else { 0 }]
    };
    let image = Image { width: 32, height: 32, rgba: (0..1024).flat_map(texel).collect() };
    tree.foliage.palette = None;
    for material in &mut tree.foliage.materials {
        material.surface = Surface::Texture(image.clone(), false);
        material.alpha_cutoff = Some(0.5);
    }
    tree.foliage.simple_shapes = simple_shapes(&tree.foliage);
    tree
}

static MODELS: LazyLock<Vec<TreeModel>> = LazyLock::new(|| {
    let trees = [Species::Birch.grow_with(1, 6000), Species::Maple.grow_with(2, 6000), masked()];
    trees.iter().map(upload).collect()
});

/// Three trees on a slope, in the wind, that shed so fast that many leaves fall and lie.
pub fn scene() -> Scene {
    let place = |model, x: f64, z: f64, seed| {
        let place = TreePlace::at(DVec3::new(x, 0.1 * x - 0.05 * z, z), seed);
        (model, TreePlace { yaw: 0.5 * seed as f32, ..place })
    };
    Scene {
        models: MODELS.clone(),
        terrain: Terrain::slope(Vec2::new(0.1, -0.05), 200.0),
        origin: DVec3::ZERO,
        places: vec![place(0, -4.0, 0.0, 1), place(1, 2.0, -3.0, 2), place(2, 6.0, 1.0, 3)],
        falls: Falls {
            shedding: Shedding {
                start: -14.0,
                duration: 46.0,
                tree_spread: 0.0,
                ..Shedding::default()
            },
            capacity: 6000,
            ..Falls::default()
        },
    }
}

pub fn shot(time: f64) -> Shot {
    let view = View::new(camera([3.0, 3.0, 16.0], [0.0, 3.0, 0.0]));
    Shot { time, season: 0.55, view }
}

#[test]
fn strategies_draw_the_picture_of_the_compute_path() {
    let scene = scene();
    let mut compute = scene.compute();
    let mut published = Strategy::ALL
        .map(|strategy| scene.published(HARNESS.passes(strategy, false), ListOptions::default()));
    let still = Falls { shedding: Shedding::never(), ..scene.falls.clone() };
    let mut still = Scene { falls: still, ..self::scene() }.compute();
    // The second moment is beyond the capacity: the oldest leaves have vanished. The third goes back.
    for (time, show) in [(2.0, DebugView::Final), (29.5, DebugView::Final), (1.0, DebugView::Loops)]
    {
        let at = |time| {
            let mut shot = shot(time);
            shot.view.show = show;
            shot
        };
        let reference = compute.paint(&at(time));
        for stage in &mut published {
            let error = difference(&reference, &stage.paint(&at(time)));
            let leaves = stage.leaves.as_ref().unwrap();
            let (strategy, counts) = (leaves.strategy(), leaves.counts());
            println!("{time} s: {strategy} differs by {error:.6}, {counts:?}");
            assert!(error < SAME, "{strategy} differs by {error} at {time} s");
            assert!(counts.falling > 500 && counts.landed > 300, "{counts:?}");
        }
        // The check can fail: leaves half a second later, and a forest whose leaves hang.
        let later = difference(&reference, &compute.paint(&at(time + 0.5)));
        let hanging = difference(&reference, &still.paint(&at(time)));
        println!("{time} s: half a second later {later:.6}, no leaf fallen {hanging:.6}");
        assert!(later > 2.0 * SAME && hanging > 2.0 * SAME, "{later} {hanging}");
    }
}

#[test]
fn counts_are_those_of_the_compute_path() {
    use windfall_gpu::CountReadback;
    let scene = scene();
    let mut compute = scene.compute();
    let mut vertex =
        scene.published(HARNESS.passes(Strategy::Vertex, false), ListOptions::default());
    for time in [3.0, 31.0] {
        let (_, count) = compute.paint_with(&shot(time), |stage, encoder| {
            CountReadback::encode(&HARNESS.device, encoder, &stage.forest, stage.state()).unwrap()
        });
        count.map();
        let reference = windfall_testing::wait(&HARNESS.device, || count.take()).unwrap();
        vertex.paint(&shot(time));
        let counts = vertex.leaves.as_ref().unwrap().counts();
        println!("{time} s: {counts:?}, {reference:?}");
        let apart = counts.falling.abs_diff(reference.falling.into());
        assert!(apart <= 3, "{} and {} in the air", counts.falling, reference.falling);
        let all = |falling: u64, landed: u64| falling + landed;
        let reference = all(reference.falling.into(), reference.landed.into());
        assert_eq!(all(counts.falling, counts.landed), reference, "{time} s");
        assert_eq!(counts.eliminated, counts.landed);
    }
}

#[test]
fn elimination_and_earlier_frames_make_no_difference() {
    let scene = scene();
    let at = |time, away| {
        let view = View::new(camera([3.0, 3.0, away], [0.0, 3.0, 0.0]));
        Shot { view, ..shot(time) }
    };
    for strategy in Strategy::ALL {
        let passes = HARNESS.passes(strategy, false);
        let with = |elimination| {
            scene.published(passes, ListOptions { elimination, ..ListOptions::default() })
        };
        let direct = with(Elimination::Off).paint(&at(6.0, 16.0));
        let compute = difference(&scene.compute().paint(&at(6.0, 16.0)), &direct);
        assert!(compute < SAME, "{strategy} differs by {compute}");
        for elimination in Elimination::ALL {
            let mut stage = with(elimination);
            // Forward, back and forward again, with leaves that are small and large in the view.
            let before =
                [(0.0, 16.0), (0.1, 60.0), (9.0, 3.0), (5.0, 16.0), (5.5, 1.0), (5.53, 40.0)];
            for (time, away) in before {
                stage.paint(&at(time, away));
            }
            let picture = stage.paint(&at(6.0, 16.0));
            let counts = stage.leaves.as_ref().unwrap().counts();
            assert_eq!(counts.eliminated > 0, elimination != Elimination::Off, "{elimination}");
            assert!(counts.landed > 0 && counts.falling > 0, "{counts:?}");
            // The order of leaves in a list decides between two at the same depth.
            let error = difference(&direct, &picture);
            println!("{strategy}, elimination {elimination}: {error:.6}");
            assert!(error < 0.001, "{strategy}, {elimination} differs by {error}");
        }
    }
}

/// VB 5: the shader looks for the landing, and the CPU for leaves that lie.
#[test]
fn landings_searched_in_the_shader_are_those_searched_ahead() {
    let scene = scene();
    let mut compute = scene.compute();
    for strategy in [Strategy::Vertex, Strategy::Fragment, Strategy::VertexBuffer] {
        let landing = LandingSearch::InShader;
        let options = PassOptions { landing, ..PassOptions::new(strategy) };
        let passes = Arc::new(PublishedPasses::new(&HARNESS.device, options));
        for elimination in Elimination::ALL {
            let options = ListOptions { elimination, ..ListOptions::default() };
            let mut stage = scene.published(&passes, options);
            for frame in 0..16 {
                let time = 3.0 + f64::from(frame) / 30.0;
                let mut shot = shot(time);
                // Where a leaf is, the CPU does not know: none is drawn in two triangles.
                shot.view.detail.leaf_pixels = 0.0;
                shot.view.shadows = false;
                shot.view.show = DebugView::Loops;
                let picture = stage.paint(&shot);
                if frame % 15 != 0 {
                    continue;
                }
                let error = difference(&compute.paint(&shot), &picture);
                let counts = stage.leaves.as_ref().unwrap().counts();
                println!("{strategy}, {elimination}, {time:.2} s: {error:.6}, {counts:?}");
                assert!(error < SAME, "{strategy}, {elimination}: {error} at {time} s");
                // Only those are known to lie that elimination has found.
                let known = if elimination == Elimination::Off { 0 } else { counts.eliminated };
                assert_eq!(counts.landed, known, "{strategy}, {elimination}");
                assert!(elimination == Elimination::Off || frame == 0 || counts.eliminated > 100);
            }
        }
    }
}

/// VB 3.3's textures have the samples that the table has.
#[test]
fn path_data_may_be_in_one_dimensional_textures() {
    let mut scene = scene();
    let paths = PathSet::new(scene.falls.paths.paths()[..1].to_vec()).unwrap();
    let all = std::mem::replace(&mut scene.falls.paths, paths);
    let of = |paths| {
        let options = PassOptions { paths, ..PassOptions::new(Strategy::Vertex) };
        Arc::new(PublishedPasses::new(&HARNESS.device, options))
    };
    let passes = [PathData::Table, PathData::OneDimensional].map(of);
    let mut stages =
        passes.each_ref().map(|passes| scene.published(passes, ListOptions::default()));
    for time in [2.0, 9.0] {
        let [table, textures] = stages.each_mut().map(|stage| stage.paint(&shot(time)));
        let error = difference(&table, &textures);
        println!("{time} s: {error:.7}");
        assert!(error < 1e-4, "{error} at {time} s");
        // The check can fail: a thirtieth of a second later, leaves are elsewhere.
        let later = difference(&table, &stages[1].paint(&shot(time + 1.0 / 30.0)));
        assert!(later > 1e-3, "{later} at {time} s");
    }
    // The built-in set has more samples than such a texture texels.
    scene.falls.paths = all;
    let mut falls = scene.falls.clone();
    falls.capacity = 0;
    let forest = Scene { falls, ..scene }.compute().forest;
    let error = PublishedFalls::new(&passes[1], &forest, ListOptions::default()).err().unwrap();
    assert!(matches!(error, PublishedError::LongPaths { .. }), "{error}");
    assert!(PublishedFalls::new(&passes[0], &forest, ListOptions::default()).is_ok());
}

/// A program throws every third leaf of the first tree; the others are left to the season.
#[test]
fn scripted_leaves_are_drawn_once() {
    let scene = scene();
    let mut compute = scene.compute();
    let throw = |forest: &mut Forest| {
        let (id, leaves) = {
            let (id, model, _) = forest.trees().next().unwrap();
            (id, model.leaf_count())
        };
        for leaf in (0..leaves).step_by(3) {
            forest.throw(id, leaf, 1.0 + f64::from(leaf % 100) / 100.0).unwrap();
        }
    };
    let unscripted = compute.paint(&shot(3.0));
    throw(&mut compute.forest);
    for strategy in Strategy::ALL {
        let mut stage = scene.published(HARNESS.passes(strategy, false), ListOptions::default());
        stage.paint(&shot(3.0));
        throw(&mut stage.forest);
        // While the scripted leaves fall, and when the season would have taken most of them.
        for time in [3.0, 28.0] {
            let reference = compute.paint(&shot(time));
            let error = difference(&reference, &stage.paint(&shot(time)));
            println!("{time} s: {strategy} differs by {error:.6}");
            assert!(error < SAME, "{strategy} differs by {error} at {time} s");
        }
    }
    let changed = difference(&unscripted, &compute.paint(&shot(3.0)));
    assert!(changed > 2.0 * SAME, "{changed}");
}

/// What is done to a forest, and its name.
type Change<'a> = (&'a str, Box<dyn Fn(&mut Forest) + 'a>);

#[test]
fn changes_of_the_forest_are_followed() {
    let scene = scene();
    let mut compute = scene.compute();
    let mut stage =
        scene.published(HARNESS.passes(Strategy::Vertex, false), ListOptions::default());
    let ids: Vec<_> = compute.forest.trees().map(|(id, ..)| id).collect();
    assert!(ids == stage.forest.trees().map(|(id, ..)| id).collect::<Vec<_>>());
    let wind = Wind::new(4.0, 2.0, 0.4, 5);
    let earlier = Shedding { start: -18.0, ..scene.falls.shedding };
    let changes: [Change; 5] = [
        ("nothing", Box::new(|_| ())),
        ("wind", Box::new(|forest| forest.set_wind(wind))),
        ("shedding", Box::new(|forest| forest.set_shedding(earlier))),
        (
            "a tree moves",
            Box::new(|forest| {
                forest.set_transform(ids[1], DVec3::new(-1.0, 0.0, 3.0), 1.0, 0.9).unwrap();
            }),
        ),
        ("a tree is removed", Box::new(|forest| forest.remove(ids[0]).unwrap())),
    ];
    let mut before = Vec::new();
    for (what, change) in changes {
        change(&mut compute.forest);
        change(&mut stage.forest);
        let reference = compute.paint(&shot(4.0));
        let error = difference(&reference, &stage.paint(&shot(4.0)));
        println!("{what}: {error:.6}");
        assert!(error < SAME, "{what}: {error}");
        if !before.is_empty() {
            let changed = difference(&before, &reference);
            assert!(changed > 2.0 * SAME, "{what} changes the picture by {changed}");
        }
        before = reference;
    }
}

/// After ten days, 100 km from the world's origin, single precision of the world's clock and places would show.
#[test]
fn far_places_and_late_times_are_as_precise() {
    let mut scene = scene();
    scene.origin = DVec3::new(100_000.0, 0.0, -70_000.0);
    for (_, place) in &mut scene.places {
        place.position += scene.origin;
    }
    let day_ten = 864_000.123;
    scene.falls.shedding.start += day_ten;
    let mut at = shot(day_ten + 4.0);
    at.view.camera.eye += scene.origin;
    let reference = scene.compute().paint(&at);
    for strategy in Strategy::ALL {
        let passes = HARNESS.passes(strategy, false);
        let mut stage = scene.published(passes, ListOptions::default());
        let error = difference(&reference, &stage.paint(&at));
        println!("{strategy}: {error:.6}");
        assert!(error < SAME, "{strategy} differs by {error}");
        // A sixteenth of a second, the step of single precision there, is seen.
        let late = Shot { time: at.time + 0.0625, ..at.clone() };
        assert!(difference(&reference, &stage.paint(&late)) > 0.5 * SAME);
    }
}

#[test]
fn dropped_encoders_leave_nothing_wrong_behind() {
    let scene = scene();
    for strategy in Strategy::ALL {
        let passes = HARNESS.passes(strategy, false);
        let mut stage = scene.published(passes, ListOptions::default());
        stage.paint(&shot(1.0));
        let mut dropped = HARNESS.device.create_command_encoder(&Default::default());
        stage.record(&shot(5.0), &mut dropped);
        drop(dropped);
        let picture = stage.paint(&shot(5.0));
        let direct = scene.published(passes, ListOptions::default()).paint(&shot(5.0));
        let error = difference(&direct, &picture);
        assert!(error < 0.001, "{strategy} differs by {error}");
    }
}

/// From near, leaves that lie wither, but keep their veins and blotches.
#[test]
fn leaves_that_lie_do_not_flicker() {
    let scene = Scene {
        models: vec![upload(&Species::Maple.grow_with(1, 700))],
        terrain: Terrain::flat(),
        origin: DVec3::ZERO,
        places: vec![(0, TreePlace { yaw: 0.3, ..TreePlace::at(DVec3::ZERO, 9) })],
        falls: Falls {
            shedding: Shedding { start: -20.0, duration: 1.0, ..Shedding::default() },
            wind: Wind::calm(),
            capacity: 2000,
            ..Falls::default()
        },
    };
    let most = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    for strategy in Strategy::ALL {
        for elimination in [Elimination::Off, Elimination::Scheduled] {
            let options = ListOptions { elimination, ..ListOptions::default() };
            let mut stage = scene.published(HARNESS.passes(strategy, false), options);
            let [before, after, bare] = [30.0, 32.0, -30.0].map(|time| {
                let mut view = View::new(camera([1.5, 1.2, 1.5], [1.5, 0.0, 1.2]));
                view.light = Light::from(Sky { clouds: 0.0, ..Sky::default() });
                stage.paint(&Shot { view, ..shot(time) })
            });
            let flicker = most(&before, &after);
            println!("{strategy}, {elimination}: at most {flicker:?} in two seconds");
            // Two seconds of 240 take 1% of the blue that is lost: two levels of 255, and one for rounding.
            assert!(flicker <= Some(3), "{strategy}, {elimination}: {flicker:?}");
            assert!(most(&before, &bare) > Some(100), "leaves lie there");
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let scene = scene();
    let passes = HARNESS.passes(Strategy::VertexBuffer, false);
    let twice = PublishedFalls::new(passes, &scene.compute().forest, ListOptions::default());
    assert!(matches!(twice, Err(PublishedError::DrawnTwice { capacity: 6000 })));
    let mut places = scene.places.clone();
    places.extend((0..2000).map(|i| (1, TreePlace::at(DVec3::new(f64::from(i), 0.0, 0.0), i))));
    let falls = Falls { capacity: 0, ..scene.falls.clone() };
    let wood = Scene { places, falls, ..scene };
    let forest = wood.compute().forest;
    let options = ListOptions { capacity: u32::MAX, ..ListOptions::default() };
    let many = PublishedFalls::new(passes, &forest, options);
    let error = many.map(|_| ()).unwrap_err();
    assert!(matches!(error, PublishedError::TooManyLeaves { .. }), "{error}");
    assert!(error.to_string().contains("set a lower capacity"), "{error}");
}
