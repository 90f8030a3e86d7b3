//! Small pictures of fixed setups, held against `references/*.png` by FLIP.
//!
//! After a wanted change of the look: run `scripts/bless`, look at what changed, commit it.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod cards;
mod culling;
mod resolution;
mod sweeps;

use glam::{DVec3, Quat, Vec2, Vec3};
use std::sync::{LazyLock, Mutex, PoisonError};
use windfall_core::foliage::{Foliage, Leaf, LeafShape};
use windfall_core::forest::{Forest, Instance, Placement, Terrain};
use windfall_core::rng::{hash, unit};
use windfall_core::shed::Shedding;
use windfall_core::simplify::{PruneOrder, Simplification};
use windfall_core::tree::{Image, Material, Surface, Tree, Wood, WoodVertex};
use windfall_core::wind::Wind;
use windfall_gpu::{
    Camera, Capture, CountReadback, DebugView, Falls, Light, Moment, Options, Picture,
    PictureTargets, Projection, Quality, Recording, Renderer, Sky, TreeCounts, TreeId, TreeModel,
    View, ViewState, wgpu,
};
use windfall_testing::{Mismatch, Snapshots, Tolerance, device, picture};
use windfall_tree::prepare::{prepare_wood, simple_shapes};
use windfall_tree::species::Species;
use windfall_tree::{prepare, prepare_in_order};

const SIZE: (u32, u32) = (160, 90);

/// What draws: one for all tests of this file.
struct Harness {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Renderer,
    texture: wgpu::Texture,
}

static HARNESS: LazyLock<Harness> = LazyLock::new(|| {
    let (device, queue) = device();
    let texture = picture(&device, SIZE);
    Harness {
        renderer: Renderer::new(&device, &Options::picture(texture.format())).unwrap(),
        texture,
        device,
        queue,
    }
});

/// One drawing at a time: there is one texture.
static TURN: Mutex<()> = Mutex::new(());

/// A forest and a view of it.
struct Scene {
    forest: windfall_gpu::Forest,
    ids: Vec<TreeId>,
    state: ViewState,
}

fn upload(trees: &[Tree], forest: &Forest, falls: &Falls) -> Mutex<Scene> {
    let Harness { device, queue, renderer, .. } = &*HARNESS;
    let models: Vec<TreeModel> =
        trees.iter().map(|tree| TreeModel::new(device, queue, tree).unwrap()).collect();
    let terrain = forest.terrain.clone();
    let mut planted =
        windfall_gpu::Forest::new(device, DVec3::ZERO, terrain, falls.clone()).unwrap();
    let ids = planted.plant(&models, &forest.instances).unwrap();
    Mutex::new(Scene { state: renderer.view(&planted), forest: planted, ids })
}

/// A view at a moment.
#[derive(Clone)]
struct Shot {
    time: f64,
    season: f32,
    view: View,
}

impl std::ops::Deref for Shot {
    type Target = View;

    fn deref(&self) -> &View {
        &self.view
    }
}

impl std::ops::DerefMut for Shot {
    fn deref_mut(&mut self) -> &mut View {
        &mut self.view
    }
}

impl Shot {
    fn sky(&mut self) -> &mut Sky {
        match &mut self.view.light {
            Light::Sky(sky, _) => sky,
            Light::Host(_) => unreachable!("views of these tests have Windfall's sky"),
        }
    }

    fn set_fov(&mut self, fov_y: f32) {
        self.view.camera.projection = Projection::Perspective { fov_y, near: 0.1 };
    }
}

fn targets() -> PictureTargets {
    HARNESS.renderer.targets(SIZE.0, SIZE.1).unwrap()
}

fn paint(scene: &Mutex<Scene>, shot: &Shot) -> Vec<u8> {
    paint_on(&targets(), scene, shot)
}

