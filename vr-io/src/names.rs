//! Columns and arrays by their names.

use crate::error::{FieldError, shown};

/// The place of a name in a list, spelled as it is, or else but for case and punctuation.
pub(crate) fn named(names: &[String], name: &str) -> Option<usize> {
    let same = |n: &String| n == name;
    names.iter().position(same).or_else(|| names.iter().position(|n| plain(n) == plain(name)))
}

/// The error of a name that a list does not hold.
pub(crate) fn missing(field: &str, name: &str, names: &[String]) -> FieldError {
    FieldError::new(field, name, format!("must be one of {}", listed(names)))
}

/// Names in one line.
pub(crate) fn listed(names: &[String]) -> String {
    const MAX_NAMES: usize = 40;
    if names.is_empty() {
        return "no column".to_owned();
    }
    let mut list = names.iter().take(MAX_NAMES).map(|name| shown(name)).collect::<Vec<_>>().join(", ");
    if names.len() > MAX_NAMES {
        list.push_str(&format!(" and {} more", names.len() - MAX_NAMES));
    }
    list
}

/// Lower case, letters and digits alone, units in brackets left out.
pub(crate) fn plain(name: &str) -> String {
    let name = name.split(['[', '(']).next().unwrap_or_default();
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}
