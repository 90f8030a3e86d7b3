//! What is despawned leaves nothing behind.

mod scene;

use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::renderer::RenderInstance;
use bevy_windfall::windfall::shed::Shedding;
use bevy_windfall::{LeafBudget, WindfallForest, WindfallStatus, WindfallTree};
use scene::headless::Headless;
use scene::{app, camera, model};

/// Buffers, textures, views and bind groups of the device.
fn resources(headless: &Headless) -> [usize; 4] {
    let instance = headless.app.sub_app(RenderApp).world().resource::<RenderInstance>();
    let report = instance.generate_report().expect("the instance has a hub");
    let hub = report.hub_report();
    [&hub.buffers, &hub.textures, &hub.texture_views, &hub.bind_groups].map(|r| r.num_allocated)
}

/// Memory of the process, MiB; where the system does not say, 0.
fn memory() -> f32 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = statm.split_whitespace().nth(1).and_then(|pages| pages.parse::<f32>().ok());
    pages.unwrap_or(0.0) * 4096.0 / (1024.0 * 1024.0)
}

#[test]
fn a_thousand_forests_leave_no_memory_behind() {
    let mut of_model = Handle::default();
    let mut headless = app(|world| {
        camera(world);
        of_model = model(world);
    });
    // The renderer is built while there is a forest.
    let first = headless.app.world_mut().spawn(WindfallTree::new(of_model.clone(), 0)).id();
    headless.settle(1.0);
    headless.app.world_mut().despawn(first);
    let round = |headless: &mut Headless, seed: u32| {
        let spawn = |i: u32| {
            let forest = WindfallForest { shedding: Shedding::never(), ..default() };
            let at = Transform::from_xyz(i as f32 - 10.0, 0.0, 0.0);
            (WindfallTree::new(of_model.clone(), seed + i), forest, LeafBudget(1000), at)
        };
        let forests: Vec<Entity> =
            (0..25).map(|i| headless.app.world_mut().spawn(spawn(i)).id()).collect();
        headless.app.update();
        headless.app.update();
        let status = headless.app.world().resource::<WindfallStatus>();
        assert_eq!((status.forests(), status.views(), status.waiting()), (25, 25, 0));
        assert!(status.bytes() > 0);
        forests.into_iter().for_each(|forest| {
            headless.app.world_mut().despawn(forest);
        });
        (0..3).for_each(|_| headless.app.update());
        assert_eq!(headless.app.world().resource::<WindfallStatus>().forests(), 0);
    };
    // What is kept for good is there after the first rounds.
    (0..4).for_each(|i| round(&mut headless, i * 25));
    let (before, held) = (resources(&headless), memory());
    (4..40).for_each(|i| round(&mut headless, i * 25));
    let (after, now) = (resources(&headless), memory());
    assert_eq!(before, after, "buffers, textures, views, bind groups");
    // 900 forests of one tree have some 200 MB: a hundredth of that would show.
    assert!(now - held < 24.0, "{held} MiB before, {now} MiB after");
}
