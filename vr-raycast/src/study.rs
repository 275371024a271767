//! Documented properties of the caster, for a study of speed against error.

use vr_core::{ConvergenceClaim, ConvergenceOrders, Documented, Filter, HardCaseErrors, NamedSetting};

use crate::caster::{ImageSampling, RayCaster, Rule, Step, Traversal};
use crate::options::STEP;

/// Error of f32 kernels, table and early termination together, on smooth scenes.
const FLOOR_F32: f64 = 3e-4;
/// Error of f64 sums.
const FLOOR_F64: f64 = 1e-12;
/// Rounding of frames, which are f32 whatever kernels are.
const FLOOR_OF_FRAMES: f64 = 3e-7;

impl Documented for RayCaster {
    /// Steps of one length under every rule; steps that follow the data, and screens that leave rays out, from coarse to fine; error bounds;
    /// every filter; and the f64 instance, which shows what the floor is made of.
    fn settings(&self) -> Vec<NamedSetting> {
        let named = |name: String, caster: &Self| NamedSetting::new(name, caster, None, FLOOR_F32);
        let converging =
            |name: String, caster: &Self| NamedSetting { order: Some(orders(caster).smooth), ..named(name, caster) };
        let uniform = |rule: Rule, steps: &[f64]| -> Vec<NamedSetting> {
            let caster = |step| Self { rule, ..Self::uniform(step) };
            steps.iter().map(|&step| converging(format!("{} {step}", rule.name()), &caster(step))).collect()
        };
        let mut all = uniform(Rule::Midpoint, &[4.0, 2.0, 1.0, 0.5, 0.2, 0.1]);

        let local =
            |error| Self { step: Step::Local { error }, image_sampling: ImageSampling::EveryPixel, ..Self::default() };
        all.extend([2e-2, 6e-3, 2e-3, 1e-3, 5e-4, 1e-4].map(|e| named(format!("local {e}"), &local(e))));
        let adaptive = |caster, threshold| Self { image_sampling: ImageSampling::Adaptive { threshold }, ..caster };
        all.extend([(2e-2, 0.3), (6e-3, 0.16), (2e-3, 0.08), (5e-4, 0.05)].map(|(error, threshold)| {
            named(format!("local {error} adaptive {threshold}"), &adaptive(local(error), threshold))
        }));
        all.extend([(1.0, 0.16), (0.5, 0.08)].map(|(step, threshold)| {
            named(format!("midpoint {step} adaptive {threshold}"), &adaptive(Self::uniform(step), threshold))
        }));
        all.extend([1.0 / 255.0, 1e-3, 1e-4].map(|error| {
            let caster = Self { step: Step::ErrorBound(error), ..Self::default() };
            NamedSetting { error_floor: 1e-6, ..named(format!("promised {error:.0e}"), &caster) }
        }));

        for (rule, steps) in
            [(Rule::Linear, &[2.0, 1.0, 0.5][..]), (Rule::Quadratic, &[2.0, 1.0, 0.5]), (Rule::Left, &[0.5])]
        {
            all.extend(uniform(rule, steps));
        }
        let exact_cells = Self { rule: Rule::Exact, traversal: Traversal::Cells, ..Self::default() };
        all.push(named("exact cells".to_owned(), &exact_cells));

        #[cfg(feature = "classics")]
        all.extend(crate::classics::options::settings().map(|(name, caster)| named(name, &caster)));
        all.extend(Filter::ALL.into_iter().filter(|&f| f != Filter::Trilinear).map(|filter| {
            converging(format!("midpoint {filter} 0.5"), &Self { filter: Some(filter), ..Self::uniform(0.5) })
        }));
        let f64_instance = converging("midpoint f64 0.2".to_owned(), &Self::exact(0.2));
        all.push(NamedSetting { error_floor: FLOOR_F64, ..f64_instance });
        all
    }

    /// Returns the claims of the orders of rules and of filters, as the instances in f64 show them.
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        let claim =
            |name: &str, caster: Self| ConvergenceClaim::new(name, &caster, STEP, FLOOR_OF_FRAMES, orders(&caster));
        let ruled = |rule| Self { rule, ..Self::exact(1.0) };
        let filtered = |filter| Self { filter: Some(filter), ..Self::exact(1.0) };
        vec![
            claim("midpoint", ruled(Rule::Midpoint)),
            claim("left", ruled(Rule::Left)),
            claim("linear", ruled(Rule::Linear)),
            claim("quadratic", ruled(Rule::Quadratic)),
            claim("quadratic in cells", Self { traversal: Traversal::Cells, ..ruled(Rule::Quadratic) }),
            claim("midpoint bspline", filtered(Filter::BSpline)),
            claim("midpoint nearest", filtered(Filter::Nearest)),
        ]
    }

    fn hard_case_errors(&self) -> HardCaseErrors {
        self.documented_errors()
    }
}

/// Orders of convergence of uniform steps.
fn orders(caster: &RayCaster) -> ConvergenceOrders {
    let (smooth, jumps): (f64, f64) = match (caster.rule, caster.traversal) {
        // A field that jumps, as the nearest sample's does, leaves order 1 to every rule.
        _ if caster.filter == Some(Filter::Nearest) => (1.0, 1.0),
        (Rule::Left, _) => (1.0, 1.0),
        (Rule::Auto | Rule::Midpoint, _) => (2.0, 1.0),
        (Rule::Quadratic, Traversal::Cells) => (4.0, 3.0),
        // The kinks of a trilinear field at cell faces leave no rule a higher order.
        (Rule::Linear | Rule::Quadratic | Rule::Exact, _) => (2.0, 2.0),
    };
    // Errors of the nearest sample have either sign, and even out along a ray: more than the 1 of each of them. The samples of a
    // trilinear field have order 2 themselves.
    let grid = if caster.filter == Some(Filter::Nearest) { 1.75 } else { smooth.min(2.0) };
    // A midpoint of pixels has no more.
    ConvergenceOrders { smooth, jumps, grid, pixels: 2.0 }
}

#[cfg(test)]
mod tests {
    use vr_core::{Configurable, OptionValue};
    use vr_physics::check::documents_what_can_be_set;

    use super::*;

    #[test]
    fn what_is_documented_can_be_set() {
        documents_what_can_be_set(&RayCaster::default(), 2).unwrap();
    }

    #[test]
    fn what_is_claimed_is_of_uniform_steps_in_f64() {
        for claim in RayCaster::default().convergence() {
            let set = claim.options.clone().with(claim.key, 0.25);
            assert_eq!(RayCaster::default().configure(&set).unwrap().step, Step::Uniform(0.25), "{}", claim.name);
            assert_eq!(claim.options.0["precision"], OptionValue::from("f64"));
        }
    }
}
