//! For any path that is accepted, any leaf, any time: poses are finite and continuous, no leaf sinks
//! into the ground, and none moves once it lies there.

use proptest::prelude::*;
use windfall_core::forest::Terrain;
use windfall_core::glam::{Quat, Vec2, Vec3};
use windfall_core::path::{
    Edition, Fall, FallPath, FallSettings, Hashed, LeafFall, PathSet, Phase, Variation, analysis,
};
use windfall_core::wind::Wind;
use windfall_flight::fall_path;

fn quaternion() -> impl Strategy<Value = Quat> {
    prop::array::uniform4(-1.0f32..1.0).prop_map(|q| {
        let q = Quat::from_array(q);
        if q.length() > 0.1 { q * (1.0 / q.length()) } else { Quat::IDENTITY }
    })
}

/// Jagged paths: random steps that may well lead upwards, random turns up to a full one.
fn path() -> impl Strategy<Value = FallPath> {
    let step = (-0.3f32..0.3, -0.4f32..0.15, -0.3f32..0.3);
    (10.0f32..120.0, prop::collection::vec((step, quaternion()), 8..80)).prop_filter_map(
        "refused",
        |(rate, samples)| {
            let mut at = Vec3::ZERO;
            let (p, q): (Vec<Vec3>, Vec<Quat>) = samples
                .into_iter()
                .map(|((x, y, z), q)| {
                    at += Vec3::new(x, y, z);
                    (at, q)
                })
                .unzip();
            fall_path("random", rate, p, q).ok()
        },
    )
}

fn leaf() -> impl Strategy<Value = LeafFall> {
    let origin = (-40.0f32..40.0, 0.0f32..60.0, -40.0f32..40.0);
    (origin, quaternion(), any::<u32>(), 0.0f64..1e7).prop_map(
        |((x, y, z), twig_orientation, seed, detach_time)| LeafFall {
            origin: Vec3::new(x, y, z),
            twig_orientation,
            tree: Vec3::new(x, 0.0, z),
            seed,
            group: 0,
            detach_time,
        },
    )
}

fn ground() -> impl Strategy<Value = Terrain> {
    prop_oneof![
        Just(Terrain::flat()),
        (-0.5f32..0.5, -0.5f32..0.5).prop_map(|(x, z)| Terrain::slope(Vec2::new(x, z), 30.0)),
        any::<u32>().prop_map(|seed| Terrain::rolling(120.0, 6.0, seed)),
    ]
}

fn variation() -> impl Strategy<Value = Variation> {
    prop_oneof![
        Just(Variation::Paper(Edition::Of2008)),
        Just(Variation::Paper(Edition::Of2007)),
        Just(Variation::Hashed(Hashed::default())),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn falls_are_finite_continuous_and_end_on_the_ground(
        path in path(), leaf in leaf(), ground in ground(), variation in variation(),
        speed in 0.0f32..12.0, share in 0.0f32..1.0,
    ) {
        let rate = path.rate();
        // Leaves hang above the ground.
        let above = ground.height(leaf.origin.x, leaf.origin.z) + 0.05;
        let leaf = LeafFall { origin: leaf.origin + Vec3::Y * above, ..leaf };
        let fastest = path.positions().windows(2)
            .map(|w| (w[1] - w[0]).length()).fold(0.0, f32::max) * rate;
        let paths = PathSet::new(vec![path]).unwrap();
        let wind = Wind::new(speed, share * 6.0, 0.8, leaf.seed);
        let settings = FallSettings::default();
        let fall = Fall::new(&paths, &ground, wind, variation, settings);
        let landing = fall.landing(&leaf);
        prop_assert!(landing.time.is_finite() && landing.position.is_finite());
        prop_assert!((landing.orientation.length() - 1.0).abs() < 1e-3);
        let end = f64::from(landing.time);

        // Horizontal scales go up to 3 (paper); within a sample a path is at most twice as fast as its
        // chords. A blend into a joint adds to a chord c what its weight w(x) makes of the way between
        // the two motions, which meet at x = 1: at most w' 2c (1 - x) = 12 c x (1 - x)^2 < 1.8 c.
        // So short a step that a jump of half a millisecond of 1.1 times such speed shows.
        let dt = 1.9e-4;
        let reach = (fastest * 2.0 * 3.0 * 2.8 + wind.fastest()) * dt as f32 + 2e-3;
        let moments = [0.0, 0.01, end * f64::from(share), end - 0.3, end - 0.01];
        for begin in moments {
            let begin = leaf.detach_time + begin.max(-0.01);
            let mut last = fall.pose(&leaf, &landing, begin);
            for i in 1..106 {
                let pose = fall.pose(&leaf, &landing, begin + f64::from(i) * dt);
                prop_assert!(pose.position.is_finite() && pose.orientation.is_finite());
                prop_assert!((pose.orientation.length() - 1.0).abs() < 1e-3);
                let moved = (pose.position - last.position).length();
                prop_assert!(moved < reach, "moved {moved} of {reach} at {i}");
                // Half a turn from sample to sample, twice as fast as the mean, and the settling.
                let turned = analysis::angle(pose.orientation, last.orientation);
                let most = (8.0 * rate + 30.0) * dt as f32 + 0.02;
                prop_assert!(turned < most, "turned {turned} of {most}");
                if pose.phase != Phase::Landed {
                    let p = pose.position;
                    prop_assert!(p.y - ground.height(p.x, p.z) > -0.01);
                }
                last = pose;
            }
        }
        let lying = fall.pose(&leaf, &landing, leaf.detach_time + end + 1e-3);
        prop_assert_eq!(lying.phase, Phase::Landed);
        let under = ground.height(lying.position.x, lying.position.z);
        prop_assert!((lying.position.y - under).abs() < 1e-4);
        for later in [1.0, 1e3, 1e6] {
            prop_assert_eq!(fall.pose(&leaf, &landing, leaf.detach_time + end + later), lying);
        }
    }

    #[test]
    fn any_time_without_ground_is_finite(path in path(), leaf in leaf(), t in 0.0f32..1e6) {
        let paths = PathSet::new(vec![path]).unwrap();
        let ground = Terrain::flat();
        let fall = Fall::new(
            &paths, &ground, Wind::new(3.0, 0.0, 0.5, 1), Variation::default(),
            FallSettings::default(),
        );
        let pose = fall.airborne(&leaf, &fall.variant(&leaf), t);
        prop_assert!(pose.position.is_finite() && pose.orientation.is_finite());
    }
}
