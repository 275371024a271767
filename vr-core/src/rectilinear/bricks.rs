//! Bricks of cells, with the ranges of the field in them.

use super::axis::Axis;
use super::segment::Segment;
use crate::cancel;
use crate::filter::Lattice;
use crate::grid::Calibration;
use crate::grid_volume::GridVolume;
use crate::parallel::collect;
use crate::with_grid;

/// Cells of a rectilinear grid in bricks of 8³, each with the range of the field in it; and the segments of its axes.
#[derive(Clone, Debug)]
pub struct Bricks {
    axes: [AxisCuts; 3],
    /// Bricks along x, y and z.
    counts: [usize; 3],
    bricks: Vec<Brick>,
}

/// Cuts of an axis into segments and bricks: pieces, each of one of both.
#[derive(Clone, Debug)]
pub(super) struct AxisCuts {
    pub(super) segments: Vec<Segment>,
    /// Planes between pieces, and those at both ends.
    pub(super) planes: Vec<f64>,
    /// Number of the segment and of the brick of each piece.
    pub(super) pieces: Vec<[u32; 2]>,
    /// Number of the piece of each cell.
    pub(super) of_cells: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Brick {
    /// Smallest and largest stored number; the wrong way round if there is none.
    stored: [f32; 2],
    has_vacuum: bool,
}

impl AxisCuts {
    /// Largest number of bytes of the cuts of so many cells, each cell a segment and a piece of its own at worst: with them, its width and the length of
    /// its run for as long as cuts are looked for.
    fn max_bytes(cells: usize) -> u64 {
        let each =
            size_of::<Segment>() + 2 * size_of::<f64>() + size_of::<[u32; 2]>() + size_of::<u32>() + size_of::<usize>();
        // Lists that grow have room for twice as many for a moment.
        2 * cells as u64 * each as u64
    }

    fn new(axis: &Axis) -> Self {
        let cells = axis.places().len() - 1;
        cancel::claim("the cuts of an axis of the rectilinear grid", Self::max_bytes(cells));
        let segments = Segment::cut(axis.places());
        let (mut planes, mut pieces, mut of_cells) = (vec![axis.places()[0]], Vec::<[u32; 2]>::new(), Vec::new());
        for (number, segment) in segments.iter().enumerate() {
            for cell in segment.first..segment.end {
                let piece = [number as u32, (cell / Bricks::EDGE) as u32];
                if pieces.last() == Some(&piece) {
                    planes.pop();
                } else {
                    pieces.push(piece);
                }
                planes.push(axis.places()[cell + 1]);
                of_cells.push(pieces.len() as u32 - 1);
            }
        }
        Self { segments, planes, pieces, of_cells }
    }
}

impl Bricks {
    /// Cells along the edge of a brick.
    pub const EDGE: usize = 8;

    pub(super) fn new(axes: &[Axis; 3], lattice: &GridVolume) -> Self {
        let counts = lattice.dims().map(|n| (n - 1).div_ceil(Self::EDGE));
        cancel::claim(
            "the bricks of the rectilinear grid",
            (counts.iter().product::<usize>() * size_of::<Brick>()) as u64,
        );
        let bricks = with_grid!(lattice.values(), grid => {
            let lattice = Lattice { samples: grid.samples(), dims: grid.dims() };
            collect(counts.iter().product(), |brick| {
                let at = [brick % counts[0], brick / counts[0] % counts[1], brick / (counts[0] * counts[1])];
                let mut found = Brick { stored: [f32::INFINITY, f32::NEG_INFINITY], has_vacuum: false };
                // All samples at corners of its cells.
                let [xs, ys, zs]: [_; 3] = std::array::from_fn(|a| {
                    at[a] * Self::EDGE..((at[a] + 1) * Self::EDGE + 1).min(lattice.dims[a])
                });
                for z in zs {
                    for y in ys.clone() {
                        for x in xs.clone() {
                            let value: f32 = lattice.at(x, y, z);
                            found.has_vacuum |= value.is_nan();
                            // What is not a number is neither.
                            found.stored = [found.stored[0].min(value), found.stored[1].max(value)];
                        }
                    }
                }
                found
            })
        });
        Self { axes: axes.each_ref().map(AxisCuts::new), counts, bricks }
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.bricks.len()
    }

    /// True if there are none: never.
    pub fn is_empty(&self) -> bool {
        self.bricks.is_empty()
    }

    /// Segments of an axis, ascending.
    pub fn segments(&self, axis: usize) -> &[Segment] {
        &self.axes[axis].segments
    }

    /// Smallest and largest number stored in a brick; `None` if all of it is vacuum.
    pub fn stored_range(&self, brick: usize) -> Option<[f32; 2]> {
        let [low, high] = self.bricks[brick].stored;
        (low <= high).then_some([low, high])
    }

    /// Two values that enclose those of the field in a brick; `None` if all of it is vacuum.
    pub fn range(&self, brick: usize, calibration: Calibration) -> Option<[f32; 2]> {
        let range = self.stored_range(brick)?.map(|stored| calibration.value(f64::from(stored)));
        let (low, high) = (range[0].min(range[1]), range[0].max(range[1]));
        let (below, above) = (low as f32, high as f32);
        Some([
            if f64::from(below) > low { below.next_down() } else { below },
            if f64::from(above) < high { above.next_up() } else { above },
        ])
    }

    /// True if a part of a brick is vacuum.
    pub(super) fn has_vacuum(&self, brick: usize) -> bool {
        self.bricks[brick].has_vacuum
    }

    /// Cuts of the axes.
    pub(super) fn cuts(&self) -> &[AxisCuts; 3] {
        &self.axes
    }

    /// Number of the brick at a place among the bricks.
    pub(super) fn number(&self, at: [usize; 3]) -> usize {
        (at[2] * self.counts[1] + at[1]) * self.counts[0] + at[0]
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::{Centering, RectilinearGrid};
    use super::*;

    #[test]
    fn pieces_end_with_segments_and_with_bricks() {
        let mut places: Vec<f64> = (0..=12).map(f64::from).collect();
        places.extend((1..=20).map(|k| 12.0 + 0.1 * f64::from(k)));
        let cuts = AxisCuts::new(&Axis::new(places, 0).unwrap());
        assert_eq!(cuts.pieces, [[0, 0], [0, 1], [1, 1], [1, 2], [1, 3]]);
        assert_eq!(cuts.planes, [0.0, 8.0, 12.0, 12.4, 13.2, 14.0]);
        assert_eq!((cuts.of_cells.len(), cuts.of_cells[11], cuts.of_cells[12]), (32, 1, 2));
    }

    #[test]
    fn ranges_are_those_of_all_corners() {
        let axes = [(0..10).map(f64::from).collect::<Vec<_>>(), vec![0.0, 1.0], vec![0.0, 3.0]];
        let mut values: Vec<f32> = (0..40u8).map(f32::from).collect();
        values[19] = f32::NAN;
        let grid = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
        let (bricks, calibration) = (grid.bricks(), grid.lattice().calibration());
        assert_eq!(bricks.len(), 2);
        assert_eq!(bricks.range(0, calibration), Some([0.0, 38.0]));
        assert_eq!(bricks.range(1, calibration), Some([8.0, 39.0]));
        assert!(!bricks.has_vacuum(0) && bricks.has_vacuum(1));
    }
}
