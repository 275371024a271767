//! The two precisions a kernel can be instantiated in.

/// Precision of a kernel, `f32` (renderers) or `f64` (the reference): one generic kernel, two instances.
///
/// Transcendental functions come from `libm`, because std's call the system's, which pick fused variants at run time:
/// pictures must not depend on the machine.
///
/// # Examples
/// ```
/// use vr_core::Real;
///
/// fn transmittance<R: Real>(extinction: f64, length: R) -> R {
///     (-R::from_f64(extinction) * length).exp()
/// }
/// let (single, double) = (transmittance(0.5, 2.0f32), transmittance(0.5, 2.0f64));
/// assert!((single.to_f64() - double).abs() <= 4.0 * <f32 as Real>::ROUNDOFF);
/// ```
pub trait Real:
    Copy
    + PartialOrd
    + Default
    + Send
    + Sync
    + std::fmt::Debug
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::Neg<Output = Self>
    + std::ops::AddAssign
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Not a number: the value of a field in vacuum.
    const NAN: Self;
    /// Name of the type.
    const NAME: &'static str;
    /// Unit round-off (half the distance from 1 to the next larger number).
    const ROUNDOFF: f64;
    /// Rounds from `f64`.
    fn from_f64(x: f64) -> Self;
    /// Rounds from `f32` (exact for both).
    fn from_f32(x: f32) -> Self;
    /// Widens to `f64` (exact for both).
    fn to_f64(self) -> f64;
    /// The integer part of a non-negative number; 0 for negative ones and NaN.
    fn to_index(self) -> usize;
    /// The number of an index.
    fn from_index(i: usize) -> Self;
    /// |x|.
    fn abs(self) -> Self;
    /// √x, correctly rounded.
    fn sqrt(self) -> Self;
    /// eˣ − 1.
    fn exp_m1(self) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// ln(1 + x).
    fn ln_1p(self) -> Self;
    /// xʸ.
    fn pow(self, y: Self) -> Self;
    /// The smaller of two numbers; the other one where one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers; the other one where one is NaN.
    fn max(self, other: Self) -> Self;
    /// True for NaN.
    fn is_nan(self) -> bool;
}

macro_rules! real {
    ($t:ident, $from_f32:expr, $exp_m1:path, $exp:path, $ln_1p:path, $pow:path) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const NAN: Self = $t::NAN;
            const NAME: &'static str = stringify!($t);
            const ROUNDOFF: f64 = ($t::EPSILON / 2.0) as f64;
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                $from_f32(x)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn to_index(self) -> usize {
                // `as` saturates: NaN and negative numbers become 0.
                self.max(0.0) as i32 as usize
            }
            #[inline(always)]
            fn from_index(i: usize) -> Self {
                i as i32 as $t
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $t::sqrt(self)
            }
            #[inline(always)]
            fn exp_m1(self) -> Self {
                $exp_m1(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline(always)]
            fn ln_1p(self) -> Self {
                $ln_1p(self)
            }
            #[inline(always)]
            fn pow(self, y: Self) -> Self {
                $pow(self, y)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                $t::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                $t::max(self, other)
            }
            #[inline(always)]
            fn is_nan(self) -> bool {
                self != self
            }
        }
    };
}

real!(f32, |x: f32| x, libm::expm1f, libm::expf, libm::log1pf, libm::powf);
real!(f64, f64::from, libm::expm1, libm::exp, libm::log1p, libm::pow);