fn paint_on(targets: &PictureTargets, scene: &Mutex<Scene>, shot: &Shot) -> Vec<u8> {
    let Harness { device, queue, renderer, texture } = &*HARNESS;
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let Scene { forest, state, .. } = &mut *scene.lock().unwrap_or_else(PoisonError::into_inner);
    let output = &texture.create_view(&wgpu::TextureViewDescriptor::default());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut recording = Recording::new(queue, &mut encoder);
    forest.set_season(shot.season).unwrap();
    renderer.advance(&mut recording, forest, Moment::of(shot.time, &shot.view)).unwrap();
    let picture = Picture { targets, output, layers: &mut [] };
    renderer.render(&mut recording, forest, state, &shot.view, picture).unwrap();
    let capture = Capture::encode(device, &mut encoder, texture);
    queue.submit([encoder.finish()]);
    capture.map();
    windfall_testing::wait(device, || capture.take()).unwrap()
}

/// The trees of the frame that was painted last.
fn counts(scene: &Mutex<Scene>) -> TreeCounts {
    let Harness { device, queue, .. } = &*HARNESS;
    let Scene { forest, state, .. } = &*scene.lock().unwrap_or_else(PoisonError::into_inner);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let count = CountReadback::encode(device, &mut encoder, forest, state).unwrap();
    queue.submit([encoder.finish()]);
    count.map();
    windfall_testing::wait(device, || count.take()).unwrap().trees
}

/// A forest in which no leaf falls.
fn paint_still(trees: &[Tree], forest: &Forest, shot: &Shot) -> Vec<u8> {
    paint(&upload(trees, forest, &Falls::none()), shot)
}

/// Half of all leaves fall within a minute, in a breeze.
fn falls() -> Falls {
    Falls {
        shedding: Shedding { start: 0.0, duration: 120.0, ..Shedding::default() },
        capacity: 200_000,
        ..Falls::default()
    }
}

fn view(eye: [f32; 3], target: [f32; 3]) -> Shot {
    let [eye, target] = [eye, target].map(|p| Vec3::from(p).as_dvec3());
    let camera = Camera::look_at(eye, target, 0.8, 0.1);
    Shot { time: 0.0, season: 0.55, view: View::new(camera) }
}

fn stand(position: Vec3, model: u32) -> Instance {
    Instance { model, position, yaw: 0.3, scale: 1.0, season_offset: 0.0, seed: 9 }
}

fn lone(tree: Tree) -> (Vec<Tree>, Forest) {
    let forest = Forest { terrain: Terrain::flat(), instances: vec![stand(Vec3::ZERO, 0)] };
    (vec![tree], forest)
}

/// Twelve trees of three species on rolling ground.
fn glade() -> (Vec<Tree>, Forest) {
    let trees = vec![Species::Birch.grow(1), Species::Maple.grow(2), Species::Oak.grow(3)];
    let placement = Placement {
        trees: 12,
        spacing: 6.0,
        keep_out: Vec::new(),
        scale: (0.8, 1.2),
        season_spread: 0.15,
        seed: 5,
    };
    let forest = placement.place(Terrain::rolling(200.0, 2.0, 4), &[1.0; 3]);
    (trees, forest)
}

/// A birch with pictures: leaves are the discs that a mask leaves, wood repeats its texture.
fn masked() -> Tree {
    pictured(|x, y| (x as f32 - 15.5).hypot(y as f32 - 15.5) < 15.0)
}

/// A birch whose leaves are cards: of their picture, 32 texels a side, that is there which is `solid`.
fn pictured(solid: impl Fn(u32, u32) -> bool) -> Tree {
    let mut tree = Species::Birch.grow(4);
    let image = with_holes(32, solid);
    tree.foliage.palette = None;
    for material in &mut tree.foliage.materials {
        *material = of_cards(material, image.clone());
    }
    for material in &mut tree.wood.materials {
        material.surface = Surface::Texture(image.clone(), true);
    }
    tree.foliage.simple_shapes = simple_shapes(&tree.foliage);
    prepare_wood(&mut tree.wood);
    tree
}

