//! Random filters, shadings and compositing schemes.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{Compositing, Filter, GradientMethod, Light, Shading};

/// Any filter, trilinear as often as not.
pub fn filter() -> impl Strategy<Value = Filter> {
    prop_oneof![
        4 => Just(Filter::Trilinear),
        1 => Just(Filter::Nearest),
        1 => Just(Filter::BSpline),
        1 => Just(Filter::CatmullRom),
        1 => Just(Filter::Gaussian),
    ]
}

/// Reflection of light, and the lights.
pub type Lit = (Shading, Vec<Light>);

/// Usually none; any coefficients, up to two lights and a headlight, either gradient.
pub fn shading() -> impl Strategy<Value = Option<Lit>> {
    let direction = [-1.0..1.0, -1.0..1.0, 0.1..1.0];
    let light = (proptest::option::of(direction), [0.0..1.0, 0.0..1.0, 0.0..1.0])
        .prop_map(|(direction, color)| Light { direction: direction.map(DVec3::from), color });
    let gradient = prop_oneof![Just(GradientMethod::CentralDifferences), Just(GradientMethod::Analytic)];
    let shading = (0.0..1.0, 0.0..1.0, prop_oneof![Just(0.0), 0.0..1.0], 1.0..50.0, vec(light, 0..=2), gradient)
        .prop_map(reflecting);
    proptest::option::weighted(0.25, shading)
}

/// A headlight or one to three lights of any colour, either gradient.
pub(super) fn lit() -> impl Strategy<Value = Lit> {
    let direction = [-1.0..1.0, -1.0..1.0, 0.1..1.0];
    let light = (proptest::option::weighted(0.7, direction), [0.0..1.0, 0.0..1.0, 0.0..1.0])
        .prop_map(|(direction, color)| Light { direction: direction.map(DVec3::from), color });
    let gradient = prop_oneof![3 => Just(GradientMethod::CentralDifferences), 1 => Just(GradientMethod::Analytic)];
    (0.0..0.5, 0.2..1.0, prop_oneof![Just(0.0), 0.0..0.5], 1.0..20.0, vec(light, 1..=3), gradient).prop_map(reflecting)
}

fn reflecting(
    (ambient, diffuse, specular, power, lights, gradient): (f64, f64, f64, f64, Vec<Light>, GradientMethod),
) -> Lit {
    (Shading { ambient, diffuse, specular, power, gradient, gradient_opacity: Vec::new() }, lights)
}

/// Factors on κ, at fractions of the steepest slope that there can be: rising, falling, one that is 0 in the middle.
pub(super) fn modulation() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let factor = || prop_oneof![1 => Just(0.0), 1 => Just(1.0), 2 => 0.0..2.0];
    vec((0.02..0.4, factor()), 1..=3).prop_map(|points| {
        let mut magnitude = 0.0;
        let mut place = |&(gap, factor): &(f64, f64)| {
            let at = magnitude;
            magnitude += gap;
            (at, factor)
        };
        points.iter().map(&mut place).collect()
    })
}

/// A compositing scheme, with its threshold as a fraction of the range of values.
pub(super) fn scheme() -> impl Strategy<Value = Compositing> {
    prop_oneof![
        6 => tame_compositing(),
        1 => (0.0..1.0).prop_map(|threshold| Compositing::First { threshold }),
    ]
}

/// Any compositing scheme; the threshold of `first` lies between the given values.
pub fn compositing(range: (f64, f64)) -> impl Strategy<Value = Compositing> {
    scheme().prop_map(move |c| stretched(c, range))
}

pub(super) fn stretched(compositing: Compositing, (low, high): (f64, f64)) -> Compositing {
    match compositing {
        Compositing::First { threshold } => Compositing::First { threshold: low + threshold * (high - low) },
        other => other,
    }
}

/// Any compositing scheme but `first`, where rounding decides whether a ray that grazes the surface hits it.
pub fn tame_compositing() -> impl Strategy<Value = Compositing> {
    prop_oneof![
        6 => Just(Compositing::Over),
        1 => Just(Compositing::Average),
        1 => Just(Compositing::Maximum),
        1 => Just(Compositing::Minimum),
        1 => (0.05..=1.0).prop_map(|level| Compositing::Accumulate { level }),
    ]
}
