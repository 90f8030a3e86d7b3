//! Universal Scene Description, as text (`.usda`).
//!
//! The stage is in metres, Y up, a time code a frame. Each tree is an instanceable reference to its model. Leaves are
//! `PointInstancer`s, two for each shape, material and model: one for leaves that do not change in the frames, one with
//! time samples for those that do. Between samples, velocities carry positions on, as USD does it.
//!
//! An attribute has all of its time samples in one place, so frames are gone through once an attribute; no more than
//! one frame is held.

mod model;
mod text;

pub use model::identifier;

use crate::mesh::{colored, encode, leaf_material, picture, shape_of};
use crate::selection::{Group, Selection};
use crate::shade::Shades;
use crate::{ExportError, LeafState, season_color};
use glam::Vec3;
use std::collections::BTreeSet;
use std::io::Write;
use text::{LENGTH, Text, UNIT};

/// Times that the frames of moving leaves are gone through.
const PASSES: u64 = 4;

/// The textures of what is selected: file names and PNG files, for the folder that [`write_usda`] is given.
///
/// # Errors
///
/// A picture whose size is not that of its pixels.
pub fn textures(selection: &Selection<'_>) -> Result<Vec<(String, Vec<u8>)>, ExportError> {
    let source = selection.source();
    let mut out = Vec::new();
    let mut models = BTreeSet::new();
    models.extend(selection.trees().iter().map(|&t| source.forest.instances[t as usize].model));
    for model in models {
        for (i, material) in source.trees[model as usize].wood.materials.iter().enumerate() {
            if picture(material).is_some()
                && let Some((image, _)) = picture(&colored(material))
            {
                out.push((model::texture_name(model, "wood", i), encode(material, image)?));
            }
        }
    }
    let leaves: BTreeSet<(u32, u32)> =
        selection.groups().iter().map(|g| (g.kind.model, g.kind.material)).collect();
    for (model, number) in leaves {
        let foliage = &source.trees[model as usize].foliage;
        let Some(material) = foliage.materials.get(number as usize) else { continue };
        if picture(material).is_none() {
            continue;
        }
        let color = season_color(foliage, source.season);
        let material = colored(&leaf_material(foliage, material, color));
        if let Some((image, _)) = picture(&material) {
            let name = model::texture_name(model, "leaves", number as usize);
            out.push((name, encode(&material, image)?));
        }
    }
    Ok(out)
}