/// A picture of `side` texels a side, of which that is there which is `solid`.
fn with_holes(side: u32, solid: impl Fn(u32, u32) -> bool) -> Image {
    let texel = |i: u32| {
        let (x, y) = (i % side, i / side);
        [200, (120 + 128 * y / side) as u8, 40, if solid(x, y) { 255 } else { 0 }]
    };
    Image { width: side, height: side, rgba: (0..side * side).flat_map(texel).collect() }
}

fn of_cards(material: &Material, image: Image) -> Material {
    let surface = Surface::Texture(image, false);
    Material { alpha_cutoff: Some(0.5), surface, ..material.clone() }
}

/// Of a byte of a picture.
fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn compare(name: &str, rgba: &[u8]) {
    Snapshots::of_crate(env!("CARGO_MANIFEST_DIR")).assert(name, SIZE, rgba, Tolerance::default());
}

fn check(name: &str, (trees, forest): (Vec<Tree>, Forest), view: &Shot) {
    compare(name, &paint_still(&trees, &forest, view));
}

#[test]
fn sky_and_ground_alone() {
    let forest = Forest { terrain: Terrain::rolling(200.0, 3.0, 1), instances: Vec::new() };
    check("empty", (Vec::new(), forest), &view([0.0, 4.0, 20.0], [0.0, 4.0, 0.0]));
}

#[test]
fn one_tree_from_near() {
    check("maple", lone(Species::Maple.grow(1)), &view([2.0, 2.0, 20.0], [0.0, 6.0, 0.0]));
}

#[test]
fn one_tree_against_the_light() {
    let mut view = view([0.0, 1.7, 18.0], [0.0, 8.0, 0.0]);
    let sky = view.sky();
    (sky.sun_azimuth, sky.sun_elevation) = (std::f32::consts::PI, 0.35);
    check("aspen-backlit", lone(Species::Aspen.grow(1)), &view);
}

#[test]
fn a_tree_with_pictures_for_leaves() {
    check("masked", lone(masked()), &view([2.0, 2.0, 16.0], [0.0, 6.0, 0.0]));
}

#[test]
fn a_glade() {
    check("glade", glade(), &view([0.0, 3.0, 30.0], [0.0, 5.0, 0.0]));
}

#[test]
fn a_glade_from_above() {
    check("glade-above", glade(), &view([0.0, 45.0, 0.0], [0.0, 0.0, 0.0]));
}

#[test]
fn a_glade_in_late_summer_haze() {
    let mut view = view([0.0, 3.0, 30.0], [0.0, 5.0, 0.0]);
    view.season = 0.1;
    (view.sky().haze, view.sky().exposure) = (0.02, 0.5);
    check("glade-haze", glade(), &view);
}

#[test]
fn leaves_in_the_air_and_on_the_ground() {
    let (trees, forest) = glade();
    let view = Shot { time: 60.0, ..view([0.0, 3.0, 30.0], [0.0, 2.0, 0.0]) };
    compare("falling", &paint(&upload(&trees, &forest, &falls()), &view));
}

#[test]
fn a_moment_is_the_same_whatever_came_before_it() {
    let (trees, forest) = glade();
    let falls = falls();
    let at = |time| Shot { time, ..view([0.0, 3.0, 30.0], [0.0, 2.0, 0.0]) };
    let alone = paint(&upload(&trees, &forest, &falls), &at(40.0));
    let played = upload(&trees, &forest, &falls);
    let moments = [0.0, 40.0, 90.0, 40.0, 39.9, 40.0, -5.0, 40.0].map(|t| paint(&played, &at(t)));
    for i in [1, 3, 5, 7] {
        assert!(moments[i] == alone, "moment {i} differs");
    }
    assert!(moments[2] != alone && moments[4] != alone, "time changes the picture");
}

