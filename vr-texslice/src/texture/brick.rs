//! A texture of a brick's own texels, as fragments of the whole volume see it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_core::GradientMethod;
use vr_core::filter::Lattice;
use vr_kernels::vector::{Cells, Field, Lanes, Stage, cells, inside, pick, splat};

use super::Texture;
use super::blocks::differences;
use super::interpolant::slopes;
use super::sliced::on_slices;
use crate::compression::gradient_of_texels;

/// Cells of a brick in its volume, and where its texels begin; along the axes of the texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrickPart {
    /// Texels of the volume along each axis.
    dims: [usize; 3],
    /// First cell and last.
    cells: [[i32; 2]; 3],
    /// Index of its first texel in the volume.
    first: [i32; 3],
    /// Slices to a layer along the last axis, to the nearest of which samples are moved.
    per_layer: Option<f32>,
}

/// Part of a cell by which rounding may put a sample before the one ahead of it.
const SLACK: f32 = 1e-3;

impl BrickPart {
    /// The part of a volume of these dimensions between the first of the cells and the one behind the last, with texels from an index on. `per_layer`: slices to a
    /// layer along the last axis, if samples are moved to the nearest.
    pub(crate) fn new(dims: [usize; 3], cells: &[[usize; 2]; 3], first: [usize; 3], per_layer: Option<u32>) -> Self {
        Self {
            per_layer: per_layer.map(|n| n as f32),
            dims,
            cells: cells.map(|[first, behind]| [first as i32, behind as i32 - 1]),
            first: first.map(|n| n as i32),
        }
    }

    /// True for positions in the brick's cells, or as far before them along a stack as samples are moved: the middle of a segment lies there whose end was moved to
    /// the brick's first layer.
    #[inline(always)]
    pub(crate) fn holds<S: Simd>(&self, simd: S, position: [f32x16<S>; 3]) -> mask32x16<S> {
        let still = splat(simd, 0.0);
        let [x, y, z] = position;
        let along = match self.per_layer {
            None => self.holds_along(simd, 2, z, still),
            Some(per_layer) => {
                self.holds_along(simd, 2, z, still) | self.holds_along(simd, 2, z + 0.5 / per_layer, still)
            }
        };
        self.holds_along(simd, 0, x, still) & self.holds_along(simd, 1, y, still) & along
    }

    /// True for samples, by their positions, in the brick's cells, and just before them on rays that go on by so much from sample to sample: in the bricks before, there is
    /// nothing of such a ray any more but what rounding has put back.
    #[inline(always)]
    pub(crate) fn holds_ahead<S: Simd>(
        &self,
        simd: S,
        [x, y, z]: [f32x16<S>; 3],
        heading: [f32x16<S>; 3],
    ) -> mask32x16<S> {
        let across = self.holds_along(simd, 0, x, heading[0]) & self.holds_along(simd, 1, y, heading[1]);
        let (zero, slack) = (splat(simd, 0.0), splat(simd, SLACK));
        let ahead = pick(heading[2].simd_gt(zero), slack, pick(heading[2].simd_lt(zero), -slack, zero));
        let along = match self.per_layer {
            None => self.holds_along(simd, 2, z, heading[2]),
            // Rounding may move a sample to one slice or the next.
            Some(_) => {
                self.holds_along(simd, 2, self.moved(simd, z), zero)
                    | self.holds_along(simd, 2, self.moved(simd, z + ahead), zero)
            }
        };
        across & along
    }

    /// Positions along the last axis, moved as samples are.
    #[inline(always)]
    fn moved<S: Simd>(&self, simd: S, at: f32x16<S>) -> f32x16<S> {
        let max = (self.dims[2] - 1) as f32;
        self.per_layer.map_or(at, |per_layer| on_slices(simd, inside(simd, at, max), per_layer, max))
    }

