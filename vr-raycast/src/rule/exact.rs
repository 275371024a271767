//! Light of a step on which the value is a cubic, to rounding.

use std::sync::{Arc, LazyLock};

use vr_core::transfer::Segment;
use vr_core::{OpacityRule, TransferFunction};

use super::cubic::Cubic;

/// Integrator of the equation of transfer over a step on which the calibrated value is a given polynomial.
///
/// The step is cut where the polynomial passes a knot of the transfer function; on each piece κ and q are smooth, and Gauss and
/// Legendre's rule with 8 points integrates both, the optical depth in front of each point by the same polynomial. A piece is halved
/// until its two halves say what it says itself, to 10⁻¹³ in optical depth and light. Where α touches 1, κ has a logarithm, and halving
/// closes in on it.
///
/// A trilinear field along a ray is a cubic in each cell. So with steps that are cells, nothing but rounding is left.
#[derive(Clone, Debug)]
pub(crate) struct ExactIntegral {
    transfer: Arc<TransferFunction>,
    /// Calibrated values at which the transfer function has a kink or jumps, ascending.
    knots: Vec<f64>,
}

/// Contribution of a piece, before anything in front dims it.
#[derive(Clone, Copy, Debug)]
struct Gain {
    depth: f64,
    light: [f64; 3],
}

/// Largest number of halvings of a piece: the logarithm at α = 1 is then enclosed to 10⁻¹³.
const MAX_HALVINGS: u32 = 48;
/// Largest difference of two results that count as the same, relative to 1 or the larger one.
const AGREEMENT: f64 = 1e-13;
/// Optical depth behind which nothing is left to see in f64.
const BLIND: f64 = 40.0;

impl ExactIntegral {
    pub(crate) fn new(transfer: Arc<TransferFunction>) -> Self {
        let mut knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| s.from).collect();
        knots.dedup();
        Self { transfer, knots }
    }

    /// Returns the transfer function that it integrates.
    pub(crate) fn transfer(&self) -> &TransferFunction {
        &self.transfer
    }

    fn is_wall(&self, segment: &Segment) -> bool {
        segment.is_opaque() && self.transfer.rule() == OpacityRule::Power
    }

    /// True if a value that goes from `low` to `high` would get into a wall if it went on by `more` to either side.
    pub(crate) fn wall_is_near(&self, low: f64, high: f64, more: f64) -> bool {
        let mut walls = self.transfer.segments().iter().filter(|s| self.is_wall(s));
        walls.any(|w| high + more > w.from && low - more < w.to && !(high > w.from && low < w.to))
    }

    /// Returns light (r, g, b) and opacity of a step of `length` world units.
    pub(crate) fn step(&self, value: Cubic, length: f64) -> [f64; 4] {
        if value.is_constant() {
            return self.transfer.step(value.0[0], length);
        }
        // Most steps meet no knot: no list, then, and no memory.
        let mut cuts = Vec::new();
        value.crossings(&self.knots, &mut cuts);
        cuts.push(1.0);
        let mut total = Gain { depth: 0.0, light: [0.0; 3] };
        let mut from = 0.0;
        for to in cuts {
            if to <= from {
                continue;
            }
            let segment = self.transfer.segment_at(value.at(0.5 * (from + to)));
            if !segment.is_clear() {
                if self.is_wall(segment) {
                    let middle = value.at(0.5 * (from + to));
                    if middle - segment.from <= touch(segment.from) || segment.to - middle <= touch(segment.to) {
                        // Touched up to rounding, not entered.
                        from = to;
                        continue;
                    }
                    let at = segment.at(value.at(from));
                    let color = if self.transfer.has_emission() { [0.0; 3] } else { at.color };
                    total = total.before(Gain { depth: f64::INFINITY, light: color });
                    break;
                }
                let piece = Piece { integral: self, segment, value, length };
                total = total.before(piece.gain(from, to, MAX_HALVINGS));
            }
            from = to;
            if total.depth > BLIND {
                break;
            }
        }
        let [r, g, b] = total.light;
        [r, g, b, -libm::expm1(-total.depth)]
    }
}

/// Returns the margin by which a value must exceed the border of a wall to be in it, and not only beside it up to rounding.
fn touch(border: f64) -> f64 {
    if border.is_finite() { 1e-13 * border.abs() } else { 0.0 }
}

impl Gain {
    /// Joins two contributions, this one in front.
    fn before(self, behind: Self) -> Self {
        let clear = libm::exp(-self.depth);
        let light = std::array::from_fn(|c| self.light[c] + clear * behind.light[c]);
        Self { depth: self.depth + behind.depth, light }
    }

    fn agrees(&self, other: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= AGREEMENT * a.abs().max(1.0);
        close(self.depth, other.depth) && (0..3).all(|c| close(self.light[c], other.light[c]))
    }
}

