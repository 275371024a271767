//! Plotfiles of AMReX: a folder with a text file `Header`, and for each level a header of its boxes (`Level_0/Cell_H`) and files of their numbers.
//!
//! The format is that of AMReX's own writer and readers (`WriteGenericPlotfileHeader`, `PlotFileDataImpl`, `VisMF::Header`, `FArrayBox`).

mod fab;
mod level_header;
mod plot_header;

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::facts::Facts;
use crate::inside::inside;
use crate::read::{each_once, file_head};
use crate::vtk::Candidate;

use super::amr_file::{AmrFile, BlockBox, Hierarchy};
use super::text::read_text;

use fab::Fab;
use level_header::LevelHeader;
use plot_header::PlotHeader;

/// Name of the text file in the folder.
const HEADER: &str = "Header";

/// True if a file begins as the header of a plotfile.
pub(super) fn is_header(head: &[u8]) -> bool {
    plot_header::VERSIONS.iter().any(|version| {
        head.strip_prefix(version.as_bytes()).is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
    })
}

/// True if a folder is a plotfile.
pub(super) fn is_plotfile(folder: &Path) -> bool {
    file_head(&folder.join(HEADER)).is_ok_and(|head| is_header(&head))
}

/// A plotfile of which the headers have been read.
pub(super) struct Plotfile {
    header: PathBuf,
    arrays: Vec<Candidate>,
    hierarchy: Hierarchy,
    /// The place of each block's numbers.
    fabs: Vec<Fab>,
    files: Vec<PathBuf>,
}

impl Plotfile {
    /// Reads the headers of a folder, or of the one that the path of `Header` lies in.
    ///
    /// # Errors
    /// Headers that are missing, damaged, or do not agree; plotfiles that are not of three Cartesian dimensions.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let header = if path.is_dir() { path.join(HEADER) } else { path.to_path_buf() };
        let folder = header.parent().unwrap_or(Path::new("")).to_path_buf();
        let in_header = |e: FieldError| e.in_file(&header);
        let plot = PlotHeader::parse(&read_text(&header)?).map_err(in_header)?;

        // Put the blocks of all levels together.
        let (mut boxes, mut fabs, mut files) = (Vec::new(), Vec::new(), vec![header.clone()]);
        for (level, entry) in plot.levels.iter().enumerate() {
            let stem = inside(&folder, &format!("level {level}, path"), &entry.path).map_err(in_header)?;
            let mut list = stem.into_os_string();
            list.push("_H");
            let list = PathBuf::from(list);
            if let Err(source) = std::fs::metadata(&list) {
                return Err(FileError::new(&header, FileErrorKind::DataFile { data: list, source }));
            }
            let found = LevelHeader::parse(&read_text(&list)?).map_err(|e| e.in_file(&list))?;
            entry.check(level, &found, plot.names.len()).map_err(|e| e.in_file(&list))?;
            let level_folder = list.parent().unwrap_or(Path::new("")).to_path_buf();
            for (number, stored) in found.boxes.iter().enumerate() {
                let (first, last) = (entry.in_domain(stored.first), entry.in_domain(stored.last));
                let block = first.zip(last).and_then(|(first, last)| BlockBox::between(level, first, last));
                let wrong = || FieldError::new(format!("box {number}"), stored, "must hold cells, with whole numbers");
                boxes.push(block.ok_or_else(|| wrong().in_file(&list))?);
                let data = inside(&level_folder, "FabOnDisk", &stored.file).map_err(|e| e.in_file(&list))?;
                let (of_file, offset) = (found.reals, stored.offset);
                fabs.push(Fab { path: data.clone(), offset, reals: of_file, first: stored.first, last: stored.last });
                files.push(data);
            }
            files.push(list);
        }
        let hierarchy = Hierarchy {
            origin: DVec3::from_array(plot.low),
            spacing: plot.spacing(),
            ratios: plot.ratios().map_err(in_header)?,
            boxes,
            placed_by: "prob_lo and prob_hi",
        };
        let array = |name: &String| Candidate { name: name.clone(), components: 1, of_cells: true, is_scalars: false };
        let arrays = plot.names.iter().map(array).collect();
        Ok(Self { header, arrays, hierarchy, fabs, files: each_once(files) })
    }
}

impl AmrFile for Plotfile {
    fn facts(&self) -> Facts {
        let mut facts = Facts::of_form("AMReX plotfile", self.files.clone());
        // A fault is told when the numbers are read.
        if let Some(Ok((form, _))) = self.fabs.first().map(Fab::form) {
            (facts.scalar, facts.endian) = (form.reals.scalar, form.reals.endian);
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
        let fab = &self.fabs[block];
        if let Err(source) = std::fs::metadata(&fab.path) {
            return Err(FileError::new(&self.header, FileErrorKind::DataFile { data: fab.path.clone(), source }));
        }
        fab.numbers(array, self.arrays.len()).map_err(|kind| FileError::new(&fab.path, kind))
    }
}
