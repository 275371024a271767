//! The numbers of a box in a file (FAB): a line that tells their form, then all cells of one component after the other.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::PathBuf;

use crate::decode::numbers_as_f64;
use crate::error::{FieldError, FileErrorKind};
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};

use super::super::amr_file::{BlockBox, count_of};
use super::super::crop::crop;
use super::super::text::integers;

/// Place of a box's numbers.
#[derive(Debug)]
pub(super) struct Fab {
    pub path: PathBuf,
    pub offset: u64,
    /// Form of the numbers, where they have no header of their own.
    pub reals: Option<Reals>,
    /// First and last cell of the box, without ghost cells.
    pub first: [i64; 3],
    pub last: [i64; 3],
}

/// Type and byte order of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reals {
    pub scalar: ScalarType,
    pub endian: Endian,
}

/// Form of a box's numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    pub reals: Reals,
    /// First and last cell that are stored, ghost cells among them.
    first: [i64; 3],
    last: [i64; 3],
    components: usize,
}

const SINGLE: [i64; 8] = [32, 8, 23, 0, 1, 9, 0, 127];
const DOUBLE: [i64; 8] = [64, 11, 52, 0, 1, 12, 0, 1023];

impl Reals {
    /// Reads the numbers of a description such as `((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))`; returns how many there were.
    fn parse(numbers: &[i64]) -> Option<(Self, usize)> {
        let (&[8, ref format @ ..], rest) = numbers.split_first_chunk::<9>()? else { return None };
        let (&bytes, rest) = rest.split_first()?;
        let scalar = match *format {
            SINGLE if bytes == 4 => ScalarType::F32,
            DOUBLE if bytes == 8 => ScalarType::F64,
            _ => return None,
        };
        let order = rest.get(..bytes as usize)?;
        let endian = if order.iter().copied().eq(1..=bytes) {
            Endian::Big
        } else if order.iter().copied().eq((1..=bytes).rev()) {
            Endian::Little
        } else {
            return None;
        };
        Some((Self { scalar, endian }, 10 + order.len()))
    }

    /// Reads the description at the end of a text.
    pub fn at_end(text: &str) -> Result<Self, FieldError> {
        let begin = text.rfind("((8,").unwrap_or(text.len());
        let parsed = integers(&text[begin..]).and_then(|numbers| Self::parse(&numbers));
        parsed.map(|(reals, _)| reals).ok_or_else(|| FieldError::new("form of numbers", &text[begin..], ALLOWED))
    }
}

const ALLOWED: &str = "must tell IEEE numbers of 32 or 64 bits, in one of the two byte orders";

impl Fab {
    /// Form of the numbers, and the place of the first of them.
    pub fn form(&self) -> Result<(Form, u64), FileErrorKind> {
        /// A description of any length that makes sense.
        const MAX_LINE: u64 = 1024;
        if let Some(reals) = self.reals {
            let form = Form { reals, first: self.first, last: self.last, components: usize::MAX };
            return Ok((form, self.offset));
        }
        let mut file = BufReader::new(regular_file::open(&self.path)?);
        file.seek(SeekFrom::Start(self.offset))?;
        let mut line = Vec::new();
        file.take(MAX_LINE).read_until(b'\n', &mut line)?;
        let text = String::from_utf8_lossy(&line);
        let wrong = |allowed: &str| FileErrorKind::field(format!("FAB at byte {}", self.offset), text.trim(), allowed);
        let numbers = text.strip_prefix("FAB ").filter(|_| line.ends_with(b"\n")).and_then(integers);
        let numbers = numbers.ok_or_else(|| wrong("must begin with a line FAB, form, box and number of components"))?;
        let (reals, used) = Reals::parse(&numbers).ok_or_else(|| wrong(ALLOWED))?;
        let &[a, b, c, d, e, f, 0, 0, 0, components] = &numbers[used..] else {
            return Err(wrong("must end with a box of cells and the number of components"));
        };
        let components = usize::try_from(components).map_err(|_| wrong("must have components"))?;
        let form = Form { reals, first: [a, b, c], last: [d, e, f], components };
        Ok((form, self.offset + line.len() as u64))
    }

