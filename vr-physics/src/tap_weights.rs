//! Polynomial weights of the taps along one axis.

use vr_core::Filter;

use vr_core::field::Poly;

/// Lattice indices and weights along one axis.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) index: [usize; 4],
    pub(crate) weight: [Poly; 4],
    pub(crate) taps: usize,
}

impl Axis {
    /// The weights' derivatives by the index coordinate, of which `half` is the rate by t and `middle` the value at t = 0.
    pub(crate) fn slopes(&self, half: f64, filter: Filter, middle: f64) -> Self {
        let x = Poly::new(&[middle, half]);
        let weight = match filter {
            Filter::Trilinear => {
                let one = Poly::constant(1.0);
                [one * -1.0, one, one, one]
            }
            Filter::BSpline => cubics(x, &derivatives(&BSPLINE)),
            Filter::CatmullRom => cubics(x, &derivatives(&CATMULL_ROM)),
            Filter::Nearest | Filter::Gaussian => [Poly::constant(0.0); 4],
        };
        Self { weight, ..*self }
    }
}

/// Four cubics in the fraction: coefficients of 1, x, x², x³.
pub(crate) type Cubics = [[f64; 4]; 4];

pub(crate) const BSPLINE: Cubics = [
    [1.0 / 6.0, -0.5, 0.5, -1.0 / 6.0],
    [4.0 / 6.0, 0.0, -1.0, 0.5],
    [1.0 / 6.0, 0.5, 0.5, -0.5],
    [0.0, 0.0, 0.0, 1.0 / 6.0],
];

pub(crate) const CATMULL_ROM: Cubics =
    [[0.0, -0.5, 1.0, -0.5], [1.0, 0.0, -2.5, 1.5], [0.0, 0.5, 2.0, -1.5], [0.0, 0.0, -0.5, 0.5]];

fn derivatives(cubics: &Cubics) -> Cubics {
    cubics.map(|c| [c[1], 2.0 * c[2], 3.0 * c[3], 0.0])
}

pub(crate) fn cubics(x: Poly, c: &Cubics) -> [Poly; 4] {
    let (x2, one) = (x * x, Poly::constant(1.0));
    let x3 = x2 * x;
    c.map(|c| one * c[0] + x * c[1] + x2 * c[2] + x3 * c[3])
}
