//! What simplification takes when a model is made: prune orders, looks at the crown, wood levels.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use windfall_core::simplify::{PruneOrder, SimpleWood, Visibility, openness};
use windfall_core::tree::species::Species;

fn simplify(c: &mut Criterion) {
    let mut group = c.benchmark_group("simplify");
    group.sample_size(10);
    let many = Species::Birch.grow_with(1, 100_000).foliage;
    for order in PruneOrder::ALL {
        group.bench_function(format!("{order} order of 100,000 leaves"), |b| {
            b.iter_batched(
                || many.clone(),
                |mut foliage| foliage.set_prune_order(order, 1),
                BatchSize::LargeInput,
            );
        });
    }
    for species in [Species::Oak, Species::Birch] {
        let tree = species.grow(0);
        let about = format!("{species}, {} leaves", tree.foliage.leaves.len());
        group.bench_function(format!("visibility: {about}"), |b| {
            b.iter(|| Visibility::of(black_box(&tree.foliage)));
        });
        group.bench_function(format!("openness: {about}"), |b| {
            b.iter(|| openness(black_box(&tree.foliage)));
        });
        let triangles = tree.wood_triangles();
        group.bench_function(format!("wood levels: {species}, {triangles} triangles"), |b| {
            b.iter(|| SimpleWood::new(black_box(&tree.wood)));
        });
    }
    group.finish();
}

criterion_group!(benches, simplify);
criterion_main!(benches);
