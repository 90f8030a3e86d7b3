//! Each preset falls as that leaf does.

use windfall_core::glam::DVec3;
use windfall_core::rng::Rng;
use windfall_flight::{Flight, measure, presets};

struct Habit {
    descent: f64,
    half_turns: f64,
    tumbling: f64,
    /// Mean rate of turning about the vertical, rad/s.
    yaw: f64,
}

fn habit(name: &str) -> Habit {
    let plate = presets::find(name).expect("a preset").body.plate();
    let mut h = Habit { descent: 0.0, half_turns: 0.0, tumbling: 0.0, yaw: 0.0 };
    let falls = 20;
    for i in 0..falls {
        let flight =
            plate.fly(Flight::released(&mut Rng::new(5).stream(i)), DVec3::ZERO, 5.0, 250.0);
        let figures = measure::figures(&flight, 250.0, 2.0);
        let late = &flight[500..];
        let yaw = late.iter().map(|s| s.world_spin().y).sum::<f64>() / late.len() as f64;
        let n = f64::from(falls);
        h.descent += figures.descent / n;
        h.half_turns += figures.half_turns / n;
        h.tumbling += f64::from(u8::from(figures.tumbles)) / n;
        h.yaw += yaw.abs() / n;
    }
    println!(
        "{name:8} descent {:.2} m/s, {:.1} half-turns/s, {:.0}% tumble, yaw {:.1} rad/s",
        h.descent,
        h.half_turns,
        h.tumbling * 100.0,
        h.yaw
    );
    h
}

#[test]
fn every_species_falls_in_its_own_way() {
    for name in ["birch", "ash", "oak", "beech", "ginkgo"] {
        let h = habit(name);
        assert!(h.tumbling > 0.6 && h.half_turns > 3.0, "{name}");
        assert!((0.5..1.1).contains(&h.descent), "{name}");
    }
    for name in ["maple", "aspen"] {
        let h = habit(name);
        assert!(h.tumbling < 0.3 && h.half_turns > 2.0, "{name}");
        assert!((0.4..1.0).contains(&h.descent), "{name}");
    }
    let samara = habit("samara");
    assert!(samara.yaw > 35.0 && samara.tumbling < 0.1);
    assert!((0.8..1.8).contains(&samara.descent));
}
