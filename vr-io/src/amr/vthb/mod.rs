//! AMR of VTK's XML (.vthb, .vth): a list of blocks by level, each of them an image in a file of its own.
//!
//! Versions 1.0 and 1.1 (`vtkXMLHierarchicalBoxDataReader`, `vtkXMLUniformGridAMRReader`): 1.1 tells the origin, the spacing of each level and the
//! box of each block; 1.0 tells boxes and ratios, and leaves the rest to the images; of blocks that do not overlap the images tell all.

mod block;
mod list;

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::facts::Facts;
use crate::read::each_once;
use crate::vtk::{Candidate, Content, PieceArrays, content};

use super::amr_file::{AmrFile, Hierarchy, count_of};
use super::crop::crop;
use super::lattices::{ratios_of, spacing_of};

use block::Block;
use list::List;

/// The kinds of lists.
const KINDS: [&str; 3] = ["vtkOverlappingAMR", "vtkHierarchicalBoxDataSet", "vtkNonOverlappingAMR"];
/// Name of the array of marks.
const GHOST_TYPE: &str = "vtkGhostType";

/// True if a file begins as such a list.
pub(super) fn is_vthb(head: &[u8]) -> bool {
    matches!(content(head), Some(Content::Xml(kind)) if KINDS.contains(&kind.as_str()))
}

/// A list of which all images have been described.
pub(super) struct Vthb {
    path: PathBuf,
    arrays: Vec<Candidate>,
    hierarchy: Hierarchy,
    blocks: Vec<Block>,
    /// Blocks without a file.
    empty: usize,
}

impl Vthb {
    /// Reads the list, and everything but numbers of its images; of ghost marks these, too.
    ///
    /// # Errors
    /// Faults of the list, an image that is missing, and images that lie elsewhere than the list says.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let list = List::read(path).map_err(|kind| FileError::new(path, kind))?;
        let in_list = |e: FieldError| e.in_file(path);
        let mut blocks: Vec<(usize, Option<[i64; 6]>, Block)> = Vec::new();
        for (&level, listed) in &list.levels {
            for (image, cells) in &listed.images {
                if let Err(source) = std::fs::metadata(image) {
                    return Err(FileError::new(path, FileErrorKind::DataFile { data: image.clone(), source }));
                }
                blocks.push((level, *cells, Block::open(image)?));
            }
        }

        // Find the lattices of the levels.
        let low = |block: &Block| block.low();
        let of_level = |level: usize| blocks.iter().filter(move |(l, ..)| *l == level).map(|(_, _, block)| block);
        let coarsest = of_level(0).map(low).reduce(DVec3::min).unwrap_or(DVec3::ZERO);
        let origin = list.origin.unwrap_or(coarsest);
        let mut spacings: Vec<DVec3> = Vec::new();
        for (level, listed) in &list.levels {
            let of_ratio = || {
                let coarser = list.levels.get(&level.checked_sub(1)?)?;
                Some(*spacings.last()? / f64::from(coarser.ratio?))
            };
            let of_image = || of_level(*level).find_map(Block::spacing);
            let spacing = listed.spacing.or_else(of_image).or_else(of_ratio);
            let missing = || FieldError::new(format!("level {level}, spacing"), "nothing", "must be three numbers");
            spacings.push(spacing.ok_or_else(missing).map_err(in_list)?);
        }
        let ratios = spacings.windows(2).enumerate();
        let ratios = ratios.map(|(i, pair)| ratios_of(pair[0], pair[1], &format!("level {}, spacing", i + 1)));
        let ratios = ratios.collect::<Result<Vec<_>, _>>().map_err(in_list)?;

        // Place the blocks on them.
        let mut boxes = Vec::new();
        for (level, cells, block) in &blocks {
            let spacing = spacing_of(spacings[0], &ratios, *level);
            boxes.push(block.place(*level, *cells, origin, spacing).map_err(|e| e.in_file(&block.path))?);
        }
        let placed_by = if list.origin.is_some() { "origin and spacing" } else { "its images" };
        let hierarchy = Hierarchy { origin, spacing: spacings[0], ratios, boxes, placed_by };
        let blocks: Vec<Block> = blocks.into_iter().map(|(_, _, block)| block).collect();
        // The first block tells what there is to choose.
        let arrays = PieceArrays::of_file(&blocks[0].image).into_iter().map(|(candidate, _)| candidate);
        let arrays = arrays.filter(|a| a.name != GHOST_TYPE && a.components > 0).collect();
        Ok(Self { path: path.into(), arrays, hierarchy, blocks, empty: list.empty })
    }
}

impl AmrFile for Vthb {
    fn facts(&self) -> Facts {
        let images = self.blocks.iter().map(|block| block.path.clone());
        let files = each_once(std::iter::once(self.path.clone()).chain(images));
        let mut facts = Facts::of_form("VTK AMR", files);
        if let Some((_, array)) = PieceArrays::of_file(&self.blocks[0].image).first() {
            (facts.encoding, facts.endian) = (array.encoding(), array.endian());
            facts.scalar = array.scalar().unwrap_or(facts.scalar);
        }
        facts
    }

    fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    fn arrays(&self) -> &[Candidate] {
        &self.arrays
    }

    fn numbers(&self, block: usize, array: usize) -> Result<Vec<f64>, FileError> {
        let (block, wanted) = (&self.blocks[block], &self.arrays[array]);
        let in_file = |e: FieldError| e.in_file(&block.path);
        let arrays = PieceArrays::of_file(&block.image);
        let is_wanted = |c: &Candidate| c.of_cells == wanted.of_cells && c.name == wanted.name;
        let missing = || {
            let allowed = "every block must have it, with as many components as the first one";
            in_file(FieldError::new(format!("array {}", wanted.name), "nothing", allowed))
        };
        let found = arrays.iter().find(|(c, _)| is_wanted(c) && c.components == wanted.components);
        let (_, array) = found.ok_or_else(missing)?;
        let corners = usize::from(!wanted.of_cells);
        let (whole, own) = (block.whole.map(|n| n + corners), block.cells.map(|n| n + corners));
        let many = || in_file(FieldError::new("Extent", "too many cells", "must be fewer"));
        let count = count_of(whole, wanted.components).ok_or_else(many)?;
        let mut numbers = array.numbers(&block.path, count)?;
        if wanted.of_cells {
            for (tuple, &hidden) in numbers.chunks_exact_mut(wanted.components).zip(&block.hidden) {
                if hidden {
                    tuple.fill(f64::NAN);
                }
            }
        }
        let is_cut = whole != own;
        Ok(if is_cut { crop(&numbers, whole, block.from, own, wanted.components) } else { numbers })
    }

    fn notes(&self) -> Vec<String> {
        let empty = self.empty;
        if empty > 0 { vec![format!("{empty} blocks are listed without a file, and are left out")] } else { Vec::new() }
    }
}
