//! Poses after ten days are as precise as at once: times are `f64` until one is taken from another.

use windfall_core::forest::Terrain;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{Fall, FallSettings, LeafFall, PathSet, Variation, analysis};
use windfall_core::rng::hash;
use windfall_core::wind::Wind;

/// Ten days, in whole periods of the wind: 844 of 1024 s.
const TEN_DAYS: f64 = 844.0 * Wind::PERIOD;

fn leaf(seed: u32, detach_time: f64) -> LeafFall {
    LeafFall {
        origin: Vec3::new(3.0, 30.0, -2.0),
        twig_orientation: Quat::from_rotation_x(0.4),
        tree: Vec3::new(4.0, 0.0, -2.0),
        seed,
        group: hash(seed, 99) % 8,
        detach_time,
    }
}

#[test]
fn a_fall_ten_days_later_is_the_same() {
    const { assert!(TEN_DAYS >= 864_000.0) };
    let (paths, ground) = (PathSet::builtin(), Terrain::rolling(100.0, 3.0, 4));
    let wind = Wind::new(4.0, 0.4, 0.8, 5);
    let fall = Fall::new(&paths, &ground, wind, Variation::default(), FallSettings::default());
    for seed in 0..20 {
        let [soon, late] = [10.1, 10.1 + TEN_DAYS].map(|t| leaf(seed, t));
        let landings = [&soon, &late].map(|leaf| fall.landing(leaf));
        assert!((landings[0].time - landings[1].time).abs() < 1e-4, "{landings:?}");
        for step in 0..600 {
            let t = 10.0 + f64::from(step) * 0.0517;
            let a = fall.pose(&soon, &landings[0], t);
            let b = fall.pose(&late, &landings[1], t + TEN_DAYS);
            let apart = a.position.distance(b.position);
            assert!(apart < 1e-3, "seed {seed}, {t} s: {apart} m");
            let turned = analysis::angle(a.orientation, b.orientation);
            assert!(turned < 5e-3, "seed {seed}, {t} s: {turned} rad");
        }
    }
}

/// A tenth of a millisecond at a time: with times in `f32`, of which two are 62 ms apart at 864,000 s, a leaf would
/// stand still for 600 steps and then jump.
#[test]
fn a_leaf_moves_smoothly_after_ten_days() {
    let (paths, ground) = (PathSet::builtin(), Terrain::flat());
    let wind = Wind::new(4.0, 0.4, 0.8, 5);
    let fall = Fall::new(&paths, &ground, wind, Variation::default(), FallSettings::default());
    let leaf = leaf(3, 864_000.1);
    let landing = fall.landing(&leaf);
    let at = |t: f64| fall.pose(&leaf, &landing, 864_000.1 + t).position;
    let mut still = 0;
    for step in 0..5000 {
        let t = 3.0 + f64::from(step) * 1e-4;
        let moved = at(t).distance(at(t + 1e-4));
        // It falls and is carried at some metres per second; what is left of 10 m/s is rounding.
        assert!(moved < 1e-3, "{t}: {moved}");
        still += u32::from(moved == 0.0);
    }
    assert!(still < 50, "stands still in {still} of 5000 steps");
}
