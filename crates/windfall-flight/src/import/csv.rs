//! Tables as text: a header line, then a line for each key. Columns are separated by commas,
//! semicolons or tabs; lines that are empty or begin with `#` are skipped.

use super::Table;
use windfall_core::{InputError, InputErrorKind};

pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Table, InputError> {
    let refuse = |place: String, cause: String| {
        InputError::new(file, place, InputErrorKind::Malformed, cause)
    };
    let text = std::str::from_utf8(bytes)
        .map_err(|_| refuse(String::new(), "neither glTF, JSON nor CSV text in UTF-8".into()))?;
    let mut lines = text
        .trim_start_matches('\u{feff}')
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let Some((_, header)) = lines.next() else {
        let cause = "no header line";
        return Err(InputError::new(file, "", InputErrorKind::Empty, cause));
    };
    let separator = [';', '\t', ','].into_iter().find(|&s| header.contains(s)).unwrap_or(',');
    let columns: Vec<String> =
        header.split(separator).map(|c| c.trim().trim_matches('"').to_ascii_lowercase()).collect();
    let (mut rows, mut places) = (Vec::new(), Vec::new());
    for (number, line) in lines {
        let place = format!("line {number}");
        let row: Vec<f64> = line
            .split(separator)
            .map(|field| {
                let field = field.trim();
                field
                    .parse()
                    .map_err(|_| refuse(place.clone(), format!("\"{field}\" is no number")))
            })
            .collect::<Result<_, _>>()?;
        if row.len() != columns.len() {
            let cause = format!("{} fields under {} columns", row.len(), columns.len());
            return Err(refuse(place, cause));
        }
        rows.push(row);
        places.push(place);
    }
    Ok(Table { columns, rows, places })
}