/// Part of a step inside one segment of the transfer function.
struct Piece<'a> {
    integral: &'a ExactIntegral,
    segment: &'a Segment,
    value: Cubic,
    length: f64,
}

impl Piece<'_> {
    fn gain(&self, from: f64, to: f64, halvings: u32) -> Gain {
        self.refined(self.estimate(from, to), from, to, halvings)
    }

    /// Returns a better contribution than the estimate, if that is not good.
    fn refined(&self, whole: Gain, from: f64, to: f64, halvings: u32) -> Gain {
        let middle = 0.5 * (from + to);
        let front = self.estimate(from, middle);
        // What is deep has one side that counts.
        let halves = front.before(self.estimate(middle, to));
        if halves.agrees(&whole) || halvings == 0 {
            return halves;
        }
        let front = self.refined(front, from, middle, halvings - 1);
        if front.depth > BLIND {
            return front;
        }
        front.before(self.gain(middle, to, halvings - 1))
    }

    fn estimate(&self, from: f64, to: f64) -> Gain {
        let rule = &*RULE;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let world = half * self.length;
        let (mut kappa, mut q) = ([0.0; POINTS], [[0.0; 3]; POINTS]);
        for j in 0..POINTS {
            (q[j], kappa[j]) = self.properties(self.value.at(middle + half * rule.nodes[j]));
        }
        let depth = world * dot(&rule.weights, &kappa);
        let mut light = [0.0; 3];
        for j in 0..POINTS {
            let seen = world * rule.weights[j] * libm::exp(-world * dot(&rule.running[j], &kappa));
            for c in 0..3 {
                light[c] += seen * q[j][c];
            }
        }
        Gain { depth, light }
    }

    fn properties(&self, value: f64) -> ([f64; 3], f64) {
        let transfer = &self.integral.transfer;
        let o = self.segment.at(value);
        // Rounding may reach the wall that the piece only touches.
        let kappa = transfer.extinction(o.opacity.min(1.0 - 0.5 * f64::EPSILON));
        (if transfer.has_emission() { o.emission } else { o.color.map(|c| kappa * c) }, kappa)
    }
}

const POINTS: usize = 8;

/// Gauss-Legendre rule on [−1, 1], and the integrals from −1 to each of its points.
struct GaussLegendre {
    nodes: [f64; POINTS],
    weights: [f64; POINTS],
    /// Weights, in row j, of the integral of the interpolating polynomial from −1 to node j.
    running: [[f64; POINTS]; POINTS],
}

static RULE: LazyLock<GaussLegendre> = LazyLock::new(GaussLegendre::new);