/// A leaf keeps its colour and its fall wherever it stands in the list: on twigs and off them the tree
/// in full is the same in each prune order.
#[test]
fn a_tree_in_full_looks_the_same_in_each_prune_order() {
    let (mut trees, forest) = lone(Species::Maple.grow(2));
    let mut view = Shot { time: 60.0, ..view([0.0, 3.0, 14.0], [0.0, 5.0, 0.0]) };
    (view.view.detail, view.view.shadow_detail) = (Simplification::NONE, Simplification::NONE);
    let pictures = PruneOrder::ALL.map(|order| {
        prepare_in_order(&mut trees[0], order, 1);
        paint(&upload(&trees, &forest, &falls()), &view)
    });
    for picture in &pictures[1..] {
        // Where leaves cross at the same depth, the one that is drawn first stays.
        let differ = picture.iter().zip(&pictures[0]).filter(|(a, b)| a != b).count();
        assert!(differ < picture.len() / 1000, "{differ} of {} bytes", picture.len());
    }
}

/// In a storm, all leaves of a tree let go at once: a moment later each is where it hung, as it hung;
/// small in the picture, and ever larger.
#[test]
fn leaves_let_go_as_the_wind_holds_them() {
    let (trees, forest) = lone(Species::Maple.grow_with(1, 700));
    let leaves = trees[0].foliage.leaves.len() as u32;
    let falls = Falls { wind: Wind::new(8.0, 0.4, 0.8, 3), ..Falls::none() };
    let apart = |a: &[u8], b: &[u8]| {
        a.iter().zip(b).map(|(a, b)| f32::from(a.abs_diff(*b))).sum::<f32>() / a.len() as f32
    };
    // Leaves of about 2, 8, 15 and 40 pixels.
    for fov_y in [0.8, 0.2, 0.1, 0.04] {
        let mut at = Shot { time: 7.25, ..view([2.0, 2.0, 12.0], [0.0, 6.0, 0.0]) };
        at.set_fov(fov_y);
        let thrown = |time| {
            let scene = upload(&trees, &forest, &falls);
            {
                let Scene { forest, ids, .. } = &mut *scene.lock().unwrap();
                for leaf in 0..leaves {
                    forest.throw(ids[0], leaf, time).unwrap();
                }
            }
            paint(&scene, &at)
        };
        let [hanging, loose, gone] = [7.2501, 7.2499, 4.0].map(thrown);
        let (pop, fall) = (apart(&hanging, &loose), apart(&hanging, &gone));
        println!("{fov_y}: {pop} when they let go, {fall} when they have fallen");
        assert!(fall > 4.0 && pop < 0.1 * fall, "{fov_y}: {pop} of {fall}");
    }
}

/// From near, leaves that lie wither, but keep their veins and blotches.
#[test]
fn leaves_that_lie_do_not_flicker() {
    let (trees, forest) = lone(Species::Maple.grow_with(1, 700));
    let shedding = Shedding { start: -20.0, duration: 1.0, ..Shedding::default() };
    let falls = Falls { shedding, wind: Wind::calm(), capacity: 2000, ..Falls::default() };
    let forest = upload(&trees, &forest, &falls);
    let at = |time| {
        let mut view = Shot { time, ..view([1.5, 1.2, 1.5], [1.5, 0.0, 1.2]) };
        view.sky().clouds = 0.0;
        paint(&forest, &view)
    };
    let [before, after, bare] = [30.0, 32.0, -30.0].map(at);
    let most = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    println!("at most {:?} in two seconds", most(&before, &after));
    // Two seconds of 240 take 1% of the blue that is lost; that is two levels of 255, and one for rounding.
    assert!(most(&before, &after) <= Some(3));
    assert!(most(&before, &bare) > Some(100), "leaves lie there");
}

