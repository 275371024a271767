//! The layout of a PLOT3D file, found by trying: nothing in the file tells it but its length.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::regular_file::{self, RegularFile};
use crate::scalar::{Endian, ScalarType};

/// The two kinds of files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    /// Positions of the points, and perhaps marks of holes.
    Grid,
    /// Four numbers about the flow, and five of each point.
    Solution,
}

/// The form of a file, and the places of its grids.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub endian: Endian,
    /// Type of the numbers.
    pub scalar: ScalarType,
    /// True if each record has its length before and behind it, as Fortran writes it.
    pub has_marks: bool,
    /// True if each point has a mark: 0 in holes.
    pub has_blanks: bool,
    pub grids: Vec<GridPlace>,
}

/// A grid in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GridPlace {
    /// Points along each axis.
    pub dims: [usize; 3],
    /// Byte at which its first array begins.
    pub at: u64,
}

/// Bytes of a block, to whole numbers of which some systems filled files up.
const BLOCK: u64 = 512;
/// Largest number of grids, and of points along an axis.
const MAX: u64 = 1 << 24;

impl Layout {
    /// Finds the one layout under which the length of a file is what its sizes add up to, exactly or filled up to whole blocks.
    pub fn find(path: &Path, content: Content) -> Option<Self> {
        let mut file = regular_file::open(path).ok()?;
        let length = file.length().ok()?;
        let forms = [Endian::Little, Endian::Big].into_iter().flat_map(|endian| {
            [false, true]
                .into_iter()
                .flat_map(move |has_marks| [false, true].map(|several| (endian, has_marks, several)))
        });
        let headers: Vec<Header> = forms
            .filter_map(|(endian, has_marks, several)| header(&mut file, length, endian, has_marks, several))
            .collect();
        let fit = |is_filled_up| headers.iter().find_map(|header| header.fit(length, content, is_filled_up));
        fit(false).or_else(|| fit(true))
    }
}

/// Sizes at the beginning of a file.
struct Header {
    endian: Endian,
    has_marks: bool,
    dims: Vec<[usize; 3]>,
    /// Byte behind it.
    end: u64,
}

/// Reads the sizes, if the file begins with sizes of this form.
fn header(file: &mut RegularFile, length: u64, endian: Endian, has_marks: bool, several: bool) -> Option<Header> {
    file.seek(SeekFrom::Start(0)).ok()?;
    let mut at = 0;
    let mut word = || -> Option<u64> {
        let mut bytes = [0; 4];
        file.read_exact(&mut bytes).ok()?;
        at += 4;
        Some(u64::from(if endian == Endian::Little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }))
    };
    let mark = |word: &mut dyn FnMut() -> Option<u64>, bytes: u64| {
        if has_marks { (word()? == bytes).then_some(()) } else { Some(()) }
    };
    let mut count = 1;
    if several {
        mark(&mut word, 4)?;
        count = word()?;
        mark(&mut word, 4)?;
    }
    // A grid has its sizes, and eight points at least.
    if !(1..=MAX.min(length / 12)).contains(&count) {
        return None;
    }
    mark(&mut word, 12 * count)?;
    let mut dims = Vec::new();
    for _ in 0..count {
        let sizes = [word()?, word()?, word()?];
        if sizes.iter().any(|&n| n == 0 || n > MAX) {
            return None;
        }
        dims.push(sizes.map(|n| n as usize));
    }
    mark(&mut word, 12 * count)?;
    Some(Header { endian, has_marks, dims, end: at })
}

impl Header {
    /// The layout whose length is that of the file or, if that is filled up, of all but the end of its last block.
    fn fit(&self, length: u64, content: Content, is_filled_up: bool) -> Option<Layout> {
        let kinds = [ScalarType::F32, ScalarType::F64];
        let forms = kinds.into_iter().flat_map(|scalar| [false, true].map(|has_blanks| (scalar, has_blanks)));
        let forms = forms.filter(|&(_, has_blanks)| content == Content::Grid || !has_blanks);
        forms.into_iter().find_map(|(scalar, has_blanks)| {
            let (real, mark) = (scalar.bytes() as u64, if self.has_marks { 4 } else { 0 });
            let (mut at, mut grids) = (self.end, Vec::new());
            for &dims in &self.dims {
                let points = dims.iter().try_fold(1u64, |n, &d| n.checked_mul(d as u64))?;
                let (before, per_point) = match content {
                    Content::Grid => (0, 3 * real + if has_blanks { 4 } else { 0 }),
                    Content::Solution => (4 * real + 2 * mark, 5 * real),
                };
                let begin = at.checked_add(before + mark)?;
                grids.push(GridPlace { dims, at: begin });
                at = begin.checked_add(points.checked_mul(per_point)?)?.checked_add(mark)?;
            }
            let Self { endian, has_marks, .. } = *self;
            let fits = if is_filled_up {
                length.is_multiple_of(BLOCK) && at <= length && length - at < BLOCK
            } else {
                at == length
            };
            fits.then_some(Layout { endian, scalar, has_marks, has_blanks, grids })
        })
    }
}
