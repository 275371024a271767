//! Steps through a medium that follows the magnitude of the gradient, one by one in f64.

use vr_core::{Shading, TransferFunction};

/// Light and opacity of a homogeneous step, `length` world units long, before it reflects, where the field has a value and its gradient a magnitude: the
/// mixture of a transfer function's rows, or its extinction times the factor of a shading.
pub fn step_by_gradient(
    transfer: &TransferFunction,
    shading: &Shading,
    [value, magnitude]: [f64; 2],
    length: f64,
) -> [f64; 4] {
    if transfer.has_rows() {
        return transfer.mixture(value, magnitude).step(length);
    }
    step_with_extinction_times(transfer, value, length, shading.modulation(magnitude))
}

/// Light and opacity of a homogeneous step, `length` world units long, at a value, with the extinction there times a factor.
///
/// κ times a factor over a length is κ over that length times the factor; emission given on its own must not be multiplied along.
pub fn step_with_extinction_times(transfer: &TransferFunction, value: f64, length: f64, factor: f64) -> [f64; 4] {
    let emits = transfer.has_emission();
    if factor == 0.0 {
        let [r, g, b] = if emits { transfer.at(value).emission.map(|q| q * length) } else { [0.0; 3] };
        return [r, g, b, 0.0];
    }
    let [r, g, b, alpha] = transfer.step(value, length * factor);
    let share = if emits { 1.0 / factor } else { 1.0 };
    [r * share, g * share, b * share, alpha]
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{ControlPoint, OpacityRule};

    /// α = 1 − e^(−fκh), and light c·α or q·α/(fκ): q·h where nothing absorbs.
    #[test]
    fn a_factor_thins_what_absorbs_and_not_what_shines() {
        let (kappa, q, length) = (0.7, 0.3, 1.5);
        let point = |emission: Option<[f64; 3]>| ControlPoint { emission, ..ControlPoint::new(0.0, [0.25; 3], kappa) };
        for emission in [None, Some([q; 3])] {
            let transfer = TransferFunction::new(vec![point(emission)], OpacityRule::Extinction, 1.0).unwrap();
            for factor in [0.0, 1e-9, 0.5, 3.0] {
                let tau = kappa * factor * length;
                let alpha = -libm::expm1(-tau);
                let light = match emission {
                    None => 0.25 * alpha,
                    Some(_) if tau == 0.0 => q * length,
                    Some(_) => q * length * alpha / tau,
                };
                let found = step_with_extinction_times(&transfer, 0.0, length, factor);
                assert!((found[3] - alpha).abs() < 1e-15 && (found[0] - light).abs() < 1e-15, "{factor}: {found:?}");
                let shading = Shading { gradient_opacity: vec![(1.0, factor)], ..Shading::default() };
                assert_eq!(step_by_gradient(&transfer, &shading, [0.0, 9.0], length), found);
            }
        }
    }
}
