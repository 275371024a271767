//! Bounds of what each model leaves out.

use vr_core::scattering::{Albedo, PhaseFunction, Scattering};

use super::{LightModel, SceneFacts};

/// The scattering of a scene that has none.
pub(super) const NO_SCATTERING: Scattering = Scattering {
    albedo: Albedo::Constant([0.0; 3]),
    phase: PhaseFunction::Isotropic,
    environment: [0.0; 3],
    environment_map: None,
    point_lights: Vec::new(),
    surfaces: Vec::new(),
};

/// Upper bound of the difference of any component of any pixel between a model and the whole equation.
pub(super) fn cost(model: LightModel, facts: &SceneFacts) -> f64 {
    let cover = facts.cover();
    // Surfaces light the medium and each other, in every order of scattering.
    if facts.has_surfaces && model != LightModel::MultipleScattering {
        return f64::INFINITY;
    }
    match model {
        LightModel::Vacuum => cover.max(facts.glow_seen() + orders_after(0, facts)),
        LightModel::Absorption => facts.glow_seen() + orders_after(0, facts),
        // ∫ q (1 − e^(−τ)) ds; with q ≤ χ·glow that is at most glow·(τ − 1 + e^(−τ)). The opacity is missing, too.
        LightModel::Emission => {
            let by_source = facts.glow * (facts.thickness_bound - cover);
            let by_length = facts.emission * facts.length * cover;
            let dimmed = if by_source.is_nan() { by_length } else { by_source.min(by_length) };
            cover.max(dimmed + orders_after(0, facts))
        }
        LightModel::EmissionAbsorption => orders_after(0, facts),
        LightModel::SingleScattering => orders_after(1, facts),
        LightModel::MultipleScattering => 0.0,
    }
}

/// Bound of the radiance of light that is scattered more than so many times, 0 or 1. The light of the medium itself, scattered once, counts as more than
/// once: the model of one scattering leaves it out.
fn orders_after(times: u32, facts: &SceneFacts) -> f64 {
    let cover = facts.cover();
    let (albedo, ratio) = (facts.albedo, facts.albedo * cover);
    if albedo == 0.0 || cover == 0.0 {
        return 0.0;
    }
    let own = albedo * facts.glow_seen();
    let first = if times == 0 { facts.lit + own } else { facts.lit * ratio + own };
    if first == 0.0 {
        return 0.0;
    }
    let series = cover * first / (1.0 - ratio);
    // Without lamps no radiance is above the brightest that comes in, or that of the medium in equilibrium with itself.
    series.min(facts.incoming.max(facts.thermal))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DARK: SceneFacts = SceneFacts {
        extinction: 1.0,
        thickness_bound: 2.0,
        thickness: 1.0,
        length: 2.0,
        albedo: 0.0,
        glow: 0.0,
        thermal: 0.0,
        emission: 0.0,
        lit: 0.0,
        incoming: 0.0,
        has_surfaces: false,
    };

    #[test]
    fn nothing_left_out_costs_nothing() {
        let of = |facts: &SceneFacts| LightModel::ALL.map(|model| cost(model, facts));
        let cover = 1.0 - (-2.0f64).exp();
        assert_eq!(of(&SceneFacts { thickness_bound: 0.0, ..DARK }), [0.0; 6]);
        let dark = of(&DARK);
        assert!((dark[0] - cover).abs() < 1e-15 && dark[1] == 0.0, "{dark:?}");
        let glowing = of(&SceneFacts { glow: 3.0, thermal: 3.0, emission: 3.0, ..DARK });
        assert!((glowing[1] - 3.0 * cover).abs() < 1e-12 && glowing[3] == 0.0, "{glowing:?}");
        assert!((glowing[2] - 3.0 * (2.0 - cover)).abs() < 1e-12);
    }

    #[test]
    fn light_of_surfaces_is_not_bounded() {
        let of = |facts: &SceneFacts| LightModel::ALL.map(|model| cost(model, facts));
        let [lower @ .., full] = of(&SceneFacts { has_surfaces: true, ..DARK });
        assert!(lower.iter().all(|cost| *cost == f64::INFINITY) && full == 0.0, "{lower:?}");
    }

    #[test]
    fn orders_of_scattering_fall() {
        let lamps = SceneFacts { albedo: 0.5, lit: 0.5, incoming: f64::INFINITY, ..DARK };
        let [none, once] = [LightModel::EmissionAbsorption, LightModel::SingleScattering].map(|m| cost(m, &lamps));
        let ratio = 0.5 * lamps.cover();
        assert!((once / none - ratio).abs() < 1e-12 && none < 1.0, "{none} {once}");
        // A white fog without end in the light of a sky is as bright as the sky at most.
        let sky = SceneFacts { albedo: 1.0, lit: 0.3, incoming: 0.3, thickness_bound: f64::INFINITY, ..DARK };
        assert_eq!(cost(LightModel::EmissionAbsorption, &sky), 0.3);
        // One that glows and hardly absorbs is, deep inside, as bright as if it scattered nothing: ten times its q/χ.
        let warm = SceneFacts { albedo: 0.9, glow: 0.1, thermal: 1.0, emission: 0.1, length: f64::INFINITY, ..sky };
        let warm = SceneFacts { incoming: 0.0, lit: 0.0, ..warm };
        let cost = cost(LightModel::EmissionAbsorption, &warm);
        assert!((cost - 0.9).abs() < 1e-12, "{cost}");
    }
}
