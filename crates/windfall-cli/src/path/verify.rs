//! `windfall path verify`: the flight models against published figures.

use anyhow::Result;
use std::io::Write;
use windfall_flight::verify::{self, Check, DISCS};

/// Prints both tables. Rows of the first that miss their tolerance are an error.
pub fn run(falls: u32) -> Result<()> {
    let (failed, _) = tables(&mut std::io::stdout().lock(), falls)?;
    anyhow::ensure!(
        failed == 0,
        "{failed} figures of the falling card are outside their tolerance"
    );
    Ok(())
}

/// Writes both tables; how many rows of each miss their tolerance.
pub fn tables(mut out: &mut impl Write, falls: u32) -> Result<(usize, usize)> {
    writeln!(
        out,
        "Falling card, two dimensions (Andersen, Pesavento & Wang, J. Fluid Mech. 541, 2005)\n"
    )?;
    let card = verify::card();
    table(&mut out, &card)?;

    writeln!(
        out,
        "\nFalling discs, six degrees of freedom, against 444 tracked falls of paper of 70 g/m²;\n\
         {falls} simulated falls for each size; each within 25%, shares within 25 points\n"
    )?;
    // Sizes are independent: a thread each, printed in order.
    let sizes: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> =
            DISCS.iter().map(|d| scope.spawn(move || verify::disc(d, falls))).collect();
        threads.into_iter().filter_map(|t| t.join().ok()).collect()
    });
    anyhow::ensure!(sizes.len() == DISCS.len(), "a simulation failed");
    let (measured, checks): (Vec<_>, Vec<_>) = sizes.into_iter().unzip();
    let mut rows: Vec<Check> = checks.into_iter().flatten().collect();
    rows.push(verify::scatter(&measured));
    table(&mut out, &rows)?;
    let off = rows.iter().filter(|c| !c.holds()).count();
    writeln!(
        out,
        "\n{} of {} figures of real discs within their range.",
        rows.len() - off,
        rows.len()
    )?;
    if off > 0 {
        for line in wrap(verify::EXPLANATION, 96) {
            writeln!(out, "{line}")?;
        }
    }
    Ok((card.iter().filter(|c| !c.holds()).count(), off))
}

/// Lines of at most `width` characters.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].len() + 1 + word.len() > width {
            lines.push(word.into());
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last].push_str(word);
        }
    }
    lines
}

pub fn table(out: &mut impl Write, checks: &[Check]) -> Result<()> {
    writeln!(out, "{:<48} {:>18} {:>10}  ", "", "published", "model")?;
    for c in checks {
        let verdict = if c.holds() {
            "ok".to_owned()
        } else {
            format!("off by {:+.2} beyond its tolerance", c.off())
        };
        writeln!(out, "{:<48} {:>18} {:>10.4}  {verdict}", c.what, c.published, c.value)?;
    }
    Ok(())
}
