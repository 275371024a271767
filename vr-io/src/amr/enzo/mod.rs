//! Packed AMR of Enzo: a text file of parameters (`DD0010/name`), one of grids (`name.hierarchy`), and HDF5 files with a group for each grid.
//!
//! The format is that of Enzo's documentation ("Enzo's output formats") and of its writer (`Grid_Group_WriteGrid`). Ghost zones are in no file unless
//! Enzo was told to write them; they are left out.

mod datasets;
mod grid_file;
mod grids;
mod parameters;

use std::path::{Path, PathBuf};

use crate::error::FileError;
use crate::read::{Loaded, ReadOptions};

use super::amr_file::Hierarchy;
use super::text::read_text;

use grids::Grid;
use parameters::Parameters;

/// The end of the name of the list of grids.
const HIERARCHY: &str = "hierarchy";

/// True if a file is one of the two texts: the list of grids, or the parameters beside it.
pub(super) fn is_part(path: &Path, head: &[u8]) -> bool {
    let has = |word: &str| head.windows(word.len()).any(|bytes| bytes == word.as_bytes());
    let is_list = has("GridRank") && has("GridLeftEdge");
    is_list || (has("InitialCycleNumber") || has("TopGridRank")) && list_of(path).is_file()
}

/// The list of grids beside the parameters.
fn list_of(parameters: &Path) -> PathBuf {
    let mut name = parameters.as_os_str().to_owned();
    name.push(".");
    name.push(HIERARCHY);
    name.into()
}

/// The list of grids in a folder, if there is exactly one.
pub(super) fn hierarchy_in(folder: &Path) -> Option<PathBuf> {
    /// A folder of something else may hold many files.
    const MAX_ENTRIES: usize = 65_536;
    let entries = folder.read_dir().ok()?.flatten().take(MAX_ENTRIES).map(|e| e.path());
    let mut lists = entries.filter(|p| p.extension().is_some_and(|e| e == HIERARCHY) && p.with_extension("").is_file());
    let first = lists.next()?;
    lists.next().is_none().then_some(first)
}

/// The two texts of a mesh.
struct Texts {
    /// The two files.
    parameters: PathBuf,
    list: PathBuf,
    /// Names of the fields, in Enzo's order.
    labels: Vec<String>,
    grids: Vec<Grid>,
    hierarchy: Hierarchy,
}

impl Texts {
    /// Reads both texts, from the path of either or of their folder.
    fn read(path: &Path) -> Result<Self, FileError> {
        let list = if path.is_dir() {
            hierarchy_in(path).unwrap_or_else(|| list_of(path))
        } else if path.extension().is_some_and(|e| e == HIERARCHY) {
            path.to_path_buf()
        } else {
            list_of(path)
        };
        let parameters = list.with_extension("");
        let found = Parameters::parse(&read_text(&parameters)?).map_err(|e| e.in_file(&parameters))?;
        let grids = grids::parse(&read_text(&list)?).map_err(|e| e.in_file(&list))?;
        let hierarchy = grids::hierarchy(&found, &grids).map_err(|e| e.in_file(&list))?;
        Ok(Self { parameters, list, labels: found.labels, grids, hierarchy })
    }
}

/// Reads a mesh.
///
/// # Errors
/// Texts that are no mesh, and numbers that are not as these say.
pub(super) fn load(path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    super::load::load(&datasets::Datasets::open(Texts::read(path)?)?, path, options)
}
