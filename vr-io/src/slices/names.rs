//! Order of names with numbers in them.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// A stretch of a name: digits, or anything else.
fn stretches(name: &str) -> Vec<&str> {
    let mut out = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let digits = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (stretch, after) = rest.split_at(end);
        out.push(stretch);
        rest = after;
    }
    out
}

fn is_number(stretch: &str) -> bool {
    stretch.starts_with(|c: char| c.is_ascii_digit())
}

/// Compares two names: numbers by value however long they are, all else letter by letter; names that differ in leading zeros alone by those.
pub(super) fn natural_order(a: &str, b: &str) -> Ordering {
    let (left, right) = (stretches(a), stretches(b));
    for (x, y) in left.iter().zip(&right) {
        let order = if is_number(x) && is_number(y) {
            let (x, y) = (x.trim_start_matches('0'), y.trim_start_matches('0'));
            x.len().cmp(&y.len()).then_with(|| x.cmp(y))
        } else {
            x.cmp(y)
        };
        if order.is_ne() {
            return order;
        }
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// A note on numbers that are missing between the first and the last file, where the names differ in one number.
pub(super) fn missing(files: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = files.iter().map(|f| shown_name(f)).collect();
    let parts: Vec<Vec<&str>> = names.iter().map(|n| stretches(n)).collect();
    let (first, last) = (parts.first()?, parts.last()?);
    if parts.iter().any(|p| p.len() != first.len()) {
        return None;
    }
    let mut differing = (0..first.len()).filter(|&i| parts.iter().any(|p| p[i] != first[i]));
    let (place, None) = (differing.next()?, differing.next()) else { return None };
    let (low, high): (u64, u64) = (first[place].parse().ok()?, last[place].parse().ok()?);
    let (low, high) = (low.min(high), low.max(high));
    let gap = (high - low).checked_add(1)?.checked_sub(files.len() as u64).filter(|&gap| gap > 0)?;
    Some(format!("{gap} of the numbers {low} to {high} in the names have no file: the slices close ranks"))
}

/// The name of a file.
pub(super) fn shown_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The pattern of a name: its last number replaced.
pub(super) fn pattern_of(name: &str) -> Option<String> {
    let parts = stretches(name);
    let place = parts.iter().rposition(|p| is_number(p))?;
    let number = parts[place];
    let conversion = if number.starts_with('0') { format!("%0{}d", number.len()) } else { "%d".into() };
    Some(parts.iter().enumerate().map(|(i, part)| if i == place { conversion.as_str() } else { part }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_by_value() {
        let mut names = ["s10", "s9", "s009", "s1b2", "s1b10", "t1", "s1", "s123456789012345678901234567890", "s"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["s", "s1", "s1b2", "s1b10", "s009", "s9", "s10", "s123456789012345678901234567890", "t1"]);
    }

    #[test]
    fn gaps_are_counted() {
        let files = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(missing(&files(&["a1_7", "a1_8", "a1_9"])), None);
        assert!(missing(&files(&["a1_7", "a1_10"])).unwrap().starts_with("2 of the numbers 7 to 10"));
        assert_eq!(missing(&files(&["a1_7", "a2_10"])), None);
        assert_eq!(missing(&files(&["a0", "a18446744073709551615"])), None);
    }

    #[test]
    fn patterns_of_names() {
        assert_eq!(pattern_of("ct2_007.png").as_deref(), Some("ct2_%03d.png"));
        assert_eq!(pattern_of("slice12.png").as_deref(), Some("slice%d.png"));
        assert_eq!(pattern_of("slice.png"), None);
    }
}
