//! Nanoseconds for a pose on one thread, soon after the detachment and hours later: the same.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use windfall_core::forest::Terrain;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{Fall, FallSettings, LeafFall, PathSet, Variation};
use windfall_core::rng::hash;
use windfall_core::wind::Wind;

fn pose(c: &mut Criterion) {
    let (paths, ground) = (PathSet::builtin(), Terrain::flat());
    let wind = Wind::new(3.0, 0.5, 0.5, 1);
    let fall = Fall::new(&paths, &ground, wind, Variation::default(), FallSettings::default());
    let birch = paths.group("birch").unwrap_or(0);
    // From 100 km up: in the air at all times. One species, as in one draw: its paths stay in cache.
    let leaves: Vec<_> = (0..1024u32)
        .map(|i| {
            let leaf = LeafFall {
                origin: Vec3::new(i as f32, 1e5, 0.0),
                twig_orientation: Quat::IDENTITY,
                tree: Vec3::ZERO,
                seed: hash(1, i),
                group: birch,
                detach_time: 0.0,
            };
            (leaf, fall.landing(&leaf))
        })
        .collect();
    let mut group = c.benchmark_group("pose");
    group.throughput(criterion::Throughput::Elements(leaves.len() as u64));
    for time in [1.0, 100.0, 10_000.0] {
        group.bench_function(format!("1024 leaves at t = {time} s"), |b| {
            b.iter(|| {
                for (leaf, landing) in &leaves {
                    black_box(fall.pose(black_box(leaf), landing, black_box(time)));
                }
            });
        });
    }
    group.finish();
    let low = LeafFall { origin: Vec3::new(0.0, 10.0, 0.0), ..leaves[0].0 };
    c.bench_function("landing from 10 m", |b| b.iter(|| fall.landing(black_box(&low))));
}

criterion_group!(benches, pose);
criterion_main!(benches);