    #[inline(always)]
    fn holds_along<S: Simd>(&self, simd: S, axis: usize, at: f32x16<S>, heading: f32x16<S>) -> mask32x16<S> {
        let (zero, slack) = (splat(simd, 0.0), splat(simd, SLACK));
        let [first, last] = self.cells[axis];
        let at = inside(simd, at, (self.dims[axis] - 1) as f32);
        // What lies on the volume's upper face lies in its last cells.
        let behind = if last as usize + 2 == self.dims[axis] { f32::INFINITY } else { (last + 1) as f32 };
        let low = splat(simd, first as f32) - pick(heading.simd_gt(zero), slack, zero);
        let high = splat(simd, behind) + pick(heading.simd_lt(zero), slack, zero);
        at.simd_ge(low) & at.simd_lt(high)
    }

    /// Places among the brick's texels; of positions elsewhere, that on its faces which is nearest, or on that of so many layers before.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, position: [f32x16<S>; 3], layers_before: i32) -> Cells<S> {
        let mut at = position;
        for a in 0..3 {
            let [first, last] = self.cells[a];
            let first = if a == 2 { (first - layers_before).max(0) } else { first };
            at[a] = at[a].max(splat(simd, first as f32)).min(splat(simd, (last + 1) as f32));
        }
        let mut at = cells(simd, at, self.cells.map(|[_, last]| last));
        for a in 0..3 {
            at.cell[a] -= i32x16::splat(simd, self.first[a]);
        }
        at
    }
}

/// A brick's texture: positions are the volume's. Cells and the fractions in them are found as in the volume, so what is fetched and interpolated has the same bits.
pub(crate) struct InBrick<X> {
    pub(crate) texture: X,
    pub(crate) part: BrickPart,
}

impl<X: Texture> Texture for InBrick<X> {
    type Stage = X::Stage;
    const LIGHT: bool = X::LIGHT;

    fn dims(&self) -> [usize; 3] {
        self.part.dims
    }

    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        self.part.place(simd, [x, y, self.part.moved(simd, z)], 0)
    }

    #[inline(always)]
    fn place_between<S: Simd>(&self, simd: S, position: [f32x16<S>; 3]) -> Cells<S> {
        self.part.place(simd, position, i32::from(self.part.per_layer.is_some()))
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Self::Stage) {
        self.texture.fetch(simd, at, stage);
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Self::Stage) -> [f32x16<S>; 4] {
        self.texture.read(simd, at, stage)
    }

    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, wanted: u32, stage: &mut Self::Stage) -> [Lanes; 3] {
        self.texture.gradient(simd, at, wanted, stage)
    }
}

/// Values of a brick decoded from compressed blocks, with the gradients of the blocks themselves.
pub(crate) struct Decoded<'a> {
    field: Field<'a, f32>,
    /// Values that central differences are taken from.
    filled: Lattice<'a, f32>,
    method: GradientMethod,
    /// Index of the first of them in the volume, and the volume's own dimensions.
    first: [usize; 3],
    whole: [usize; 3],
}

impl<'a> Decoded<'a> {
    /// Values, and what gradients are taken from: both begin at an index of a volume of these dimensions.
    pub(crate) fn new(
        values: &Lattice<'a, f32>,
        (filled, method): (Lattice<'a, f32>, GradientMethod),
        first: [usize; 3],
        whole: [usize; 3],
    ) -> Self {
        Self { field: Field::new(values), filled, method, first, whole }
    }
}

impl Texture for Decoded<'_> {
    type Stage = Stage<f32>;
    const LIGHT: bool = false;

    fn dims(&self) -> [usize; 3] {
        self.filled.dims
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<f32>) {
        self.field.fetch(simd, at, stage);
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<f32>) -> [f32x16<S>; 4] {
        [self.field.value(simd, at, stage); 4]
    }

    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, wanted: u32, stage: &mut Stage<f32>) -> [Lanes; 3] {
        if self.method == GradientMethod::Analytic {
            self.field.fetch(simd, at, stage);
            return slopes(simd, at, |axis| self.field.faces(simd, axis, stage));
        }
        // A position rounded up to the next cell does not count what lies beyond the brick's texels, but asks for it.
        let texel = |index: [usize; 3]| {
            let [x, y, z] = std::array::from_fn(|a| (index[a] - self.first[a]).min(self.filled.dims[a] - 1));
            self.filled.at(x, y, z)
        };
        // In the volume's own positions: rounding is the same then.
        differences(at, wanted, self.first, |at| gradient_of_texels(self.whole, at, texel))
    }
}
