//! Tables as JSON: a list of objects, one for each key, whose fields are named like the columns of a
//! CSV table; or an object that has such a list as `samples`.

use super::table::Table;
use serde_json::Value;
use windfall_core::{InputError, InputErrorKind};

pub(super) fn read(file: &str, value: &Value) -> Result<Table, InputError> {
    let refuse = |place: String, cause: String| {
        InputError::new(file, place, InputErrorKind::Malformed, cause)
    };
    let list = value.get("samples").unwrap_or(value);
    let list = list.as_array().ok_or_else(|| {
        let cause = "expected a list of samples, or an object with \"samples\"";
        refuse(String::new(), cause.into())
    })?;
    let mut columns: Vec<String> = Vec::new();
    let (mut rows, mut places) = (Vec::new(), Vec::new());
    for (i, sample) in list.iter().enumerate() {
        let place = format!("sample {i}");
        let object =
            sample.as_object().ok_or_else(|| refuse(place.clone(), "expected an object".into()))?;
        if i == 0 {
            columns =
                object.iter().filter(|(_, v)| v.is_number()).map(|(k, _)| k.clone()).collect();
        }
        let field = |name: &String| {
            let found = object.iter().find(|(k, _)| k.eq_ignore_ascii_case(name));
            let cause = || refuse(place.clone(), format!("\"{name}\" is missing or no number"));
            found.and_then(|(_, v)| v.as_f64()).ok_or_else(cause)
        };
        rows.push(columns.iter().map(field).collect::<Result<_, _>>()?);
        places.push(place);
    }
    if rows.is_empty() {
        return Err(InputError::new(file, "", InputErrorKind::Empty, "no samples"));
    }
    Ok(Table { columns, rows, places })
}
