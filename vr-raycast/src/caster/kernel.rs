//! Settings of the kernels: tables, precision and instructions.

/// Way in which the transfer function is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransferLookup {
    /// Look-up wherever a table serves; evaluation elsewhere.
    #[default]
    Auto,
    /// Look-up in a table made for the step's length; see [`vr_kernels::tables::BakedTransfer`] for what that adds to the error.
    /// A transfer function that tells apart what no table of some thousand entries can is evaluated exactly after all.
    ///
    /// It is refused where nothing is looked up in a table, whatever the transfer function: under operators that pick a value, by
    /// [`Rule::Exact`](super::Rule::Exact), under an error bound, and in fields that the plain engine draws and that are no grids.
    Table,
    /// Evaluation at every sample in f64: slow, for study and for transfer functions finer than any table. What an operator picks or averages is evaluated
    /// by default, too.
    Exact,
}

/// Precision of the kernels. Rays, and sums of more than a few dozen samples, are in f64 always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats. Where a ramp of the transfer function, or a field in which it jumps, is narrower than 1/4096 of the largest stored
    /// number, which f32 hardly tells apart, 64-bit ones after all.
    #[default]
    F32,
    /// 64-bit floats: for measuring the rounding of 32-bit ones.
    F64,
}

/// Instructions that the vector engine may use.
///
/// It draws `over` and `accumulate` under every filter, front to back, in f32 with a table, by the rules `midpoint`, `linear` and `quadratic` in uniform and
/// in local steps, and by `left` in uniform ones; unshaded or shaded by gradients of either kind; opacity may follow the gradient, by factors or by rows of the
/// transfer function, samples may be missing, and voxels may have colours. Steps from node to node of an octree, by homogeneity or by variance, it takes by `midpoint`. It picks values, too (but no mean of colours). Grids of fewer than four voxels along x have no rows for filters of four taps.
/// Scattered points it draws under `over` and `accumulate` by `midpoint` and `left`, shaded or not, with opacity by the gradient, while lists of the points near
/// each place fit into 320 MB. Everything else goes through the plain engine. Under uniform steps it leaps by cubes of blocks of its own; with
/// [`EmptySpace::None`](super::EmptySpace::None), not at all. A structure that is asked for by name is the plain engine's.
///
/// Pictures do not depend on the instructions, bit for bit; from the plain engine's they differ by rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vector {
    /// Widest instructions that the machine has.
    #[default]
    Auto,
    /// AVX2 at most.
    Avx2,
    /// Instructions that every machine of the architecture has: SSE2, NEON.
    Baseline,
    /// No vector instructions: the plain engine draws everything.
    Off,
}
