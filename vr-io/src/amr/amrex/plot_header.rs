//! The file `Header` of a plotfile: names of the components, levels, and the box of the problem.

use glam::DVec3;

use crate::error::{FieldError, shown};

use super::super::lattices::ratios_of;
use super::super::text::{Words, integers};
use super::level_header::LevelHeader;

/// First lines of the files that are written alike.
pub(super) const VERSIONS: [&str; 3] = ["HyperCLaw-V1.1", "NavierStokes-V1.1", "CartGrid-V2.0"];

/// The header of a plotfile.
#[derive(Debug)]
pub(super) struct PlotHeader {
    /// Names of the components, fit for a line.
    pub names: Vec<String>,
    /// Corners of the problem's box.
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub levels: Vec<LevelEntry>,
}

/// One level.
#[derive(Debug)]
pub(super) struct LevelEntry {
    /// First and last cell of the level in the problem's box.
    pub domain: [[i64; 3]; 2],
    /// Number of its boxes.
    pub boxes: usize,
    /// Path of its list of boxes, without `_H`, as the file has it.
    pub path: String,
}

impl PlotHeader {
    /// Reads the text.
    ///
    /// # Errors
    /// Anything that is no header, ends early, or is not of three Cartesian dimensions.
    pub fn parse(text: &str) -> Result<Self, FieldError> {
        const WHOLE: &str = "must be a whole number";
        const REAL: &str = "must be a number";
        let mut words = Words::new(text);
        let version = words.line("version")?;
        if !VERSIONS.contains(&version) {
            return Err(FieldError::new("version", version, format!("must be one of {}", VERSIONS.join(", "))));
        }
        let count: usize = words.number("number of components", WHOLE)?;
        words.line("number of components")?;
        let mut names = Vec::new();
        for i in 0..count {
            names.push(shown(words.line(&format!("name of component {i}"))?));
        }
        let dimension: usize = words.number("dimension", WHOLE)?;
        if dimension != 3 {
            return Err(FieldError::new("dimension", dimension, "plotfiles of 3 dimensions are read"));
        }
        words.number::<f64>("time", REAL)?;
        let finest: usize = words.number("finest level", WHOLE)?;
        let (low, high) = (words.triple("prob_lo")?, words.triple("prob_hi")?);
        for level in 0..finest {
            // Those that count come from the boxes of the levels, which may tell more than one number.
            words.word(&format!("refinement ratio of level {level}"))?;
        }
        let mut domains = Vec::new();
        for level in 0..=finest {
            let what = format!("domain of level {level}");
            let (first, last) = box_of(&mut words, &what)?;
            domains.push([first, last]);
        }
        for level in 0..=finest {
            words.word(&format!("steps of level {level}"))?;
        }
        for level in 0..=finest {
            words.triple(&format!("cell size of level {level}"))?;
        }
        match words.number("coordinate system", WHOLE)? {
            0 => {}
            1u32 => return Err(FieldError::new("coordinate system", "1, cylindrical", "0, Cartesian, is read")),
            2 => return Err(FieldError::new("coordinate system", "2, spherical", "0, Cartesian, is read")),
            other => return Err(FieldError::new("coordinate system", other, "0, Cartesian, is read")),
        }
        words.word("width of the boundary")?;
        let mut levels = Vec::new();
        for (level, domain) in domains.into_iter().enumerate() {
            let what = |of: &str| format!("level {level}, {of}");
            let number: usize = words.number(&what("number"), WHOLE)?;
            if number != level {
                return Err(FieldError::new(what("number"), number, "levels must stand in their order"));
            }
            let boxes: usize = words.number(&what("number of boxes"), WHOLE)?;
            words.number::<f64>(&what("time"), REAL)?;
            words.word(&what("steps"))?;
            // Their corners are told in whole numbers elsewhere.
            for _ in 0..boxes {
                for _ in 0..6 {
                    words.word(&what("corners of a box"))?;
                }
            }
            levels.push(LevelEntry { domain, boxes, path: words.word(&what("path"))?.to_owned() });
        }
        Ok(Self { names, low, high, levels })
    }

    /// Edges of a cell of level 0.
    pub fn spacing(&self) -> DVec3 {
        (DVec3::from_array(self.high) - DVec3::from_array(self.low)) / self.levels[0].cells()
    }

