//! The field along a stretch of a ray by polynomials, handed over as cubics with a bound of what they miss.

use vr_core::Real;
use vr_core::field::Poly;

use super::cubic::Cubic;
use super::looks::Looks;
use super::piece_by_piece::Place;
use super::walk::Course;

/// Largest number of halvings of a stretch, after which a cubic is taken as it is: what it misses falls by 16 with each.
const MAX_HALVINGS: u32 = 9;
/// Smallest miss that shorter cubics are asked for, relative to the field's reach, and to its steepest slope.
pub(super) const MIN_MISS: f64 = 1e-10;
/// Largest miss of a gradient, relative to its largest component on the piece, and as a share of the error promised.
const GRADIENT_SHARE: f64 = 0.02;
/// Largest miss of a colour, as a share of the error promised.
const COLOR_SHARE: f64 = 0.02;

/// Field along a stretch of a ray, by polynomials of t from −1 to 1.
pub(super) struct Polynomials<'a> {
    /// The field, less its base, and a bound of what that is off by.
    pub(super) field: Poly,
    pub(super) off: f64,
    /// The base, the largest difference from it, values that the field does not reach, and the error of places: as a [`Place`] has them.
    pub(super) base: f64,
    pub(super) reach: f64,
    pub(super) limits: Option<[f64; 2]>,
    pub(super) misplaced: f64,
    /// The gradient, a bound of what each component is off by, and of its size; `None` where it is not known by polynomials.
    pub(super) gradient: Option<([Poly; 3], f64, f64)>,
    /// Distances at which the stretch begins and ends.
    pub(super) ends: [f64; 2],
    /// Error that is promised.
    pub(super) error: f64,
    /// Colours of the places, and a bound of what each channel is off by; `None` where they are not known by polynomials.
    pub(super) colors: Option<([Poly; 3], f64)>,
    /// Makes gradient and colours along a part.
    pub(super) looks: &'a LooksOfPart<'a>,
}

/// Function that makes gradient and colours along a part between two distances, of cubics of either where they are known by polynomials.
type LooksOfPart<'a> = dyn Fn([f64; 2], Option<&CubicVector>, Option<&CubicVector>) -> Looks + 'a;

/// Three functions along a part of a stretch, such as the components of the gradient or the channels of a colour: by the powers of a parameter from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct CubicVector {
    pub(super) powers: [[f64; 4]; 3],
    /// Bound of what each component is off by.
    pub(super) off: f64,
}

impl CubicVector {
    /// Returns them along a whole stretch, each being off by at most `off`.
    pub(super) fn whole(components: &[Poly; 3], off: f64) -> Self {
        Self::part(components, [-1.0, 1.0], off).0
    }

    /// Returns them on a part of [−1, 1], and what the cubics miss.
    fn part(components: &[Poly; 3], part: [f64; 2], off: f64) -> (Self, f64) {
        let parts = components.map(|component| restricted(&component, part));
        let missed = parts.iter().map(|(_, missed)| *missed).fold(0.0, f64::max);
        (Self { powers: parts.map(|(cubic, _)| cubic.powers()), off: missed + off }, missed)
    }
}

impl Polynomials<'_> {
    /// Takes a course along the stretch.
    pub(super) fn hand_over<R: Real>(&self, course: &mut impl Course) {
        self.piece::<R>([-1.0, 1.0], 0, course);
    }

    /// Hands over a piece, from one place on [−1, 1] to another: as one cubic if what that misses does not matter, else by halves.
    fn piece<R: Real>(&self, part: [f64; 2], halvings: u32, course: &mut impl Course) {
        if course.is_done() {
            return;
        }
        let [a, b] = part;
        let (cubic, missed) = restricted(&self.field, part);
        let off = missed + self.off;
        let (low, high) = cubic.hull();
        let range = [self.base + low - off, self.base + high + off];
        if course.passes_values(range) {
            return;
        }
        // What is a little beyond counts, too, as far as the field is off.
        let nearby = [range[0] - 4.0 * off, range[1] + 4.0 * off];
        let gradient = self.gradient.as_ref().map(|(gradient, off, _)| CubicVector::part(gradient, part, *off));
        let turns =
            gradient.as_ref().zip(self.gradient.as_ref()).is_some_and(|((cubics, missed), (_, off, steepest))| {
                let size = cubics.powers.iter().map(|p| p.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
                *missed > (GRADIENT_SHARE * self.error * size).max(MIN_MISS * steepest).max(*off)
            });
        let colors = self.colors.as_ref().map(|(colors, off)| CubicVector::part(colors, part, *off));
        let fades = colors
            .as_ref()
            .zip(self.colors.as_ref())
            .is_some_and(|((_, missed), (_, off))| *missed > (COLOR_SHARE * self.error).max(MIN_MISS).max(*off));
        let smallest = MIN_MISS.max(4.0 * R::ROUNDOFF) * self.reach;
        let bends = missed > course.resolution(nearby).max(smallest).max(self.off);
        if halvings < MAX_HALVINGS && (bends || turns || fades) {
            let middle = 0.5 * (a + b);
            self.piece::<R>([a, middle], halvings + 1, course);
            self.piece::<R>([middle, b], halvings + 1, course);
            return;
        }
        let [from, to] = self.ends;
        let at = |t: f64| from + (to - from) * 0.5 * (t + 1.0);
        let ends = [at(a), at(b)];
        let Self { base, reach, limits, misplaced, .. } = *self;
        let cubic = Cubic(cubic.0.map(R::from_f64));
        let cubics = [&gradient, &colors].map(|known| known.as_ref().map(|(cubics, _)| cubics));
        let looks = || (self.looks)(ends, cubics[0], cubics[1]);
        course.cell(cubic, Place { base, reach, limits, misplaced, off }, looks, ends[0], ends[1] - ends[0]);
    }
}

/// Returns a polynomial on a part of [−1, 1], as a cubic, and a bound of what that misses.
fn restricted(poly: &Poly, [a, b]: [f64; 2]) -> (Cubic<f64>, f64) {
    let part = if [a, b] == [-1.0, 1.0] { *poly } else { poly.restricted(a, b) };
    let (cubic, missed) = part.economized(3);
    let mut c = [0.0; 4];
    c[..=cubic.degree()].copy_from_slice(cubic.coefficients());
    // Roundings of the shift and of taking the degree down, of sums of all coefficients.
    let rounding = 64.0 * f64::EPSILON * (poly.coefficients()[0].abs() + poly.spread(1.0));
    (Cubic::of_powers_about_middle(c), missed + rounding)
}
