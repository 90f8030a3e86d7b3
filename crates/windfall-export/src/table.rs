//! Poses as a table: one row a leaf and frame.

use crate::{ExportError, LeafState, Selection};
use std::io::Write;
use windfall_core::path::Phase;

/// The columns, in order.
///
/// | column | |
/// |---|---|
/// | `frame`, `time` | number of the frame; seconds |
/// | `id`, `tree`, `leaf` | [`crate::LeafId`], and the indices that it is made of |
/// | `state` | `hanging`, `falling` or `landed` |
/// | `x`, `y`, `z` | centre in the world, metres |
/// | `qx`, `qy`, `qz`, `qw` | rotation from the leaf's frame into the world's |
/// | `scale` | factor on the coordinates of the leaf's shape |
/// | `red`, `green`, `blue` | linear colour |
pub const COLUMNS: [&str; 17] = [
    "frame", "time", "id", "tree", "leaf", "state", "x", "y", "z", "qx", "qy", "qz", "qw", "scale",
    "red", "green", "blue",
];

/// Writes the leaves that are shown in each frame as CSV, with [`COLUMNS`] in the first line. Numbers are written such
/// that reading gives the same `f32`. Returns the number of rows. `progress` is told the share that is done.
///
/// # Errors
///
/// The output cannot be written.
pub fn write_csv(
    selection: &Selection<'_>,
    out: &mut dyn Write,
    progress: &mut dyn FnMut(f32),
) -> Result<u64, ExportError> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    let moments = selection.moments();
    let mut rows = 0;
    for (done, frame) in moments.frames().enumerate() {
        let time = moments.time(frame);
        for leaf in selection.at(time) {
            let LeafState { id, position: p, orientation: q, scale, color: c, .. } = leaf;
            let (tree, number, state) = (id.tree(), id.leaf(), name(leaf.phase));
            writeln!(
                out,
                "{frame},{time},{id},{tree},{number},{state},{},{},{},{},{},{},{},{scale},{},{},{}",
                p.x, p.y, p.z, q.x, q.y, q.z, q.w, c.x, c.y, c.z
            )?;
            rows += 1;
        }
        progress((done + 1) as f32 / moments.count as f32);
    }
    Ok(rows)
}

/// What a leaf is doing, in a word.
pub fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Hanging => "hanging",
        Phase::Falling { .. } => "falling",
        Phase::Landed => "landed",
    }
}
