//! Colours of voxels at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::{ColorGrid, Filter};

use super::Lanes;
use super::field::{Cells, Field, Stage, cells, inside};

/// Colours of voxels, as packets of sixteen read them: see [`ColorGrid::color`].
#[derive(Clone, Copy, Debug)]
pub struct VoxelColors<'a> {
    channels: [Field<'a, u16>; 3],
    dims: [usize; 3],
    is_nearest: bool,
}

impl<'a> VoxelColors<'a> {
    /// Colours of a grid.
    pub fn new(colors: &'a ColorGrid) -> Self {
        Self {
            channels: colors.channels().each_ref().map(Field::new),
            dims: colors.values().dims(),
            is_nearest: colors.color_filter() == Filter::Nearest,
        }
    }

    /// Linear light of red, green and blue at places in index space, or at the nearest ones that are in the box.
    ///
    /// Its own function: most samples have no colour of their own.
    #[inline(never)]
    pub fn at<S: Simd>(&self, simd: S, place: &[Lanes; 3]) -> [Lanes; 3] {
        let mut light = [Lanes::ZERO; 3];
        simd.vectorize(
            #[inline(always)]
            || {
                let mut position = [f32x16::splat(simd, 0.0); 3];
                for a in 0..3 {
                    position[a] = inside(simd, place[a].load(simd), (self.dims[a] - 1) as f32);
                }
                let at = cells(simd, position, self.dims.map(|n| n as i32 - 2));
                light = self.in_cells(simd, &at, &mut Stage::default()).map(Lanes::new);
            },
        );
        light
    }

    /// The same at places whose cells are known; `stage` holds nothing between calls.
    #[inline(always)]
    pub fn in_cells<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<u16>) -> [f32x16<S>; 3] {
        let mut light = [f32x16::splat(simd, 0.0); 3];
        for c in 0..3 {
            let channel = &self.channels[c];
            let stored = if self.is_nearest {
                f32x16::load_array(simd, channel.nearest(simd, at))
            } else {
                channel.fetch(simd, at, stage);
                channel.value(simd, at, stage)
            };
            light[c] = stored * (1.0 / f32::from(ColorGrid::WHITE));
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use vr_core::Placement;

    #[test]
    fn colours_are_those_of_the_grid() {
        let dims = [5, 4, 7];
        let components: Vec<u8> = (0..3 * 5 * 4 * 7).map(|i| (i * 7919 % 251) as u8).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let linear = ColorGrid::from_components(dims, &components, 3, placement).unwrap();
        for grid in [linear.with_filter(Filter::Nearest), linear] {
            let colors = VoxelColors::new(&grid);
            // Some of them beyond the box, where the nearest place in it counts.
            let at = |i: usize, a: usize| (i * 31 + a * 17) as f32 % 8.3 - 0.6;
            let place = std::array::from_fn(|a| Lanes(std::array::from_fn(|i| at(i, a))));
            let found = dispatch!(Level::new(), simd => colors.at(simd, &place));
            for i in 0..16 {
                let inside = std::array::from_fn(|a| f64::from(at(i, a)).clamp(0.0, (dims[a] - 1) as f64));
                let want = grid.color(inside);
                for c in 0..3 {
                    assert!((f64::from(found[c].0[i]) - want[c]).abs() < 1e-6, "{i} {c}");
                }
            }
        }
    }
}
