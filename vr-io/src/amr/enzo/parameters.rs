//! The parameters of a run that its grids need: the root grid, the box, the ratio of levels, the names of fields.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::error::{FieldError, shown};

/// Parameters that the grids need.
#[derive(Debug)]
pub(super) struct Parameters {
    /// Corners of the root grid.
    pub low: DVec3,
    pub high: DVec3,
    /// Cells of the root grid.
    pub dims: [f64; 3],
    /// Ratio of each level to the one before.
    pub refine_by: u32,
    /// Names of the fields.
    pub labels: Vec<String>,
}

impl Parameters {
    /// Reads lines `name = value`.
    ///
    /// # Errors
    /// A parameter that is missing or makes no sense, and grids that are not of three dimensions.
    pub fn parse(text: &str) -> Result<Self, FieldError> {
        let (mut values, mut labels) = (BTreeMap::new(), Vec::new());
        for (key, value) in text.lines().filter_map(|line| line.split_once('=')) {
            let (key, value) = (key.trim(), value.trim());
            if key.starts_with("DataLabel[") {
                labels.push(shown(value));
            }
            values.entry(key).or_insert(value);
        }
        let wrong = |key: &str, allowed: &str| {
            FieldError::new(key, values.get(key).copied().unwrap_or_default(), allowed.to_owned())
        };
        let numbers = |key: &str, absent: Option<[f64; 3]>| {
            let Some(text) = values.get(key) else {
                return absent.ok_or_else(|| wrong(key, "must be three numbers"));
            };
            let parsed: Option<Vec<f64>> =
                text.split_ascii_whitespace().take(3).map(|word| word.parse().ok()).collect();
            let three: Option<[f64; 3]> = parsed.and_then(|list| list.try_into().ok());
            three.filter(|n| n.iter().all(|x| x.is_finite())).ok_or_else(|| wrong(key, "must be three numbers"))
        };
        if let Some(rank) = values.get("TopGridRank").filter(|rank| **rank != "3") {
            return Err(FieldError::new("TopGridRank", rank, "meshes of 3 dimensions are read"));
        }
        let dims = numbers("TopGridDimensions", None)?;
        if !dims.iter().all(|n| (1.0..1e15).contains(n) && n.fract() == 0.0) {
            return Err(wrong("TopGridDimensions", "must be three whole numbers above 0"));
        }
        let (low, high) = (numbers("DomainLeftEdge", Some([0.0; 3]))?, numbers("DomainRightEdge", Some([1.0; 3]))?);
        if (0..3).any(|a| low[a] >= high[a]) {
            return Err(wrong("DomainRightEdge", "must be above DomainLeftEdge, along every axis"));
        }
        let refine_by = values.get("RefineBy").and_then(|text| text.parse().ok()).filter(|&n: &u32| n > 1);
        let refine_by = refine_by.ok_or_else(|| wrong("RefineBy", "must be a whole number above 1"))?;
        Ok(Self { low: low.into(), high: high.into(), dims, refine_by, labels })
    }

    /// Edges of a cell of the root grid.
    pub fn spacing(&self) -> DVec3 {
        (self.high - self.low) / DVec3::from_array(self.dims)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "TopGridRank = 3\nTopGridDimensions   = 16 8 8\nRefineBy = 2\nDomainRightEdge = 2 1 1\nDataLabel[0] = Density\n\
                        # Time = 1\nDataLabel[1]  = x-velocity\n";

    #[test]
    fn what_is_needed_is_found() {
        let found = Parameters::parse(TEXT).unwrap();
        assert_eq!((found.spacing(), found.refine_by), (DVec3::splat(0.125), 2));
        assert_eq!(found.labels, ["Density", "x-velocity"]);
        let error = |from: &str, to: &str| Parameters::parse(&TEXT.replace(from, to)).unwrap_err().to_string();
        assert!(error("Rank = 3", "Rank = 2").contains("TopGridRank: found 2; meshes of 3"));
        assert!(error("16 8 8", "16 8").contains("three numbers"));
        assert!(error("16 8 8", "16 0 8").contains("whole numbers above 0"));
        assert!(error("RefineBy = 2", "RefineBy = 1").contains("RefineBy: found 1"));
        assert!(error("2 1 1", "2 0 1").contains("DomainRightEdge"));
    }
}
