//! The mistakes that the marcher can be told to make.

/// The classic mistakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// None: a right renderer.
    None,
    /// Cell-centred, though the voxels are at lattice points.
    HalfVoxelShift,
    /// α of the unit distance, whatever the step.
    NoOpacityCorrection,
    /// The last, shorter step is left out.
    DroppedLastStep,
    /// The sample at the front of each step: a rule of order 1.
    LeftSample,
    /// Missing voxels count as 0.
    MissingIsZero,
    /// A number where there is none.
    Nan,
    /// Steps of a fixed world length.
    WorldStep,
    /// x and y are mixed up.
    SwappedSpacing,
    /// Colours are clamped to 1.
    ClampedLight,
    /// Every frame is a little brighter than the last.
    Memory,
    /// The picture depends on the threads that draw it.
    CountsThreads,
    /// It panics.
    Panic,
    /// It says that it cannot draw the scene, whatever the scene is.
    RefusesEverything,
    /// Voxels are classified before they are interpolated.
    PreClassification,
    /// Rays go through the corners of pixels.
    PixelCorners,
    /// A table of optics is interpolated across the jumps of the transfer function: the shorter the steps, the more of them land
    /// between two entries, where there is neither the one side's colour nor the other's.
    BleedingJumps,
    /// Values are carried in half the digits of f32, whatever the transfer function tells apart.
    NarrowValues,
    /// The second frame and all later ones come without the depth that the first has.
    LosesDepth,
    /// An update leaves the old transfer function.
    StaleTransfer,
    /// An update leaves the old volume.
    StaleVolume,
    /// An update leaves the old filter.
    StaleFilter,
    /// An update is not asked whether it can be drawn.
    StaleSupport,
    /// Finer levels of an adaptive mesh are left out.
    CoarsestLevel,
    /// The axes of a rectilinear grid are taken for even ones.
    EvenAxes,
}
