//! Objects of a native file: regular grids, and arrays of numbers with the place where these are.

use std::io::{self, BufRead, Read};

use glam::DVec3;

use crate::error::FieldError;
use crate::scalar::ScalarType;

use super::keyword::{Form, TYPES, scalar_type};

/// Longest line of a header.
const MAX_LINE: u64 = 1 << 20;

/// True if the beginning of a file is that of a native file: after comments, an object.
pub(crate) fn is_native(head: &[u8]) -> bool {
    let lines = head.split(|&c| c == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let words: Option<Vec<&str>> =
        first.and_then(|line| str::from_utf8(line).ok()).map(|l| l.split_whitespace().collect());
    words.is_some_and(|w| {
        w.first() == Some(&"object") && w.iter().any(|w| matches!(*w, "class" | "gridpositions" | "array"))
    })
}

/// A `gridpositions` object of three dimensions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    pub counts: [usize; 3],
    pub origin: DVec3,
    pub deltas: [DVec3; 3],
}

/// An `array` object.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array {
    pub scalar: ScalarType,
    pub items: u64,
    /// Numbers in each item.
    pub components: u64,
    pub form: Form,
    pub place: Place,
}

/// Place of an array's numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Place {
    /// In this file, at this offset.
    Here(u64),
    /// In this file, at this offset from the line after `end`.
    Section(u64),
    /// In another file.
    File(String, u64),
}

/// Objects of a file.
#[derive(Debug, Default)]
pub(super) struct Objects {
    pub grids: Vec<Grid>,
    pub arrays: Vec<Array>,
    /// Offset of the line after `end`.
    pub section: u64,
}

impl Objects {
    /// Reads objects up to `end`, or until there are a grid and numbers for it that follow at once.
    pub fn read(mut file: impl BufRead) -> Result<Self, Fault> {
        let mut objects = Self::default();
        let mut default = Form::default();
        let (mut statement, mut offset) = (Vec::<String>::new(), 0);
        loop {
            let mut line = Vec::new();
            let length = file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)? as u64;
            offset += length;
            let words = words(&String::from_utf8_lossy(&line));
            let first = words.first().map(String::as_str);
            if length == 0 || first == Some("end") {
                objects.add(&statement, &mut default)?;
                objects.section = offset;
                return Ok(objects);
            }
            // These begin a statement; other lines go on with the last one.
            if matches!(first, Some("object" | "attribute" | "component" | "member")) {
                objects.add(&statement, &mut default)?;
                statement.clear();
            }
            let follows = words.last().is_some_and(|w| w == "follows");
            statement.extend(words);
            if follows {
                statement.push(offset.to_string());
                objects.add(&statement, &mut default)?;
                statement.clear();
                if objects.data().is_some() {
                    return Ok(objects);
                }
                offset += objects.skip_last(&mut file)?;
            }
        }
    }

    /// The grid, and the first array with numbers for each of its points.
    pub fn data(&self) -> Option<(&Grid, &Array)> {
        let grid = self.grids.first()?;
        let points = grid.counts.iter().try_fold(1u64, |n, &c| n.checked_mul(c as u64))?;
        Some((grid, self.arrays.iter().find(|a| a.items == points)?))
    }

    /// Adds the object of a statement, if it is one that matters.
    fn add(&mut self, statement: &[String], default: &mut Form) -> Result<(), FieldError> {
        let words: Vec<&str> = statement.iter().map(String::as_str).collect();
        let rest = match words.as_slice() {
            ["object", _, "class", rest @ ..] | ["object", _, rest @ ..] => rest,
            _ => return Ok(()),
        };
        match rest {
            ["gridpositions", rest @ ..] => self.grids.extend(grid(rest)?),
            ["array", rest @ ..] => self.arrays.extend(array(rest, default)?),
            _ => {}
        }
        Ok(())
    }

    /// Passes over the numbers of the last array.
    fn skip_last(&self, file: &mut impl BufRead) -> Result<u64, Fault> {
        let Some(array) = self.arrays.last() else { return Ok(0) };
        let numbers = array.items.saturating_mul(array.components);
        if array.form.binary {
            let bytes = numbers.saturating_mul(array.scalar.bytes() as u64);
            return Ok(io::copy(&mut file.take(bytes), &mut io::sink())?);
        }
        let (mut passed, mut left) = (0, numbers);
        while left > 0 {
            let mut line = Vec::new();
            let length = file.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)?;
            if length == 0 {
                break;
            }
            passed += length as u64;
            left = left.saturating_sub(words(&String::from_utf8_lossy(&line)).len() as u64);
        }
        Ok(passed)
    }
}

/// Why a file gave no objects.
#[derive(Debug)]
pub(super) enum Fault {
    Io(io::Error),
    Field(FieldError),
}

impl From<io::Error> for Fault {
    fn from(e: io::Error) -> Self {
        Self::Io(e)
    }
}

impl From<FieldError> for Fault {
    fn from(e: FieldError) -> Self {
        Self::Field(e)
    }
}

/// Words of a line between blanks and commas, those in quotes whole; a comment is left out.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for c in line.chars() {
        match c {
            '"' => {
                if quoted {
                    words.push(std::mem::take(&mut word));
                }
                quoted = !quoted;
            }
            _ if quoted => word.push(c),
            '#' => break,
            _ if c.is_whitespace() || c == ',' => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            _ => word.push(c),
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    words
}

