//! The files of JSON that make a folder an array or a group.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{FieldError, FileError};
use crate::regular_file;

/// Kind of a folder.
pub(super) enum Node {
    Array { file: PathBuf, json: Value, attributes: Value },
    Group { file: PathBuf, attributes: Value },
}

impl Node {
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let file = |name: &str| Some(folder.join(name)).filter(|path| path.is_file());
        if let Some(file) = file("zarr.json") {
            let mut json = parse(&file)?;
            let attributes = json.get_mut("attributes").map_or(Value::Null, Value::take);
            return match json.get("node_type").and_then(Value::as_str) {
                Some("array") => Ok(Self::Array { file, json, attributes }),
                Some("group") => Ok(Self::Group { file, attributes }),
                other => {
                    let found = other.unwrap_or_default();
                    Err(FieldError::new("node_type", found, "must be array or group").in_file(&file))
                }
            };
        }
        let attributes = file(".zattrs").map_or(Ok(Value::Null), |f| parse(&f))?;
        if let Some(file) = file(".zarray") {
            return Ok(Self::Array { json: parse(&file)?, file, attributes });
        }
        let group = file(".zgroup").or_else(|| file(".zattrs"));
        let missing = || FieldError::new("Zarr folder", "none of them", "must hold .zarray, .zgroup or zarr.json");
        let file = group.ok_or_else(|| missing().in_file(folder))?;
        Ok(Self::Group { file, attributes })
    }
}

/// A file of JSON; longer than any that describes arrays is refused.
fn parse(path: &Path) -> Result<Value, FileError> {
    let text = regular_file::read(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    serde_json::from_slice(&text).map_err(|e| FieldError::new("JSON", e, "must be whole").in_file(path))
}

/// A value, for messages.
pub(super) fn shown(value: Option<&Value>) -> String {
    match value {
        None => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    }
}

/// A list of positive sizes.
pub(super) fn sizes(json: &Value, key: &str) -> Result<Vec<usize>, FieldError> {
    let value = json.get(key);
    let list = value.and_then(Value::as_array);
    let sizes = list.and_then(|l| {
        l.iter().map(|n| usize::try_from(n.as_u64()?).ok().filter(|&n| n > 0)).collect::<Option<Vec<_>>>()
    });
    sizes.ok_or_else(|| FieldError::new(key, shown(value), "must be a list of positive integers"))
}

/// A list of finite numbers, `count` of them.
pub(super) fn numbers(value: Option<&Value>, field: &str, count: usize) -> Result<Vec<f64>, FieldError> {
    let list = value.and_then(Value::as_array);
    let numbers = list.and_then(|l| l.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>());
    numbers
        .filter(|n| n.len() == count)
        .ok_or_else(|| FieldError::new(field, shown(value), format!("must be a list of {count} numbers")))
}

/// A list of strings; null in it is an empty one.
pub(super) fn strings(value: &Value) -> Option<Vec<String>> {
    let string = |v: &Value| if v.is_null() { Some(String::new()) } else { v.as_str().map(str::to_owned) };
    value.as_array()?.iter().map(string).collect()
}
