//! How far a picture is from the exact solution.

pub use vr_benches::exact::Exact;
pub use vr_benches::figures::ErrorFigures as ErrorJson;

/// Rows and columns of the subgrid of pixels on which a picture's error is measured where not every pixel is.
pub const SUBGRID: u32 = 64;
