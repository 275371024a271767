//! An array of a lattice, in all its pieces.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::decode::numbers_as_f64;
use crate::error::{FieldError, FileError};
use crate::payload::Payload;
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};

use super::data_array::DataArray;
use super::image::{Candidate, Extent, assemble};
use super::lattice_file::{LatticeFile, LatticePiece, PieceArray};
use super::xml::Store;

/// An array, in all pieces.
pub(crate) struct PieceArrays {
    whole: Extent,
    of_cells: bool,
    pieces: Vec<Part>,
    files: Vec<PathBuf>,
}

struct Part {
    store: Arc<Store>,
    extent: Extent,
    array: Result<DataArray, FieldError>,
}

impl Part {
    /// The array, or the error of the file that lacks it.
    fn array(&self) -> Result<&DataArray, FileError> {
        self.array.as_ref().map_err(|e| e.clone().in_file(&self.store.path))
    }
}

impl PieceArrays {
    /// The arrays of the first piece that may be chosen, each found in the others.
    pub fn of_file(file: &LatticeFile) -> Vec<(Candidate, Self)> {
        let whole = file.hull();
        let of = |PieceArray { of_cells, is_scalars, array }: &PieceArray| {
            let (name, of_cells) = (array.name.clone(), *of_cells);
            let pieces = file.pieces.iter().map(|piece| Part {
                store: piece.store.clone(),
                extent: piece.extent,
                array: array_of(piece, of_cells, &name),
            });
            let arrays = Self { whole, of_cells, pieces: pieces.collect(), files: file.files.clone() };
            (Candidate { name, components: array.components, of_cells, is_scalars: *is_scalars }, arrays)
        };
        file.pieces[0].arrays.iter().map(of).collect()
    }

    /// Type of the numbers; `None` where the array is faulty.
    pub fn scalar(&self) -> Option<ScalarType> {
        self.first().map(|array| array.scalar)
    }

    /// The encoding in a word.
    pub fn encoding(&self) -> &'static str {
        self.first().map_or("ascii", |array| array.encoding(&self.pieces[0].store))
    }

    /// The files that hold them.
    pub fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    /// Byte order of [`Self::bytes`].
    pub fn endian(&self) -> Endian {
        self.pieces[0].store.endian
    }

    fn first(&self) -> Option<&DataArray> {
        self.pieces[0].array.as_ref().ok()
    }

    /// Checks that all pieces have it, with the same type and number of components.
    fn check(&self, path: &Path) -> Result<(ScalarType, usize), FileError> {
        let mut first = None;
        for part in &self.pieces {
            let array = part.array()?;
            let kind = (array.scalar, array.components);
            let (scalar, components) = *first.get_or_insert(kind);
            if kind != (scalar, components) || part.store.endian != self.endian() {
                let found = format!("{} {} of {} components", part.store.endian, array.scalar, array.components);
                let allowed = format!("the first piece has {} {scalar} of {components} components", self.endian());
                return Err(FieldError::new(format!("Piece, array {}", array.name), found, allowed).in_file(path));
            }
        }
        first.ok_or_else(|| FieldError::new("Piece", "none with points", "there must be one").in_file(path))
    }

    /// The bytes of all its numbers, of which there must be `count`.
    pub fn bytes(&self, path: &Path, count: usize) -> Result<Vec<u8>, FileError> {
        let (scalar, components) = self.check(path)?;
        let bytes_of = |part: &Part, count: usize| {
            part.array()?.bytes(count, &part.store).map_err(|kind| FileError::new(&part.store.path, kind))
        };
        if let [part] = &self.pieces[..] {
            return bytes_of(part, count);
        }
        let load = |part: &Part| {
            let sizes = part.extent.dims(self.of_cells);
            let count = sizes.iter().try_fold(components, |n, &size| n.checked_mul(size));
            let many = || FieldError::new("Piece, Extent", "a piece", "must have fewer points").in_file(path);
            Ok((part.extent, bytes_of(part, count.ok_or_else(many)?)?))
        };
        let loaded = self.pieces.iter().map(load).collect::<Result<Vec<_>, FileError>>()?;
        assemble(&self.whole, self.of_cells, components * scalar.bytes(), &loaded).map_err(|e| e.in_file(path))
    }

    /// All its numbers, of which there must be `count`.
    pub fn numbers(&self, path: &Path, count: usize) -> Result<Vec<f64>, FileError> {
        let bytes = self.bytes(path, count)?;
        Ok(numbers_as_f64(&bytes, self.scalar().unwrap_or(ScalarType::U8), self.endian()))
    }

    /// Source of its `count` numbers.
    pub fn source(self, path: &Path, count: usize) -> Result<Source, FileError> {
        let (scalar, _) = self.check(path)?;
        let endian = self.endian();
        // Uncompressed numbers of one piece may stay in the file.
        if let [Part { store, array: Ok(array), .. }] = &self.pieces[..] {
            let in_file = |kind| FileError::new(&store.path, kind);
            if let Some(start) = array.place_in_file(count, store).map_err(in_file)? {
                return Ok(Payload::part(&store.path, start, scalar, endian).into());
            }
        }
        let (encoding, files, path) = (self.encoding(), self.files.clone(), path.to_path_buf());
        let decode = Box::new(move |_: &mut Vec<String>| self.bytes(&path, count));
        Ok(Decoded { decode, scalar, endian, encoding, files }.into())
    }
}

fn array_of(piece: &LatticePiece, of_cells: bool, name: &str) -> Result<DataArray, FieldError> {
    let found = piece.arrays.iter().find(|a| a.of_cells == of_cells && a.array.name == name);
    found.map(|a| a.array.clone()).ok_or_else(|| {
        let allowed = "every piece must have it, as the first one has";
        FieldError::new(format!("Piece, array {name}"), "nothing", allowed)
    })
}
