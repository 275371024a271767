//! The settings as named options, both ways.

use std::sync::LazyLock;

use vr_core::{Filter, OptionError, OptionKind, OptionSpec, OptionValue, Options};

use crate::caster::{Classification, Order, Precision, RayCaster, Rule, Step};

const UNIFORM: &str = "uniform";
const HOMOGENEOUS: &str = "homogeneous";
const TOLERANCE: &str = "tolerance";
const SCENE_FILTER: &str = "scene";
const FILTERS: &[&str] = &[SCENE_FILTER, "nearest", "trilinear", "bspline", "catmull-rom", "gaussian"];
const RULES: &[(&str, Rule)] = &[("midpoint", Rule::Midpoint), ("left", Rule::Left)];
const FRONT_TO_BACK: &str = "front-to-back";
const BACK_TO_FRONT: &str = "back-to-front";
const CLASSIFICATIONS: &[(&str, Classification)] =
    &[("table", Classification::Table), ("exact", Classification::Exact)];
const PRECISIONS: &[(&str, Precision)] = &[("f32", Precision::F32), ("f64", Precision::F64)];

/// The errors where steps are chosen by one and none is given: what cannot be seen in 8 bits, and a quarter of it.
const MAX_ERROR: f64 = 4e-3;
const HOMOGENEITY: f64 = 1e-3;

/// Every option, with the default caster's values.
pub(crate) static SPECS: LazyLock<Vec<OptionSpec>> = LazyLock::new(|| {
    let defaults = to_options(&RayCaster::default());
    let spec = |key, kind, help| OptionSpec { key, kind, default: defaults.0[key].clone(), help };
    let number = |key, most, default, help| {
        OptionSpec { key, kind: OptionKind::Number { above: 0.0, most }, default: OptionValue::Number(default), help }
    };
    vec![
        spec(
            "steps",
            OptionKind::Choice(&[UNIFORM, HOMOGENEOUS, TOLERANCE]),
            "how long steps are: all alike; long where the medium is nearly the same; or as max-error asks for",
        ),
        number("homogeneity", 1.0, HOMOGENEITY, "largest error that all long steps of a ray together may make (steps=homogeneous)"),
        number("max-error", 1.0, MAX_ERROR, "the picture's largest error, promised (steps=tolerance); 1e-6 at the least"),
        spec(
            "step",
            OptionKind::Number { above: 0.0, most: RayCaster::LONGEST_STEP },
            "distance between samples, as a fraction of the smallest voxel edge",
        ),
        spec(
            "rule",
            OptionKind::Choice(&["midpoint", "left"]),
            "where in its step a sample is taken: midpoint has order 2, left has order 1",
        ),
        spec(
            "order",
            OptionKind::Choice(&[FRONT_TO_BACK, BACK_TO_FRONT]),
            "from which end samples are composited; back-to-front is for over alone",
        ),
        spec("filter", OptionKind::Choice(FILTERS), "reconstruction filter; scene: the one that the scene names"),
        spec(
            "classification",
            OptionKind::Choice(&["table", "exact"]),
            "how a value becomes light and opacity: looked up, or evaluated at every sample",
        ),
        spec("precision", OptionKind::Choice(&["f32", "f64"]), "precision of the kernels"),
        spec(
            "termination",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "opacity at which a ray ends (1: only where opaque); changes no pixel by more than 1 - termination",
        ),
    ]
});

/// All options that say what this caster is.
pub(crate) fn to_options(caster: &RayCaster) -> Options {
    let options = match caster.step {
        Step::Uniform(step) => Options::new().with("steps", UNIFORM).with("step", step),
        Step::Homogeneous { step, error } => {
            Options::new().with("steps", HOMOGENEOUS).with("step", step).with("homogeneity", error)
        }
        Step::Tolerance(error) => Options::new().with("steps", TOLERANCE).with("max-error", error),
    };
    let options = options
        .with("rule", word_of(RULES, caster.rule))
        .with("filter", caster.filter.map_or(SCENE_FILTER, Filter::name))
        .with("classification", word_of(CLASSIFICATIONS, caster.classification))
        .with("precision", word_of(PRECISIONS, caster.precision));
    match caster.order {
        Order::FrontToBack { termination } => options.with("order", FRONT_TO_BACK).with("termination", termination),
        Order::BackToFront => options.with("order", BACK_TO_FRONT),
    }
}

/// A caster with options set.
pub(crate) fn configure(caster: &RayCaster, options: &Options) -> Result<RayCaster, OptionError> {
    let mut new = RayCaster { step: step_of(caster.step, options)?, ..caster.clone() };
    // In the order of the list: `order` is set before `termination`.
    for (key, value) in options.check(RayCaster::NAME, &SPECS)? {
        match (key, value) {
            // All four together are `step_of`.
            ("steps" | "step" | "homogeneity" | "max-error", _) => {}
            ("rule", OptionValue::Word(w)) => new.rule = meaning_of(RULES, w),
            ("order", OptionValue::Word(w)) => {
                new.order = match (w.as_str(), new.order) {
                    (BACK_TO_FRONT, _) => Order::BackToFront,
                    (_, Order::BackToFront) => Order::default(),
                    (_, front_to_back) => front_to_back,
                }
            }
            ("filter", OptionValue::Word(w)) => new.filter = Filter::from_name(w),
            ("classification", OptionValue::Word(w)) => new.classification = meaning_of(CLASSIFICATIONS, w),
            ("precision", OptionValue::Word(w)) => new.precision = meaning_of(PRECISIONS, w),
            ("termination", OptionValue::Number(x)) => {
                let Order::FrontToBack { termination } = &mut new.order else {
                    return Err(OptionError::Value {
                        renderer: RayCaster::NAME,
                        key: key.to_owned(),
                        found: x.to_string(),
                        allowed: "back to front, no ray can end early: must be absent".to_owned(),
                    });
                };
                *termination = *x;
            }
            _ => unreachable!("checked against the list"),
        }
    }
    Ok(new)
}

