//! AMR of VTK's XML (.vthb, .vth): a list of blocks by level, each of them an image in a file of its own.
//!
//! Versions 1.0 and 1.1 (`vtkXMLHierarchicalBoxDataReader`, `vtkXMLUniformGridAMRReader`): 1.1 tells the origin, the spacing of each level and the box
//! of each block; 1.0 tells boxes and ratios, and leaves the rest to the images; of blocks that do not overlap the images tell all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::facts::Facts;
use crate::inside::inside;
use crate::read::each_once;
use crate::vtk::{self, Candidate, Content, IMAGE, LatticeFile, PieceArrays, XmlFile, content, exactly};

use super::amr_file::{AmrFile, BlockBox, Hierarchy, count_of};
use super::crop::crop;
use super::lattices::{index_of, ratios_of, spacing_of};

/// The kinds of lists.
const KINDS: [&str; 3] = ["vtkOverlappingAMR", "vtkHierarchicalBoxDataSet", "vtkNonOverlappingAMR"];
/// Marks of cells: copied from a neighbour, or blanked (`vtkDataSetAttributes`). Those under finer cells need no mark.
const DUPLICATE_CELL: u8 = 1;
const HIDDEN_CELL: u8 = 32;
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

/// The image of a block.
struct Block {
    path: PathBuf,
    image: LatticeFile,
    /// Cells of the image, ghost cells among them.
    whole: [usize; 3],
    /// First of its cells that is its own.
    from: [usize; 3],
    /// Its own cells.
    cells: [usize; 3],
    /// Cells that are blanked; empty where none is.
    hidden: Vec<bool>,
}

/// The list, as it stands.
#[derive(Debug, Default)]
struct List {
    origin: Option<DVec3>,
    levels: BTreeMap<usize, ListedLevel>,
    empty: usize,
}

#[derive(Debug, Default)]
struct ListedLevel {
    spacing: Option<DVec3>,
    /// Ratio to the next level, in version 1.0.
    ratio: Option<u32>,
    /// Path of each image, and first and last cell along each axis.
    images: Vec<(PathBuf, Option<[i64; 6]>)>,
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

impl List {
    fn read(path: &Path) -> Result<Self, FileErrorKind> {
        let file = XmlFile::open(path)?;
        let document = file.document()?;
        let (root, kind) = vtk::root(&document, &KINDS)?;
        let wrong = |what: &str, found: &str, allowed: &str| FileErrorKind::field(what, found, allowed);
        let list = root.children().find(|n| n.has_tag_name(kind));
        let list = list.ok_or_else(|| wrong(kind, "nothing", "must follow the root, and hold blocks"))?;
        let triple = |node: roxmltree::Node<'_, '_>, name: &str| match node.attribute(name) {
            None => Ok(None),
            Some(text) => {
                let numbers =
                    exactly::<f64, 3>(text.split_ascii_whitespace()).filter(|n| n.iter().all(|x| x.is_finite()));
                numbers.map(|n| Some(DVec3::from_array(n))).ok_or_else(|| wrong(name, text, "must be three numbers"))
            }
        };
        if let Some(flat) =
            list.attribute("grid_description").filter(|d| matches!(d.trim(), "XY" | "YZ" | "XZ" | "X" | "Y" | "Z"))
        {
            return Err(wrong("grid_description", flat, "meshes of three dimensions are read: XYZ"));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut found = Self { origin: triple(list, "origin")?, ..Self::default() };
        for (number, block) in list.children().filter(|n| n.has_tag_name("Block")).enumerate() {
            let level = match block.attribute("level") {
                None => number,
                Some(text) => text.trim().parse().map_err(|_| wrong("Block, level", text, "must be a whole number"))?,
            };
            let listed = found.levels.entry(level).or_default();
            listed.spacing = triple(block, "spacing")?.or(listed.spacing);
            if let Some(text) = block.attribute("refinement_ratio") {
                let ratio = text.trim().parse().ok().filter(|&ratio| ratio > 0);
                listed.ratio = Some(
                    ratio.ok_or_else(|| wrong("Block, refinement_ratio", text, "must be a whole number above 0"))?,
                );
            }
            for image in block.children().filter(|n| n.has_tag_name("DataSet")) {
                let Some(name) = image.attribute("file").filter(|name| !name.is_empty()) else {
                    found.empty += 1;
                    continue;
                };
                let cells = match image.attribute("amr_box") {
                    None => None,
                    Some(text) => Some(
                        exactly::<i64, 6>(text.split_ascii_whitespace())
                            .ok_or_else(|| wrong("amr_box", text, "must be the first and last cell of each axis"))?,
                    ),
                };
                listed.images.push((inside(folder, "DataSet, file", name)?, cells));
            }
        }
        // Levels of which no process has a block are written all the same, behind the others.
        while found.levels.last_key_value().is_some_and(|(_, listed)| listed.images.is_empty()) {
            found.levels.pop_last();
        }
        let missing =
            (0..).zip(found.levels.iter()).find(|(i, (level, listed))| i != *level || listed.images.is_empty());
        if found.levels.is_empty() || missing.is_some() {
            let level = missing.map_or(0, |(i, _)| i);
            return Err(wrong(&format!("level {level}"), "no block with a file", "each level must have one"));
        }
        Ok(found)
    }
}

impl Block {
    fn open(path: &Path) -> Result<Self, FileError> {
        let image = LatticeFile::open(path, IMAGE)?;
        let wrong = |what: &str, found: String, allowed: &str| Err(FieldError::new(what, found, allowed).in_file(path));
        if image.is_list {
            return wrong("VTKFile type", IMAGE[1].to_owned(), "a block must be in one file");
        }
        if image.attributes.direction.is_some_and(|m| m != [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]) {
            return wrong("Direction", "a rotation".to_owned(), "the axes of a block must be those of the world");
        }
        let points = image.hull().dims(false);
        if points.contains(&1) {
            return wrong("Extent", format!("{points:?} points"), "a block must have cells in three dimensions");
        }
        let whole = image.hull().dims(true);
        let mut block = Self { path: path.into(), image, whole, from: [0; 3], cells: whole, hidden: Vec::new() };
        block.read_marks()?;
        Ok(block)
    }

