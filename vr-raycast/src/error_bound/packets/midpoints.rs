//! Truth that the tests of steps and stretches compare with.

use crate::error_bound::optics::Optics;

/// Returns light and opacity along a way of a length by so many midpoints, in f64: `f` is the field by the distance.
pub(super) fn exact(optics: &Optics, f: impl Fn(f64) -> f64, length: f64, count: usize) -> [f64; 4] {
    let (mut light, mut clear) = ([0.0; 3], 1.0);
    for i in 0..count {
        let (rate, color) = optics.exactly(f((i as f64 + 0.5) / count as f64 * length));
        let alpha = -libm::expm1(-rate * length / count as f64);
        for c in 0..3 {
            light[c] += clear * alpha * color[c];
        }
        clear *= 1.0 - alpha;
    }
    let [r, g, b] = light;
    [r, g, b, 1.0 - clear]
}
