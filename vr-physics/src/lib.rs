//! The reference that every renderer here is measured against: the equation of transfer for light in an emitting and absorbing
//! medium, solved in f64 with a bound on the solution's own error.
//!
//! Along a ray, s being the distance behind its front, radiance I and optical depth τ obey
//!
//! dI/ds = κ I − q (towards the eye: what is emitted adds, what is absorbed is lost), so that
//! I = ∫ q e^(−τ) ds + I₀ e^(−τ(L)), τ(s) = ∫₀ˢ κ ds.
//!
//! # How
//! 1. **Pieces.** A reconstructed field is a polynomial of s in every cell ([`GridLine`]): a cubic for trilinear, degree 9 for
//!    tricubic filters. The ray is cut at cell faces and where the polynomial crosses a knot of the transfer function.
//!    Scattered points ([`vr_core::field::PointLine`]) are a sum of kernels, smooth between the spheres that bound them; there it is interpolated, with a
//!    bound on what that misses. Their weighted mean, and that of their colours, is a quotient of two such sums, interpolated with the bound that its residual
//!    gives, on pieces as short as that asks for.
//! 2. **Quadrature.** On a piece κ and q are analytic. Clenshaw-Curtis rules integrate optical depth and light together.
//! 3. **Bound.** What a rule misses is bounded beforehand, by how large the integrand is on ellipses in the complex plane around
//!    the piece (not by the difference of two rules, which can be too small). Pieces are halved until the bound fits the
//!    tolerance; a term for rounding is added. Where α only touches 1, the logarithm is enclosed instead.
//!
//! Every pixel says its [`Certainty`]: a `Bound`, or an `Estimate` where a field or a model has none to offer. Where
//! the correct pixel itself jumps between neighbouring rays (a ray that touches an opaque wall within the last bits), the bound
//! says so by being large.
//!
//! # Example
//! A slab of optical depth 4·0.1054 before a lamp:
//! ```
//! use vr_core::*;
//! use vr_physics::Reference;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let grid = UniformGrid::new([2, 2, 3], vec![7u8; 12], Placement::from_spacing([1.0, 1.0, 2.0])?, Calibration::default())?;
//! let fog = ControlPoint::new(0.0, [0.5; 3], 0.1); // opacity 0.1 per unit distance
//! let scene = Scene::new(grid.into(), TransferFunction::new(vec![fog], OpacityRule::Power, 1.0)?);
//! let view = View::new(Camera::framing(scene.volume.bounds(), 0.0, 0.0, None), [1, 1]);
//!
//! let solution = Reference::default().solve(&scene, &view, &Model::Canonical, &Control::default())?;
//! let pixel = solution.pixels[0];
//! let transmittance = 0.9f64.powi(4);
//! assert!((pixel.rgba[0] - 0.5 * (1.0 - transmittance)).abs() <= pixel.certainty.value());
//! assert!(pixel.certainty.value() < 1e-12);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! * `proptest`: random scenes, and checks for any `Renderer`, in `check`.

pub mod cases;
#[cfg(feature = "proptest")]
pub mod check;
mod colored_line;
mod component;
mod crossings;
mod double;
mod exact_ray;
mod first_crossing;
mod grid_line;
mod leaf;
pub mod metrics;
mod model_solvers;
mod nodes;
mod optics;
mod order;
mod phantom_pixels;
mod picked_color;
mod reference;
mod scattered;
mod segments;
mod solver;
mod ssim;
mod tap_weights;
mod transport;
pub mod value_operators;
mod walls;
pub use grid_line::{GradientSource, GridLine, SampleGradients};
pub use metrics::{Channels, Metrics};
pub use model_solvers::{integrate_continuous, sum_segments};
pub use optics::Optics;
pub use order::{fit_order, fit_order_above};
pub use reference::{DEFAULT_TOLERANCE, MIN_TOLERANCE, Pixel, Reference, Solution};
pub use scattered::spread;
pub use segments::{RaySegment, SegmentLight};
pub use ssim::ssim;
pub use transport::{Certainty, Transport, transport};
#[cfg(feature = "proptest")]
#[doc(hidden)]
pub use vr_core;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
