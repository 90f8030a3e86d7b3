//! Trees, leaves and ground as meshes with materials.

use super::text::{LENGTH, Text, UNIT};
use crate::frame::{Kind, Source};
use crate::mesh::{Mesh, picture};
use crate::{GROUND_COLOR, plain_color, short_name};
use glam::Vec2;
use std::io;
use windfall_core::material::{Material, Surface};

/// A name that USD takes: letters, digits and underscores, not a digit first.
pub fn identifier(name: &str) -> String {
    let mut out: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert(0, '_');
    }
    out
}

/// Name of a tree model's prim.
pub fn tree_name(source: &Source<'_>, model: u32) -> String {
    identifier(&format!("Tree_{model}_{}", short_name(&source.trees[model as usize].name)))
}

/// Name of the prim of a kind of leaf.
pub fn leaf_name(source: &Source<'_>, kind: Kind) -> String {
    let Kind { model, shape, material } = kind;
    let name = short_name(&source.trees[model as usize].name);
    identifier(&format!("Leaf_{model}_{name}_{shape}_{material}"))
}

/// File of a material's texture: of the wood, or of the leaves.
pub fn texture_name(model: u32, part: &str, material: usize) -> String {
    format!("tree_{model}_{part}_{material}.png")
}

/// What a mesh's material is made of.
struct Look<'a> {
    material: &'a Material,
    /// Its texture, if it has one.
    texture: Option<String>,
}

/// Writes a tree model: its wood as one mesh for each material.
pub fn tree(text: &mut Text<'_>, source: &Source<'_>, model: u32, folder: &str) -> io::Result<()> {
    let wood = &source.trees[model as usize].wood;
    text.open(format_args!("def Xform \"{}\"", tree_name(source, model)))?;
    let parts = Mesh::of_wood(wood);
    for (material, part) in &parts {
        mesh(text, &format!("Wood_{material}"), part, false)?;
    }
    text.open(format_args!("def Scope \"Looks\""))?;
    let parent = format!("/Models/{}/Looks", tree_name(source, model));
    for (number, _) in &parts {
        let material = &wood.materials[*number];
        let texture =
            picture(material).map(|_| format!("{folder}/{}", texture_name(model, "wood", *number)));
        let look = Look { material, texture };
        self::material(text, &parent, &format!("Wood_{number}"), &look)?;
    }
    text.close()?;
    text.close()
}

/// Writes a kind of leaf.
pub fn leaf(text: &mut Text<'_>, source: &Source<'_>, kind: Kind, folder: &str) -> io::Result<()> {
    let foliage = &source.trees[kind.model as usize].foliage;
    let name = leaf_name(source, kind);
    text.open(format_args!("def Xform \"{name}\""))?;
    let material = foliage.materials.get(kind.material as usize);
    let shape = Mesh::of_leaf(&foliage.shapes[kind.shape as usize]);
    mesh(text, "Leaf", &shape, true)?;
    if let Some(material) = material {
        text.open(format_args!("def Scope \"Looks\""))?;
        let texture = picture(material).map(|_| {
            format!("{folder}/{}", texture_name(kind.model, "leaves", kind.material as usize))
        });
        let look = Look { material, texture };
        self::material(text, &format!("/Models/{name}/Looks"), "Leaf", &look)?;
        text.close()?;
    }
    text.close()
}

/// Writes the ground.
pub fn ground(text: &mut Text<'_>, source: &Source<'_>) -> io::Result<()> {
    text.open(format_args!("def Xform \"Ground\""))?;
    mesh(text, "Terrain", &Mesh::of_ground(source), false)?;
    text.open(format_args!("def Scope \"Looks\""))?;
    let soil = Material {
        name: "ground".to_owned(),
        base_color: GROUND_COLOR,
        roughness: 1.0,
        alpha_cutoff: None,
        surface: Surface::Plain,
    };
    material(text, "/World/Ground/Looks", "Terrain", &Look { material: &soil, texture: None })?;
    text.close()?;
    text.close()
}

