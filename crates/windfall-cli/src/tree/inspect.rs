//! What a tree is made of, and what each primitive of its file is taken for.

use anyhow::Context;
use std::io::Write;
use windfall_tree::{Import, Inspection, Part, Use};

/// Primitives that are printed before the rest is only counted.
const MOST_PRINTED: usize = 60;

/// Prints a tree, for people or as JSON.
pub fn print(read: &Import, json: bool) -> anyhow::Result<()> {
    let facts = Inspection::of(&read.tree);
    let bytes_gpu = windfall_gpu::model_bytes(&read.tree);
    let mut out = std::io::stdout().lock();
    let mut object = serde_json::to_value(&facts)?;
    object["bytes_gpu"] = bytes_gpu.into();
    if let Some(about) = &read.baked {
        object["baked"] = serde_json::json!({
            "source": about.source.to_string(),
            "prune_order": about.prune_order.map(|(order, _)| order),
        });
    }
    if json {
        object["notes"] = serde_json::to_value(&read.notes)?;
        object["primitives"] = serde_json::to_value(&read.parts)?;
        writeln!(out, "{}", serde_json::to_string_pretty(&object)?)?;
        return Ok(());
    }
    let fields = object.as_object().context("an inspection is an object")?;
    for (name, value) in fields {
        let value = match value {
            serde_json::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        writeln!(out, "{name:<15} {value}")?;
    }
    if !read.parts.is_empty() {
        writeln!(out, "primitives")?;
    }
    for part in read.parts.iter().take(MOST_PRINTED) {
        writeln!(out, "  {}", line(part))?;
    }
    if let Some(more) = read.parts.len().checked_sub(MOST_PRINTED + 1) {
        writeln!(out, "  and {} more (--json lists all)", more + 1)?;
    }
    Ok(())
}

fn line(part: &Part) -> String {
    let name = |name: &Option<String>| match name {
        Some(name) => format!("\"{name}\""),
        None => "(unnamed)".to_owned(),
    };
    let times = if part.instances > 1 {
        format!(" in {} instances", part.instances)
    } else {
        String::new()
    };
    let [low, high] = part.bounds;
    let taken_for = match part.taken_for {
        Use::Leaves => "leaves",
        Use::Wood => "wood",
        Use::LeftOut => "left out",
    };
    format!(
        "{}: {taken_for} ({}); node {} {}, mesh {}, material {}; {} triangles{times}; \
         x {:.2}..{:.2}, y {:.2}..{:.2}, z {:.2}..{:.2} m",
        part.number,
        part.why,
        part.node,
        name(&part.node_name),
        name(&part.mesh_name),
        name(&part.material_name),
        part.triangles,
        low.x,
        high.x,
        low.y,
        high.y,
        low.z,
        high.z,
    )
}
