//! Colours of the places along cells, with a bound of what they are off by.

use vr_core::ColorGrid;
use vr_core::filter::{Filter, Lattice, Nearest, Reconstruction};

use super::crossed::Crossed;
use super::cubic::Cubic;
use super::polynomials::CubicVector;
use super::series::Series;

/// Colours of the places along a cell, by which those of the transfer function are multiplied: linear light between 0 and 1.
#[derive(Clone, Copy, Debug)]
pub(super) enum Tint {
    /// White: places have no colours of their own.
    White,
    /// Red, green and blue along the cell.
    Along(CubicVector),
    /// Any colours.
    Unknown,
}

impl Tint {
    /// Returns the channels on the part [from, to] of a cell, 0 to 1; `None` where all are white.
    pub(super) fn on(&self, part: [f64; 2]) -> Option<[Series; 3]> {
        match self {
            Self::White => None,
            Self::Along(CubicVector { powers, off }) => Some(powers.map(|p| Series::part_of(&p, part, *off))),
            Self::Unknown => Some([Series::between(0.0, 1.0); 3]),
        }
    }

    /// Returns the colour at a fraction of a cell, and a bound of what its channels are off by.
    pub(super) fn at(&self, t: f64) -> ([f64; 3], f64) {
        self.on([t; 2]).map_or(([1.0; 3], 0.0), |channels| known(&channels))
    }

    /// Returns the mean colour of a cell, and a bound of what its channels are off by.
    pub(super) fn mean(&self) -> ([f64; 3], f64) {
        match self {
            Self::Along(CubicVector { powers, off }) => {
                (powers.map(|[a, b, c, d]| a + b / 2.0 + c / 3.0 + d / 4.0), off + 8.0 * f64::EPSILON)
            }
            _ => self.at(0.5),
        }
    }

    /// True if the colour changes by no more than it is off by on the part [from, to] of a cell: shorter parts would tell no more of it.
    pub(super) fn is_blurred(&self, part: [f64; 2]) -> bool {
        let Self::Along(CubicVector { powers, off }) = self else { return true };
        powers.iter().all(|p| Series::part_of(p, part, 0.0).spread() <= 4.0 * off)
    }
}

/// Returns the colour in the middle of a part, and the largest distance of a channel from it.
fn known(channels: &[Series; 3]) -> ([f64; 3], f64) {
    (channels.map(|channel| channel.c[0]), channels.iter().map(Series::spread).fold(0.0, f64::max))
}

/// Colours of the voxels of a grid.
#[derive(Clone, Copy)]
pub(super) struct VoxelColors<'a> {
    channels: [Lattice<'a, u16>; 3],
    filter: Filter,
}

/// Largest error of a colour by rounding: of the share of full light, three linear interpolations and the cubic's powers, of numbers up to 1.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl<'a> VoxelColors<'a> {
    pub(super) fn new(colors: &'a ColorGrid) -> Self {
        Self { channels: colors.channels(), filter: colors.color_filter() }
    }

    /// Returns the colours along a part of a cell that a ray crosses.
    pub(super) fn along(&self, crossed: &Crossed) -> Tint {
        if self.filter == Filter::Nearest {
            // On the part between two faces half-way between voxels, that in the middle has the colour of all.
            let middle =
                std::array::from_fn(|a| crossed.cell[a] as f64 + 0.5 * (crossed.part[a][0] + crossed.part[a][1]));
            let powers =
                self.channels.map(|channel| [Nearest::value::<_, f64>(&channel, middle) * SHARE, 0.0, 0.0, 0.0]);
            return Tint::Along(CubicVector { powers, off: 0.0 });
        }
        let powers = self.channels.map(|channel| {
            let corner = |i: usize| {
                let [x, y, z] = std::array::from_fn(|a| crossed.cell[a] + (i >> a & 1));
                channel.at::<f64>(x, y, z) * SHARE
            };
            Cubic::across_box(std::array::from_fn(corner), &crossed.part).powers()
        });
        // A colour changes by 1 along a cell's edge at most.
        Tint::Along(CubicVector { powers, off: ROUNDING + 3.0 * crossed.misplaced })
    }
}

/// Light of one stored unit.
const SHARE: f64 = 1.0 / ColorGrid::WHITE as f64;

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::{Calibration, GridVolume, IndexRay, Placement, UniformGrid};

    use super::*;

    /// Along a cell, colours are those of the grid, in parts and in the mean.
    #[test]
    fn colours_are_those_of_the_grid() {
        let grid =
            UniformGrid::new([3; 3], vec![0u8; 27], Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
        let values = GridVolume::new(grid.unwrap().into(), Filter::Trilinear);
        let channels = [7919, 104_729, 1_299_709].map(|p| (0..27u32).map(|i| (i * p % 65_521) as u16).collect());
        let trilinear = ColorGrid::new(values, channels).unwrap();
        let ray = IndexRay {
            origin: DVec3::new(1.1, 0.2, 0.9),
            direction: DVec3::new(0.3, 0.2, -0.4),
            start: 0.0,
            end: 1.0,
            offset: 0.0,
        };
        for colors in [trilinear.with_filter(Filter::Nearest), trilinear] {
            // Half-way between voxels along no axis.
            let ends = [0.1, 0.9];
            let crossed = Crossed::new(&ray, [1, 0, 0], ends, 1e-15);
            let tint = VoxelColors::new(&colors).along(&crossed);
            let at = |t: f64| colors.color::<f64>(ray.at(ends[0] + t * (ends[1] - ends[0])).to_array());
            let count = 2000;
            let mut sums = [0.0; 3];
            for i in 0..count {
                let t = (f64::from(i) + 0.5) / f64::from(count);
                let (found, off) = tint.at(t);
                for c in 0..3 {
                    assert!((found[c] - at(t)[c]).abs() <= off + 1e-15, "{:?}, {t}", colors.color_filter());
                    sums[c] += at(t)[c] / f64::from(count);
                }
            }
            let (mean, off) = tint.mean();
            // Midpoints of a cubic are off by a 24th of its bend and the square of their distance.
            assert!((0..3).all(|c| (mean[c] - sums[c]).abs() <= off + 1e-7), "{mean:?} {sums:?}");
            assert_eq!(tint.is_blurred([0.0, 1.0]), colors.color_filter() == Filter::Nearest);
        }
    }
}