fn dot(a: &[f64; POINTS], b: &[f64; POINTS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the Legendre polynomials P₀ … P₉ at a point, by Bonnet's recursion.
fn legendre(x: f64) -> [f64; POINTS + 1] {
    let mut p = [1.0; POINTS + 1];
    p[1] = x;
    for n in 1..POINTS {
        let k = n as f64;
        p[n + 1] = ((2.0 * k + 1.0) * x * p[n] - k * p[n - 1]) / (k + 1.0);
    }
    p
}

impl GaussLegendre {
    /// Makes the rule. The nodes are the zeros of P₈, found by Newton's method from Tricomi's guess; with ℓⱼ = Σₖ (k + ½) wⱼ Pₖ(xⱼ) Pₖ, running
    /// integrals follow from ∫ Pₖ = (Pₖ₊₁ − Pₖ₋₁)/(2k + 1).
    fn new() -> Self {
        let n = POINTS as f64;
        let node = |j: usize| {
            let mut x = -libm::cos(std::f64::consts::PI * (j as f64 + 0.75) / (n + 0.5));
            let slope = |x: f64| {
                let p = legendre(x);
                n * (x * p[POINTS] - p[POINTS - 1]) / (x * x - 1.0)
            };
            for _ in 0..20 {
                x -= legendre(x)[POINTS] / slope(x);
            }
            (x, 2.0 / ((1.0 - x * x) * slope(x) * slope(x)))
        };
        let rule: [(f64, f64); POINTS] = std::array::from_fn(node);
        let (nodes, weights) = (rule.map(|r| r.0), rule.map(|r| r.1));
        let at = nodes.map(legendre);
        let running = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let integral = |k: usize| {
                    if k == 0 { nodes[i] + 1.0 } else { (at[i][k + 1] - at[i][k - 1]) / (2.0 * k as f64 + 1.0) }
                };
                (0..POINTS).map(|k| (k as f64 + 0.5) * weights[j] * at[j][k] * integral(k)).sum()
            })
        });
        Self { nodes, weights, running }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::ControlPoint;

    #[test]
    fn the_rule_integrates_powers() {
        let rule = GaussLegendre::new();
        for k in 0..16 {
            let sum: f64 = (0..POINTS).map(|j| rule.weights[j] * rule.nodes[j].powi(k)).sum();
            let exact = if k % 2 == 0 { 2.0 / f64::from(k + 1) } else { 0.0 };
            assert!((sum - exact).abs() < 1e-15, "{k}: {sum}");
        }
        for k in 0..POINTS as i32 {
            let values = rule.nodes.map(|x| x.powi(k));
            for (x, row) in rule.nodes.iter().zip(&rule.running) {
                let exact = (x.powi(k + 1) - (-1.0f64).powi(k + 1)) / f64::from(k + 1);
                assert!((dot(row, &values) - exact).abs() < 1e-14, "{k}");
            }
        }
    }

    fn integral(points: &[(f64, [f64; 3], f64)], rule: OpacityRule) -> ExactIntegral {
        let points = points.iter().map(|&(v, c, a)| ControlPoint::new(v, c, a)).collect();
        ExactIntegral::new(Arc::new(TransferFunction::new(points, rule, 1.0).unwrap()))
    }

    fn assert_close(got: [f64; 4], want: [f64; 4]) {
        assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-12), "{got:?}, expected {want:?}");
    }

    #[test]
    fn closed_forms() {
        let white = [1.0; 3];
        // κ = s along s in [0, 2] when the value is s.
        let ramp = integral(&[(0.0, white, 0.0), (1.0, white, 1.0)], OpacityRule::Extinction);
        let alpha = -libm::expm1(-0.5 - 1.0);
        assert_close(ramp.step(Cubic::line(0.0, 2.0), 2.0), [alpha; 4]);
        // A ramp 0 → 1 under the power rule across one unit distance has τ = 1, and then a wall follows.
        let wall =
            integral(&[(0.0, [0.0; 3], 0.0), (1.0, [0.0; 3], 1.0), (1.0, [0.25, 0.5, 1.0], 1.0)], OpacityRule::Power);
        let behind = libm::exp(-1.0);
        assert_close(wall.step(Cubic::line(0.0, 1.0), 1.0), [0.0, 0.0, 0.0, 1.0 - behind]);
        assert_close(wall.step(Cubic::line(0.0, 2.0), 2.0), [0.25 * behind, 0.5 * behind, behind, 1.0]);
        // A shell that a parabola enters and leaves twice: 0.2 of value at κ = 3.
        let c = [0.5, 0.25, 1.0];
        let points = [(0.4, c, 0.0), (0.4, c, 3.0), (0.6, c, 3.0), (0.6, c, 0.0)].map(|(v, c, k)| (v, c, k / 3.0));
        let shell = integral(&points, OpacityRule::Extinction);
        // v = 4u(1 − u): between 0.4 and 0.6 for u = ½ ∓ ½√(1 − v).
        let inside = 0.6f64.sqrt() - 0.4f64.sqrt();
        let alpha = -libm::expm1(-inside * 7.0);
        assert_close(shell.step(Cubic::parabola(0.0, 1.0, 0.0), 7.0), [0.5 * alpha, 0.25 * alpha, alpha, alpha]);
    }

    #[test]
    fn a_wall_is_entered_or_not() {
        let t = integral(&[(0.0, [0.5; 3], 0.0), (255.0, [1.0; 3], 1.0)], OpacityRule::Power);
        // Up to a rounding above 255, where the wall begins that has no end; and well into it.
        let touched = t.step(Cubic::line(250.0, 255.0f64.next_up()), 1e-3);
        assert!(touched[3] < 0.01, "{touched:?}");
        assert_eq!(t.step(Cubic::line(250.0, 256.0), 1e-3)[3], 1.0);
        assert_eq!(t.step(Cubic::line(300.0, 256.0), 1e-3), [1.0; 4]);
        assert!(
            t.wall_is_near(200.0, 255.0, 3.0)
                && !t.wall_is_near(200.0, 250.0, 3.0)
                && !t.wall_is_near(250.0, 256.0, 3.0)
        );
    }

    #[test]
    fn colour_and_extinction_that_change_together() {
        // Against 2·10⁵ homogeneous steps.
        let t = integral(
            &[(0.0, [0.1, 0.9, 0.4], 0.05), (0.5, [0.8, 0.1, 0.3], 0.9), (1.0, [0.2, 1.0, 0.9], 0.999)],
            OpacityRule::Power,
        );
        let value = Cubic([0.1, 2.9, -4.5, 2.4]);
        let n = 200_000;
        let mut sum = [0.0; 4];
        for i in 0..n {
            let step = t.transfer.step(value.at((f64::from(i) + 0.5) / f64::from(n)), 1.7 / f64::from(n));
            let clear = 1.0 - sum[3];
            for c in 0..4 {
                sum[c] += clear * step[c];
            }
        }
        let got = t.step(value, 1.7);
        assert!((0..4).all(|c| (got[c] - sum[c]).abs() < 1e-9), "{got:?} {sum:?}");
    }
}
