//! `windfall bench compare`: what got slower from one report to another.

use super::report::{Report, Row};
use anyhow::{Context, bail};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `windfall bench compare`.
#[derive(clap::Args)]
pub struct Args {
    /// The report.json of before
    before: PathBuf,
    /// The report.json of after
    after: PathBuf,
}

/// How a row has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    Same,
    Slower,
    Faster,
}

/// Slower or faster by more than the spread: the quartiles of before and after do not meet.
fn change(before: &Row, after: &Row) -> Change {
    if after.ms.low > before.ms.high {
        Change::Slower
    } else if after.ms.high < before.ms.low {
        Change::Faster
    } else {
        Change::Same
    }
}

fn read(path: &Path) -> anyhow::Result<Report> {
    let text = std::fs::read_to_string(path).with_context(|| format!("{}", path.display()))?;
    serde_json::from_str(&text)
        .with_context(|| format!("{}: not a report of `windfall bench papers`", path.display()))
}

/// Rows of both reports, with the name of adapter, table and row; and how many of `before` have none in `after`.
fn pairs<'a>(before: &'a Report, after: &'a Report) -> (Vec<(String, &'a Row, &'a Row)>, usize) {
    let (mut out, mut lost) = (Vec::new(), 0);
    for adapter in &before.adapters {
        let other = after.adapters.iter().find(|a| a.adapter == adapter.adapter);
        for table in &adapter.tables {
            let tables = other.map_or(&[][..], |a| &a.tables);
            let other = tables.iter().find(|t| t.id == table.id);
            for row in &table.rows {
                let rows = other.map_or(&[][..], |t| &t.rows);
                match rows.iter().find(|r| r.name == row.name) {
                    Some(now) => {
                        let name = format!("{}: {}: {}", adapter.adapter, table.id, row.name);
                        out.push((name, row, now));
                    }
                    None => lost += 1,
                }
            }
        }
    }
    (out, lost)
}

/// Runs `windfall bench compare`. That something got slower is an error.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let (before, after) = (read(&args.before)?, read(&args.after)?);
    if before.quick != after.quick {
        bail!("one is of a short run and one of a full run: their scenes differ in size");
    }
    let (pairs, lost) = pairs(&before, &after);
    if pairs.is_empty() {
        bail!("the reports have no row in common: are they of the same adapter?");
    }
    let mut out = std::io::stdout().lock();
    let mut slower = 0;
    for (name, before, after) in &pairs {
        let change = change(before, after);
        slower += usize::from(change == Change::Slower);
        let word = match change {
            Change::Same => continue,
            Change::Slower => "slower",
            Change::Faster => "faster",
        };
        let factor = after.ms.median / before.ms.median;
        writeln!(out, "{word}  {factor:.2} x  {name}: {} -> {} ms", before.ms, after.ms)?;
    }
    writeln!(out, "{} rows, {slower} slower by more than their spread", pairs.len())?;
    if lost > 0 {
        writeln!(out, "{lost} rows of {} are not in the other", args.before.display())?;
    }
    if slower > 0 {
        bail!("{slower} of {} got slower", pairs.len());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::report;
    use super::*;

    #[test]
    fn slower_is_what_lies_beyond_the_spread() {
        let before = report(1.0, 2.0, 3.0);
        let judge = |after: &Report| {
            let (pairs, lost) = pairs(&before, after);
            assert_eq!((pairs.len(), lost), (1, 0));
            change(pairs[0].1, pairs[0].2)
        };
        assert_eq!(judge(&report(2.5, 3.5, 4.0)), Change::Same);
        assert_eq!(judge(&report(3.5, 4.0, 5.0)), Change::Slower);
        assert_eq!(judge(&report(0.2, 0.5, 0.9)), Change::Faster);
        let mut other = report(1.0, 2.0, 3.0);
        other.adapters[0].tables[0].rows[0].name = "fragment".into();
        assert_eq!(pairs(&before, &other).1, 1);
    }
}
