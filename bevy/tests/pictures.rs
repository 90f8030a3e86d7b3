//! What cameras see, pixel by pixel.

mod scene;

use bevy::camera::visibility::RenderLayers;
use bevy::camera::{Hdr, ImageRenderTarget, RenderTarget, Viewport};
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_windfall::{
    LeavesNear, Season, ThrowLeaf, TreeModel, WindfallForest, WindfallStatus, WindfallTime,
    WindfallTree,
};
use scene::{
    MAGENTA, SIZE, apart, app, camera, eye, flat_box, floor, is_magenta, maple, mean, model,
    pixels, still_tree, sun,
};

/// Pixels in which something of the tree is seen: those that differ with and without it, before black.
fn tree_pixels(with: &[[u8; 4]], without: &[[u8; 4]]) -> Vec<usize> {
    (0..with.len()).filter(|&i| with[i] != without[i]).collect()
}

#[test]
fn leaves_are_before_one_box_and_behind_another() {
    let mut tree = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        camera(world);
        sun(world);
        tree = still_tree(world);
    });
    let alone = pixels(&mut headless, 1.0);
    headless.app.world_mut().entity_mut(tree).insert(Visibility::Hidden);
    let empty = pixels(&mut headless, 1.0);
    let seen = tree_pixels(&alone, &empty);
    assert!(seen.len() > 1500, "the tree covers {} pixels", seen.len());
    headless.app.world_mut().entity_mut(tree).insert(Visibility::Visible);

    // A wall of 60 m behind the tree: what the tree covered it still covers, and the wall is all the rest.
    let wall = Vec3::new(60.0, 60.0, 1.0);
    let behind = flat_box(headless.app.world_mut(), wall, Vec3::new(0.0, 5.0, -12.0), MAGENTA);
    let before_wall = pixels(&mut headless, 1.0);
    let magenta = before_wall.iter().filter(|p| is_magenta(p)).count();
    assert_eq!(magenta, before_wall.len() - seen.len(), "the wall is where the tree is not");
    let lost = seen.iter().filter(|&&i| is_magenta(&before_wall[i])).count();
    assert_eq!(lost, 0, "pixels of the tree are behind the wall");

    // The same wall before it hides all of the tree; and one through its middle hides some of it.
    let place = |headless: &mut scene::headless::Headless, z| {
        let mut transform = Transform::from_xyz(0.0, 5.0, z);
        transform.scale.z = 0.1;
        headless.app.world_mut().entity_mut(behind).insert(transform);
    };
    place(&mut headless, 12.0);
    assert!(pixels(&mut headless, 1.0).iter().all(is_magenta), "the wall before the tree");
    place(&mut headless, 0.0);
    let through = pixels(&mut headless, 1.0);
    let left =
        seen.iter().filter(|&&i| !is_magenta(&through[i])).count() as f32 / seen.len() as f32;
    assert!((0.3..0.95).contains(&left), "{left} of the tree stands before the middle");
}

#[test]
fn every_kind_of_target_shows_the_same_tree() {
    let mut eye = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        eye = camera(world);
        sun(world);
        still_tree(world);
    });
    let first = pixels(&mut headless, 1.0);
    for (hdr, msaa) in [(true, Msaa::Sample4), (false, Msaa::Off), (false, Msaa::Sample4)] {
        let mut camera = headless.app.world_mut().entity_mut(eye);
        camera.insert(msaa);
        if !hdr {
            camera.remove::<Hdr>();
        }
        let now = pixels(&mut headless, 1.0);
        // With a sample a pixel nothing differs but the rounding of 16 bits; with four, edges do.
        let most = if msaa == Msaa::Off { 0.0 } else { 0.45 };
        let differ = apart(&first, &now, 3);
        assert!(differ <= most, "hdr {hdr}, {msaa:?}: {differ} of the pixels differ");
        for channel in 0..3 {
            let all = [0, 0, SIZE.x as usize, SIZE.y as usize];
            let (a, b) = (mean(&first, channel, all), mean(&now, channel, all));
            assert!((a - b).abs() < 2.5, "hdr {hdr}, {msaa:?}: channel {channel} is {b}, was {a}");
        }
        assert_eq!(msaa == Msaa::Off, differ == 0.0, "four samples soften edges: {differ}");
    }
    // Two samples are no foliage, and no error of the device.
    headless.app.world_mut().entity_mut(eye).insert(Msaa::Sample2);
    for _ in 0..5 {
        headless.app.update();
    }
}