/// What the tolerance must not let pass: a later season, one tree of twelve less, a camera half a
/// metre off.
#[test]
fn perturbed_pictures_fail() {
    let folder = std::env::temp_dir().join(format!("windfall-perturbed-{}", std::process::id()));
    let at = |bless| Snapshots::new(folder.join("references"), folder.join("failures"), bless);
    let here = view([0.0, 3.0, 30.0], [0.0, 5.0, 0.0]);
    let (trees, forest) = glade();
    let tolerance = Tolerance::default();
    at(true).assert("glade", SIZE, &paint_still(&trees, &forest, &here), tolerance);
    at(false).assert("glade", SIZE, &paint_still(&trees, &forest, &here), tolerance);

    let mut fewer = forest.clone();
    // The nearest one: one that others hide would rightly change nothing.
    let near = |i: &Instance| i.position.distance(here.camera.eye.as_vec3());
    let nearest =
        (0..12).min_by(|&a, &b| near(&forest.instances[a]).total_cmp(&near(&forest.instances[b])));
    fewer.instances.remove(nearest.unwrap());
    let later = Shot { season: 0.8, ..here.clone() };
    let mut moved = here.clone();
    moved.camera.eye.x += 0.5;
    for (what, forest, view) in
        [("one tree less", &fewer, &here), ("later", &forest, &later), ("moved", &forest, &moved)]
    {
        let failed = at(false).check("glade", SIZE, &paint_still(&trees, forest, view), tolerance);
        assert!(matches!(failed, Err(Mismatch::Different { .. })), "{what}: {failed:?}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// A column of plain wood, `height` metres high and `radius` thick, under a flat cone, and no leaf.
fn column(radius: f32, height: f32) -> Tree {
    let mut tree = Species::Birch.grow_with(1, 0);
    tree.foliage.leaves.clear();
    let mut wood = Wood { materials: tree.wood.materials[1..2].to_vec(), ..Wood::default() };
    let (sides, rings) = (24u32, 2u32);
    for ring in 0..rings {
        for side in 0..sides {
            let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
            let normal = Vec3::new(cos, 0.0, sin);
            let position = normal * radius + Vec3::Y * (height * ring as f32 - 0.2);
            wood.vertices.push(WoodVertex { position, normal, uv: Vec2::ZERO, material: 0 });
        }
    }
    // Rim and apex for each side: a normal shared by all sides is none's.
    let (top, slope) = (wood.vertices.len() as u32, 0.6);
    for side in 0..sides {
        let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
        let out = Vec3::new(cos, 0.0, sin);
        let normal = (out * slope + Vec3::Y).normalize_or(Vec3::Y);
        let rim = out * radius + Vec3::Y * (height - 0.2);
        for position in [rim, Vec3::Y * (height - 0.2 + slope * radius)] {
            wood.vertices.push(WoodVertex { position, normal, uv: Vec2::ZERO, material: 0 });
        }
    }
    for side in 0..sides {
        let next = (side + 1) % sides;
        wood.indices.extend([side, side + sides, next, next, side + sides, next + sides]);
        wood.indices.extend([top + 2 * side, top + 2 * side + 1, top + 2 * next]);
    }
    tree.wood = wood;
    prepare(&mut tree);
    tree
}

/// Where light is bright or dim alone matters: no sky, grass or litter to look at.
fn plain_view(eye: Vec3, target: Vec3, elevation: f32, shadows: bool) -> Shot {
    let mut view = view(eye.into(), target.into());
    let sky = view.sky();
    (sky.sun_azimuth, sky.sun_elevation) = (0.0, elevation);
    view.sky().haze = 0.0;
    view.shadows = shadows;
    view.quality = Quality { grass: false, ground_detail: false, sway: false, ..Quality::HIGH };
    view
}

/// Looked at from where the sun is, a column is lit all over, to where its sides turn away: shadows
/// change nothing. For a grazing sun, a steep one and one straight above; where cascades meet, too.
#[test]
fn what_the_sun_sees_has_no_acne() {
    let trees = vec![column(0.5, 5.0)];
    let forest = Forest { terrain: Terrain::flat(), instances: vec![stand(Vec3::ZERO, 0)] };
    let gpu = upload(&trees, &forest, &Falls::none());
    for elevation in [0.035f32, 0.3, 1.0, std::f32::consts::FRAC_PI_2] {
        let sun = Vec3::new(0.0, elevation.sin(), elevation.cos());
        for distance in [6.0, 13.0, 14.5, 50.0, 54.0, 150.0] {
            let target = Vec3::new(0.0, 2.0, 0.0);
            let eye = target + sun * distance;
            let [with, without] = [true, false].map(|shadows| {
                let mut view = plain_view(eye, target, elevation, shadows);
                // A picture 0.88 m wide of a column of 1 m.
                view.set_fov(2.0 * (0.25 / (distance - 0.5)).atan());
                paint(&gpu, &view)
            });
            let dark = |(a, b): (&u8, &u8)| f32::from(b.saturating_sub(*a));
            let loss = with.iter().zip(&without).map(dark).sum::<f32>() / with.len() as f32;
            assert!(loss < 0.5, "{elevation} rad, {distance} m: {loss} of 255 darker");
            let spots = with.iter().zip(&without).filter(|&p| dark(p) > 12.0).count();
            let share = spots as f32 / with.len() as f32;
            assert!(share < 0.01, "{elevation} rad, {distance} m: {share} of the picture in spots");
        }
    }
}

/// Right behind a stick or a column, seen from the side, the ground is dark: the shadow hangs on its
/// foot. At the distances where cascades meet, too.
#[test]
fn shadows_begin_at_the_foot() {
    let cases = [(0.05, 6.0), (0.05, 12.5), (0.3, 14.5), (0.5, 50.0), (0.5, 56.0)];
    for (radius, distance) in cases {
        let forest = Forest { terrain: Terrain::flat(), instances: vec![stand(Vec3::ZERO, 0)] };
        let gpu = upload(&[column(radius, 5.0)], &forest, &Falls::none());
        for elevation in [0.2f32, 0.8] {
            let eye = Vec3::new(distance, 0.35 * distance, 0.0);
            let behind = Vec3::new(0.0, 0.0, -1.2 * radius - 0.02);
            let [with, without] = [true, false].map(|shadows| {
                let mut view = plain_view(eye, behind, elevation, shadows);
                // Narrow: the middle of the picture is that place alone.
                view.set_fov(2.0 * (3.0 * radius / distance).atan());
                paint(&gpu, &view)
            });
            let middle = ((SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) * 4) as usize;
            let light = |p: &[u8]| p[middle..middle + 3].iter().map(|&v| f32::from(v)).sum::<f32>();
            let left = light(&with) / light(&without);
            assert!(left < 0.85, "{elevation} rad, {distance} m: {left} of the light is left");
        }
    }
}

/// A tree stands where cascades meet. Seen a little nearer, there, and a little farther, in pictures that
/// show it in one size, it and its shadow take as much light away. For a low sun, a high one and one
/// straight above.
#[test]
fn a_tree_where_cascades_meet_is_shaded_alike() {
    let (trees, forest) = lone(Species::Maple.grow_with(1, 1500));
    let gpu = upload(&trees, &forest, &Falls::none());
    for (boundary, elevation) in [14.0, 52.0]
        .into_iter()
        .flat_map(|b| [0.1f32, 0.8, std::f32::consts::FRAC_PI_2].map(|e| (b, e)))
    {
        let target = Vec3::new(0.0, 3.0, 0.0);
        let losses = [0.88f32, 0.96, 1.0, 1.04, 1.12].map(|share| {
            let distance = boundary * share;
            let eye = target + Vec3::new(0.94, 0.34, 0.0) * distance;
            let [with, without] = [true, false].map(|shadows| {
                let mut view = plain_view(eye, target, elevation, shadows);
                view.set_fov(2.0 * (5.0 / distance).atan());
                paint(&gpu, &view)
            });
            let dark = |(a, b): (&u8, &u8)| f32::from(b.saturating_sub(*a));
            with.iter().zip(&without).map(dark).sum::<f32>() / with.len() as f32
        });
        let (least, most) =
            losses.iter().fold((f32::MAX, 0.0f32), |(a, b), &l| (a.min(l), b.max(l)));
        assert!(least > 0.5, "{boundary} m, {elevation} rad: {losses:?}");
        // Of this tree leaves are half a metre long: in two triangles they close the gaps between their lobes, of which
        // the farthest map has lost some already. At 0.1 rad, where a tree takes 1 of 255, that is 16%; else below 10%.
        let bound = if elevation < 0.2 { 1.2 } else { 1.1 };
        assert!(most < bound * least, "{boundary} m, {elevation} rad: {losses:?}");
    }
}

/// Large leaves that are lit at their vertices have the outlines, the light and the midribs of those that are
/// lit in pixels.
#[test]
fn large_leaves_lit_at_vertices_look_the_same() {
    let (trees, forest) = lone(Species::Maple.grow_with(1, 3000));
    let gpu = upload(&trees, &forest, &Falls::none());
    let crown = trees[0].foliage.crown_center;
    let shot = |pixel_lighting, show| {
        let eye = crown + Vec3::new(0.0, 0.5, 8.0);
        let mut view = plain_view(eye, crown, 0.6, false);
        // Leaves are a hundred pixels long and more.
        view.set_fov(0.06);
        view.quality = Quality { pixel_lighting, ..Quality::PLAIN };
        view.show = show;
        paint(&gpu, &view)
    };
    assert!(shot(true, DebugView::Coverage) == shot(false, DebugView::Coverage), "outlines");
    let (pixels, vertices) = (shot(true, DebugView::Leaves), shot(false, DebugView::Leaves));
    let mean = |p: &[u8]| p.iter().map(|&v| f64::from(v)).sum::<f64>() / p.len() as f64;
    let light = mean(&vertices) / mean(&pixels);
    let apart: Vec<u8> = pixels.iter().zip(&vertices).map(|(a, b)| a.abs_diff(*b)).collect();
    // Radiance is not quite in proportion to albedo, which a midrib is paler by: of the brightest it is not seen
    // in pixels.
    assert!((light - 1.0).abs() < 0.01, "{light} of the light");
    assert!(mean(&apart) < 1.0, "apart by {}", mean(&apart));
    assert!(mean(&apart) > 0.0, "the setting changes nothing");
}

/// Views that explain a tree: what of it is leaf and what is wood, and where each pixel faces. Both show the same pixels.
#[test]
fn a_tree_shows_its_parts_and_its_normals() {
    let (trees, forest) = lone(Species::Oak.grow_with(1, 3000));
    let gpu = upload(&trees, &forest, &Falls::none());
    let shot = |show, pixel_lighting| {
        let mut view = plain_view(Vec3::new(0.0, 5.0, 9.0), Vec3::new(0.0, 5.0, 0.0), 0.6, false);
        view.quality = Quality { pixel_lighting, ..Quality::PLAIN };
        view.show = show;
        paint(&gpu, &view)
    };
    for pixel_lighting in [false, true] {
        let parts = shot(DebugView::Parts, pixel_lighting);
        let normals = shot(DebugView::Normals, pixel_lighting);
        let (mut leaves, mut wood, mut facing) = (0u32, 0u32, 0u32);
        for (part, normal) in parts.chunks_exact(4).zip(normals.chunks_exact(4)) {
            let shown = |pixel: &[u8]| pixel[..3].iter().any(|v| *v > 0);
            assert_eq!(shown(part), shown(normal));
            let [r, g, b] = [0, 1, 2].map(|i| f32::from(part[i]));
            leaves += u32::from(g > 1.5 * r);
            wood += u32::from(r > 1.3 * g && g > b);
            // Of pixels that one surface covers, the file's values are the normal, which is of length 1 and faces the eye.
            let [x, y, z] = [0, 1, 2].map(|i| f32::from(normal[i]) / 127.5 - 1.0);
            facing += u32::from((x.hypot(y).hypot(z) - 1.0).abs() < 0.03 && z > -0.3);
        }
        assert!(leaves > 1000 && wood > 100, "{leaves} of leaves, {wood} of wood");
        assert!(facing > (leaves + wood) / 5, "{facing} normals of {}", leaves + wood);
    }
}

/// No square of the ground is left out, beyond the rim of the terrain neither.
#[test]
fn no_sky_shows_through_the_ground() {
    let forest = Forest { terrain: Terrain::rolling(260.0, 30.0, 6), instances: Vec::new() };
    let gpu = upload(&[], &forest, &Falls::none());
    for (eye, target) in [
        ([0.0, 60.0, 0.0], [1.0, 0.0, 0.0]),
        ([90.0, 45.0, 90.0], [140.0, 0.0, 140.0]),
        ([-20.0, 40.0, 10.0], [30.0, 0.0, -40.0]),
    ] {
        let mut shot = view(eye, target);
        shot.view.transparent_sky = true;
        shot.view.quality.backdrop = false;
        shot.view.quality.grass = false;
        let rgba = paint(&gpu, &shot);
        let open = rgba.chunks_exact(4).filter(|p| p[3] < 255).count();
        assert_eq!(open, 0, "pixels of {} that show the sky from {eye:?}", rgba.len() / 4);
    }
}

/// Two stops below the curve's bend, a stop more is 2 to the power of the system gamma of the light in
/// the picture.
#[test]
fn a_stop_more_is_the_system_gamma_more_light() {
    let forest = Forest { terrain: Terrain::rolling(200.0, 3.0, 1), instances: Vec::new() };
    let gpu = upload(&[], &forest, &Falls::none());
    let at = |stops: f32| {
        let mut view = view([0.0, 4.0, 20.0], [0.0, 4.0, 0.0]);
        view.sky().exposure = stops;
        paint(&gpu, &view)
    };
    let (dim, bright) = (at(-3.0), at(-2.0));
    let mean = |p: &[u8]| {
        p.chunks_exact(4).flat_map(|c| &c[..3]).map(|&b| linear(b)).sum::<f32>() / p.len() as f32
    };
    let ratio = mean(&bright) / mean(&dim);
    let want = 2.0f32.powf(1.2);
    assert!((ratio / want - 1.0).abs() < 0.015, "{ratio} for {want}");
}

#[test]
fn bare_trees_keep_their_crowns_far_away() {
    // A pixel is half a metre wide: nearly all branches are thinner, and fewer are drawn, wider.
    let bald = |species: Species| {
        let mut tree = species.grow(1);
        tree.foliage = Foliage { materials: tree.foliage.materials.clone(), ..Foliage::default() };
        tree
    };
    for species in [Species::Oak, Species::Birch, Species::Maple] {
        let instances = (0..6).map(|i| {
            let x = 14.0 * (i as f32 - 2.5);
            Instance { yaw: i as f32, ..stand(Vec3::new(x, 0.0, 0.0), 0) }
        });
        let forest = Forest { terrain: Terrain::flat(), instances: instances.collect() };
        let trees = upload(&[bald(species)], &forest, &Falls::none());
        let nothing = Forest { terrain: Terrain::flat(), instances: Vec::new() };
        let nothing = upload(&[bald(species)], &nothing, &Falls::none());
        let with = |detail| {
            let (eye, target) = (Vec3::new(0.0, 3.0, 55.0), Vec3::new(0.0, 3.0, 0.0));
            let mut shot = plain_view(eye, target, 0.6, false);
            shot.detail = detail;
            shot
        };
        // What the trees take of the light of the sky behind them, above three metres.
        let taken = |detail| {
            let pairs =
                paint(&trees, &with(detail)).into_iter().zip(paint(&nothing, &with(detail)));
            let rows = 44 * SIZE.0 as usize * 4;
            pairs.take(rows).map(|(a, b)| f64::from(b.abs_diff(a))).sum::<f64>()
        };
        let (simple, full) = (taken(Simplification::DEFAULT), taken(Simplification::NONE));
        println!("{species}: {}", simple / full);
        // Tubes of a few sides have up to a quarter less surface than those they stand for.
        assert!((0.7..1.15).contains(&(simple / full)), "{species}: {simple} for {full}");
        assert!(full > 2e4, "{species}: {full}");
    }
}
