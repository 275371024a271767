//! The list of grids (`.hierarchy`), and their places on the lattices of their levels.

use glam::DVec3;

use crate::error::FieldError;

use super::super::amr_file::{BlockBox, Hierarchy};
use super::super::lattices::{index_of, spacing_of};
use super::parameters::Parameters;

/// A grid, as the list has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Grid {
    /// Number of the grid, from 1.
    pub id: u64,
    /// Cells with its ghost zones.
    pub whole: [usize; 3],
    /// First and last of its own cells among these.
    pub start: [usize; 3],
    pub end: [usize; 3],
    pub low: DVec3,
    pub high: DVec3,
    /// Name of the file with its numbers, without folders: these are of the machine that ran Enzo.
    pub file: String,
}

impl Grid {
    /// Its own cells along each axis.
    pub fn cells(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| self.end[a] - self.start[a] + 1)
    }
}

/// Reads the list: for each grid a line `Grid = number`, and lines `name = value` that follow it.
///
/// # Errors
/// A list without grids, and grids that are not of three dimensions, lack a line, or have cells or corners that make no sense.
pub(super) fn parse(text: &str) -> Result<Vec<Grid>, FieldError> {
    let mut grids = Vec::new();
    let mut lines: Vec<(&str, &str)> = Vec::new();
    let mut take = |lines: &mut Vec<(&str, &str)>| {
        if !lines.is_empty() {
            grids.push(grid(lines)?);
            lines.clear();
        }
        Ok(())
    };
    for (key, value) in text.lines().filter_map(|line| line.split_once('=')) {
        let key = key.trim();
        if key == "Grid" {
            take(&mut lines)?;
        }
        if key == "Grid" || !lines.is_empty() {
            lines.push((key, value.trim()));
        }
    }
    take(&mut lines)?;
    if grids.is_empty() { Err(FieldError::new("Grid", "none", "the hierarchy must list grids")) } else { Ok(grids) }
}

fn grid(lines: &[(&str, &str)]) -> Result<Grid, FieldError> {
    let of = |key: &str| lines.iter().find(|(k, _)| *k == key).map(|(_, value)| *value);
    let id = of("Grid").unwrap_or_default();
    let place = |key: &str| format!("grid {id}, {key}");
    let missing = |key: &str, allowed: &str| FieldError::new(place(key), of(key).unwrap_or_default(), allowed);
    fn three<T: std::str::FromStr>(text: Option<&str>) -> Option<[T; 3]> {
        crate::vtk::exactly(text?.split_ascii_whitespace())
    }
    if let Some(rank) = of("GridRank").filter(|rank| *rank != "3") {
        return Err(FieldError::new(place("GridRank"), rank, "meshes of 3 dimensions are read"));
    }
    let indices = |key: &str| three::<usize>(of(key)).ok_or_else(|| missing(key, "must be three whole numbers"));
    let corner = |key: &str| {
        let corner = three::<f64>(of(key)).filter(|x| x.iter().all(|x| x.is_finite()));
        corner.map(DVec3::from_array).ok_or_else(|| missing(key, "must be three numbers"))
    };
    // Grids without gas name the file of their particles alone, which is the same.
    let file = of("BaryonFileName").or_else(|| of("ParticleFileName")).unwrap_or_default();
    let file = file.rsplit(['/', '\\']).next().unwrap_or_default();
    if file.is_empty() || file == ".." || file == "." {
        return Err(missing("BaryonFileName", "must name the file of its numbers"));
    }
    let found = Grid {
        id: id.parse().map_err(|_| FieldError::new("Grid", id, "must be a whole number"))?,
        whole: indices("GridDimension")?,
        start: indices("GridStartIndex")?,
        end: indices("GridEndIndex")?,
        low: corner("GridLeftEdge")?,
        high: corner("GridRightEdge")?,
        file: file.to_owned(),
    };
    for a in 0..3 {
        if !(found.start[a] <= found.end[a] && found.end[a] < found.whole[a]) {
            return Err(missing("GridEndIndex", "must be from GridStartIndex on, and below GridDimension"));
        }
    }
    if found.low.cmpge(found.high).any() {
        return Err(missing("GridRightEdge", "must be above GridLeftEdge, along every axis"));
    }
    Ok(found)
}