#[test]
fn cameras_share_a_frame_a_viewport_and_layers() {
    let mut second = Entity::PLACEHOLDER;
    let half = |left: bool| {
        let physical_position = UVec2::new(if left { 0 } else { SIZE.x / 2 }, 0);
        let physical_size = UVec2::new(SIZE.x / 2, SIZE.y);
        Some(Viewport { physical_position, physical_size, ..default() })
    };
    let mut headless = app(|world| {
        let first = camera(world);
        world.entity_mut(first).insert(Camera { viewport: half(true), ..default() });
        second = camera(world);
        let after = ClearColorConfig::None;
        let right = Camera { viewport: half(false), order: 1, clear_color: after, ..default() };
        world.entity_mut(second).insert(right);
        sun(world);
        still_tree(world);
    });
    let image = pixels(&mut headless, 1.0);
    let (width, middle) = (SIZE.x as usize, SIZE.x as usize / 2);
    let halves = |image: &[[u8; 4]]| -> [Vec<[u8; 4]>; 2] {
        [0, middle].map(|from| {
            image.chunks_exact(width).flat_map(|row| row[from..from + middle].to_vec()).collect()
        })
    };
    let [left, right] = halves(&image);
    let background = left[0];
    // What is drawn is the same, but for the grain of shadows, which is of the picture's pixels.
    let outline = |half: &[[u8; 4]]| half.iter().map(|p| *p == background).collect::<Vec<_>>();
    let apart = outline(&left).iter().zip(outline(&right)).filter(|(a, b)| *a != b).count();
    assert!(apart < 20, "two cameras at one place see one thing: {apart} pixels differ");
    let covered = left.iter().filter(|p| **p != background).count();
    assert!(covered > 1000, "the tree covers {covered} pixels");

    // From elsewhere the second one sees something else, and the first what it saw.
    let aside = Transform::from_xyz(18.0, 5.0, 0.0).looking_at(Vec3::Y * 5.0, Vec3::Y);
    headless.app.world_mut().entity_mut(second).insert(aside);
    let [still, turned] = halves(&pixels(&mut headless, 1.0));
    assert!(still == left && turned != left);

    // In another layer it sees no tree.
    headless.app.world_mut().entity_mut(second).insert(RenderLayers::layer(3));
    let [still, none] = halves(&pixels(&mut headless, 1.0));
    assert!(still == left && none.iter().all(|p| *p == background));
}

#[test]
fn a_camera_draws_into_a_texture() {
    let mut headless = app(|world| {
        let other = camera(world);
        sun(world);
        still_tree(world);
        // Seen by the camera that is photographed: a picture frame with what the other one sees.
        let image = Image::new_target_texture(64, 64, TextureFormat::Rgba8UnormSrgb, None);
        let image = world.resource_mut::<Assets<Image>>().add(image);
        world.entity_mut(other).insert((
            RenderTarget::Image(ImageRenderTarget::from(image.clone())),
            Camera { order: -1, clear_color: ClearColorConfig::Custom(Color::BLACK), ..default() },
        ));
        let frame =
            flat_box(world, Vec3::new(8.0, 8.0, 0.1), Vec3::new(100.0, 0.0, 0.0), Color::WHITE);
        let material = world.get::<MeshMaterial3d<StandardMaterial>>(frame).unwrap().0.clone();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&material).unwrap().base_color_texture = Some(image);
        let visitor = camera(world);
        let there = Transform::from_xyz(100.0, 0.0, 9.0);
        world.entity_mut(visitor).insert(there.looking_at(Vec3::new(100.0, 0.0, 0.0), Vec3::Y));
    });
    let image = pixels(&mut headless, 1.0);
    let middle = image[SIZE.y as usize / 2 * SIZE.x as usize + SIZE.x as usize / 2];
    let colored = image.iter().filter(|p| p[0] > p[2].saturating_add(25)).count();
    assert!(
        colored > 500,
        "{colored} pixels of autumn leaves on the screen; the middle is {middle:?}"
    );
}

#[test]
fn despawned_trees_are_gone_and_moved_ones_elsewhere() {
    let mut tree = Entity::PLACEHOLDER;
    let mut eye = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        eye = camera(world);
        sun(world);
        tree = still_tree(world);
    });
    let here = pixels(&mut headless, 1.0);
    // A world that moves as a whole, as a floating origin moves it, looks the same.
    let far = Vec3::new(4096.0, 0.0, -2048.0);
    for entity in [tree, eye] {
        headless.app.world_mut().get_mut::<Transform>(entity).unwrap().translation += far;
    }
    let there = pixels(&mut headless, 1.0);
    let differ = apart(&here, &there, 8);
    assert!(differ < 0.02, "{differ} of the pixels differ 4.6 km away");
    headless.app.world_mut().get_mut::<Transform>(tree).unwrap().translation.x += 3.0;
    assert!(apart(&here, &pixels(&mut headless, 1.0), 8) > 0.1, "a tree that has moved");

    headless.app.world_mut().despawn(tree);
    let none = pixels(&mut headless, 1.0);
    assert!(none.iter().all(|p| *p == none[0]), "a despawned tree is not seen");
    assert_eq!(headless.app.world().resource::<WindfallStatus>().forests(), 0);
}

