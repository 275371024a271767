//! Exodus II: finite elements in NetCDF's classic formats (Schoof & Yarberry, SAND92-2137, 1994, and the SEACAS library's later names).
//!
//! Elements stand in blocks of one type, `connect1` and on; values of nodes and elements in variables of their own, one for each name, with time as
//! the first axis.

mod blocks;
mod variables;

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::decode::numbers_as_f64;
use crate::error::{FileError, FileErrorKind};
use crate::netcdf::Classic;
use crate::scalar::{Endian, ScalarType};
use crate::variables::{Store, Variable};
use crate::vtk::Candidate;

use super::cell_file::{CellFile, Facts, Hidden, Piece};
use super::cell_list::{CellList, Listed};

use blocks::Block;
use variables::{Values, candidates};

/// True if a NetCDF file holds blocks of elements.
pub(crate) fn is_exodus(path: &Path) -> bool {
    Classic::open(path).is_ok_and(|store| {
        let has = |name: &str| store.variables().iter().any(|v| v.name == name);
        (has("coordx") || has("coord")) && store.variables().iter().any(|v| blocks::number_of(&v.name).is_some())
    })
}

/// A file of which the header has been read.
pub(super) struct Exodus {
    path: PathBuf,
    store: Classic,
    blocks: Vec<Block>,
    values: Vec<Values>,
    candidates: Vec<Candidate>,
    frame: usize,
    frames: usize,
}

impl Exodus {
    /// Reads the header, the names of the values, and the sizes of the blocks.
    pub fn open(path: &Path, frame: usize) -> Result<Self, FileErrorKind> {
        let store = Classic::open(path)?;
        let blocks = blocks::blocks(&store)?;
        let (mut values, mut candidates) = candidates(&store)?;
        let mut frames = values.iter().filter_map(|v| v.frames(&store)).max().unwrap_or(0);
        if frames == 0 {
            // Without a time step no value has numbers: there are elements alone.
            (values, candidates, frames) = (Vec::new(), Vec::new(), 1);
        }
        Ok(Self { path: path.into(), store, blocks, values, candidates, frame, frames })
    }

    fn coordinates(&self) -> Result<Vec<DVec3>, FileErrorKind> {
        let axis = |name| variable(&self.store, name).map(|v| whole(&self.store, v)).transpose();
        // Each axis alone or, in older files, all in one.
        let axes = match variable(&self.store, "coord") {
            Some(all) => {
                let numbers = whole(&self.store, all)?;
                let nodes = all.shape.last().copied().unwrap_or(0);
                numbers.chunks(nodes.max(1)).map(<[f64]>::to_vec).collect()
            }
            None => [axis("coordx")?, axis("coordy")?, axis("coordz")?]
                .into_iter()
                .map(Option::unwrap_or_default)
                .collect::<Vec<_>>(),
        };
        let count = axes.first().map_or(0, Vec::len);
        // What has no z lies in a plane.
        let at = |axis: usize, node: usize| axes.get(axis).and_then(|numbers| numbers.get(node)).copied();
        if let Some(short) = axes.iter().find(|numbers| !numbers.is_empty() && numbers.len() != count) {
            let allowed = format!("each axis has one for each of {count} nodes");
            return Err(FileErrorKind::field("coordinates", short.len(), allowed));
        }
        Ok((0..count).map(|node| DVec3::from([0, 1, 2].map(|axis| at(axis, node).unwrap_or(0.0)))).collect())
    }

    fn read_piece(&self) -> Result<Piece, FileErrorKind> {
        let positions = self.coordinates()?;
        let mut listed = Listed::default();
        for block in &self.blocks {
            block.read(&self.store, positions.len(), &mut listed)?;
        }
        Ok(Piece { positions, cells: CellList::Listed(listed), hidden: Hidden::default() })
    }
}

/// The variable of a name.
fn variable<'s>(store: &'s Classic, name: &str) -> Option<&'s Variable> {
    store.variables().iter().find(|v| v.name == name)
}

/// Numbers of a whole variable.
fn whole(store: &Classic, variable: &Variable) -> Result<Vec<f64>, FileErrorKind> {
    let bytes = store.read(variable, &vec![0; variable.shape.len()], &variable.shape)?;
    Ok(numbers_as_f64(&bytes, variable.scalar, Endian::Big))
}

impl CellFile for Exodus {
    fn facts(&self) -> Facts {
        let place = variable(&self.store, "coordx").or_else(|| variable(&self.store, "coord"));
        Facts {
            format: "Exodus II",
            encoding: "raw",
            scalar: place.map_or(ScalarType::F64, |v| v.scalar),
            endian: Endian::Big,
            frames: self.frames,
            files: vec![self.path.clone()],
        }
    }

    fn arrays(&self) -> &[Candidate] {
        &self.candidates
    }

    fn piece(&self, _: usize) -> Result<Piece, FileError> {
        self.read_piece().map_err(|kind| FileError::new(&self.path, kind))
    }

    fn numbers(&self, _: usize, array: usize) -> Result<Vec<f64>, FileError> {
        let numbers = self.values[array].read(&self.store, self.frame, &self.blocks);
        numbers.map_err(|kind| FileError::new(&self.path, kind))
    }
}
