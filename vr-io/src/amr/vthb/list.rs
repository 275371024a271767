//! The list of blocks, as it stands.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use roxmltree::Node;

use crate::error::FileErrorKind;
use crate::inside::inside;
use crate::vtk::{XmlFile, exactly, root};

use super::KINDS;

/// The list of blocks.
#[derive(Debug, Default)]
pub(super) struct List {
    pub origin: Option<DVec3>,
    pub levels: BTreeMap<usize, ListedLevel>,
    /// Blocks without a file.
    pub empty: usize,
}

/// A level of the list.
#[derive(Debug, Default)]
pub(super) struct ListedLevel {
    pub spacing: Option<DVec3>,
    /// Ratio to the next level, in version 1.0.
    pub ratio: Option<u32>,
    /// Path of each image, and first and last cell along each axis.
    pub images: Vec<(PathBuf, Option<[i64; 6]>)>,
}

impl List {
    /// Reads the list.
    ///
    /// # Errors
    /// Anything that is no list, names files elsewhere than in its folder, or leaves out a level.
    pub fn read(path: &Path) -> Result<Self, FileErrorKind> {
        let file = XmlFile::open(path)?;
        let document = file.document()?;
        let (root, kind) = root(&document, &KINDS)?;
        let wrong = |what: &str, found: &str, allowed: &str| FileErrorKind::field(what, found, allowed);
        let list = root.children().find(|n| n.has_tag_name(kind));
        let list = list.ok_or_else(|| wrong(kind, "nothing", "must follow the root, and hold blocks"))?;
        let triple = |node: Node<'_, '_>, name: &str| match node.attribute(name) {
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
