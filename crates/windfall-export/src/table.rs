//! Poses as a table: one row a leaf and frame.

use crate::{ExportError, LeafState, Selection};
use parquet::data_type::{
    ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::parser::parse_message_type;
use std::io::Write;
use std::sync::Arc;
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
            let (id, state) = (leaf.id, name(leaf.phase));
            write!(out, "{frame},{time},{id},{},{},{state}", id.tree(), id.leaf())?;
            floats(&leaf).iter().try_for_each(|value| write!(out, ",{value}"))?;
            writeln!(out)?;
            rows += 1;
        }
        progress((done + 1) as f32 / moments.count as f32);
    }
    Ok(rows)
}

/// A Parquet file: [`COLUMNS`], all of them required, in their types.
const SCHEMA: &str = "message leaves {
    required int32 frame; required double time; required int64 id; required int32 tree; required int32 leaf;
    required binary state (string);
    required float x; required float y; required float z;
    required float qx; required float qy; required float qz; required float qw;
    required float scale; required float red; required float green; required float blue;
}";

/// Writes the same rows as [`write_csv`] as Parquet, a row group a frame, not compressed. Returns the number of rows.
///
/// # Errors
///
/// The output cannot be written.
pub fn write_parquet(
    selection: &Selection<'_>,
    out: &mut (impl Write + Send),
    progress: &mut dyn FnMut(f32),
) -> Result<u64, ExportError> {
    let schema = Arc::new(parse_message_type(SCHEMA)?);
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(out, schema, properties)?;
    let moments = selection.moments();
    let mut rows = 0;
    for (done, frame) in moments.frames().enumerate() {
        let time = moments.time(frame);
        let leaves: Vec<LeafState> = selection.at(time).collect();
        let mut group = writer.next_row_group()?;
        let mut number = 0;
        while let Some(mut column) = group.next_column()? {
            let of = |pick: fn(&LeafState) -> i32| leaves.iter().map(pick).collect::<Vec<_>>();
            match number {
                0 => put::<Int32Type>(&mut column, &vec![frame as i32; leaves.len()])?,
                1 => put::<DoubleType>(&mut column, &vec![time; leaves.len()])?,
                2 => {
                    let ids: Vec<i64> = leaves.iter().map(|l| l.id.0 as i64).collect();
                    put::<Int64Type>(&mut column, &ids)?;
                }
                3 => put::<Int32Type>(&mut column, &of(|l| l.id.tree() as i32))?,
                4 => put::<Int32Type>(&mut column, &of(|l| l.id.leaf() as i32))?,
                5 => {
                    let names: Vec<ByteArray> =
                        leaves.iter().map(|l| ByteArray::from(name(l.phase))).collect();
                    put::<ByteArrayType>(&mut column, &names)?;
                }
                _ => {
                    let values: Vec<f32> = leaves.iter().map(|l| floats(l)[number - 6]).collect();
                    put::<FloatType>(&mut column, &values)?;
                }
            }
            column.close()?;
            number += 1;
        }
        group.close()?;
        rows += leaves.len() as u64;
        progress((done + 1) as f32 / moments.count as f32);
    }
    writer.close()?;
    Ok(rows)
}

fn put<T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    values: &[T::T],
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, None, None).map(|_| ())
}

/// The last of [`COLUMNS`], from `x` on.
fn floats(leaf: &LeafState) -> [f32; 11] {
    let LeafState { position: p, orientation: q, scale, color: c, .. } = leaf;
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w, *scale, c.x, c.y, c.z]
}

/// What a leaf is doing, in a word.
pub fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Hanging => "hanging",
        Phase::Falling { .. } => "falling",
        Phase::Landed => "landed",
    }
}