/// Places the grids: the edges of their cells tell their level, their corners the place on it.
///
/// # Errors
/// Grids whose cells are of no level, or lie beside its lattice; levels without a grid.
pub(super) fn hierarchy(parameters: &Parameters, grids: &[Grid]) -> Result<Hierarchy, FieldError> {
    /// Deeper ones cannot be told apart in 64-bit floats.
    const MAX_LEVELS: usize = 60;
    let Parameters { low, refine_by, .. } = *parameters;
    let spacing = parameters.spacing();
    let ratio = [refine_by; 3];
    let all = [ratio; MAX_LEVELS];
    let mut boxes = Vec::new();
    for grid in grids {
        let cells = grid.cells();
        let edge = (grid.high - grid.low) / DVec3::from_array(cells.map(|n| n as f64));
        let is_level = |&level: &usize| {
            let expected = spacing_of(spacing, &all, level);
            ((edge - expected) / expected).abs().cmplt(DVec3::splat(1e-3)).all()
        };
        let level = (0..=MAX_LEVELS).find(is_level).ok_or_else(|| {
            let allowed = format!("must be those of the root grid over a power of {refine_by}");
            FieldError::new(
                format!("grid {}, edges of a cell", grid.id),
                format!("{} {} {}", edge.x, edge.y, edge.z),
                allowed,
            )
        })?;
        let place = format!("grid {}, GridLeftEdge", grid.id);
        let first = index_of(grid.low, low, spacing_of(spacing, &all, level), &place)?;
        boxes.push(BlockBox { level, first, cells });
    }
    let finest = boxes.iter().map(|b| b.level).max().unwrap_or(0);
    Ok(Hierarchy { origin: low, spacing, ratios: vec![ratio; finest], boxes, placed_by: "GridLeftEdge" })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOT: &str = "\nGrid = 1\nGridRank = 3\nGridDimension = 10 10 10\nGridStartIndex = 3 3 3\nGridEndIndex = 6 6 6\nGridLeftEdge = 0 0 0\n\
                        GridRightEdge = 1 1 1\nBaryonFileName = /far/away/run.cpu0000\nPointer: Grid[1]->NextGridThisLevel = 0\n";

    fn fine() -> String {
        let fine = ROOT.replace("Grid = 1\n", "Grid = 2\n").replace("Edge = 0 0 0", "Edge = 0.25 0.25 0.25");
        fine.replace("RightEdge = 1 1 1", "RightEdge = 0.5 0.5 0.5")
    }

    fn place(text: &str) -> Result<Hierarchy, String> {
        let root = "TopGridDimensions = 4 4 4\nRefineBy = 2\n";
        let grids = parse(text).map_err(|e| e.to_string())?;
        hierarchy(&Parameters::parse(root).unwrap(), &grids).map_err(|e| e.to_string())
    }

    #[test]
    fn grids_find_their_levels() {
        let text = format!("{ROOT}{}", fine());
        assert_eq!(parse(&text).unwrap()[1].file, "run.cpu0000");
        let found = place(&text).unwrap();
        // Cells of 1/16 are those of level 2.
        assert_eq!(found.boxes[1], BlockBox { level: 2, first: [4; 3], cells: [4; 3] });
        assert_eq!((found.ratios.len(), found.spacing), (2, DVec3::splat(0.25)));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |from: &str, to: &str| place(&ROOT.replace(from, to)).unwrap_err();
        assert!(error("GridRank = 3", "GridRank = 2").contains("grid 1, GridRank: found 2"));
        assert!(error("= 6 6 6", "= 6 2 6").contains("GridEndIndex: found 6 2 6"));
        assert!(error("= 6 6 6", "= 6 10 6").contains("GridEndIndex"));
        assert!(error("= 1 1 1", "= 1 0 1").contains("GridRightEdge"));
        assert!(error("= 1 1 1", "= 1 1 0.9").contains("power of 2"));
        assert!(error("Grid = 1", "Grid = x").contains("Grid: found x"));
        assert!(error("/far/away/run.cpu0000", "/far/..").contains("BaryonFileName"));
        assert!(error("Grid", "Net").contains("must list grids"));
        let shifted = ROOT.replace("= 0 0 0", "= 0.1 0 0").replace("= 1 1 1", "= 1.1 1 1");
        assert!(place(&shifted).unwrap_err().contains("GridLeftEdge"));
    }
}
