//! A mesh of the ground that leaves land on.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use windfall::forest::Terrain;

/// The terrain as a mesh about the forest's place, with normals, and texture coordinates in metres. Its triangles are
/// those that leaves land on. Level ground, which has no edge, becomes a square of `extent` metres; other terrains have
/// the extent of their own.
pub fn ground_mesh(terrain: &Terrain, extent: f32) -> Mesh {
    let (low, high) = terrain.range();
    let level = low == high;
    let side = if level { 2 } else { terrain.side() };
    let cell = if level { extent } else { terrain.cell() };
    let half = 0.5 * cell * (side - 1) as f32;
    let places = || {
        (0..side * side)
            .map(move |i| [(i % side) as f32, (i / side) as f32].map(|k| k * cell - half))
    };
    let positions: Vec<[f32; 3]> = places().map(|[x, z]| [x, terrain.height(x, z), z]).collect();
    let normals: Vec<[f32; 3]> = places().map(|[x, z]| terrain.normal(x, z).to_array()).collect();
    let uvs: Vec<[f32; 2]> = places().collect();
    let indices = (0..side - 1)
        .flat_map(|row| (0..side - 1).map(move |column| row * side + column))
        .flat_map(|i| [i, i + side, i + 1, i + 1, i + side, i + side + 1])
        .collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(indices))
}
