//! Tables as text: a header line, then a line for each key. Columns are separated by commas,
//! semicolons or tabs; lines that are empty or begin with `#` are skipped. Fields may be quoted (RFC 4180).
//! Where commas do not separate unquoted columns, numbers may have a decimal comma, all of them or none.

use super::table::Table;
use std::borrow::Cow;
use windfall_core::{InputError, InputErrorKind};

pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Table, InputError> {
    let refuse = |place: String, cause: String| {
        InputError::new(file, place, InputErrorKind::Malformed, cause)
    };
    let text = std::str::from_utf8(bytes)
        .map_err(|_| refuse(String::new(), "neither glTF, JSON nor CSV text in UTF-8".into()))?;
    let mut records = Records { rest: text.trim_start_matches('\u{feff}'), line: 0 };
    let Some((number, header)) = records.next() else {
        let cause = "no header line";
        return Err(InputError::new(file, "", InputErrorKind::Empty, cause));
    };
    let separator =
        [';', '\t', ','].into_iter().find(|&s| outside_quotes(header, s)).unwrap_or(',');
    let split = |number: usize, record| {
        fields(record, separator).map_err(|e| refuse(format!("line {number}"), e.into()))
    };
    let columns: Vec<String> = split(number, header)?.into_iter().map(Cow::into_owned).collect();
    let mut decimals = Decimals::default();
    let (mut rows, mut places) = (Vec::new(), Vec::new());
    for (number, record) in records {
        let place = format!("line {number}");
        let fields = split(number, record)?;
        let row: Vec<f64> = fields
            .iter()
            .map(|field| decimals.number(field, number).map_err(|e| refuse(place.clone(), e)))
            .collect::<Result<_, _>>()?;
        if row.len() != columns.len() {
            let mut cause = format!("{} fields under {} columns", row.len(), columns.len());
            if separator == ',' && row.len() > columns.len() {
                cause += ": if decimals are commas, separate columns by semicolons";
            }
            return Err(refuse(place, cause));
        }
        rows.push(row);
        places.push(place);
    }
    Ok(Table { columns, rows, places })
}

/// The lines that hold something, each with its number. A line break in quotes does not end one.
struct Records<'a> {
    rest: &'a str,
    /// Lines taken so far.
    line: usize,
}

impl<'a> Iterator for Records<'a> {
    type Item = (usize, &'a str);

    fn next(&mut self) -> Option<Self::Item> {
        while !self.rest.is_empty() {
            let number = self.line + 1;
            let comment = self.rest.trim_start_matches([' ', '\t']).starts_with('#');
            let (mut quoted, mut length) = (false, self.rest.len());
            for (at, byte) in self.rest.bytes().enumerate() {
                match byte {
                    b'"' if !comment => quoted = !quoted,
                    b'\n' => {
                        self.line += 1;
                        if !quoted {
                            length = at + 1;
                            break;
                        }
                    }
                    _ => {}
                }
            }
            let (record, rest) = self.rest.split_at(length);
            self.rest = rest;
            let record = record.trim();
            if !record.is_empty() && !record.starts_with('#') {
                return Some((number, record));
            }
        }
        None
    }
}

fn outside_quotes(record: &str, wanted: char) -> bool {
    record.split('"').step_by(2).any(|part| part.contains(wanted))
}

/// The fields of a record, without the space around them and without their quotes.
fn fields(record: &str, separator: char) -> Result<Vec<Cow<'_, str>>, &'static str> {
    let mut fields = Vec::new();
    let mut rest = record;
    loop {
        let start = rest.trim_start_matches(|c: char| c.is_whitespace() && c != separator);
        let Some(mut quoted) = start.strip_prefix('"') else {
            let Some((field, after)) = rest.split_once(separator) else {
                fields.push(rest.trim().into());
                return Ok(fields);
            };
            fields.push(field.trim().into());
            rest = after;
            continue;
        };
        let mut field = Cow::Borrowed("");
        loop {
            let (part, after) = quoted.split_once('"').ok_or("a quote that is not closed")?;
            field += part;
            quoted = after;
            // A doubled quote stands for one.
            let Some(after) = quoted.strip_prefix('"') else { break };
            field += "\"";
            quoted = after;
        }
        fields.push(Cow::Owned(field.trim().to_owned()));
        let after = quoted.trim_start_matches(|c: char| c.is_whitespace() && c != separator);
        if after.is_empty() {
            return Ok(fields);
        }
        rest = after.strip_prefix(separator).ok_or("text behind a closing quote")?;
    }
}

/// Which sign decimals have in this file, and the line that told.
#[derive(Default)]
struct Decimals(Option<(char, usize)>);

impl Decimals {
    fn number(&mut self, field: &str, line: usize) -> Result<f64, String> {
        let no_number = || format!("\"{field}\" is no number");
        let sign = match (field.contains('.'), field.matches(',').count()) {
            (true, 0) => '.',
            (false, 1) => ',',
            (false, 0) => return field.parse().map_err(|_| no_number()),
            _ => return Err(no_number()),
        };
        let number = match sign {
            ',' => field.replace(',', ".").parse(),
            _ => field.parse(),
        };
        let number = number.map_err(|_| no_number())?;
        let (first, at) = *self.0.get_or_insert((sign, line));
        if first != sign {
            return Err(format!("\"{field}\" has a decimal '{sign}', line {at} has '{first}'"));
        }
        Ok(number)
    }
}
