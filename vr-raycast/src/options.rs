//! The settings as named options, both ways.

use std::sync::LazyLock;

use vr_core::{Filter, OptionError, OptionKind, OptionSpec, OptionValue, Options, meaning_of, word_of};

#[cfg(feature = "classics")]
use crate::caster::Connectivity;
use crate::caster::{Classification, Leaping, Order, Precision, RayCaster, Rule, Screen, Traversal, Vector};
use crate::step_options;

const SCENE_FILTER: &str = "scene";
const FILTERS: &[&str] = &[SCENE_FILTER, "nearest", "trilinear", "bspline", "catmull-rom", "gaussian"];
const RULES: &[(&str, Rule)] = &[
    (Rule::Midpoint.name(), Rule::Midpoint),
    (Rule::Left.name(), Rule::Left),
    (Rule::Linear.name(), Rule::Linear),
    (Rule::Quadratic.name(), Rule::Quadratic),
    (Rule::Exact.name(), Rule::Exact),
];
const TRAVERSALS: &[(&str, Traversal)] = &[
    ("samples", Traversal::Samples),
    ("cells", Traversal::Cells),
    #[cfg(feature = "classics")]
    ("voxels", Traversal::Voxels),
];
const LEAPINGS: &[(&str, Leaping)] = &[
    ("auto", Leaping::Auto),
    ("none", Leaping::None),
    #[cfg(feature = "classics")]
    ("octree", Leaping::Octree),
    #[cfg(feature = "classics")]
    ("pyramid", Leaping::Pyramid),
    ("exact-cloud", Leaping::ExactCloud),
    #[cfg(feature = "classics")]
    ("chessboard-cloud", Leaping::ChessboardCloud),
    #[cfg(feature = "classics")]
    ("boxes", Leaping::Boxes),
    #[cfg(feature = "classics")]
    ("polyhedron", Leaping::Polyhedron),
];
const FRONT_TO_BACK: &str = "front-to-back";
const BACK_TO_FRONT: &str = "back-to-front";
const CLASSIFICATIONS: &[(&str, Classification)] =
    &[("table", Classification::Table), ("exact", Classification::Exact)];
const PRECISIONS: &[(&str, Precision)] = &[("f32", Precision::F32), ("f64", Precision::F64)];

const ADAPTIVE: &str = "adaptive";
/// Those without a number of their own.
const SCREENS: &[(&str, Screen)] = &[
    ("every-pixel", Screen::EveryPixel),
    #[cfg(feature = "classics")]
    ("coherent", Screen::Coherent),
    #[cfg(feature = "classics")]
    ("template-discrete", Screen::Template { connectivity: Connectivity::Discrete }),
    #[cfg(feature = "classics")]
    ("template-continuous", Screen::Template { connectivity: Connectivity::Continuous }),
];
/// What a refined picture may miss by default. Its RMSE is a twentieth of that or less: about what default steps are wrong by.
const THRESHOLD: f64 = 0.05;
const VECTORS: &[(&str, Vector)] =
    &[("auto", Vector::Auto), ("avx2", Vector::Avx2), ("baseline", Vector::Baseline), ("off", Vector::Off)];

/// Every option, with the default caster's values.
pub(crate) static SPECS: LazyLock<Vec<OptionSpec>> = LazyLock::new(|| {
    let defaults = to_options(&RayCaster::default());
    let spec = |key, kind, help| OptionSpec { key, kind, default: defaults.0[key].clone(), help };
    let others = [
        spec(
            "leaping",
            OptionKind::Choice(&[
                "auto",
                "none",
                #[cfg(feature = "classics")]
                "octree",
                #[cfg(feature = "classics")]
                "pyramid",
                "exact-cloud",
                #[cfg(feature = "classics")]
                "chessboard-cloud",
                #[cfg(feature = "classics")]
                "boxes",
                #[cfg(feature = "classics")]
                "polyhedron",
            ]),
            "how rays find out where nothing is visible; changes no pixel. But for auto, it goes with uniform steps, and all but none with the plain engine",
        ),
        spec(
            "rule",
            OptionKind::Choice(&["midpoint", "left", "linear", "quadratic", "exact"]),
            "how the light of a step is found: midpoint and linear have order 2, quadratic has 4, left has 1; exact needs cells",
        ),
        spec(
            "traversal",
            OptionKind::Choice(&[
                "samples",
                "cells",
                #[cfg(feature = "classics")]
                "voxels",
            ]),
            "what steps are: of one length, ending at cell faces, or from voxel to voxel",
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
            "vector",
            OptionKind::Choice(&["auto", "avx2", "baseline", "off"]),
            "widest instructions of the vector engine; off: the plain engine draws everything",
        ),
        spec(
            "termination",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "opacity at which a ray ends (1: only where opaque); changes no pixel by more than 1 - termination",
        ),
        spec(
            "screen",
            OptionKind::Choice(&[
                "every-pixel",
                ADAPTIVE,
                #[cfg(feature = "classics")]
                "coherent",
                #[cfg(feature = "classics")]
                "template-discrete",
                #[cfg(feature = "classics")]
                "template-continuous",
            ]),
            "which rays are cast: all, those where colours bend, from where the last view saw something, or by a template",
        ),
        OptionSpec {
            key: "screen-threshold",
            kind: OptionKind::Number { above: 0.0, most: 1.0 },
            default: OptionValue::Number(THRESHOLD),
            help: "adaptive screen: how far from the straight lines through its neighbours a colour may be where nothing is refined",
        },
    ];
    step_options::specs().into_iter().chain(others).collect()
});

