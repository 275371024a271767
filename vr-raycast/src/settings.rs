//! What a study of speed against error should try, and what the caster documents of convergence.

use vr_core::{Filter, NamedSetting, OrderClaim, Orders};

#[cfg(feature = "classics")]
use crate::caster::Connectivity;
use crate::caster::{RayCaster, Rule, Screen, Step, Traversal};
use crate::options::to_options;

/// Rounding of f32 kernels, table and early termination together, on smooth scenes.
const FLOOR_F32: f64 = 3e-4;
/// Rounding of f64 sums.
const FLOOR_F64: f64 = 1e-12;
/// Frames are f32, whatever kernels are.
const FLOOR_OF_FRAMES: f64 = 3e-7;

fn named(name: String, caster: &RayCaster, order: Option<f64>, error_floor: f64) -> NamedSetting {
    NamedSetting { name, options: to_options(caster), order, error_floor }
}

/// Steps of one length under every rule; steps that follow the data, and screens that leave rays out, from coarse to fine; promises;
/// every filter; and the f64 instance, which shows what the floor is made of.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let uniform = |rule: Rule, order: f64, steps: &[f64]| -> Vec<NamedSetting> {
        let caster = |step| RayCaster { rule, ..RayCaster::uniform(step) };
        let name = |step| format!("{} {step}", rule.name());
        steps.iter().map(|&step| named(name(step), &caster(step), Some(order), FLOOR_F32)).collect()
    };
    let mut all = uniform(Rule::Midpoint, 2.0, &[4.0, 2.0, 1.0, 0.5, 0.2, 0.1]);

    let local = |error| RayCaster { step: Step::Local { error }, ..RayCaster::default() };
    all.extend([2e-2, 6e-3, 2e-3, 5e-4, 1e-4].map(|e| named(format!("local {e}"), &local(e), None, FLOOR_F32)));
    let adaptive = |caster, threshold| RayCaster { screen: Screen::Adaptive { threshold }, ..caster };
    all.extend([(2e-2, 0.3), (6e-3, 0.16), (2e-3, 0.08), (5e-4, 0.05)].map(|(error, threshold)| {
        named(format!("local {error} adaptive {threshold}"), &adaptive(local(error), threshold), None, FLOOR_F32)
    }));
    all.extend([(1.0, 0.16), (0.5, 0.08)].map(|(step, threshold)| {
        let caster = adaptive(RayCaster::uniform(step), threshold);
        named(format!("midpoint {step} adaptive {threshold}"), &caster, None, FLOOR_F32)
    }));
    all.extend([1.0 / 255.0, 1e-3, 1e-4].map(|error| {
        let caster = RayCaster { step: Step::Tolerance(error), ..RayCaster::default() };
        named(format!("promised {error:.0e}"), &caster, None, 1e-6)
    }));

    // Of the trilinear field, whose kinks at cell faces leave no rule a higher order.
    all.extend(uniform(Rule::Linear, 2.0, &[2.0, 1.0, 0.5]));
    all.extend(uniform(Rule::Quadratic, 2.0, &[2.0, 1.0, 0.5]));
    all.extend(uniform(Rule::Left, 1.0, &[0.5]));
    all.push(named("exact cells".to_owned(), &exact_cells(), None, FLOOR_F32));

    #[cfg(feature = "classics")]
    let template = Screen::Template { connectivity: Connectivity::Continuous };
    #[cfg(feature = "classics")]
    for (word, screen) in [("coherent", Screen::Coherent), ("template", template)] {
        all.push(named(
            format!("midpoint 1 {word}"),
            &RayCaster { screen, ..RayCaster::uniform(1.0) },
            None,
            FLOOR_F32,
        ));
    }
    all.extend(Filter::ALL.into_iter().filter(|&f| f != Filter::Trilinear).map(|filter| {
        // A field that jumps, as the nearest sample's does, leaves order 1 to every rule.
        let order = if filter == Filter::Nearest { 1.0 } else { 2.0 };
        let caster = RayCaster { filter: Some(filter), ..RayCaster::uniform(0.5) };
        named(format!("midpoint {filter} 0.5"), &caster, Some(order), FLOOR_F32)
    }));
    all.push(named("midpoint f64 0.2".to_owned(), &RayCaster::exact(0.2), Some(2.0), FLOOR_F64));
    all
}

fn exact_cells() -> RayCaster {
    RayCaster { rule: Rule::Exact, traversal: Traversal::Cells, ..RayCaster::uniform(1.0) }
}

/// The orders of `rule`'s table, and of filters, as the instances in f64 show them.
pub(crate) fn orders() -> Vec<OrderClaim> {
    let claim = |name: &str, caster: RayCaster, smooth: f64, jumps: f64| {
        let mut options = to_options(&caster);
        options.0.remove("step");
        // The samples of a trilinear field have order 2 themselves; a midpoint of pixels has no more.
        let orders = Orders { smooth, jumps, grid: smooth.min(2.0), pixels: 2.0 };
        OrderClaim { name: name.to_owned(), options, key: "step", coarsest: 1.0, floor: FLOOR_OF_FRAMES, orders }
    };
    let ruled = |rule| RayCaster { rule, ..RayCaster::exact(1.0) };
    let in_cells = |rule| RayCaster { traversal: Traversal::Cells, ..ruled(rule) };
    let filtered = |filter| RayCaster { filter: Some(filter), ..RayCaster::exact(1.0) };
    vec![
        claim("midpoint", ruled(Rule::Midpoint), 2.0, 1.0),
        claim("left", ruled(Rule::Left), 1.0, 1.0),
        claim("linear", ruled(Rule::Linear), 2.0, 2.0),
        claim("quadratic", ruled(Rule::Quadratic), 2.0, 2.0),
        claim("quadratic in cells", in_cells(Rule::Quadratic), 4.0, 3.0),
        claim("midpoint bspline", filtered(Filter::BSpline), 2.0, 1.0),
        OrderClaim {
            // Errors of the nearest sample have either sign, and even out along a ray: more than the 1 of each of them.
            orders: Orders { smooth: 1.0, jumps: 1.0, grid: 1.75, pixels: 2.0 },
            ..claim("midpoint nearest", filtered(Filter::Nearest), 1.0, 1.0)
        },
    ]
}

#[cfg(test)]
mod tests {
    use vr_core::OptionValue;

    use super::*;
    use crate::options::configure;

    #[test]
    fn settings_are_distinct_and_can_be_set() {
        let all = settings();
        for (i, a) in all.iter().enumerate() {
            let caster = configure(&RayCaster::default(), &a.options).unwrap();
            assert!(caster.validate().is_ok(), "{}", a.name);
            assert!(all[..i].iter().all(|b| b.name != a.name && b.options != a.options), "{}", a.name);
        }
    }

    #[test]
    fn what_is_claimed_can_be_refined() {
        for claim in orders() {
            let at =
                |step: f64| configure(&RayCaster::default(), &claim.options.clone().with(claim.key, step)).unwrap();
            assert!(at(claim.coarsest).validate().is_ok(), "{}", claim.name);
            assert_eq!(at(0.25).step, Step::Uniform(0.25), "{}", claim.name);
            assert!(!claim.options.0.contains_key(claim.key));
            assert_eq!(claim.options.0["precision"], OptionValue::from("f64"));
        }
    }
}
