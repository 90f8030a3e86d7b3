use windfall_core::flight::{LeafBody, measure};
#[test]
#[ignore]
fn rows() {
    let e = |n: &str, d: f64| std::env::var(n).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    for d in [0.033, 0.045, 0.055, 0.07, 0.095] {
        let mut b = LeafBody::disc(d, 0.07);
        b.air.broadside = e("N", b.air.broadside);
        b.air.slope = e("K", b.air.slope);
        b.air.friction = e("F", b.air.friction);
        b.air.leading = e("L", b.air.leading);
        b.air.circulation = e("C", b.air.circulation);
        b.air.damping = e("D", b.air.damping);
        let r = measure::row(&b, 60, 1);
        println!(
            "{:.1} cm: descent {:.2} along {:.2} half-turns {:.1} (f d {:.2}) tumbling {:.0}% scatter {:.2}",
            d * 100.0,
            r.descent,
            r.along,
            r.half_turns,
            r.half_turns * d,
            r.tumbling * 100.0,
            r.scatter
        );
    }
}
