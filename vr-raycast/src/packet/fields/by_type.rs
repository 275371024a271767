//! Fields of voxels of any type, and the stages that they are read through.

use fearless_simd::Simd;
use vr_kernels::vector::{AxisWeights, Blocks, ByType, Cells, Field, Lanes, Stage, WideField};

/// Blocks of 4³ voxels of any type, under a filter of four taps an axis.
pub(super) type AnyWideField<'a> =
    ByType<WideField<'a, u8>, WideField<'a, i8>, WideField<'a, u16>, WideField<'a, i16>, WideField<'a, f32>>;

/// Stages for voxels of one type.
#[derive(Default)]
pub(super) struct TypeStage<T: Blocks> {
    pub(super) cells: Stage<T>,
    pub(super) blocks: T::Stage,
}

/// Stages for voxels of any type, of which one is in use.
#[derive(Default)]
pub(super) struct AnyStage {
    pub(super) u8: TypeStage<u8>,
    pub(super) i8: TypeStage<i8>,
    pub(super) u16: TypeStage<u16>,
    pub(super) i16: TypeStage<i16>,
    pub(super) f32: TypeStage<f32>,
}

/// Type of voxels, by which fields are told apart.
pub(super) trait OfType: Blocks {
    fn wide_field(field: WideField<'_, Self>) -> AnyWideField<'_>;
}

macro_rules! of_type {
    ($($voxel:ident $name:ident),*) => {$(
        impl OfType for $voxel {
            fn wide_field(field: WideField<'_, Self>) -> AnyWideField<'_> {
                ByType::$name(field)
            }
        }
    )*};
}
of_type!(u8 U8, i8 I8, u16 U16, i16 I16, f32 F32);

/// Runs code for a field and the stages of its type.
macro_rules! with_type {
    ($any:expr, $stages:expr, ($field:ident, [$($mutable:tt)*] $stage:ident) => $body:expr) => {
        match $any {
            ByType::U8($field) => {
                let $stage = &$($mutable)* $stages.u8;
                $body
            }
            ByType::I8($field) => {
                let $stage = &$($mutable)* $stages.i8;
                $body
            }
            ByType::U16($field) => {
                let $stage = &$($mutable)* $stages.u16;
                $body
            }
            ByType::I16($field) => {
                let $stage = &$($mutable)* $stages.i16;
                $body
            }
            ByType::F32($field) => {
                let $stage = &$($mutable)* $stages.f32;
                $body
            }
        }
    };
}
pub(super) use with_type;

// Functions of their own, for there are many marches: what they call is there once for each level and type.

/// Writes the voxels nearest to places.
#[inline(never)]
pub(super) fn nearest_values<S: Simd, T: Blocks>(simd: S, field: &Field<'_, T>, at: &Cells<S>, values: &mut Lanes) {
    simd.vectorize(
        #[inline(always)]
        || values.0 = field.nearest(simd, at),
    );
}

/// Writes the values of the trilinear field at places, whose cells are staged.
#[inline(never)]
pub(super) fn cell_values<S: Simd, T: Blocks>(
    simd: S,
    field: &Field<'_, T>,
    at: &Cells<S>,
    stage: &mut TypeStage<T>,
    values: &mut Lanes,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            field.fetch(simd, at, &mut stage.cells);
            *values = Lanes::new(field.value(simd, at, &stage.cells));
        },
    );
}

/// Writes the values of a filter of four taps an axis at places, whose blocks are staged, and the weights of their voxels.
#[inline(never)]
pub(super) fn block_values<S: Simd, T: Blocks>(
    simd: S,
    field: &WideField<'_, T>,
    at: &Cells<S>,
    weights: &mut AxisWeights,
    stage: &mut TypeStage<T>,
    values: &mut Lanes,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            field.fetch(simd, at, &mut stage.blocks);
            field.weights(simd, at, weights);
            *values = Lanes::new(field.value(simd, weights, &stage.blocks));
        },
    );
}

/// Writes the gradients of the trilinear field itself, whose cells are staged.
#[inline(never)]
pub(super) fn cell_gradients<S: Simd, T: Blocks>(
    simd: S,
    field: &Field<'_, T>,
    at: &Cells<S>,
    stage: &TypeStage<T>,
    gradients: &mut [Lanes; 3],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let [x, y, z] = field.slopes(simd, at, &stage.cells);
            *gradients = [Lanes::new(x), Lanes::new(y), Lanes::new(z)];
        },
    );
}

/// Writes the gradients of a filter of four taps an axis, whose blocks are staged and whose weights are known.
#[inline(never)]
pub(super) fn block_gradients<S: Simd, T: Blocks>(
    simd: S,
    field: &WideField<'_, T>,
    at: &Cells<S>,
    weights: &AxisWeights,
    stage: &TypeStage<T>,
    gradients: &mut [Lanes; 3],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut slopes = [[Lanes::ZERO; 4]; 3];
            field.slopes(simd, at, &mut slopes);
            let [x, y, z] = field.gradient(simd, weights, &slopes, &stage.blocks);
            *gradients = [Lanes::new(x), Lanes::new(y), Lanes::new(z)];
        },
    );
}
