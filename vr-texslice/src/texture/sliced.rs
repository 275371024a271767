//! A texture in the coordinates of slices: along their axis last, and of a stack on its layers alone.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::{Filter, GridVolume};
use vr_kernels::vector::{Cells, Lanes, inside, pick, splat};

use super::{Texture, TextureVisitor};
use crate::layout::Layout;

/// A texture as slices see it, whatever its texels are: coordinates are turned, and along a stack samples are moved to the nearest slice.
pub(crate) struct Sliced<X> {
    texture: X,
    /// From texture coordinates to the axes along which the texels lie.
    layout: Layout,
    /// True if voxels are missing: what lies on a layer of a stack is vacuum, then, if the cell on either side of it is.
    has_holes: bool,
    /// True if what is nearest is read, and nothing interpolated.
    nearest: bool,
}

/// Hands textures on to another visitor in the coordinates of slices.
pub(crate) struct InSlices<V> {
    pub(crate) visitor: V,
    pub(crate) layout: Layout,
    pub(crate) has_holes: bool,
    pub(crate) nearest: bool,
}

impl<V> InSlices<V> {
    /// For the texels of a volume that lie along its own axes.
    pub(crate) fn new(visitor: V, volume: &GridVolume, layout: Layout) -> Self {
        let nearest = volume.filter() == Filter::Nearest;
        Self { visitor, layout, has_holes: volume.vacuum_cells().is_some(), nearest }
    }

    /// The same for texels that lie along texture coordinates already.
    pub(crate) fn of_turned_texels(self) -> Self {
        Self { layout: self.layout.of_turned_texels(), ..self }
    }
}

impl<V: TextureVisitor> TextureVisitor for InSlices<V> {
    type Output = V::Output;

    fn visit<X: Texture>(self, texture: X) -> V::Output {
        let Self { visitor, layout, has_holes, nearest } = self;
        // Anywhere else than on layers, cells meet where no sample lies but by rounding.
        visitor.visit(Sliced { texture, layout, has_holes: has_holes && layout.per_layer.is_some(), nearest })
    }
}

/// Positions along a stack inside the box, moved to the nearest slice, so many to a layer.
#[inline(always)]
pub(crate) fn on_slices<S: Simd>(simd: S, at: f32x16<S>, per_layer: f32, max: f32) -> f32x16<S> {
    let slice: i32x16<S> = (at * per_layer + 0.5).to_int();
    // Divided, a slice on a layer is there to the last bit: beside holes it matters.
    inside(simd, slice.to_float::<f32x16<S>>() / per_layer, max)
}

impl<X: Texture> Sliced<X> {
    /// Places in texture coordinates, along the axes of the texels.
    #[inline(always)]
    fn turned_back<S: Simd>(&self, at: &Cells<S>) -> Cells<S> {
        let ([x, y, z], [tx, ty, tz]) = (at.cell, at.fraction);
        // Written out: vectors that are indexed go through memory.
        match self.layout.axes {
            [1, 2, 0] => Cells { cell: [z, x, y], fraction: [tz, tx, ty] },
            [0, 2, 1] => Cells { cell: [x, z, y], fraction: [tx, tz, ty] },
            _ => Cells { cell: [x, y, z], fraction: [tx, ty, tz] },
        }
    }

    /// Reads what was fetched for places in texture coordinates.
    #[inline(always)]
    fn read_there<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &X::Stage) -> [f32x16<S>; 4] {
        let Cells { cell, mut fraction } = self.turned_back(at);
        if self.nearest {
            // In the same cell: which is vacuum is asked of that, and fractions are exact, so that places half-way go up, as in f64.
            let (zero, half, one) = (splat(simd, 0.0), splat(simd, 0.5), splat(simd, 1.0));
            // A loop, and not `map`: a closure that is not inlined loses its instructions.
            for t in &mut fraction {
                *t = pick(t.simd_ge(half), one, zero);
            }
        }
        self.texture.read(simd, &Cells { cell, fraction }, stage)
    }

    /// Texels at places, NaN on the lower face of a cell along the last axis where the cell before it is vacuum.
    ///
    /// Its own function: few volumes have holes.
    #[inline(never)]
    fn unless_vacuum_before<S: Simd>(&self, simd: S, at: &Cells<S>, texel: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
        let mut lanes = texel.map(Lanes::new);
        simd.vectorize(
            #[inline(always)]
            || {
                let ([x, y, z], [tx, ty, tz]) = (at.cell, at.fraction);
                let on_face = tz.simd_eq(splat(simd, 0.0)) & z.simd_gt(i32x16::splat(simd, 0));
                if on_face.any_true() {
                    let cell = [x, y, (z - 1).max(i32x16::splat(simd, 0))];
                    let before = Cells { cell, fraction: [tx, ty, splat(simd, 1.0)] };
                    let mut stage = X::Stage::default();
                    self.texture.fetch(simd, &self.turned_back(&before), &mut stage);
                    // The opacity of light is missing where any of it is.
                    let [.., there] = self.read_there(simd, &before, &stage);
                    let vacuum = on_face & !there.simd_eq(there);
                    for component in &mut lanes {
                        *component = Lanes::new(pick(vacuum, there, component.load(simd)));
                    }
                }
            },
        );
        lanes.map(|component| component.load(simd))
    }
}

impl<X: Texture> Texture for Sliced<X> {
    type Stage = X::Stage;
    const LIGHT: bool = X::LIGHT;

    #[inline(always)]
    fn dims(&self) -> [usize; 3] {
        self.layout.turned(self.texture.dims())
    }

    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        let max = (self.dims()[2] - 1) as f32;
        let z = match self.layout.per_layer {
            Some(per_layer) => on_slices(simd, inside(simd, z, max), per_layer as f32, max),
            None => z,
        };
        self.place_between(simd, [x, y, z])
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut X::Stage) {
        self.texture.fetch(simd, &self.turned_back(at), stage);
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &X::Stage) -> [f32x16<S>; 4] {
        let texel = self.read_there(simd, at, stage);
        if self.has_holes { self.unless_vacuum_before(simd, at, texel) } else { texel }
    }

    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, wanted: u32, stage: &mut X::Stage) -> [Lanes; 3] {
        self.layout.turned(self.texture.gradient(simd, &self.turned_back(at), wanted, stage))
    }
}
