//! Time to prepare a tree: prune orders, measurements of the crown, levels of the wood.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use windfall_core::simplify::PruneOrder;
use windfall_tree::Species;
use windfall_tree::prepare::{openness, prepare_wood, set_prune_order, visibility};

fn prepare(c: &mut Criterion) {
    let mut group = c.benchmark_group("prepare");
    group.sample_size(10);
    let many = Species::Birch.grow_with(1, 100_000).foliage;
    for order in PruneOrder::ALL {
        group.bench_function(format!("{order} order of 100,000 leaves"), |b| {
            b.iter_batched(
                || many.clone(),
                |mut foliage| set_prune_order(&mut foliage, order, 1),
                BatchSize::LargeInput,
            );
        });
    }
    for species in [Species::Oak, Species::Birch] {
        let tree = species.grow(0);
        let about = format!("{species}, {} leaves", tree.foliage.leaves.len());
        group.bench_function(format!("visibility: {about}"), |b| {
            b.iter(|| visibility(black_box(&tree.foliage)));
        });
        group.bench_function(format!("openness: {about}"), |b| {
            b.iter(|| openness(black_box(&tree.foliage)));
        });
        let triangles = tree.wood_triangles();
        group.bench_function(format!("wood levels: {species}, {triangles} triangles"), |b| {
            b.iter_batched(
                || tree.wood.clone(),
                |mut wood| prepare_wood(black_box(&mut wood)),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, prepare);
criterion_main!(benches);