/// Numbers at the beginning of some words, and the words after them.
fn numbers<'w, 's, T: std::str::FromStr>(words: &'w [&'s str]) -> (Vec<T>, &'w [&'s str]) {
    let numbers: Vec<T> = words.iter().map_while(|w| w.parse().ok()).collect();
    let rest = &words[numbers.len()..];
    (numbers, rest)
}

/// A grid of three dimensions; `None` for other dimensions.
fn grid(words: &[&str]) -> Result<Option<Grid>, FieldError> {
    let words = words.strip_prefix(&["counts"]).unwrap_or(words);
    let (counts, mut rest) = numbers::<usize>(words);
    if counts.len() != 3 && (1..9).contains(&counts.len()) {
        return Ok(None);
    }
    let counts: [usize; 3] = counts
        .try_into()
        .map_err(|_| FieldError::new("gridpositions counts", words.join(" "), "must be three sizes"))?;
    let mut origin = DVec3::ZERO;
    let mut deltas = Vec::new();
    while let Some((&key, after)) = rest.split_first() {
        let (found, after) = numbers::<f64>(after);
        let vector = <[f64; 3]>::try_from(found.as_slice()).map(DVec3::from_array);
        let vector = vector.map_err(|_| {
            FieldError::new(key, rest[1..].join(" "), "must be three numbers, of a grid of three dimensions")
        })?;
        match key {
            "origin" => origin = vector,
            "delta" => deltas.push(vector),
            _ => return Err(FieldError::new("gridpositions", key, "must be followed by origin and delta")),
        }
        rest = after;
    }
    let deltas: [DVec3; 3] = match deltas.as_slice() {
        [] => [DVec3::X, DVec3::Y, DVec3::Z],
        &[x, y, z] => [x, y, z],
        _ => {
            return Err(FieldError::new(
                "gridpositions",
                format_args!("{} lines of delta", deltas.len()),
                "must have 3",
            ));
        }
    };
    Ok(Some(Grid { counts, origin, deltas }))
}

/// An array of real numbers; `None` for others.
fn array(words: &[&str], default: &mut Form) -> Result<Option<Array>, FieldError> {
    let (mut scalar, mut items, mut components) = (Some(ScalarType::F32), None, 1u64);
    let mut form = *default;
    let mut rest = words;
    let wrong = |field: &str, found: &[&str], allowed: &str| FieldError::new(field, found.join(" "), allowed);
    while let Some((&key, after)) = rest.split_first() {
        rest = match (key, after) {
            ("type", ["string", after @ ..]) => {
                scalar = None;
                after
            }
            ("type", after) => {
                let count = if matches!(after.first(), Some(&"signed" | &"unsigned")) { 2 } else { 1 };
                let (name, after) = after.split_at(count.min(after.len()));
                scalar = Some(scalar_type(name.iter().copied()).ok_or_else(|| wrong("type", name, TYPES))?);
                after
            }
            ("category", ["complex", after @ ..]) => {
                scalar = None;
                after
            }
            ("category" | "rank", [_, after @ ..]) => after,
            ("shape", after) => {
                let (shape, after) = numbers::<u64>(after);
                let product = shape.iter().try_fold(1u64, |n, &s| n.checked_mul(s));
                components = product.ok_or_else(|| wrong("shape", words, "must be of fewer numbers"))?;
                after
            }
            ("items", after) => {
                let (found, after) = after.split_at(1.min(after.len()));
                items = Some(
                    found
                        .first()
                        .and_then(|n| n.parse().ok())
                        .ok_or_else(|| wrong("items", found, "must be a number"))?,
                );
                after
            }
            ("data", after) => {
                let after = match after.strip_prefix(&["mode"]) {
                    Some(after) => {
                        *default = form;
                        after
                    }
                    None => after,
                };
                let number = |n: &str| n.parse().ok();
                let place = match after {
                    // The reader puts the offset there.
                    ["follows", offset] => number(offset).map(Place::Here),
                    ["file", name, offset] => number(offset).map(|n| Place::File((*name).to_owned(), n)),
                    ["file", name] => Some(Place::File((*name).to_owned(), 0)),
                    [offset] => number(offset).map(Place::Section),
                    _ => None,
                };
                let place =
                    place.ok_or_else(|| wrong("data", after, "must be follows, an offset, or file and name"))?;
                let (Some(scalar), Some(items)) = (scalar, items) else { return Ok(None) };
                return Ok(Some(Array { scalar, items, components, form, place }));
            }
            (word, after) if form.set(word) => after,
            (word, _) => {
                return Err(FieldError::new("array", word, "must be type, category, rank, shape, items or data"));
            }
        };
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_in_quotes_are_whole() {
        assert_eq!(words("object \"a b\" class field # no\n"), ["object", "a b", "class", "field"]);
        assert_eq!(words("data file x.bin,3\r\n"), ["data", "file", "x.bin", "3"]);
        assert_eq!(words("attribute \"\" string"), ["attribute", "", "string"]);
    }

    #[test]
    fn native_files_are_told() {
        assert!(is_native(b"# a comment\n\nobject 1 class gridpositions counts 2 2 2\n"));
        assert!(is_native(b"object \"x\" array type float\n"));
        assert!(!is_native(b"object of my desire\n"));
        assert!(!is_native(b""));
    }
}