/// Writes a mesh, bound to the material of its name in the scope `Looks` beside it.
fn mesh(text: &mut Text<'_>, name: &str, mesh: &Mesh, both_sides: bool) -> io::Result<()> {
    text.line(format_args!("def Mesh \"{name}\" ("))?;
    text.line(format_args!("    prepend apiSchemas = [\"MaterialBindingAPI\"]"))?;
    text.open(format_args!(")"))?;
    let (low, high) = mesh.bounds();
    text.array("float3[] extent", [low, high], LENGTH, "")?;
    let faces = mesh.indices.len() / 3;
    text.array("int[] faceVertexCounts", std::iter::repeat_n(3u32, faces), 0, "")?;
    text.array("int[] faceVertexIndices", mesh.indices.iter().copied(), 0, "")?;
    text.array("point3f[] points", mesh.positions.iter().copied(), UNIT, "")?;
    let vertex = " (\n            interpolation = \"vertex\"\n        )";
    text.array("normal3f[] normals", mesh.normals.iter().copied(), UNIT, vertex)?;
    if !mesh.uvs.is_empty() {
        // USD counts from the bottom of the picture.
        let uvs = mesh.uvs.iter().map(|uv| Vec2::new(uv.x, 1.0 - uv.y));
        text.array("texCoord2f[] primvars:st", uvs, UNIT, vertex)?;
    }
    text.line(format_args!("uniform token subdivisionScheme = \"none\""))?;
    if both_sides {
        text.line(format_args!("uniform bool doubleSided = 1"))?;
    }
    text.line(format_args!("rel material:binding = <../Looks/{name}>"))?;
    text.close()
}

/// Writes a UsdPreviewSurface.
fn material(text: &mut Text<'_>, parent: &str, name: &str, look: &Look<'_>) -> io::Result<()> {
    let color = plain_color(look.material);
    let color = format!("({:.5}, {:.5}, {:.5})", color.x, color.y, color.z);
    let path = format!("{parent}/{name}");
    text.open(format_args!("def Material \"{name}\""))?;
    text.line(format_args!("token outputs:surface.connect = <{path}/Surface.outputs:surface>"))?;
    text.open(format_args!("def Shader \"Surface\""))?;
    text.line(format_args!("uniform token info:id = \"UsdPreviewSurface\""))?;
    if look.texture.is_some() {
        text.line(format_args!(
            "color3f inputs:diffuseColor.connect = <{path}/Texture.outputs:rgb>"
        ))?;
        if let Some(cutoff) = look.material.alpha_cutoff {
            text.line(format_args!("float inputs:opacity.connect = <{path}/Texture.outputs:a>"))?;
            text.line(format_args!("float inputs:opacityThreshold = {cutoff}"))?;
        }
    } else {
        text.line(format_args!("color3f inputs:diffuseColor = {color}"))?;
    }
    text.line(format_args!("float inputs:metallic = 0"))?;
    text.line(format_args!("float inputs:roughness = {}", look.material.roughness))?;
    text.line(format_args!("token outputs:surface"))?;
    text.close()?;
    if let Some(file) = &look.texture {
        text.open(format_args!("def Shader \"Texture\""))?;
        text.line(format_args!("uniform token info:id = \"UsdUVTexture\""))?;
        text.line(format_args!("asset inputs:file = @{file}@"))?;
        text.line(format_args!("token inputs:sourceColorSpace = \"sRGB\""))?;
        text.line(format_args!("float2 inputs:st.connect = <{path}/Place.outputs:result>"))?;
        let repeat = picture(look.material).is_some_and(|(_, repeat)| repeat);
        let wrap = if repeat { "repeat" } else { "clamp" };
        text.line(format_args!("token inputs:wrapS = \"{wrap}\""))?;
        text.line(format_args!("token inputs:wrapT = \"{wrap}\""))?;
        text.line(format_args!("float3 outputs:rgb"))?;
        text.line(format_args!("float outputs:a"))?;
        text.close()?;
        text.open(format_args!("def Shader \"Place\""))?;
        text.line(format_args!("uniform token info:id = \"UsdPrimvarReader_float2\""))?;
        text.line(format_args!("string inputs:varname = \"st\""))?;
        text.line(format_args!("float2 outputs:result"))?;
        text.close()?;
    }
    text.line(format_args!("token outputs:surface"))?;
    text.close()
}
