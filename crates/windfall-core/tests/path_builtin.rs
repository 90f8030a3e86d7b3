//! The built-in paths: what they promise.

use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{PathSet, PathTables, analysis};

#[test]
fn every_species_has_its_paths_and_they_are_small() {
    let set = PathSet::builtin();
    assert_eq!(
        set.groups(),
        ["oak", "maple", "birch", "beech", "aspen", "ginkgo", "ash", "samara"]
    );
    assert!(set.tables().groups.iter().all(|group| group[1] == 2));
    assert!(set.to_bytes().len() < 150_000);
}

/// Position, velocity, orientation and angular velocity on both sides of every joint, by one-sided
/// differences on the curve that is played, as fine as `f32` allows, in double precision.
#[test]
fn joints_cannot_be_seen() {
    let set = PathSet::builtin();
    let tables = set.tables();
    for (path, record) in set.paths().iter().zip(&tables.paths) {
        let mean_speed = path.positions().windows(2).map(|w| (w[1] - w[0]).length()).sum::<f32>()
            / path.duration();
        let turn_of = |a: Quat, b: Quat| (b * a.conjugate()).to_scaled_axis();
        let q = path.orientations();
        let mean_spin =
            q.windows(2).map(|w| turn_of(w[0], w[1]).length()).sum::<f32>() / path.duration();
        for (k, stored) in path.analysis().joints.iter().enumerate() {
            let joint = &tables.joints[record.first_joint as usize + k];
            let turn = stored.rotation();
            let at = |u: f32| tables.curve(record, joint, u);
            let (from, to) = (joint.from as f32, joint.to as f32);
            // Second-order one-sided differences over an eighth of a sample.
            let e = 0.125;
            let [b2, b1, b0] = [2.0, 1.0, 0.0].map(|n| at(from - n * e));
            let [a0, a1, a2] = [0.0, 1.0, 2.0].map(|n| at(to + n * e));
            let lap = Vec3::from(joint.lap);
            assert!((b0.position - a0.position - lap).length() < 1e-4);
            let rate = path.rate() / e;
            let before = (b0.position * 3.0 - b1.position * 4.0 + b2.position) * 0.5 * rate;
            let after = (a1.position * 4.0 - a0.position * 3.0 - a2.position) * 0.5 * rate;
            let velocity = (turn * after - before).length() / mean_speed;
            assert!(velocity < 0.02, "{} joint {k}: velocity {velocity}", path.name());
            let orientation = analysis::angle(b0.orientation, turn * a0.orientation);
            assert!(orientation < 0.5f32.to_radians());
            let spin = |near: Quat, next: Quat, far: Quat| {
                (turn_of(near, next) * 4.0 - turn_of(near, far)) * 0.5 * rate
            };
            let before = -spin(b0.orientation, b1.orientation, b2.orientation);
            let after = turn * spin(a0.orientation, a1.orientation, a2.orientation);
            let spin = (after - before).length() / mean_spin.max(1.0);
            assert!(spin < 0.05, "{} joint {k}: angular velocity {spin}", path.name());
            // What is stored says the same.
            let gap = stored.blended;
            assert!(gap.position < 1e-4 && gap.velocity < 0.02 && gap.angular_velocity < 0.05);
            assert_eq!(PathTables::index(record, joint, joint.blend_start), joint.tail as usize);
        }
    }
}