    /// Finds the box of its own cells, and those that are blanked.
    fn read_marks(&mut self) -> Result<(), FileError> {
        let arrays = PieceArrays::of_file(&self.image);
        let found = arrays.iter().find(|(c, _)| c.of_cells && c.name == GHOST_TYPE && c.components == 1);
        let Some((_, array)) = found else { return Ok(()) };
        let many = || FieldError::new("Extent", "too many cells", "must be fewer").in_file(&self.path);
        let marks = array.numbers(&self.path, count_of(self.whole, 1).ok_or_else(many)?)?;
        let is = |mark: f64, bit: u8| mark as u8 & bit != 0;
        let [nx, ny, _] = self.whole;
        let (mut low, mut high) = (self.whole, [0; 3]);
        for i in (0..marks.len()).filter(|&i| !is(marks[i], DUPLICATE_CELL)) {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            for a in 0..3 {
                (low[a], high[a]) = (low[a].min(at[a]), high[a].max(at[a] + 1));
            }
        }
        // Where all are copies, the block is kept: its values are right.
        if high != [0; 3] {
            self.from = low;
            self.cells = [0, 1, 2].map(|a| high[a] - low[a]);
        }
        if marks.iter().any(|&mark| is(mark, HIDDEN_CELL)) {
            self.hidden = marks.iter().map(|&mark| is(mark, HIDDEN_CELL)).collect();
        }
        Ok(())
    }

    /// Distances of the planes, if the image tells them.
    fn spacing(&self) -> Option<DVec3> {
        self.image.attributes.spacing.map(DVec3::from_array)
    }

    /// Corner of its first own cell.
    fn low(&self) -> DVec3 {
        let origin = self.image.attributes.origin.map_or(DVec3::ZERO, DVec3::from_array);
        let first = self.image.hull().first();
        let index = [0, 1, 2].map(|a| first[a] as f64 + self.from[a] as f64);
        origin + DVec3::from_array(index) * self.spacing().unwrap_or(DVec3::ONE)
    }

    /// Its own cells on the lattice of its level, where the list may have a box for it, with or without ghost cells.
    fn place(
        &self,
        level: usize,
        listed: Option<[i64; 6]>,
        origin: DVec3,
        spacing: DVec3,
    ) -> Result<BlockBox, FieldError> {
        let first = index_of(self.low(), origin, spacing, "Origin and Extent")?;
        let found = BlockBox { level, first, cells: self.cells };
        if let Some([a, b, c, d, e, f]) = listed {
            let listed = BlockBox::between(level, [a, c, e], [b, d, f]);
            let mut with_ghosts = BlockBox { cells: self.whole, ..found };
            for (first, &ghosts) in with_ghosts.first.iter_mut().zip(&self.from) {
                *first -= ghosts as i64;
            }
            if listed.is_none_or(|listed| listed != found && listed != with_ghosts) {
                let shown = format!("{:?} cells from {first:?} on", self.cells);
                let allowed = format!("the list has amr_box {a} {b} {c} {d} {e} {f} for it");
                return Err(FieldError::new("Origin and Extent", shown, allowed));
            }
        }
        Ok(found)
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