/// The steps that the options ask for. One that belongs to a kind of steps chooses that kind, unless `steps` says otherwise.
fn step_of(old: Step, options: &Options) -> Result<Step, OptionError> {
    options.check(RayCaster::NAME, &SPECS)?;
    let number = |key: &str| match options.0.get(key) {
        Some(OptionValue::Number(x)) => Some(*x),
        _ => None,
    };
    let (step, homogeneity, max_error) = (number("step"), number("homogeneity"), number("max-error"));
    let kind = match (options.0.get("steps"), old) {
        (Some(OptionValue::Word(word)), _) => word.as_str(),
        _ if max_error.is_some() => TOLERANCE,
        _ if homogeneity.is_some() => HOMOGENEOUS,
        (_, Step::Uniform(_)) => UNIFORM,
        (_, Step::Homogeneous { .. }) => HOMOGENEOUS,
        (_, Step::Tolerance(_)) if step.is_some() => UNIFORM,
        (_, Step::Tolerance(_)) => TOLERANCE,
    };
    let (given, out_of_place): (_, &[(&str, Option<f64>)]) = match kind {
        HOMOGENEOUS => (HOMOGENEOUS, &[("max-error", max_error)]),
        TOLERANCE => (TOLERANCE, &[("step", step), ("homogeneity", homogeneity)]),
        _ => (UNIFORM, &[("homogeneity", homogeneity), ("max-error", max_error)]),
    };
    if let Some((key, Some(x))) = out_of_place.iter().find(|(_, x)| x.is_some()) {
        return Err(OptionError::Value {
            renderer: RayCaster::NAME,
            key: (*key).to_owned(),
            found: x.to_string(),
            allowed: format!("steps are '{given}': must be absent"),
        });
    }
    let voxels = step.unwrap_or(match (old, Step::default()) {
        (Step::Uniform(step) | Step::Homogeneous { step, .. }, _) | (_, Step::Uniform(step)) => step,
        _ => unreachable!("the default is uniform"),
    });
    Ok(match (given, old) {
        (HOMOGENEOUS, Step::Homogeneous { error, .. }) => {
            Step::Homogeneous { step: voxels, error: homogeneity.unwrap_or(error) }
        }
        (HOMOGENEOUS, _) => Step::Homogeneous { step: voxels, error: homogeneity.unwrap_or(HOMOGENEITY) },
        (TOLERANCE, Step::Tolerance(error)) => Step::Tolerance(max_error.unwrap_or(error)),
        (TOLERANCE, _) => Step::Tolerance(max_error.unwrap_or(MAX_ERROR)),
        _ => Step::Uniform(voxels),
    })
}

fn word_of<T: PartialEq>(words: &[(&'static str, T)], meaning: T) -> &'static str {
    words.iter().find(|(_, m)| *m == meaning).expect("every meaning has a word").0
}

fn meaning_of<T: Copy>(words: &[(&'static str, T)], word: &str) -> T {
    words.iter().find(|(w, _)| *w == word).expect("checked against the list").1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_caster_survives_the_way_through_options() {
        let casters = [
            RayCaster::default(),
            RayCaster::exact(0.125),
            RayCaster { order: Order::BackToFront, rule: Rule::Left, ..RayCaster::default() },
            RayCaster { filter: Some(Filter::CatmullRom), ..RayCaster::default() },
            RayCaster { step: Step::Tolerance(1e-5), ..RayCaster::default() },
            RayCaster { step: Step::Homogeneous { step: 0.5, error: 0.02 }, ..RayCaster::default() },
        ];
        for from in &casters {
            for to in &casters {
                assert_eq!(configure(from, &to_options(to)).unwrap(), *to);
            }
            assert_eq!(configure(from, &Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn termination_back_to_front_is_an_error() {
        let options = Options::new().with("order", BACK_TO_FRONT).with("termination", 0.9);
        let error = configure(&RayCaster::default(), &options).unwrap_err().to_string();
        assert!(error.contains("termination") && error.contains("back to front"), "{error}");
    }

    #[test]
    fn numbers_of_other_kinds_of_steps_are_errors() {
        for (steps, key) in [(UNIFORM, "max-error"), (HOMOGENEOUS, "max-error"), (TOLERANCE, "step"), (UNIFORM, "homogeneity")] {
            let options = Options::new().with("steps", steps).with(key, 0.5);
            let error = configure(&RayCaster::default(), &options).unwrap_err().to_string();
            assert!(error.contains(key) && error.contains(steps), "{error}");
        }
    }

    #[test]
    fn the_lists_name_what_the_options_take() {
        for filter in Filter::ALL {
            assert!(FILTERS.contains(&filter.name()), "{filter}");
        }
        assert_eq!(SPECS.iter().filter(|s| matches!(s.kind, OptionKind::Choice(w) if w.is_empty())).count(), 0);
        for spec in SPECS.iter() {
            let set = Options([(spec.key.to_owned(), spec.default.clone())].into());
            // Those that choose another kind of steps.
            let step = match spec.key {
                "homogeneity" => Step::Homogeneous { step: 0.2, error: HOMOGENEITY },
                "max-error" => Step::Tolerance(MAX_ERROR),
                _ => Step::default(),
            };
            let want = RayCaster { step, ..RayCaster::default() };
            assert_eq!(configure(&RayCaster::default(), &set).unwrap(), want, "{}", spec.key);
        }
    }
}
