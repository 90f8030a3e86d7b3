//! Writes a baked tree.

use super::format::{
    Extension, Leaves, Level, Material, Order, Palette, Remark, Shading, Shapes, Surface, View,
    Visibility, Wood,
};
use super::records::{BranchRecord, LeafRecord, ShapeArrays, WoodVertexRecord};
use super::{About, BakeError, EXTENSION, VERSION, check, digest};
use crate::export::{ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, FLOAT, UNSIGNED_INT, Writer};
use bytemuck::NoUninit;
use glam::Vec3;
use serde_json::{Value, json};
use windfall_core::material;
use windfall_core::tree::{self, Tree};

/// What other programs find in a baked tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Viewers {
    /// Wood and leaves: for files that people keep.
    Everything,
    /// The wood alone, which takes no further bytes: for caches.
    Wood,
}

/// Writes a prepared tree as a baked tree: a binary glTF that other programs open, with Windfall's arrays beside.
///
/// What other programs show is what [`crate::export_glb`] would write. The same tree gives the same bytes.
///
/// # Errors
///
/// [`BakeError`]: the tree has not been prepared, holds what no reader would take, or does not fit into a file.
pub fn bake(tree: &Tree, about: &About, viewers: Viewers) -> Result<Vec<u8>, BakeError> {
    let foliage = &tree.foliage;
    let missing = if tree.wood.levels.is_empty() {
        Some("levels of the wood")
    } else if foliage.simple_shapes.len() != foliage.shapes.len() {
        Some("simple shapes of the leaves")
    } else {
        None
    };
    if let Some(missing) = missing {
        return Err(BakeError::NotPrepared { missing });
    }
    check::tree(tree)?;
    if tree.wood.levels[0].indices != tree.wood.indices || tree.wood.levels[0].error != 0.0 {
        let cause = "the first level is not the mesh itself".into();
        return Err(BakeError::Unfit { place: "wood".into(), cause });
    }

    let mut writer = Writer::default();
    writer.reserve(about_bytes(tree, viewers));
    let mut nodes = Vec::new();
    let wood = wood(&mut writer, &mut nodes, &tree.wood)?;
    if viewers == Viewers::Everything {
        writer.leaves(tree, &mut nodes, false)?;
    }
    let records: Vec<LeafRecord> = foliage.leaves.iter().map(LeafRecord::from).collect();
    let (seen, shading) = (&foliage.visibility, &foliage.shading);
    let leaves = Leaves {
        records: view(&mut writer, &records),
        shapes: shapes(&mut writer, &ShapeArrays::of(foliage.shapes.iter().map(Some))),
        simple_shapes: shapes(
            &mut writer,
            &ShapeArrays::of(foliage.simple_shapes.iter().map(Option::as_ref)),
        ),
        materials: materials(&mut writer, &foliage.materials)?,
        palette: foliage.palette.as_ref().map(|palette| Palette {
            stops: palette.stops.iter().map(Vec3::to_array).collect(),
            spread: palette.spread,
        }),
        crown_center: foliage.crown_center.to_array(),
        visibility: Visibility {
            share: seen.share,
            disocclusion: seen.disocclusion,
            sunlight: seen.sunlight,
        },
        shading: Shading {
            ambient: shading.ambient.to_array(),
            normals: shading.normals.to_cols_array(),
        },
    };
    let extension = Extension {
        version: VERSION,
        digest: digest::blank(),
        source: about.source.to_string(),
        prune_order: about.prune_order.map(|(name, seed)| Order { name, seed }),
        notes: about
            .notes
            .iter()
            .map(|note| Remark {
                code: note.code,
                place: note.place.clone(),
                message: note.message.clone(),
            })
            .collect(),
        name: tree.name.clone(),
        wood,
        leaves,
    };
    let content = serde_json::to_value(&extension)
        .map_err(|error| BakeError::Unfit { place: EXTENSION.into(), cause: error.to_string() })?;
    let mut bytes = writer.finish(&tree.name, &nodes, Some((EXTENSION, content)))?;
    digest::seal(&mut bytes);
    Ok(bytes)
}

/// Bytes of the arrays, about: without pictures.
fn about_bytes(tree: &Tree, viewers: Viewers) -> usize {
    let levels: usize = tree.wood.levels.iter().map(|level| level.indices.len()).sum();
    let vertex = size_of::<WoodVertexRecord>() + size_of::<BranchRecord>();
    let wood = tree.wood.vertices.len() * vertex + levels * size_of::<u32>();
    let leaves = tree.foliage.leaves.len() * size_of::<LeafRecord>();
    // Place, normal, texture coordinates and leaf of each vertex.
    let vertices = tree.foliage.vertex_count() * 12 * size_of::<f32>();
    let shown = vertices + tree.foliage.triangle_count() * 3 * size_of::<u32>();
    wood + leaves + if viewers == Viewers::Everything { shown } else { 0 }
}

/// Writes an array; nothing where there are no elements.
fn view<T: NoUninit>(writer: &mut Writer, elements: &[T]) -> View {
    (!elements.is_empty()).then(|| writer.view(bytemuck::cast_slice(elements), None))
}

