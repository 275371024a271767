//! Cells in: unstructured and curvilinear grids of VTK, PLOT3D and Exodus II become meshes of tetrahedra.
//!
//! Every format gives the same pieces (`cell_file`): vertices, cells of any kind, marks of what is hidden, and arrays. From there on there is one
//! way: an array is chosen (`crate::chosen`), pieces are welded at their seams (`weld`), cells are split (`tetrahedra`), and the mesh is made (`load`).
//! Splitting follows the numbers of the vertices, so that welding comes first: cells on both sides of a seam are split alike.

mod as_points;
mod cell_file;
mod cell_kind;
mod cell_list;
mod exodus;
mod ghosts;
mod load;
mod parallel;
pub(crate) mod plot3d;
mod tetrahedra;
mod vtk_legacy;
mod vtk_xml;
mod weld;
mod xml_cells;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::{FieldError, FileError};
use crate::points::{self, PointFormat};
use crate::read::{Loaded, ReadOptions};
use crate::vtk::{Content, content};

use cell_file::CellFile;
use cell_list::CellList;
use load::Outcome;

pub(crate) use exodus::is_exodus;

/// The two ways to take a file that has cells with vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CellsOrPoints {
    /// A mesh of the cells.
    Cells,
    /// Scattered points, one for each vertex.
    Points,
}

impl CellsOrPoints {
    /// The word that stands for it in scene files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cells => "cells",
            Self::Points => "points",
        }
    }
}

/// The formats of files that hold cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CellFormat {
    /// UNSTRUCTURED_GRID and STRUCTURED_GRID of legacy VTK files.
    VtkLegacy,
    /// UnstructuredGrid and StructuredGrid of VTK's XML.
    VtkXml,
    /// Lists of such XML files.
    VtkParallel,
    Plot3d,
    Exodus,
}

/// The format of a file of cells that its beginning shows; of unstructured grids, too, which [`points::by_content`] knows as points.
pub(crate) fn by_content(head: &[u8]) -> Option<CellFormat> {
    match content(head)? {
        Content::Legacy(kind) => vtk_legacy::DATA_SETS.contains(&kind.as_str()).then_some(CellFormat::VtkLegacy),
        Content::Xml(kind) if vtk_xml::KINDS.contains(&kind.as_str()) => Some(CellFormat::VtkXml),
        Content::Xml(kind) => parallel::KINDS.contains(&kind.as_str()).then_some(CellFormat::VtkParallel),
    }
}

/// Reads a file as a mesh of its cells or, where it has none with three dimensions and values, or where the options say so, as points.
///
/// # Errors
/// A [`FileError`] that names the file, the place, what was found and what would be right.
pub(crate) fn read_as(
    format: CellFormat,
    path: &Path,
    head: &[u8],
    options: &ReadOptions,
) -> Result<Loaded, FileError> {
    let options = &options.with_point_value();
    let as_points = || {
        // Unstructured grids have been read as points before they were read as cells.
        match points::by_content(head) {
            Some(format @ (PointFormat::VtkLegacy | PointFormat::VtkXml)) => {
                crate::read::load_points(path, format, options)
            }
            _ => as_points::load_points(&*open(format, path, options)?, path, options),
        }
    };
    if options.cells_or_points == Some(CellsOrPoints::Points) {
        return as_points();
    }
    let why = match load::load(&*open(format, path, options)?, path, options)? {
        Outcome::Mesh(loaded) => return Ok(*loaded),
        Outcome::None(why) => why,
    };
    if options.cells_or_points == Some(CellsOrPoints::Cells) {
        return Err(FieldError::new("as", "cells", format!("the file cannot be taken so: {why}")).in_file(path));
    }
    let mut loaded = as_points()?;
    loaded.notes.insert(0, format!("no mesh of cells is made of the file: {why}"));
    Ok(loaded)
}

fn open(format: CellFormat, path: &Path, options: &ReadOptions) -> Result<Box<dyn CellFile>, FileError> {
    let in_file = |kind| FileError::new(path, kind);
    Ok(match format {
        CellFormat::VtkLegacy => Box::new(vtk_legacy::LegacyCells::open(path).map_err(in_file)?),
        CellFormat::VtkXml => Box::new(vtk_xml::XmlCells::open(path)?),
        CellFormat::VtkParallel => Box::new(parallel::ParallelCells::open(path)?),
        CellFormat::Plot3d => Box::new(plot3d::Plot3d::open(path)?),
        CellFormat::Exodus => Box::new(exodus::Exodus::open(path, options.frame.unwrap_or(0)).map_err(in_file)?),
    })
}

/// Positions of vertices, from three numbers each.
fn positions(numbers: &[f64]) -> Vec<DVec3> {
    numbers.as_chunks().0.iter().map(|&p: &[f64; 3]| p.into()).collect()
}

/// The cells of a lattice, which must have as many points as there are.
fn lattice(field: &str, dims: [usize; 3], points: usize) -> Result<CellList, FieldError> {
    let claimed = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d));
    if claimed == Some(points) && points < u32::MAX as usize {
        return Ok(CellList::Lattice(dims));
    }
    let found = dims.map(|d| d.to_string()).join(" ");
    Err(FieldError::new(field, found, format!("the product must be the number of points, {points}")))
}
