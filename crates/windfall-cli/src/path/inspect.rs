//! What is in a path file.

use anyhow::Result;
use serde_json::json;
use std::io::Write;
use windfall_core::Note;
use windfall_core::path::{FallPath, Gap, PathSet};

/// Prints all paths of a set, for people or as JSON.
pub fn print(set: &PathSet, notes: &[Note], as_json: bool) -> Result<()> {
    let mut out = std::io::stdout().lock();
    if as_json {
        let paths: Vec<_> = set.paths().iter().map(describe).collect();
        serde_json::to_writer_pretty(&mut out, &json!({ "paths": paths, "notes": notes }))?;
        writeln!(out)?;
        return Ok(());
    }
    for (i, path) in set.paths().iter().enumerate() {
        let analysis = path.analysis();
        writeln!(
            out,
            "path {i} \"{}\": {} samples at {} Hz, {:.2} s, drop {:.2} m, mean descent {:.2} m/s",
            path.name(),
            path.positions().len(),
            path.rate(),
            path.duration(),
            path.drop(),
            path.descent(),
        )?;
        let starts: Vec<String> = analysis.starts.iter().map(u32::to_string).collect();
        writeln!(out, "  starting points: {}", starts.join(" "))?;
        writeln!(out, "  continuity points (gaps raw -> blended):")?;
        for j in &analysis.joints {
            let (r, b) = (j.raw, j.blended);
            writeln!(
                out,
                "    {:>5} -> {:<5} turn {:>6.1} deg, blend {:>2} samples, position {:.2} -> {:.4} mm, \
                 velocity {:.1} -> {:.3}%, orientation {:.1} -> {:.3} deg, angular velocity {:.1} -> {:.3}%",
                j.from,
                j.to,
                j.turn().to_degrees(),
                j.blend,
                r.position * 1e3,
                b.position * 1e3,
                r.velocity * 100.0,
                b.velocity * 100.0,
                r.orientation.to_degrees(),
                b.orientation.to_degrees(),
                r.angular_velocity * 100.0,
                b.angular_velocity * 100.0,
            )?;
        }
    }
    Ok(())
}

fn describe(path: &FallPath) -> serde_json::Value {
    let gap = |g: Gap| {
        json!({
            "position_m": g.position,
            "velocity": g.velocity,
            "orientation_rad": g.orientation,
            "angular_velocity": g.angular_velocity,
        })
    };
    let joints: Vec<_> = path
        .analysis()
        .joints
        .iter()
        .map(|j| {
            json!({
                "from": j.from, "to": j.to, "blend": j.blend, "turn_rad": j.turn(),
                "raw": gap(j.raw), "blended": gap(j.blended),
            })
        })
        .collect();
    json!({
        "name": path.name(),
        "samples": path.positions().len(),
        "rate_hz": path.rate(),
        "duration_s": path.duration(),
        "drop_m": path.drop(),
        "mean_descent_m_s": path.descent(),
        "starting_points": path.analysis().starts,
        "continuity_points": joints,
    })
}
