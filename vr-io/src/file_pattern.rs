//! Numbered data files: `slice%03d.raw 1 93 1`, as NRRD and MetaImage name them.

use std::path::{Path, PathBuf};

use crate::error::{FieldError, FileError};

/// Largest number of files, beyond any stack of slices; a header that claims more is wrong.
const MAX_FILES: usize = 1 << 20;

/// The file names that a printf pattern with first number, last number and step stands for; `max_count` of them at most.
pub(crate) fn expand(field: &str, text: &str, max_count: usize) -> Result<Vec<String>, FieldError> {
    const ALLOWED: &str = "must be a name with one %d (or %03d), first number, last number, step";
    let wrong = || FieldError::new(field, text, ALLOWED);
    let words: Vec<&str> = text.split_whitespace().collect();
    // The name itself may hold spaces; the numbers are the last words. NRRD allows a fourth one, which says how many axes
    // each file has: files are one after the other on the slowest axis in any case.
    let first_number = words.iter().position(|w| w.contains('%')).ok_or_else(wrong)? + 1;
    let pattern = words[..first_number].join(" ");
    let numbers: Vec<i64> =
        words[first_number..].iter().map(|w| w.parse().ok()).collect::<Option<_>>().ok_or_else(wrong)?;
    let (first, last, step) = match *numbers.as_slice() {
        [first, last] => (first, last, 1),
        [first, last, step] | [first, last, step, _] => (first, last, step),
        _ => return Err(wrong()),
    };
    if step == 0 || (last.saturating_sub(first)).signum() * step.signum() < 0 {
        return Err(wrong());
    }
    let count = (i128::from(last) - i128::from(first)) / i128::from(step) + 1;
    let max_count = max_count.min(MAX_FILES);
    if count > max_count as i128 {
        return Err(FieldError::new(field, format_args!("{count} files"), format!("must be at most {max_count}")));
    }
    let (before, width, zeros, after) = split_pattern(&pattern).ok_or_else(wrong)?;
    Ok((0..count as i64)
        .map(|i| {
            let n = first + i * step;
            let digits = if zeros { format!("{n:0width$}") } else { format!("{n:width$}") };
            format!("{before}{digits}{after}")
        })
        .collect())
}

/// The names among these that a pattern without numbers stands for, any number in its place, by that number.
pub(crate) fn matching(field: &str, pattern: &str, names: &[String]) -> Result<Vec<String>, FieldError> {
    let wrong = || FieldError::new(field, pattern, "must be a name with one %d (or %03d)");
    let (before, width, zeros, after) = split_pattern(pattern).ok_or_else(wrong)?;
    let number = |name: &str| -> Option<u64> {
        let digits = name.strip_prefix(before.as_str())?.strip_suffix(after.as_str())?;
        let bare = digits.trim_start_matches(' ');
        let n: u64 = bare.parse().ok().filter(|_| bare.bytes().all(|b| b.is_ascii_digit()))?;
        let printed = if zeros { format!("{n:0width$}") } else { format!("{n:width$}") };
        (printed == digits).then_some(n)
    };
    let mut found: Vec<(u64, &String)> = names.iter().filter_map(|name| Some((number(name)?, name))).collect();
    found.sort_unstable();
    Ok(found.into_iter().map(|(_, name)| name.clone()).collect())
}

/// The first `count` names of a pattern such as `frame-%04d.png`, numbered from 0.
///
/// # Errors
/// A [`FieldError`] for a text that has no `%d` or `%04d`, or several.
pub fn numbered_names(pattern: &str, count: usize) -> Result<Vec<String>, FieldError> {
    let last = count.saturating_sub(1);
    let names = expand("pattern", &format!("{pattern} 0 {last}"), MAX_FILES);
    names
        .map(|names| names.into_iter().take(count).collect())
        .map_err(|_| FieldError::new("pattern", pattern, "must be a name with one %d (or %04d)"))
}

