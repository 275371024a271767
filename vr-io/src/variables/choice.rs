//! The variable that is meant.

use crate::error::{FieldError, shown};

use super::Variable;

/// Numbers of the largest variable that is taken unless the caller asks for it.
const MAX_UNASKED: usize = 1 << 27;
/// Names in a message: more is no list to choose from.
const MAX_NAMES: usize = 20;

/// Chooses by name, which may leave out the groups that it is in where one variable alone is called so; of several volumes the largest one that
/// is not huge, and a note lists the others.
pub(super) fn choose<'v>(
    variables: &'v [Variable],
    wanted: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<&'v Variable, FieldError> {
    if let Some(wanted) = wanted {
        return named(variables, wanted);
    }
    let volumes: Vec<&Variable> = variables.iter().filter(|v| is_volume(v)).collect();
    let small = |v: &&&Variable| v.count() <= MAX_UNASKED;
    // The first one of the largest.
    let largest = volumes.iter().filter(small).rev().max_by_key(|v| v.count());
    let Some(&chosen) = largest.or_else(|| volumes.iter().rev().min_by_key(|v| v.count())) else {
        let found = if variables.is_empty() { "no numbers".to_owned() } else { list(variables.iter()) };
        return Err(FieldError {
            field: "variables".into(),
            found,
            allowed: "a volume is an array of numbers with three axes or more, of 2 or more each".into(),
        });
    };
    if volumes.len() > 1 {
        notes.push(format!(
            "of {} variables that are volumes {} is taken; others by name: {}",
            volumes.len(),
            shown(&chosen.name),
            list(volumes.into_iter().filter(|v| v.name != chosen.name))
        ));
    }
    Ok(chosen)
}

fn named<'v>(variables: &'v [Variable], wanted: &str) -> Result<&'v Variable, FieldError> {
    let plain = |name: &str| name.trim_matches('/').to_owned();
    let wanted_plain = plain(wanted);
    let exact = variables.iter().find(|v| plain(&v.name) == wanted_plain);
    let mut ending = variables.iter().filter(|v| plain(&v.name).ends_with(&format!("/{wanted_plain}")));
    let found = match (exact, ending.next(), ending.next()) {
        (Some(exact), ..) => Some(exact),
        (None, only, None) => only,
        _ => None,
    };
    found.ok_or_else(|| {
        let volumes: Vec<&Variable> = variables.iter().filter(|v| is_volume(v)).collect();
        let all = list(volumes.into_iter());
        FieldError::new("array", wanted, format!("the file has {}", if all.is_empty() { "no volume" } else { &all }))
    })
}

impl Variable {
    /// Count of its numbers.
    fn count(&self) -> usize {
        self.shape.iter().fold(1, |n, &size| n.saturating_mul(size))
    }
}

/// True if at least three axes have two elements or more.
fn is_volume(variable: &Variable) -> bool {
    variable.shape.iter().filter(|&&n| n > 1).count() >= 3
}

/// Names and shapes, for a message.
fn list<'v>(variables: impl Iterator<Item = &'v Variable>) -> String {
    let mut words: Vec<String> = variables
        .map(|v| {
            let sizes: Vec<String> = v.shape.iter().map(usize::to_string).collect();
            format!("{} ({})", shown(&v.name), if sizes.is_empty() { "1".to_owned() } else { sizes.join("×") })
        })
        .collect();
    if words.len() > MAX_NAMES {
        words.truncate(MAX_NAMES);
        words.push("…".to_owned());
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::ScalarType;

    fn variable(name: &str, shape: &[usize]) -> Variable {
        let dimensions = vec![None; shape.len()];
        Variable { name: name.into(), shape: shape.into(), dimensions, scalar: ScalarType::F32 }
    }

    #[test]
    fn the_largest_that_is_not_huge_is_taken() {
        let all = [
            variable("/x", &[9]),
            variable("/small", &[2, 2, 2]),
            variable("/a/whole", &[1 << 10, 1 << 10, 1 << 10]),
            variable("/a/half", &[1 << 8, 1 << 8, 1 << 8]),
            variable("/b/half", &[1 << 8, 1 << 8, 1 << 8]),
        ];
        let mut notes = Vec::new();
        assert_eq!(choose(&all, None, &mut notes).unwrap().name, "/a/half");
        assert!(notes[0].contains("of 4 variables") && notes[0].contains("/b/half (256×256×256)"), "{notes:?}");
        let name = |wanted| choose(&all, Some(wanted), &mut Vec::new()).map(|v| v.name.as_str());
        assert_eq!(name("whole"), Ok("/a/whole"));
        assert_eq!(name("b/half"), Ok("/b/half"));
        let error = name("half").unwrap_err().to_string();
        assert!(error.contains("array: found half; the file has /small (2×2×2)"), "{error}");
    }

    #[test]
    fn what_is_there_is_told_where_no_volume_is() {
        let error = choose(&[variable("time", &[5]), variable("map", &[5, 9])], None, &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("found time (5), map (5×9); a volume is"), "{error}");
    }
}