    /// Numbers of one of the components that the headers claim, without ghost cells.
    pub fn numbers(&self, component: usize, claimed: usize) -> Result<Vec<f64>, FileErrorKind> {
        let (form, begin) = self.form()?;
        let at = format!("FAB at byte {}", self.offset);
        let wrong = |found: String, allowed: &str| FileErrorKind::field(&at, found, allowed);
        if form.components < claimed {
            return Err(wrong(format!("{} components", form.components), "must have all that the header names"));
        }
        let shown = format!("a box from {:?} to {:?}", form.first, form.last);
        let stored = BlockBox::between(0, form.first, form.last);
        let stored = stored.ok_or_else(|| wrong(shown.clone(), "must hold cells"))?;
        let inner =
            BlockBox::between(0, self.first, self.last).ok_or_else(|| wrong(shown.clone(), "must hold cells"))?;
        // Index of the box's first cell in what is stored.
        let mut from = [0; 3];
        for a in 0..3 {
            let ghosts = self.first[a].checked_sub(form.first[a]).and_then(|n| usize::try_from(n).ok());
            let fits = ghosts.filter(|_| form.last[a] >= self.last[a]);
            from[a] = fits.ok_or_else(|| wrong(shown.clone(), "must hold the box that the list of boxes has here"))?;
        }

        // Read the numbers, after the file has been found long enough.
        let size = form.reals.scalar.bytes() as u64;
        let count = count_of(stored.cells, 1);
        let bytes = count.and_then(|n| (n as u64).checked_mul(size));
        let place = bytes.and_then(|n| n.checked_mul(component as u64)?.checked_add(begin));
        let (bytes, place) = bytes.zip(place).ok_or_else(|| wrong(shown.clone(), "must have fewer cells"))?;
        let mut file = regular_file::open(&self.path)?;
        let there = file.length()?.saturating_sub(place);
        if bytes > there {
            let found = format!("{there} bytes for component {component}");
            return Err(wrong(found, &format!("its box needs {bytes}: the file is cut off")));
        }
        file.seek(SeekFrom::Start(place))?;
        let mut raw = Vec::new();
        file.take(bytes).read_to_end(&mut raw)?;
        if raw.len() as u64 != bytes {
            return Err(wrong(format!("{} bytes", raw.len()), &format!("its box needs {bytes}")));
        }
        let numbers = numbers_as_f64(&raw, form.reals.scalar, form.reals.endian);
        Ok(if stored.cells == inner.cells { numbers } else { crop(&numbers, stored.cells, from, inner.cells, 1) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with one box of 2×1×1 cells with a ghost cell before, of two components.
    fn stored(text: &str, numbers: impl IntoIterator<Item = f32>) -> (tempfile::TempDir, Fab) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("Cell_D_00000");
        let mut bytes = b"....".to_vec();
        bytes.extend(text.bytes());
        bytes.extend(numbers.into_iter().flat_map(f32::to_be_bytes));
        std::fs::write(&path, bytes).unwrap();
        let fab = Fab { path, offset: 4, reals: None, first: [5, 0, 0], last: [6, 0, 0] };
        (folder, fab)
    }

    const LINE: &str = "FAB ((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))((4,0,0) (6,0,0) (0,0,0)) 2\n";

    #[test]
    fn components_without_ghost_cells() {
        let (_folder, fab) = stored(LINE, [1.0, 2.0, 3.0, 4.0, 5.0, 6.5]);
        assert_eq!((fab.numbers(0, 2).unwrap(), fab.numbers(1, 2).unwrap()), (vec![2.0, 3.0], vec![5.0, 6.5]));
        assert!(fab.numbers(0, 3).unwrap_err().to_string().contains("2 components"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |line: &str| {
            let (_folder, fab) = stored(line, [0.0; 6]);
            fab.numbers(1, 2).unwrap_err().to_string()
        };
        assert!(error(&LINE.replace("(6,0,0)", "(9,9,9)")).contains("cut off"));
        assert!(error(&LINE.replace("(4,0,0)", "(6,0,0)")).contains("must hold the box"));
        assert!(error(&LINE.replace("32 8", "48 8")).contains("IEEE"));
        assert!(error(&LINE.replace("(1 2 3 4)", "(2 1 4 3)")).contains("byte orders"));
        assert!(error("FAB: 8 0\n").contains("must begin"));
        let huge = LINE.replace("(6,0,0)", "(9223372036854775807,9223372036854775807,9223372036854775807)");
        assert!(error(&huge).contains("fewer cells") || error(&huge).contains("must hold cells"), "{}", error(&huge));
    }
}
