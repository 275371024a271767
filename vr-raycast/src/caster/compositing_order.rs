//! Directions in which rays are composited.

/// Direction in which the samples of a ray are composited under `over`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompositingOrder {
    /// Front to back: a ray can end early.
    FrontToBack {
        /// Opacity in (0, 1] at which a ray ends; at 1 it ends where nothing behind can be seen at all.
        ///
        /// No pixel changes by more than `1 − termination`: that holds as it stands where no point of the medium shines brighter
        /// than 1, and where one can, rays go on correspondingly longer.
        termination: f64,
    },
    /// Back to front: the same sum, rounded otherwise. No ray can end early, and only `over` is defined.
    BackToFront,
}

impl CompositingOrder {
    /// The opacity at which rays end by default: the 10⁻⁴ that this can cost is a fortieth of what an 8-bit picture can show.
    pub const TERMINATION: f64 = 0.9999;

    /// Front to back, ended only by what is opaque in all bits.
    pub const WHOLE_RAY: Self = Self::FrontToBack { termination: 1.0 };
}

impl Default for CompositingOrder {
    fn default() -> Self {
        Self::FrontToBack { termination: Self::TERMINATION }
    }
}