/// Writes the selection as a stage. `folder` is where [`textures`] are, relative to the file. `progress` is told the
/// share that is done.
///
/// # Errors
///
/// The output cannot be written.
pub fn write_usda(
    selection: &Selection<'_>,
    folder: &str,
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<(), ExportError> {
    let source = selection.source();
    let moments = selection.moments();
    let mut text = Text::new(out);
    let frames = moments.frames();
    text.line(format_args!("#usda 1.0"))?;
    text.line(format_args!("("))?;
    for line in [
        "defaultPrim = \"World\"".to_owned(),
        "doc = \"Written by Windfall. Leaf ids are 4294967296 times the tree plus the leaf.\""
            .to_owned(),
        format!("startTimeCode = {}", frames.start),
        format!("endTimeCode = {}", frames.end - 1),
        format!("framesPerSecond = {}", moments.fps),
        format!("timeCodesPerSecond = {}", moments.fps),
        "metersPerUnit = 1".to_owned(),
        "upAxis = \"Y\"".to_owned(),
    ] {
        text.line(format_args!("    {line}"))?;
    }
    text.line(format_args!(")"))?;

    let trees = selection.trees();
    text.open(format_args!("class \"Models\""))?;
    let used: BTreeSet<u32> =
        trees.iter().map(|&tree| source.forest.instances[tree as usize].model).collect();
    for &number in &used {
        model::tree(&mut text, source, number, folder)?;
    }
    let kinds: BTreeSet<_> = selection.groups().iter().map(|group| group.kind).collect();
    for &kind in &kinds {
        model::leaf(&mut text, source, kind, folder)?;
    }
    text.close()?;

    text.line(format_args!("def Xform \"World\" ("))?;
    text.line(format_args!("    kind = \"assembly\""))?;
    text.open(format_args!(")"))?;
    if selection.filter().parts.ground {
        model::ground(&mut text, source)?;
    }
    if !trees.is_empty() {
        text.open(format_args!("def Xform \"Trees\""))?;
        for &number in &trees {
            tree(&mut text, selection, number)?;
        }
        text.close()?;
    }
    if !selection.is_empty() {
        text.open(format_args!("def Xform \"Leaves\""))?;
        let work: u64 = selection.groups().iter().map(|g| work_of(g, moments.count)).sum();
        let mut done = 0;
        let mut advance = |leaves: u64| {
            done += leaves;
            progress(done as f32 / work as f32);
        };
        for group in selection.groups() {
            instancer(&mut text, selection, group, &mut advance)?;
        }
        text.close()?;
    }
    text.close()?;
    Ok(())
}

fn work_of(group: &Group, frames: u32) -> u64 {
    let leaves = group.leaves.len() as u64;
    if group.moves { leaves * PASSES * u64::from(frames) } else { leaves }
}

fn tree(text: &mut Text<'_>, selection: &Selection<'_>, number: u32) -> Result<(), ExportError> {
    let source = selection.source();
    let instance = &source.forest.instances[number as usize];
    let name = model::tree_name(source, instance.model);
    text.line(format_args!("def Xform \"Tree_{number}\" ("))?;
    text.line(format_args!("    instanceable = true"))?;
    text.line(format_args!("    prepend references = </Models/{name}>"))?;
    text.open(format_args!(")"))?;
    let (at, scale) = (instance.position, instance.scale);
    text.line(format_args!("double3 xformOp:translate = ({:.5}, {:.5}, {:.5})", at.x, at.y, at.z))?;
    text.line(format_args!("float xformOp:rotateY = {:.5}", instance.yaw.to_degrees()))?;
    text.line(format_args!("float3 xformOp:scale = ({scale}, {scale}, {scale})"))?;
    text.line(format_args!(
        "uniform token[] xformOpOrder = \
         [\"xformOp:translate\", \"xformOp:rotateY\", \"xformOp:scale\"]"
    ))?;
    text.close()?;
    Ok(())
}

/// Writes the leaves of a group.
fn instancer(
    text: &mut Text<'_>,
    selection: &Selection<'_>,
    group: &Group,
    advance: &mut dyn FnMut(u64),
) -> Result<(), ExportError> {
    let source = selection.source();
    let moments = selection.moments();
    let leaf = model::leaf_name(source, group.kind);
    let suffix = if group.moves { "Moving" } else { "Still" };
    let first = moments.time(moments.first);
    let count = group.leaves.len() as u64;
    let all = || group.leaves.clone();
    let states = |time: f64| all().map(move |i| selection.state(i, time));

    text.open(format_args!("def PointInstancer \"{leaf}_{suffix}\""))?;
    text.array("int64[] ids", all().map(|i| selection.id(i).0), 0, "")?;
    let shades = Shades::of(selection, group, first);
    text.array("int[] protoIndices", states(first).map(|s| shades.index(&s)), 0, "")?;
    let names: Vec<String> =
        (0..shades.colors.len()).map(|i| format!("<Prototypes/Leaf_{i}>")).collect();
    text.line(format_args!("rel prototypes = [{}]", names.join(", ")))?;
    // One size each, as its direction needs no other.
    text.array("float3[] scales", states(first).map(|s| Vec3::splat(s.scale)), UNIT, "")?;
    let each = " (\n            interpolation = \"varying\"\n        )";
    let colors = states(first).map(|s| s.color);
    text.array("color3f[] primvars:displayColor", colors, UNIT, each)?;
    let seasons = states(first).map(|s| s.season);
    text.array("float[] primvars:season", seasons, UNIT, each)?;

    let radius = shape_of(source, group.kind).radius();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut around = |state: &LeafState| {
        low = low.min(state.position - radius * state.scale);
        high = high.max(state.position + radius * state.scale);
        state.position
    };
    if group.moves {
        let frames = || moments.frames().map(|frame| (frame, moments.time(frame)));
        text.samples("point3f[] positions")?;
        for (frame, time) in frames() {
            text.sample(frame, states(time).map(|s| around(&s)), LENGTH)?;
            advance(count);
        }
        text.close()?;
        text.samples("quath[] orientations")?;
        for (frame, time) in frames() {
            text.sample(frame, states(time).map(|s| s.orientation), UNIT)?;
            advance(count);
        }
        text.close()?;
        text.samples("vector3f[] velocities")?;
        for (frame, time) in frames() {
            text.sample(frame, all().map(|i| selection.velocity(i, time)), LENGTH)?;
            advance(count);
        }
        text.close()?;
        text.samples("int64[] invisibleIds")?;
        for (frame, time) in frames() {
            let hidden = states(time).filter(|s| !s.shown).map(|s| s.id.0);
            text.sample(frame, hidden, 0)?;
            advance(count);
        }
        text.close()?;
    } else {
        text.array("point3f[] positions", states(first).map(|s| around(&s)), LENGTH, "")?;
        text.array("quath[] orientations", states(first).map(|s| s.orientation), UNIT, "")?;
        advance(count);
    }
    text.array("float3[] extent", [low, high], LENGTH, "")?;
    text.open(format_args!("def Scope \"Prototypes\""))?;
    for (i, color) in shades.colors.iter().enumerate() {
        text.line(format_args!("def \"Leaf_{i}\" ("))?;
        text.line(format_args!("    prepend references = </Models/{leaf}>"))?;
        text.open(format_args!(")"))?;
        if let Some(color) = color {
            for name in ["Looks", "Leaf", "Surface"] {
                text.open(format_args!("over \"{name}\""))?;
            }
            text.line(format_args!(
                "color3f inputs:diffuseColor = ({:.5}, {:.5}, {:.5})",
                color.x, color.y, color.z
            ))?;
            for _ in 0..3 {
                text.close()?;
            }
        }
        text.close()?;
    }
    text.close()?;
    text.close()?;
    Ok(())
}