fn shapes(writer: &mut Writer, arrays: &ShapeArrays) -> Shapes {
    Shapes {
        counts: view(writer, &arrays.counts),
        vertices: view(writer, &arrays.vertices),
        indices: view(writer, &arrays.indices),
    }
}

/// Writes the wood: the mesh that other programs show refers to the same arrays.
fn wood(writer: &mut Writer, nodes: &mut Vec<Value>, wood: &tree::Wood) -> Result<Wood, BakeError> {
    let records: Vec<WoodVertexRecord> = wood.vertices.iter().map(From::from).collect();
    let vertices = (!records.is_empty())
        .then(|| writer.view(bytemuck::cast_slice(&records), Some(ARRAY_BUFFER)));
    let indices = (!wood.indices.is_empty())
        .then(|| writer.view(bytemuck::cast_slice(&wood.indices), Some(ELEMENT_ARRAY_BUFFER)));
    if let (Some(vertices), Some(indices)) = (vertices, indices) {
        writer.buffer_views[vertices]["byteStride"] = json!(size_of::<WoodVertexRecord>());
        mesh(writer, nodes, wood, vertices, indices)?;
    }
    let branches: Vec<BranchRecord> = wood.branches.iter().map(From::from).collect();
    Ok(Wood {
        vertices,
        indices,
        branches: view(writer, &branches),
        levels: wood.levels[1..]
            .iter()
            .map(|level| Level { indices: view(writer, &level.indices), error: level.error })
            .collect(),
        materials: materials(writer, &wood.materials)?,
        outward: wood.outward,
    })
}

/// A mesh `wood` over views that are there, with a primitive per material.
fn mesh(
    writer: &mut Writer,
    nodes: &mut Vec<Value>,
    wood: &tree::Wood,
    vertices: usize,
    indices: usize,
) -> Result<(), BakeError> {
    let count = wood.vertices.len();
    let attribute = |writer: &mut Writer, offset: usize, kind: &str| {
        writer.accessors.push(json!({
            "bufferView": vertices, "byteOffset": offset, "componentType": FLOAT,
            "count": count, "type": kind,
        }));
        writer.accessors.len() - 1
    };
    let positions = attribute(writer, 0, "VEC3");
    let normals = attribute(writer, 12, "VEC3");
    let uvs = attribute(writer, 24, "VEC2");
    let (low, high) =
        wood.vertices.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), v| {
            (l.min(v.position), h.max(v.position))
        });
    writer.accessors[positions]["min"] = json!(low.to_array());
    writer.accessors[positions]["max"] = json!(high.to_array());

    let mut primitives = Vec::new();
    for (number, material) in (0..).zip(&wood.materials) {
        let is_own = |t: &[u32]| wood.vertices[t[0] as usize].material == number;
        let own: Vec<usize> = wood
            .indices
            .chunks_exact(3)
            .enumerate()
            .filter(|(_, triangle)| is_own(triangle))
            .map(|(i, _)| i)
            .collect();
        let (Some(&first), Some(&last)) = (own.first(), own.last()) else { continue };
        // One run of triangles, as most trees have for each material, lies in the array itself.
        let (view, offset) = if last - first + 1 == own.len() {
            (indices, first * 3 * size_of::<u32>())
        } else {
            let list: Vec<u32> =
                own.iter().flat_map(|&i| &wood.indices[3 * i..3 * i + 3]).copied().collect();
            (writer.view(bytemuck::cast_slice(&list), Some(ELEMENT_ARRAY_BUFFER)), 0)
        };
        writer.accessors.push(json!({
            "bufferView": view, "byteOffset": offset, "componentType": UNSIGNED_INT,
            "count": 3 * own.len(), "type": "SCALAR",
        }));
        let list = writer.accessors.len() - 1;
        let label = match primitives.len() {
            0 => "wood".to_owned(),
            before => format!("wood {}", before + 1),
        };
        primitives.push(json!({
            "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
            "indices": list,
            "material": writer.material(&label, material, None)?,
        }));
    }
    nodes.push(json!({ "name": "wood", "mesh": writer.meshes.len() }));
    writer.meshes.push(json!({ "name": "wood", "primitives": primitives }));
    Ok(())
}

fn materials(
    writer: &mut Writer,
    materials: &[material::Material],
) -> Result<Vec<Material>, BakeError> {
    let mut list = Vec::with_capacity(materials.len());
    for material in materials {
        list.push(Material {
            name: material.name.clone(),
            base_color: material.base_color.to_array(),
            roughness: material.roughness,
            alpha_cutoff: material.alpha_cutoff,
            surface: match &material.surface {
                material::Surface::Plain => Surface::Plain,
                material::Surface::Texture(image, repeat) => Surface::Texture {
                    image: writer.image(image, &material.name)?,
                    repeat: *repeat,
                },
                material::Surface::Bark(bark) => Surface::Bark {
                    ridge: bark.ridge.to_array(),
                    groove: bark.groove.to_array(),
                    scale: bark.scale,
                    pattern: bark.pattern.into(),
                },
            },
        });
    }
    Ok(list)
}
