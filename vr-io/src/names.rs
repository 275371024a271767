//! Columns and arrays by their names.

use crate::error::{FieldError, shown};

/// The place of a name in a list: spelled as it is, else but for case, else but for punctuation and units, where one name alone is so like it.
pub(crate) fn named(names: &[String], name: &str) -> Option<usize> {
    let exact = names.iter().position(|n| n == name);
    exact.or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name))).or_else(|| {
        let mut alike = (0..names.len()).filter(|&i| plain(&names[i]) == plain(name));
        // Brackets may hold more than a unit: Y(H2) and Y(O2) are two fields.
        let first = alike.next()?;
        alike.all(|i| names[i] == names[first]).then_some(first)
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_alike_are_not_mixed_up() {
        let names = ["Y(H2)", "Y(O2)", "mass [g]", "x"].map(str::to_owned);
        assert_eq!(named(&names, "y(o2)"), Some(1));
        assert_eq!(named(&names, "Y(O2)"), Some(1));
        assert_eq!(named(&names, "Y"), None);
        assert_eq!((named(&names, "Mass"), named(&names, "X"), named(&names, "z")), (Some(2), Some(3), None));
    }
}
