//! What a study of speed against error should try.

use vr_core::{Filter, NamedSetting};

use crate::caster::{RayCaster, Rule, Step};
use crate::options::to_options;

/// Rounding of f32 kernels, table and early termination together, on smooth scenes.
const FLOOR_F32: f64 = 3e-4;
/// Rounding of f64 sums.
const FLOOR_F64: f64 = 1e-12;

/// Steps for both rules; the default step for every filter; and the f64 instance, which shows what the floor is made of.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let default = RayCaster::default;
    let steps = |rule, steps: &[f64]| {
        steps.iter().map(|&step| RayCaster { step: Step::Uniform(step), rule, ..default() }).collect::<Vec<_>>()
    };
    let midpoint = steps(Rule::Midpoint, &[4.0, 2.0, 1.0, 0.5, 0.2, 0.1]);
    let left = steps(Rule::Left, &[1.0, 0.2]);
    let filters = Filter::ALL.map(|filter| RayCaster { filter: Some(filter), ..default() });
    let exact = [1.0, 0.2].map(RayCaster::exact);
    let named = |prefix: &'static str, floor: f64| {
        move |caster: RayCaster| {
            let step = caster.step.fine();
            let name = match caster.filter {
                Some(filter) => format!("{prefix} {filter} {step}"),
                None => format!("{prefix} {step}"),
            };
            // A field that jumps, as the nearest sample's does, leaves order 1 to every rule.
            let order = match (caster.rule, caster.filter) {
                (Rule::Left, _) | (_, Some(Filter::Nearest)) => 1.0,
                (Rule::Midpoint, _) => 2.0,
            };
            NamedSetting { name, options: to_options(&caster), order: Some(order), error_floor: floor }
        }
    };
    midpoint
        .into_iter()
        .chain(filters)
        .map(named("midpoint", FLOOR_F32))
        .chain(left.into_iter().map(named("left", FLOOR_F32)))
        .chain(exact.into_iter().map(named("midpoint f64", FLOOR_F64)))
        .collect()
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
