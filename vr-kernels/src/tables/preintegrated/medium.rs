//! Emission and extinction at a value of a segment, and their means over a range of it.

use vr_core::transfer::{OpacityRule, Segment, TransferFunction};

/// κ per unit distance that rows hold where it is infinite: over a quarter of a unit distance, nothing (10⁻⁷) comes through.
pub const WALL_DEPTH: f64 = 64.0;

/// (q, κ) at a value, with the line of a given segment: κ = +∞ where α only touches 1, and a wall's stand-in where it stays there.
pub(super) fn properties(transfer: &TransferFunction, segment: &Segment, value: f64) -> [f64; 4] {
    let o = segment.at(value);
    let wall = is_wall(transfer, segment);
    let kappa = if wall { WALL_DEPTH / transfer.unit_distance() } else { transfer.extinction(o.opacity) };
    // κ·0 is no light, however large κ.
    let of_color = |c: f64| if c == 0.0 { 0.0 } else { kappa * c };
    let [r, g, b] = if transfer.has_emission() { o.emission } else { o.color.map(of_color) };
    [r, g, b, kappa]
}

/// True if α is 1 throughout a segment, and κ infinite.
pub(super) fn is_wall(transfer: &TransferFunction, segment: &Segment) -> bool {
    transfer.rule() == OpacityRule::Power && segment.is_opaque()
}

/// The mean of (q, κ) over the values from `a` to `b` of one segment.
pub(super) fn mean_of(transfer: &TransferFunction, segment: &Segment, a: f64, b: f64) -> [f64; 4] {
    if transfer.rule() == OpacityRule::Extinction || is_wall(transfer, segment) {
        // κ and c are linear, their product a parabola: Simpson's rule is exact.
        let [start, middle, end] = [a, 0.5 * (a + b), b].map(|v| properties(transfer, segment, v));
        return std::array::from_fn(|c| (start[c] + 4.0 * middle[c] + end[c]) / 6.0);
    }
    let clear = [a, b].map(|v| 1.0 - segment.at(v).opacity);
    if clear[0].min(clear[1]) > 0.5 * clear[0].max(clear[1]) {
        return gauss_mean(|v| properties(transfer, segment, v), a, b);
    }
    // Towards α = 1 the logarithm bends too much for any quadrature. With w = 1 − α, linear in the value like the colour c:
    // ∫ −ln w dw = w (1 − ln w), ∫ −w ln w dw = w² (1 − 2 ln w)/4.
    let (low, high) = if clear[0] <= clear[1] { (a, b) } else { (b, a) };
    let w = [clear[0].min(clear[1]), clear[0].max(clear[1])];
    let ln = w.map(|w| if w > 0.0 { libm::log(w) } else { 0.0 });
    let span = w[1] - w[0];
    let per_unit = 1.0 / (transfer.unit_distance() * span);
    let zeroth = (w[1] * (1.0 - ln[1]) - w[0] * (1.0 - ln[0])) * per_unit;
    let first = 0.25 * (w[1] * w[1] * (1.0 - 2.0 * ln[1]) - w[0] * w[0] * (1.0 - 2.0 * ln[0])) * per_unit;
    let (start, end) = (segment.at(low), segment.at(high));
    let light = |c: usize| {
        if transfer.has_emission() {
            return 0.5 * (start.emission[c] + end.emission[c]);
        }
        let slope = (end.color[c] - start.color[c]) / span;
        (start.color[c] - slope * w[0]) * zeroth + slope * first
    };
    [light(0), light(1), light(2), zeroth]
}

/// The mean of a function whose nearest singularity is as far from the interval's middle as 1.5 intervals: Gauss and Legendre's
/// rule with 8 points misses less than 10⁻¹² of it.
fn gauss_mean(f: impl Fn(f64) -> [f64; 4], a: f64, b: f64) -> [f64; 4] {
    const NODES: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_3),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut sum = [0.0; 4];
    for (x, weight) in NODES {
        let (below, above) = (f(middle - half * x), f(middle + half * x));
        for c in 0..4 {
            sum[c] += 0.5 * weight * (below[c] + above[c]);
        }
    }
    sum
}