/// All options that say what this caster is.
pub(crate) fn to_options(caster: &RayCaster) -> Options {
    let options = step_options::to_options(caster.step)
        .with("leaping", word_of(LEAPINGS, caster.leaping))
        .with("rule", word_of(RULES, caster.rule))
        .with("traversal", word_of(TRAVERSALS, caster.traversal))
        .with("filter", caster.filter.map_or(SCENE_FILTER, Filter::name))
        .with("classification", word_of(CLASSIFICATIONS, caster.classification))
        .with("precision", word_of(PRECISIONS, caster.precision))
        .with("vector", word_of(VECTORS, caster.vector));

    let options = match caster.screen {
        Screen::Adaptive { threshold } => options.with("screen", ADAPTIVE).with("screen-threshold", threshold),
        screen => options.with("screen", word_of(SCREENS, screen)),
    };
    match caster.order {
        Order::FrontToBack { termination } => options.with("order", FRONT_TO_BACK).with("termination", termination),
        Order::BackToFront => options.with("order", BACK_TO_FRONT),
    }
}

/// A caster with options set.
pub(crate) fn configure(caster: &RayCaster, options: &Options) -> Result<RayCaster, OptionError> {
    let set = options.check(RayCaster::NAME, &SPECS)?;
    let mut new = RayCaster { step: step_options::step_of(caster.step, options)?, ..caster.clone() };
    // In the order of the list: `order` is set before `termination`.
    for (key, value) in set {
        match (key, value) {
            (key, _) if step_options::owns(key) => {}
            ("leaping", OptionValue::Word(w)) => new.leaping = meaning_of(LEAPINGS, w),
            ("rule", OptionValue::Word(w)) => new.rule = meaning_of(RULES, w),
            ("traversal", OptionValue::Word(w)) => new.traversal = meaning_of(TRAVERSALS, w),
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
            ("vector", OptionValue::Word(w)) => new.vector = meaning_of(VECTORS, w),
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
            ("screen", OptionValue::Word(w)) => {
                new.screen = match (w.as_str(), new.screen) {
                    (ADAPTIVE, adaptive @ Screen::Adaptive { .. }) => adaptive,
                    (ADAPTIVE, _) => Screen::Adaptive { threshold: THRESHOLD },
                    (word, _) => meaning_of(SCREENS, word),
                }
            }
            ("screen-threshold", OptionValue::Number(x)) => {
                let Screen::Adaptive { threshold } = &mut new.screen else {
                    return Err(OptionError::Value {
                        renderer: RayCaster::NAME,
                        key: key.to_owned(),
                        found: x.to_string(),
                        allowed: "only the screen 'adaptive' interpolates: must be absent".to_owned(),
                    });
                };
                *threshold = *x;
            }
            _ => unreachable!("checked against the list"),
        }
    }
    Ok(new)
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
            RayCaster { screen: Screen::Adaptive { threshold: 0.125 }, ..RayCaster::default() },
            RayCaster { screen: Screen::Coherent, ..RayCaster::default() },
            RayCaster { screen: Screen::Template { connectivity: Connectivity::Continuous }, ..RayCaster::default() },
            RayCaster { rule: Rule::Exact, traversal: Traversal::Cells, ..RayCaster::default() },
            RayCaster { rule: Rule::Quadratic, traversal: Traversal::Voxels, ..RayCaster::default() },
            RayCaster { vector: Vector::Off, ..RayCaster::default() },
            RayCaster { leaping: Leaping::Octree, ..RayCaster::default() },
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
    fn a_threshold_is_for_the_adaptive_screen_alone() {
        let options = Options::new().with("screen", "coherent").with("screen-threshold", 0.1);
        let error = configure(&RayCaster::default(), &options).unwrap_err().to_string();
        assert!(error.contains("screen-threshold") && error.contains("adaptive"), "{error}");
        let adaptive = configure(&RayCaster::default(), &Options::new().with("screen", ADAPTIVE)).unwrap();
        assert_eq!(adaptive.screen, Screen::Adaptive { threshold: THRESHOLD });
    }

    #[test]
    fn the_lists_name_what_the_options_take() {
        for filter in Filter::ALL {
            assert!(FILTERS.contains(&filter.name()), "{filter}");
        }
        assert_eq!(SPECS.iter().filter(|s| matches!(s.kind, OptionKind::Choice(w) if w.is_empty())).count(), 0);
        for (word, leaping) in LEAPINGS {
            let options = Options::new().with("leaping", *word).with("step", 0.2);
            assert_eq!(configure(&RayCaster::default(), &options).unwrap().leaping, *leaping);
        }
        // The numbers of other kinds of steps than the default's choose those.
        let own = to_options(&RayCaster::default());
        for spec in SPECS.iter().filter(|s| own.0.contains_key(s.key) || s.key == "screen-threshold") {
            // A threshold by itself is an error, by default.
            let adaptive = RayCaster { screen: Screen::Adaptive { threshold: THRESHOLD }, ..RayCaster::default() };
            let caster = if spec.key == "screen-threshold" { adaptive } else { RayCaster::default() };
            let set = Options([(spec.key.to_owned(), spec.default.clone())].into());
            assert_eq!(configure(&caster, &set).unwrap(), caster, "{}", spec.key);
        }
    }
}
