//! What a study of speed against error should try.

use vr_core::{Filter, NamedSetting};

use crate::caster::{RayCaster, Rule, Step};
use crate::options::to_options;

/// Rounding of f32 kernels, table and early termination together, on smooth scenes.
const FLOOR_F32: f64 = 3e-4;
/// Rounding of f64 sums.
const FLOOR_F64: f64 = 1e-12;

/// Steps for both rules; steps that follow the data; the default step for every filter; and the f64 instance, which shows what the
/// floor is made of.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let default = RayCaster::default;
    let named = |name: String, caster: RayCaster, order: Option<f64>, error_floor: f64| NamedSetting {
        name,
        options: to_options(&caster),
        order,
        error_floor,
    };
    let uniform = |rule: Rule, word: &str, order: f64, steps: &[f64]| -> Vec<NamedSetting> {
        let caster = |step| RayCaster { step: Step::Uniform(step), rule, ..default() };
        steps.iter().map(|&step| named(format!("{word} {step}"), caster(step), Some(order), FLOOR_F32)).collect()
    };
    let local = [1e-2, 2e-3, 5e-4].map(|error| {
        named(format!("local {error}"), RayCaster { step: Step::Local { error }, ..default() }, None, FLOOR_F32)
    });
    let filters = Filter::ALL.map(|filter| {
        // A field that jumps, as the nearest sample's does, leaves order 1 to every rule.
        let order = if filter == Filter::Nearest { 1.0 } else { 2.0 };
        let caster = RayCaster { filter: Some(filter), step: Step::Uniform(0.2), ..default() };
        named(format!("midpoint {filter} 0.2"), caster, Some(order), FLOOR_F32)
    });
    let exact =
        [1.0, 0.2].map(|step| named(format!("midpoint f64 {step}"), RayCaster::exact(step), Some(2.0), FLOOR_F64));
    let mut all = uniform(Rule::Midpoint, "midpoint", 2.0, &[4.0, 2.0, 1.0, 0.5, 0.2, 0.1]);
    all.extend(local);
    all.extend(filters);
    // Of the trilinear field, whose kinks at cell faces leave no rule a higher order.
    all.extend(uniform(Rule::Linear, "linear", 2.0, &[4.0, 2.0, 1.0, 0.5]));
    all.extend(uniform(Rule::Quadratic, "quadratic", 2.0, &[4.0, 2.0, 1.0, 0.5]));
    all.extend(uniform(Rule::Left, "left", 1.0, &[1.0, 0.2]));
    all.extend(exact);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::configure;

    #[test]
    fn settings_are_distinct_and_can_be_set() {
        let all = settings();
        for (i, a) in all.iter().enumerate() {
            assert!(configure(&RayCaster::default(), &a.options).is_ok(), "{}", a.name);
            assert!(all[..i].iter().all(|b| b.name != a.name && b.options != a.options), "{}", a.name);
        }
    }
}
