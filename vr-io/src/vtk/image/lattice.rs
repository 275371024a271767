//! The lattice of an image: indices from a first to a last one along each axis, and the way from an index to the world.

use glam::{DMat3, DVec3};
use vr_core::{GridError, Placement};

use crate::error::FieldError;
use crate::notes::{Assumption, Notes};

/// First and last index of the points along each axis; the last one is not below the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent([[i64; 2]; 3]);

impl Extent {
    /// Takes six numbers, as files have them; `None` for an extent without points.
    ///
    /// # Errors
    /// Numbers too far apart to count the points between them.
    pub fn new(field: &str, numbers: [i64; 6]) -> Result<Option<Self>, FieldError> {
        let [a, b, c, d, e, f] = numbers;
        let axes = [[a, b], [c, d], [e, f]];
        if axes.iter().any(|[first, last]| last < first) {
            return Ok(None);
        }
        let countable = axes.iter().all(|[first, last]| last.checked_sub(*first).is_some_and(|n| n < i64::MAX / 4));
        if !countable || axes.iter().flatten().any(|i| i.abs() > i64::MAX / 4) {
            let found = numbers.map(|n| n.to_string()).join(" ");
            return Err(FieldError::new(field, found, "must be the first and last index of each axis"));
        }
        Ok(Some(Self(axes)))
    }

    /// Indices from 0 on; `None` where an axis has no points.
    pub fn of_dims(field: &str, dims: [usize; 3]) -> Result<Option<Self>, FieldError> {
        let [x, y, z] = dims.map(|n| i64::try_from(n).unwrap_or(i64::MAX) - 1);
        Self::new(field, [0, x, 0, y, 0, z])
    }

    /// Counts of the points along each axis, or of the cells between them; a flat axis has one layer of cells.
    pub fn dims(&self, of_cells: bool) -> [usize; 3] {
        self.0.map(|[first, last]| {
            let steps = usize::try_from(last - first).unwrap_or(usize::MAX / 2);
            if of_cells { steps.max(1) } else { steps + 1 }
        })
    }

    pub fn first(&self) -> [i64; 3] {
        self.0.map(|[first, _]| first)
    }

    /// The smallest extent that holds both.
    pub fn hull(&self, other: &Self) -> Self {
        let axis = |i: usize| [self.0[i][0].min(other.0[i][0]), self.0[i][1].max(other.0[i][1])];
        Self([0, 1, 2].map(axis))
    }
}

/// Points at equal distances.
pub(super) struct Lattice {
    pub extent: Extent,
    pub origin: DVec3,
    /// Distances of points; 1 where the file tells none.
    pub spacing: Option<DVec3>,
    /// Directions of the index axes, one in a column; the world's where the file tells none.
    pub direction: Option<DMat3>,
}

impl Lattice {
    /// Places the points, or the centres of the cells.
    pub fn placement(&self, of_cells: bool, notes: &mut Notes) -> Result<Placement, GridError> {
        if self.spacing.is_none() {
            notes.assume(Assumption::Spacing, "the file states no spacing: 1, 1, 1 is assumed");
        }
        let axes = self.direction.unwrap_or(DMat3::IDENTITY) * DMat3::from_diagonal(self.spacing.unwrap_or(DVec3::ONE));
        // Said of the axes before they move the origin.
        Placement::new(DVec3::ZERO, axes)?;
        let first = self.extent.first();
        let mut index = DVec3::from_array(first.map(|i| i as f64));
        if first != [0; 3] {
            let [x, y, z] = first;
            notes.push(format!("indices begin at {x}, {y}, {z}: the origin is moved to there"));
        }
        if of_cells {
            index += 0.5;
            notes.push("the numbers belong to cells: each is placed at the centre of its cell, and the origin is moved by half a cell".to_owned());
        }
        Placement::new(self.origin + axes * index, axes)
    }

    /// Source of the placement.
    pub fn placed_by(&self) -> &'static str {
        match (self.direction, self.spacing) {
            (Some(direction), _) if direction != DMat3::IDENTITY => "Direction",
            (_, Some(_)) => "Spacing",
            _ => "assumed",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(numbers: [i64; 6]) -> Extent {
        Extent::new("Extent", numbers).unwrap().unwrap()
    }

    #[test]
    fn points_and_cells_are_counted() {
        let e = extent([2, 5, -1, 1, 7, 7]);
        assert_eq!((e.dims(false), e.dims(true), e.first()), ([4, 3, 1], [3, 2, 1], [2, -1, 7]));
        assert_eq!(Extent::new("Extent", [0, -1, 0, 3, 0, 3]).unwrap(), None);
        assert_eq!(Extent::of_dims("DIMENSIONS", [4, 3, 0]).unwrap(), None);
        assert_eq!(Extent::of_dims("DIMENSIONS", [4, 3, 2]).unwrap(), Some(extent([0, 3, 0, 2, 0, 1])));
        assert!(Extent::new("Extent", [i64::MIN, i64::MAX, 0, 3, 0, 3]).is_err());
        assert!(Extent::new("Extent", [i64::MAX - 1, i64::MAX, 0, 3, 0, 3]).is_err());
        assert!(Extent::of_dims("DIMENSIONS", [usize::MAX, 3, 3]).is_err());
        assert_eq!(e.hull(&extent([0, 3, 0, 2, 0, 1])), extent([0, 5, -1, 2, 0, 7]));
    }

    /// The numbers are those of `vtkImageData::TransformIndexToPhysicalPoint` of VTK 9.7.
    #[test]
    fn an_index_lies_where_vtk_puts_it() {
        let rows = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let lattice = Lattice {
            extent: extent([2, 5, 1, 3, 0, 1]),
            origin: DVec3::new(5.0, 6.0, 7.0),
            spacing: Some(DVec3::new(1.0, 2.0, 3.0)),
            direction: Some(DMat3::from_cols_array(&rows).transpose()),
        };
        let mut notes = Notes::default();
        let placement = lattice.placement(false, &mut notes).unwrap();
        // Index 3, 1, 0 is the voxel 1, 0, 0.
        assert_eq!(placement.to_world(DVec3::X), DVec3::new(7.0, 3.0, 7.0));
        assert_eq!((lattice.placed_by(), notes.len()), ("Direction", 1));
        let cells = lattice.placement(true, &mut notes).unwrap();
        assert_eq!(cells.origin() - placement.origin(), DVec3::new(1.0, -0.5, 1.5));
    }
}
