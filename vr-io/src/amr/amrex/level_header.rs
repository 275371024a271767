//! The list of a level's boxes (`Cell_H`), and where their numbers are.

use std::fmt;

use crate::error::FieldError;

use super::super::text::Words;
use super::fab::Reals;
use super::plot_header::box_of;

/// The list of a level.
#[derive(Debug)]
pub(super) struct LevelHeader {
    pub components: usize,
    pub boxes: Vec<StoredBox>,
    /// Form of the numbers, in files whose boxes have no header of their own.
    pub reals: Option<Reals>,
}

/// A box, and the place of its numbers.
#[derive(Debug)]
pub(super) struct StoredBox {
    pub first: [i64; 3],
    pub last: [i64; 3],
    /// Name of the file.
    pub file: String,
    /// Place in the file.
    pub offset: u64,
}

impl fmt::Display for StoredBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} to {:?}", self.first, self.last)
    }
}

/// Versions of which each box has a header before its numbers, and of which none has.
const WITH_HEADERS: u32 = 1;
const WITHOUT_HEADERS: [u32; 3] = [2, 3, 4];

impl LevelHeader {
    /// Reads the text.
    ///
    /// # Errors
    /// Anything that is no such list, or ends early.
    pub fn parse(text: &str) -> Result<Self, FieldError> {
        const WHOLE: &str = "must be a whole number";
        let mut words = Words::new(text);
        let version: u32 = words.number("version", WHOLE)?;
        if version != WITH_HEADERS && !WITHOUT_HEADERS.contains(&version) {
            return Err(FieldError::new("version", version, "versions 1 to 4 are read"));
        }
        words.word("way of writing")?;
        let components: usize = words.number("number of components", WHOLE)?;
        // One number, or one for each axis; the boxes of the numbers themselves tell it, too.
        words.word("ghost cells")?;
        let begin = words.word("number of boxes")?;
        let wrong = || FieldError::new("number of boxes", begin, "must be a bracket and a whole number, such as (8");
        let count: usize = begin.strip_prefix('(').and_then(|n| n.parse().ok()).ok_or_else(wrong)?;
        words.word("hash of the boxes")?;
        let mut corners = Vec::new();
        for i in 0..count {
            corners.push(box_of(&mut words, &format!("box {i}"))?);
        }
        let end = words.word("end of the boxes")?;
        if end != ")" {
            return Err(FieldError::new("end of the boxes", end, "must be a closing bracket"));
        }
        let places: usize = words.number("number of places", WHOLE)?;
        if places != count {
            return Err(FieldError::new("number of places", places, format!("there are {count} boxes")));
        }
        let mut boxes = Vec::new();
        for (i, (first, last)) in corners.into_iter().enumerate() {
            let what = format!("place of box {i}");
            let mark = words.word(&what)?;
            if mark != "FabOnDisk:" {
                return Err(FieldError::new(what, mark, "must be FabOnDisk:, a file and a place in it"));
            }
            let file = words.word(&what)?.to_owned();
            boxes.push(StoredBox { first, last, file, offset: words.number(&what, WHOLE)? });
        }
        let reals = if version == WITH_HEADERS { None } else { Some(Reals::at_end(words.rest())?) };
        Ok(Self { components, boxes, reals })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::{Endian, ScalarType};

    const TEXT: &str = "1\n1\n4\n0\n(2 0\n((0,0,0) (7,7,7) (0,0,0))\n((8,0,0) (15,7,7) (0,0,0))\n)\n2\nFabOnDisk: Cell_D_00001 0\n\
                        FabOnDisk: Cell_D_00001 16470\n\n2,1\n1.0,\n2.0,\n";

    #[test]
    fn boxes_and_their_places() {
        let header = LevelHeader::parse(TEXT).unwrap();
        assert_eq!((header.components, header.boxes.len(), header.reals), (4, 2, None));
        assert_eq!((header.boxes[1].first, header.boxes[1].offset), ([8, 0, 0], 16470));
        let bare = format!("3{}((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))\n", &TEXT[1..]);
        let reals = LevelHeader::parse(&bare).unwrap().reals;
        assert_eq!(reals, Some(Reals { scalar: ScalarType::F64, endian: Endian::Little }));
        let error = |text: &str| LevelHeader::parse(text).unwrap_err().to_string();
        assert!(error(&TEXT.replace("(2 0", "(3 0")).contains("box 2: found ) 2 FabOnDisk:"));
        assert!(error(&TEXT.replace("16470", "x")).contains("place of box 1: found x"));
        assert!(error(&TEXT.replace("(7,7,7)", "(-7,7,7)")).contains("not be before"));
    }
}
