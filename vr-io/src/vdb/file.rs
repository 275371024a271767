//! The beginning of a file: its version, and the grids with their places.

use std::path::Path;

use crate::error::FileErrorKind;
use crate::regular_file;

use super::bytes::Bytes;
use super::map::Map;
use super::tree::Tree;
use super::values::Compression;

/// A file: small beside the memory that its voxels take.
pub(super) struct VdbFile {
    bytes: Vec<u8>,
    pub grids: Vec<Grid>,
}

/// A grid of a file.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub name: String,
    /// Type of the tree and its values: `Tree_float_5_4_3`.
    pub kind: String,
    /// True if values are in 16 bits.
    pub is_half: bool,
    /// Grid of which it is another view, sharing the tree.
    pub parent: String,
    pub compression: Compression,
    /// Place behind the compression: metadata, transform and topology.
    start: usize,
    /// Place of the leaves' values.
    buffers: usize,
}

impl Grid {
    pub fn is_read(&self) -> bool {
        self.kind == "Tree_float_5_4_3" && self.parent.is_empty()
    }
}

/// Longest file, which is taken into memory as a whole.
const MAX_BYTES: u64 = 1 << 34;

/// Most grids of a file.
const MAX_GRIDS: u32 = 4096;

impl VdbFile {
    pub fn read(path: &Path) -> Result<Self, FileErrorKind> {
        let all = regular_file::read(path, MAX_BYTES)?;
        let mut bytes = Bytes::new(&all, 0);
        bytes.take(8)?;
        let version = bytes.u32()?;
        if !(222..=224).contains(&version) {
            return Err(FileErrorKind::field("version of the file", version, "must be 222 to 224"));
        }
        bytes.take(8)?;
        if bytes.array::<1>()? != [1] {
            let allowed = "must be there: files that were written to a stream are not read";
            return Err(FileErrorKind::field("offsets of grids", "none", allowed));
        }
        // An identifier of 36 letters.
        bytes.take(36)?;
        skip_metadata(&mut bytes)?;
        let count = bytes.u32()?;
        if count > MAX_GRIDS {
            return Err(FileErrorKind::field("grids", count, format!("must be at most {MAX_GRIDS}")));
        }
        let mut grids = Vec::new();
        for _ in 0..count {
            // Names that are there several times have a number behind them.
            let name = bytes.text()?.split('\u{1e}').next().unwrap_or_default().to_owned();
            let mut kind = bytes.text()?;
            let parent = bytes.text()?;
            let mut place = || {
                let offset = bytes.i64()?;
                let allowed = format!("must be within the {} bytes of the file", all.len());
                let fits = usize::try_from(offset).ok().filter(|&at| at <= all.len());
                fits.ok_or_else(|| FileErrorKind::field("offset of a grid", offset, allowed))
            };
            let (start, buffers, end) = (place()?, place()?, place()?);
            let is_half = kind.ends_with("_HalfFloat");
            kind.truncate(kind.len() - if is_half { "_HalfFloat".len() } else { 0 });
            let mut inner = Bytes::new(&all, start);
            let compression = Compression::from_flags(inner.u32()?)?;
            grids.push(Grid { name, kind, is_half, parent, compression, start: inner.at(), buffers });
            bytes = Bytes::new(&all, end);
        }
        Ok(Self { grids, bytes: all })
    }

    /// The tree of a grid, with the values of its leaves.
    pub fn tree(&self, grid: &Grid) -> Result<Tree, FileErrorKind> {
        let mut bytes = Bytes::new(&self.bytes, grid.start);
        skip_metadata(&mut bytes)?;
        let map = Map::read(&mut bytes)?;
        let buffers = Bytes::new(&self.bytes, grid.buffers);
        Tree::read(bytes, buffers, grid.compression, grid.is_half, map)
    }
}

fn skip_metadata(bytes: &mut Bytes<'_>) -> Result<(), FileErrorKind> {
    for _ in 0..bytes.u32()? {
        // A name, a type, and a value with its length.
        bytes.text()?;
        bytes.text()?;
        let length = bytes.u32()? as usize;
        bytes.take(length)?;
    }
    Ok(())
}