#[test]
fn time_runs_backwards_to_the_same_bytes() {
    let mut headless = app(|world| {
        camera(world);
        sun(world);
        floor(world, 60.0);
        let model = model(world);
        let mut forest = WindfallForest::scattered(vec![model], 4, 5.0);
        forest.shedding.duration = 60.0;
        world.spawn(forest);
    });
    let late = pixels(&mut headless, 25.0);
    let early = pixels(&mut headless, 4.0);
    assert!(apart(&late, &early, 8) > 0.02, "leaves fall");
    assert!(pixels(&mut headless, 25.0) == late, "the same moment after an earlier one");
    assert!(pixels(&mut headless, 4.0) == early, "the same moment after a later one");

    // Bevy's clock drives Windfall's, and a speed below 0 takes it back.
    let run = |headless: &mut scene::headless::Headless, speed: f64, frames: u32| {
        headless.app.world_mut().resource_mut::<WindfallTime>().speed = speed;
        (0..frames).for_each(|_| headless.app.update());
        headless.app.world().resource::<WindfallTime>().seconds
    };
    let there = run(&mut headless, 2.0, 30);
    assert!((there - 5.0).abs() < 1e-6, "30 frames of a 60th, twice as fast: {there}");
    headless.app.world_mut().resource_mut::<Time<Virtual>>().pause();
    assert_eq!(run(&mut headless, 1.0, 3), there, "a paused game");
    headless.app.world_mut().resource_mut::<Time<Virtual>>().unpause();
    let back = run(&mut headless, -1.0, 60);
    assert!((back - 4.0).abs() < 1e-6, "{back}");
    assert!(pixels(&mut headless, back) == early || (back - 4.0).abs() > 0.0);
}

#[test]
fn season_and_hot_reload_change_what_is_seen() {
    let mut tree = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        camera(world);
        sun(world);
        tree = still_tree(world);
    });
    let autumn = pixels(&mut headless, 1.0);
    headless.app.world_mut().entity_mut(tree).insert(Season(0.0));
    let summer = pixels(&mut headless, 1.0);
    let window = [60, 20, 40, 50];
    let green = |p: &[[u8; 4]]| mean(p, 1, window) / mean(p, 0, window);
    assert!(green(&summer) > 1.3 * green(&autumn), "{} {}", green(&summer), green(&autumn));

    // The asset changes, as hot reload changes it: the tree that stands there is another one.
    let handle = headless.app.world().get::<WindfallTree>(tree).unwrap().model.clone();
    let mut models = headless.app.world_mut().resource_mut::<Assets<TreeModel>>();
    let mut half = (*maple().tree).clone();
    half.set_height(4.0);
    *models.get_mut(&handle).unwrap() = TreeModel::from(half);
    let small = pixels(&mut headless, 1.0);
    let covered = |p: &[[u8; 4]]| p.iter().filter(|c| **c != p[0]).count();
    assert!(covered(&small) < covered(&summer) / 2, "{} {}", covered(&small), covered(&summer));
}

#[test]
fn leaves_cast_shadows_and_lie_in_them() {
    let mut tree = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        let eye = camera(world);
        // Onto the floor from above, 30 m beside the tree, whose shadow comes there from outside of all cascades'
        // slabs: the sun is low.
        let above = Transform::from_xyz(-20.0, 9.0, 0.0);
        world.entity_mut(eye).insert(above.looking_at(Vec3::new(-20.0, 0.0, 0.0), Vec3::NEG_Z));
        let sun = sun(world);
        let low = Transform::from_xyz(20.0, 7.0, 0.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.entity_mut(sun).insert(low);
        floor(world, 100.0);
        tree = still_tree(world);
    });
    let shaded = pixels(&mut headless, 1.0);
    headless.app.world_mut().entity_mut(tree).insert(Visibility::Hidden);
    let lit = pixels(&mut headless, 1.0);
    let dark = shaded.iter().zip(&lit).filter(|(a, b)| a[1].saturating_add(30) < b[1]).count();
    let all = lit.len();
    assert!(
        dark > all / 20 && dark < all * 9 / 10,
        "{dark} of {all} pixels lie in the tree's shadow"
    );

    // A Bevy wall between the sun and the tree takes the sun from its leaves.
    let world = headless.app.world_mut();
    world.entity_mut(tree).insert(Visibility::Visible);
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    *cameras.single_mut(world).unwrap() = eye();
    let sunlit = pixels(&mut headless, 1.0);
    let wall = Vec3::new(1.0, 40.0, 40.0);
    let shade = flat_box(headless.app.world_mut(), wall, Vec3::new(14.0, 0.0, 0.0), Color::BLACK);
    let dimmed = pixels(&mut headless, 1.0);
    let window = [60, 15, 40, 50];
    let (before, after) = (mean(&sunlit, 0, window), mean(&dimmed, 0, window));
    assert!(
        after < 0.8 * before,
        "leaves have {after} in the shadow of a wall, {before} in the sun"
    );
    headless.app.world_mut().despawn(shade);
    assert!(pixels(&mut headless, 1.0) == sunlit);
}