/// The files that a pattern such as `vol-%03d.nrrd` stands for, any number in its place, by that number.
///
/// # Errors
/// A [`FileError`] naming the pattern: one that has no `%d`, that no file matches, or whose folder cannot be read.
pub fn files_of_pattern(pattern: impl AsRef<Path>) -> Result<Vec<PathBuf>, FileError> {
    let pattern = pattern.as_ref();
    let folder = pattern.parent().unwrap_or(Path::new(""));
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = here.read_dir().map_err(|e| FileError::new(folder, e))?;
    let names: Vec<String> = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    let found = matching("pattern", &name, &names).map_err(|e| e.in_file(pattern))?;
    if found.is_empty() {
        return Err(FieldError::new("pattern", &name, "no file of such a name is there").in_file(pattern));
    }
    Ok(found.into_iter().map(|name| folder.join(name)).collect())
}

/// Splits a pattern into the text before the conversion, its width, true if it pads with zeros, and the text after.
fn split_pattern(pattern: &str) -> Option<(String, usize, bool, String)> {
    const WIDEST: usize = 64;
    // `%%` is a literal percent sign; the one conversion is what remains.
    let literal = "\0";
    let masked = pattern.replace("%%", literal);
    let (before, rest) = masked.split_once('%')?;
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    let after = rest[digits.len()..].strip_prefix(['d', 'i', 'u'])?;
    if after.contains('%') {
        return None;
    }
    let width = if digits.is_empty() { 0 } else { digits.parse().ok().filter(|&w| w <= WIDEST)? };
    let unmask = |s: &str| s.replace(literal, "%");
    Some((unmask(before), width, digits.starts_with('0'), unmask(after)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        expand("data file", text, 1000).unwrap()
    }

    #[test]
    fn numbers_go_up_and_down() {
        assert_eq!(names("q.%d 1 3 1"), ["q.1", "q.2", "q.3"]);
        assert_eq!(names("a b%03d.raw 10 1 -4 2"), ["a b010.raw", "a b006.raw", "a b002.raw"]);
        assert_eq!(names("100%%_%2d 9 10"), ["100%_ 9", "100%_10"]);
    }

    #[test]
    fn names_match_as_printf_would_write_them() {
        let names = ["a_002.png", "a_1000.png", "a_010.png", "a_3.png", "a_.png", "b_001.png", "a_0004.png"];
        let names = names.map(String::from);
        assert_eq!(matching("", "a_%03d.png", &names).unwrap(), ["a_002.png", "a_010.png", "a_1000.png"]);
        assert_eq!(matching("", "a_%d.png", &names).unwrap(), ["a_3.png", "a_1000.png"]);
        assert!(matching("", "a_%s.png", &names).is_err());
    }

    #[test]
    fn files_are_found_by_number() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["v10.nrrd", "v9.nrrd", "v9.raw", "v.nrrd"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let found = files_of_pattern(folder.path().join("v%d.nrrd")).unwrap();
        assert_eq!(found, [folder.path().join("v9.nrrd"), folder.path().join("v10.nrrd")]);
        for (pattern, words) in [("w%d.nrrd", "no file of such a name"), ("v.nrrd", "one %d"), ("no/%d", "no")] {
            let error = files_of_pattern(folder.path().join(pattern)).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert_eq!(numbered_names("a b-%02d.png", 2).unwrap(), ["a b-00.png", "a b-01.png"]);
        assert!(numbered_names("%d", 0).unwrap().is_empty() && numbered_names("a.png", 2).is_err());
    }

    #[test]
    fn refuses_what_is_no_pattern() {
        for bad in ["x 1 2 1", "%d", "%d 1 2 0", "%d 1 5 -1", "%s 1 2 1", "%d%d 1 2 1", "%999d 1 2", "%d a b"] {
            assert!(expand("data file", bad, 1000).is_err(), "{bad}");
        }
        assert!(expand("data file", "%d 0 9223372036854775807 1", 1000).is_err());
        assert!(expand("data file", "%d -9223372036854775808 9223372036854775807 1", 1000).is_err());
    }
}
