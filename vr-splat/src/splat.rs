//! One splat: a kernel somewhere in a view.

/// A kernel, placed in a view, and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Splat {
    /// To the right, up, and behind the view's base.
    pub(crate) place: [f32; 3],
    /// Kernel space by view units, relative to the view's kernel: 1 over the radius, for points.
    pub(crate) scale: f32,
    /// Factor of the kernel of unit integral in kernel space.
    pub(crate) weight: f32,
    /// Stored number, less the volume's smallest: sums of such numbers round less. Where the light of each voxel or point is known, the bits of its
    /// number: whole numbers below 2³¹ − 2²³, none of which is a NaN.
    pub(crate) value: f32,
}