#[derive(Resource, Default)]
struct Found(Vec<bevy_windfall::NearLeaf>);

fn look(mut near: LeavesNear, mut found: ResMut<Found>) {
    found.0 = near.find(Vec3::new(0.0, 5.0, 0.0), 20.0);
}

#[test]
fn a_thrown_leaf_is_seen_where_the_query_has_it() {
    let (mut tree, mut eye) = (Entity::PLACEHOLDER, Entity::PLACEHOLDER);
    let mut headless = app(|world| {
        eye = camera(world);
        sun(world);
        tree = still_tree(world);
        let calm = bevy_windfall::windfall::wind::Wind::calm();
        world.entity_mut(tree).insert(bevy_windfall::WindfallWind(calm));
        world.init_resource::<Found>();
    });
    headless.app.add_systems(Last, look);
    let hanging = pixels(&mut headless, 3.0);
    assert_eq!(headless.app.world().resource::<Found>().0, []);
    // The lowest leaves, which fall into the open.
    let foliage = &maple().tree.foliage;
    let mut lowest: Vec<u32> = (0..foliage.leaves.len() as u32).collect();
    lowest.sort_by(|a, b| {
        let height = |leaf: &u32| foliage.leaves[*leaf as usize].center.y;
        height(a).total_cmp(&height(b))
    });
    for &leaf in &lowest[..12] {
        let throw = ThrowLeaf { tree, instance: 0, leaf, time: Some(2.0) };
        headless.app.world_mut().write_message(throw);
    }
    // One that there is not is refused, and the others are not lost by it.
    headless.app.world_mut().write_message(ThrowLeaf { tree, instance: 0, leaf: 9999, time: None });
    let fallen = pixels(&mut headless, 3.0);
    let found = headless.app.world().resource::<Found>().0.clone();
    assert_eq!(found.len(), 12);
    let camera = headless.app.world().get::<Camera>(eye).unwrap();
    let place = headless.app.world().get::<GlobalTransform>(eye).unwrap();
    let mut hits = 0;
    for leaf in &found {
        assert!(leaf.tree == tree && lowest[..12].contains(&leaf.leaf) && leaf.landing > 0.0);
        let at = camera.world_to_viewport(place, leaf.position).unwrap();
        let near = |x: i32, y: i32| {
            let i = (at.y as i32 + y) * SIZE.x as i32 + at.x as i32 + x;
            hanging.get(i as usize) != fallen.get(i as usize)
        };
        // A leaf is some two pixels wide.
        hits += u32::from((-1..=1).any(|x| (-1..=1).any(|y| near(x, y))));
    }
    assert!(hits >= 9, "{hits} of 12 leaves are seen where they should be");
}

#[test]
fn an_orthographic_camera_sees_the_tree_before_and_behind_boxes() {
    let mut wall = Entity::PLACEHOLDER;
    let mut headless = app(|world| {
        let eye = camera(world);
        let scaling_mode = bevy::camera::ScalingMode::FixedVertical { viewport_height: 15.0 };
        let lens = OrthographicProjection { scaling_mode, ..OrthographicProjection::default_3d() };
        world.entity_mut(eye).insert(Projection::Orthographic(lens));
        sun(world);
        still_tree(world);
        let size = Vec3::new(60.0, 60.0, 0.1);
        wall = flat_box(world, size, Vec3::new(0.0, 5.0, -12.0), MAGENTA);
    });
    let behind = pixels(&mut headless, 1.0);
    let covered = behind.iter().filter(|p| !is_magenta(p)).count();
    assert!(covered > 1500, "the tree covers {covered} pixels");
    headless.app.world_mut().get_mut::<Transform>(wall).unwrap().translation.z = 12.0;
    assert!(pixels(&mut headless, 1.0).iter().all(is_magenta), "the wall before the tree");
}
