//! One splat: a kernel somewhere in a view.

/// A kernel, placed in a view, and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Splat {
    /// To the right, up, and behind the view's base.
    pub(crate) place: [f32; 3],
    /// Kernel space by view units, relative to the view's kernel: 1 over the radius, for points.
    pub(crate) scale: f32,
    /// What the kernel of unit integral in kernel space is multiplied by.
    pub(crate) weight: f32,
    /// A stored number, less the volume's smallest: sums of such round less.
    pub(crate) value: f32,
}
