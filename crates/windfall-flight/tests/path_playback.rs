//! Playback: continuous, endless, on the ground and no further.

use windfall_core::forest::Terrain;
use windfall_core::glam::{Quat, Vec2, Vec3};
use windfall_core::path::{
    Fall, FallPath, FallSettings, LeafFall, PathSet, Phase, Variation, analysis,
};
use windfall_core::rng::{Rng, hash};
use windfall_core::wind::Wind;
use windfall_flight::fall_path;

/// A leaf that swings from side to side as it comes down, turning slowly about Y.
fn swinging(n: usize, rate: f32) -> FallPath {
    let at = |i: usize| {
        let t = i as f32 / rate;
        let phase = 5.0 * t;
        let position =
            Vec3::new(0.3 * phase.sin(), -0.8 * t + 0.05 * (2.0 * phase).sin(), 0.2 * t.sin());
        (position, Quat::from_rotation_y(0.4 * t) * Quat::from_rotation_z(0.9 * phase.cos()))
    };
    let (p, q) = (0..n).map(at).unzip();
    fall_path("swinging", rate, p, q).expect("it descends")
}

fn leaf(seed: u32, origin: Vec3) -> LeafFall {
    let mut rng = Rng::new(seed);
    let mut u = || rng.range(-1.0, 1.0);
    let twig_orientation = Quat::from_xyzw(u(), u(), u(), u()).normalize();
    let tree = origin.with_y(0.0);
    LeafFall { origin, twig_orientation, tree, seed, group: hash(seed, 99) % 8, detach_time: 10.0 }
}

/// Largest step of position (m) and orientation (rad) between times `dt` apart.
fn largest_steps(fall: &Fall, leaf: &LeafFall, from: f64, to: f64, dt: f64) -> (f32, f32) {
    let landing = fall.landing(leaf);
    let mut largest = (0.0f32, 0.0f32);
    let mut last = fall.pose(leaf, &landing, from);
    for i in 1..=((to - from) / dt) as u32 {
        let pose = fall.pose(leaf, &landing, from + f64::from(i) * dt);
        assert!(pose.position.is_finite() && pose.orientation.is_finite());
        assert!((pose.orientation.length() - 1.0).abs() < 1e-4);
        largest.0 = largest.0.max((pose.position - last.position).length());
        largest.1 = largest.1.max(analysis::angle(pose.orientation, last.orientation));
        last = pose;
    }
    largest
}

#[test]
fn a_fall_from_500_m_is_continuous_through_all_its_laps() {
    for paths in [PathSet::new(vec![swinging(200, 30.0)]).unwrap(), PathSet::builtin()] {
        let ground = Terrain::flat();
        let wind = Wind::new(3.0, 0.4, 0.7, 5);
        let fall = Fall::new(&paths, &ground, wind, Variation::default(), FallSettings::default());
        for seed in 0..40 {
            let leaf = leaf(seed, Vec3::new(3.0, 500.0, -2.0));
            let landing = fall.landing(&leaf);
            assert!(landing.position.y == 0.0);
            // 500 m at 0.3 to 2 m/s.
            assert!((200.0..2000.0).contains(&landing.time), "{}", landing.time);
            let mut laps = 0;
            if let Phase::Falling { lap } =
                fall.pose(&leaf, &landing, 10.0 + f64::from(landing.time) - 0.01).phase
            {
                laps = lap;
            }
            assert!(laps > 20, "{laps} laps");
            // 10 m/s and 200 rad/s at the very most, and the clock's grain of 0.06 ms.
            let end = 10.0 + f64::from(landing.time);
            let steps = largest_steps(&fall, &leaf, end - 30.0, end + 1.0, 1e-3);
            assert!(steps.0 < 0.012 && steps.1 < 0.25, "seed {seed}: {steps:?}");
            let steps = largest_steps(&fall, &leaf, 9.9, 40.0, 1e-3);
            assert!(steps.0 < 0.012 && steps.1 < 0.25, "seed {seed}: {steps:?}");
        }
    }
}

#[test]
fn a_leaf_lands_where_it_first_meets_the_slope() {
    let paths = PathSet::builtin();
    for ground in [
        Terrain::flat(),
        Terrain::slope(Vec2::new(0.6, -0.3), 400.0),
        Terrain::rolling(400.0, 12.0, 3),
    ] {
        let wind = Wind::new(2.0, 1.0, 0.5, 5);
        let fall = Fall::new(&paths, &ground, wind, Variation::default(), FallSettings::default());
        for seed in 0..200 {
            let (x, z) = ((seed as f32 * 7.3) % 300.0 - 150.0, (seed as f32 * 3.1) % 300.0 - 150.0);
            let leaf = leaf(seed, Vec3::new(x, ground.height(x, z) + 8.0, z));
            let landing = fall.landing(&leaf);
            let above = |t: f32| {
                let p = fall.pose(&leaf, &landing, 10.0 + f64::from(t)).position;
                p.y - ground.height(p.x, p.z)
            };
            assert!(above(landing.time + 0.1).abs() < 1e-4);
            let mut t = 0.0;
            while t < landing.time - 1e-3 {
                assert!(above(t) > -0.003, "seed {seed}: {} at {t} of {landing:?}", above(t));
                t += 0.004;
            }
            assert!(above(landing.time - 1e-4) < 0.01);
            let up = landing.orientation * Vec3::Y;
            let normal = ground.normal(landing.position.x, landing.position.z);
            assert!(up.dot(normal).abs() > 0.9999);
        }
    }
}