    /// Ratios of the levels: of their numbers of cells in the problem's box.
    pub fn ratios(&self) -> Result<Vec<[u32; 3]>, FieldError> {
        let ratio = |(level, pair): (usize, &[LevelEntry])| {
            ratios_of(pair[1].cells(), pair[0].cells(), &format!("domain of level {}", level + 1))
        };
        self.levels.windows(2).enumerate().map(ratio).collect()
    }
}

impl LevelEntry {
    /// Cells along each axis of the problem's box.
    fn cells(&self) -> DVec3 {
        let [first, last] = self.domain;
        DVec3::from_array([0, 1, 2].map(|a| last[a] as f64 - first[a] as f64 + 1.0))
    }

    /// Index of a cell counted from the first one of the problem's box.
    pub fn in_domain(&self, index: [i64; 3]) -> Option<[i64; 3]> {
        let mut from = [0; 3];
        for a in 0..3 {
            from[a] = index[a].checked_sub(self.domain[0][a])?;
        }
        Some(from)
    }

    /// Holds the list of boxes against what the header says.
    pub fn check(&self, level: usize, found: &LevelHeader, components: usize) -> Result<(), FieldError> {
        if found.boxes.len() != self.boxes {
            let allowed = format!("the file Header says {} for level {level}", self.boxes);
            return Err(FieldError::new("number of boxes", found.boxes.len(), allowed));
        }
        if found.components != components {
            let allowed = format!("the file Header names {components}");
            return Err(FieldError::new("number of components", found.components, allowed));
        }
        Ok(())
    }
}

/// A box such as `((0,0,0) (7,7,7) (0,0,0))`: its first and its last cell.
///
/// # Errors
/// Anything else, and boxes of points, edges or faces.
pub(super) fn box_of(words: &mut Words<'_>, what: &str) -> Result<([i64; 3], [i64; 3]), FieldError> {
    let parts = [words.word(what)?, words.word(what)?, words.word(what)?];
    let text = parts.join(" ");
    let wrong = |allowed: &str| Err(FieldError::new(what, &text, allowed));
    match integers(&text).as_deref() {
        Some(&[a, b, c, d, e, f, 0, 0, 0]) if a <= d && b <= e && c <= f => Ok(([a, b, c], [d, e, f])),
        Some(&[_, _, _, _, _, _, 0, 0, 0]) => wrong("the last cell must not be before the first"),
        Some(&[_, _, _, _, _, _, _, _, _]) => wrong("must be a box of cells: of type (0,0,0)"),
        _ => wrong("must be a box of three dimensions such as ((0,0,0) (7,7,7) (0,0,0))"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "HyperCLaw-V1.1\n2\nY(H2 O)\ndensity\n3\n0.5\n1\n0 0 0\n2 2 1\n2\n((0,0,0) (1,1,0) (0,0,0)) ((0,0,0) (3,3,0) (0,0,0))\n\
                        20 20\n1 1 1\n0.5 0.5 1\n0\n0\n0 1 0.5\n20\n0 2\n0 2\n0 1\nLevel_0/Cell\n1 0 0.5\n20\nLevel_1/Cell\n";

    #[test]
    fn names_levels_and_ratios() {
        let header = PlotHeader::parse(TEXT).unwrap();
        assert_eq!(header.names, ["Y(H2 O)", "density"]);
        assert_eq!((header.spacing(), header.ratios().unwrap()), (DVec3::ONE, vec![[2, 2, 1]]));
        assert_eq!((header.levels[1].boxes, header.levels[0].path.as_str()), (0, "Level_0/Cell"));
        let error = |text: &str| PlotHeader::parse(text).unwrap_err().to_string();
        assert!(error(&TEXT.replace("\n3\n0.5", "\n2\n0.5")).contains("dimension: found 2; plotfiles of 3"));
        assert!(error(&TEXT.replace("(3,3,0) (0,0,0)", "(3,3,0) (1,1,1)")).contains("box of cells"));
        assert!(error(&TEXT[..TEXT.len() - 14]).contains("the end of the file"));
        assert!(error(&TEXT.replace("\n0\n0\n0 1", "\n2\n0\n0 1")).contains("spherical"));
        assert!(error(&TEXT.replace("\n2\nY", "\n18446744073709551615\nY")).contains("found"));
    }
}
