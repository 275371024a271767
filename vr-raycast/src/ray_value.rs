//! Value of a ray, as an operator returns it.

/// Value of a ray: premultiplied RGBA, and the world distance from the ray's origin to what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayValue {
    pub(crate) rgba: [f64; 4],
    /// World distance; +∞ if the ray shows nothing.
    pub(crate) depth: f64,
}

impl RayValue {
    /// Value of a ray that meets nothing.
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY };
}
