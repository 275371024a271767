//! Catmull-Rom cubic.

use super::{Filter, Separable, Taps4};
use crate::real::Real;

/// The one-dimensional kernel (Keys, *Cubic convolution interpolation for digital image processing*, 1981, a = −½).
#[derive(Clone, Copy, Debug)]
pub struct CatmullRomTaps;

/// Catmull-Rom along each axis: interpolates, continuous gradient, reproduces quadratics; may overshoot.
pub type CatmullRom = Separable<CatmullRomTaps>;

impl Taps4 for CatmullRomTaps {
    const FILTER: Filter = Filter::CatmullRom;

    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        let c = R::from_f64;
        let half = c(0.5);
        [
            half * t * (t * (c(2.0) - t) - R::ONE),
            half * (t * t * (c(3.0) * t - c(5.0)) + c(2.0)),
            half * t * (t * (c(4.0) - c(3.0) * t) + R::ONE),
            half * t * t * (t - R::ONE),
        ]
    }

    #[inline(always)]
    fn derivatives<R: Real>(t: R) -> [R; 4] {
        let c = R::from_f64;
        let half = c(0.5);
        [
            half * (t * (c(4.0) - c(3.0) * t) - R::ONE),
            half * t * (c(9.0) * t - c(10.0)),
            half * (t * (c(8.0) - c(9.0) * t) + R::ONE),
            half * t * (c(3.0) * t - c(2.0)),
        ]
    }
}
