//! Settings as named options.

use vr_core::{Configurable, DeclaredOption, Filter, MIN_MAX_ERROR, NumberRange, OptionTable};

use crate::caster::{
    CompositingOrder, EmptySpace, ImageSampling, Precision, Quality, RayCaster, Rule, Step, TransferLookup, Traversal,
    Vector,
};
#[cfg(feature = "classics")]
use crate::classics::options as classics;

/// Empty lists in place of the classics' options where they are left out.
#[cfg(not(feature = "classics"))]
mod classics {
    use super::*;

    pub(super) const STEPS_HELP: &str = "length of steps: uniform; local, as long as what is in each place allows; tolerance, as a promised error asks for; auto, local where light is followed (in large pictures one length for all, where that takes less time), else uniform";
    pub(super) const STEPS_OF_ONE_LENGTH: &str = "steps=uniform";
    pub(super) const STEPS: [(&str, Step); 0] = [];
    pub(super) const LEAPINGS: [(&str, EmptySpace); 0] = [];
    pub(super) const TRAVERSALS: [(&str, Traversal); 0] = [];
    pub(super) const SCREENS: [ImageSampling; 0] = [];

    pub(super) fn step_options() -> [DeclaredOption<RayCaster>; 0] {
        []
    }

    pub(super) fn is_rule_beyond_voxels(_: &RayCaster) -> bool {
        false
    }
}

/// Key of the option that a study refines.
pub(crate) const STEP: &str = "step";
/// Key of the option that bounds the error.
pub(crate) const MAX_ERROR: &str = "max-error";
/// Largest error bound: no picture is off by more than its largest magnitude.
pub(crate) const LARGEST_ERROR: f64 = 1.0;

const UNIFORM: Step = Step::Uniform(Step::OTHERWISE);
const LOCAL: Step = Step::Local { error: Step::ERROR };
const TOLERANCE: Step = Step::ErrorBound(4e-3);
/// Kinds of steps, with the numbers that they have where none are given.
const STEPS: [(&str, Step); 4] =
    [("auto", Step::Auto), ("uniform", UNIFORM), ("local", LOCAL), ("tolerance", TOLERANCE)];
/// Quality of any RMSE, with the one that it has where none is given.
const RMSE: Quality = Quality::Rmse(Step::ERROR);
/// Default threshold of adaptive rays. Their RMSE is a twentieth of it or less: about the error of default steps.
const ADAPTIVE: ImageSampling = ImageSampling::Adaptive { threshold: 0.05 };

impl Configurable for RayCaster {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            step_options().into_iter().chain(classics::step_options()).chain(other_options()).collect::<Vec<_>>(),
        )
    }
}

/// Returns every kind of steps.
fn steps() -> impl Iterator<Item = (&'static str, Step)> {
    STEPS.into_iter().chain(classics::STEPS)
}

/// Options of the lengths of steps. Each number makes steps the kind that has it, unless they are of one already.
fn step_options() -> [DeclaredOption<RayCaster>; 4] {
    [
        DeclaredOption::choice(
            "steps",
            classics::STEPS_HELP,
            steps(),
            |c: &RayCaster| {
                let is_same = |step: &Step| std::mem::discriminant(step) == std::mem::discriminant(&c.step);
                steps().map(|(_, step)| step).find(is_same).unwrap_or_default()
            },
            |c, step| c.step = step,
        ),
        DeclaredOption::number_only_with(
            (STEP, "length of a step, as a fraction of the smallest voxel edge"),
            NumberRange::above(0.0).up_to(RayCaster::LONGEST_STEP),
            (classics::STEPS_OF_ONE_LENGTH, |c| c.step = UNIFORM),
            |c| c.step.length(),
            |c: &mut RayCaster, x| match c.step.length_mut() {
                Some(length) => *length = x,
                None => c.step = Step::Uniform(x),
            },
        ),
        DeclaredOption::number_only_with(
            ("local-error", "RMSE that local steps aim at"),
            NumberRange::above(0.0).up_to(1.0),
            ("steps=local", |c| c.step = LOCAL),
            |c| if let Step::Local { error } = c.step { Some(error) } else { None },
            |c: &mut RayCaster, error| c.step = Step::Local { error },
        ),
        DeclaredOption::<RayCaster>::number_only_with(
            (
                MAX_ERROR,
                "largest error of a pixel that is promised, in units of max(1, the picture's largest magnitude)",
            ),
            NumberRange::at_least(MIN_MAX_ERROR).up_to(LARGEST_ERROR),
            ("steps=tolerance", |c| c.step = TOLERANCE),
            |c| if let Step::ErrorBound(error) = c.step { Some(error) } else { None },
            |c, error| c.step = Step::ErrorBound(error),
        )
        .promise()
        .refuse(
            "a promised error leaves rule, traversal, order and termination to the caster: they must not be set",
            |c| {
                let own = (c.order, c.rule, c.traversal);
                matches!(c.step, Step::ErrorBound(_))
                    && own != (CompositingOrder::default(), Rule::default(), Traversal::default())
            },
        ),
    ]
}

/// Returns all options but those of steps.
fn other_options() -> [DeclaredOption<RayCaster>; 13] {
    let rules = [Rule::Auto, Rule::Midpoint, Rule::Left, Rule::Linear, Rule::Quadratic, Rule::Exact];
    let screens = [ImageSampling::Auto, ImageSampling::EveryPixel, ADAPTIVE];
    let filters = Filter::ALL.map(|filter| (filter.name(), Some(filter)));
    [
        DeclaredOption::<RayCaster>::choice(
            "quality",
            "RMSE of the picture that automatic steps and rays aim at: draft 0.004 (a level of 8 bits), normal 0.001 (as much as rounding to 8 bits adds), fine 0.00025, rmse any; where steps are uniform, their length: 0.5, 0.2, 0.1",
            Quality::ALL.into_iter().chain([RMSE]).map(|quality| (quality.name(), quality)),
            |c| if let Quality::Rmse(_) = c.quality { RMSE } else { c.quality },
            |c, quality| c.quality = quality,
        )
        .refuse("steps are given: needs steps=auto", |c| c.quality != Quality::default() && c.step != Step::Auto),
        DeclaredOption::number_only_with(
            ("rmse", "RMSE of the picture that automatic steps and rays aim at"),
            NumberRange::above(0.0).up_to(1.0),
            ("quality=rmse", |c: &mut RayCaster| c.quality = RMSE),
            |c| if let Quality::Rmse(error) = c.quality { Some(error) } else { None },
            |c: &mut RayCaster, error| c.quality = Quality::Rmse(error),
        )
        .aim(),
        DeclaredOption::<RayCaster>::choice(
            "leaping",
            "how rays find out where nothing is visible; changes no pixel. All but auto go with uniform steps, and all but auto and none with the plain engine",
            [
                ("auto", EmptySpace::Auto),
                ("none", EmptySpace::None),
                ("exact-cloud", EmptySpace::ExactCloud),
            ]
            .into_iter()
            .chain(classics::LEAPINGS),
            |c| c.empty_space,
            |c, leaping| c.empty_space = leaping,
        )
        .refuse("coarse steps find the empty space themselves: must be none", |c| {
            c.step.finds_empty_space() && c.empty_space.is_named()
        })
        .refuse("every cell is walked: must be absent", |c| {
            c.traversal != Traversal::Samples && c.empty_space != EmptySpace::Auto
        })
        .refuse("steps that follow the medium leap by a map of their own: needs uniform steps (set step)", |c| {
            c.empty_space != EmptySpace::Auto && !c.step.is_on_lattice()
        }),
        DeclaredOption::<RayCaster>::choice(
            "rule",
            "how the light of a step is found: midpoint and linear have order 2, quadratic has 4, left has 1; exact needs traversal=cells; auto, quadratic in local steps where the transfer function jumps or has thin peaks, else midpoint. Operators that look at values take midpoint or left",
            rules.map(|rule| (rule.name(), rule)),
            |c| c.rule,
            |c, rule| c.rule = rule,
        )
        .refuse("needs traversal=cells", |c| c.rule == Rule::Exact && !c.ends_steps_at_faces()),
        DeclaredOption::<RayCaster>::choice(
            "traversal",
            "steps of the given length, steps that end at cell faces, or steps from voxel to voxel",
            [("samples", Traversal::Samples), ("cells", Traversal::Cells)].into_iter().chain(classics::TRAVERSALS),
            |c| c.traversal,
            |c, traversal| c.traversal = traversal,
        )
        .refuse("steps of this kind follow the medium, not cells or voxels: must be samples", |c| {
            c.traversal != Traversal::Samples && !matches!(c.step, Step::Auto | Step::Uniform(_))
        })
        .refuse("goes with rule=midpoint only", classics::is_rule_beyond_voxels)
        .refuse("whole voxels and whole cells have no other steps: needs steps=auto, and no step", |c| {
            c.takes_whole_parts() && c.step != Step::Auto
        }),
        DeclaredOption::choice(
            "order",
            "from which end samples are composited; back-to-front is for over alone",
            [("front-to-back", CompositingOrder::default()), ("back-to-front", CompositingOrder::BackToFront)],
            |c: &RayCaster| if c.order == CompositingOrder::BackToFront { CompositingOrder::BackToFront } else { CompositingOrder::default() },
            |c, order| c.order = order,
        ),
        DeclaredOption::choice(
            "filter",
            "reconstruction filter; scene: the one that the scene names",
            std::iter::once(("scene", None)).chain(filters),
            |c: &RayCaster| c.filter,
            |c, filter| c.filter = filter,
        ),
        DeclaredOption::<RayCaster>::choice(
            "classification",
            "how a value becomes light and opacity: looked up, or evaluated at every sample; auto: looked up where a table serves. Of what an operator picks or averages, auto and exact both evaluate it",
            [("auto", TransferLookup::Auto), ("table", TransferLookup::Table), ("exact", TransferLookup::Exact)],
            |c: &RayCaster| c.transfer_lookup,
            |c, classification| c.transfer_lookup = classification,
        )
        .refuse("rule=exact and a promised error evaluate the transfer function: must be auto or exact", |c| {
            let is_evaluated = c.rule == Rule::Exact || matches!(c.step, Step::ErrorBound(_));
            is_evaluated && c.transfer_lookup == TransferLookup::Table
        }),
        DeclaredOption::choice(
            "precision",
            "precision of the kernels",
            [("f32", Precision::F32), ("f64", Precision::F64)],
            |c: &RayCaster| c.precision,
            |c, precision| c.precision = precision,
        ),
        DeclaredOption::choice(
            "vector",
            "widest instructions of the vector engine; off: the plain engine draws everything",
            [("auto", Vector::Auto), ("avx2", Vector::Avx2), ("baseline", Vector::Baseline), ("off", Vector::Off)],
            |c: &RayCaster| c.vector,
            |c, vector| c.vector = vector,
        ),
        DeclaredOption::number_only_with(
            (
                "termination",
                "opacity at which a ray ends (1: only where opaque); changes no pixel by more than 1 - termination",
            ),
            NumberRange::above(0.0).up_to(1.0),
            ("order=front-to-back", |_| {}),
            |c: &RayCaster| if let CompositingOrder::FrontToBack { termination } = c.order { Some(termination) } else { None },
            |c, x| {
                if let CompositingOrder::FrontToBack { termination } = &mut c.order {
                    *termination = x;
                }
            },
        ),
        DeclaredOption::choice(
            "screen",
            "rays that are cast: all, those where colours bend, those from where the last view saw something, or those of a template; auto, where colours bend if steps are automatic or local, the picture has 65536 pixels or more, and that takes less time, else all",
            screens.into_iter().chain(classics::SCREENS).map(|screen| (screen.name(), screen)),
            |c: &RayCaster| if let ImageSampling::Adaptive { .. } = c.image_sampling { ADAPTIVE } else { c.image_sampling },
            |c, screen| c.image_sampling = screen,
        ),
        DeclaredOption::number_only_with(
            (
                "screen-threshold",
                "how far from the straight lines through its neighbours a colour may be where nothing is refined",
            ),
            NumberRange::at_least(0.0),
            ("screen=adaptive", |c| c.image_sampling = ADAPTIVE),
            |c: &RayCaster| if let ImageSampling::Adaptive { threshold } = c.image_sampling { Some(threshold) } else { None },
            |c, x| {
                if let ImageSampling::Adaptive { threshold } = &mut c.image_sampling {
                    *threshold = x;
                }
            },
        ),
    ]
}

#[cfg(test)]
mod tests {
    use vr_core::{OptionError, OptionValue, Options};

    use super::*;
    use crate::classics::Connectivity;

    fn configured(options: Options) -> Result<RayCaster, OptionError> {
        RayCaster::default().configure(&options)
    }

    #[test]
    fn every_caster_survives_the_way_through_options() {
        let casters = [
            RayCaster::default(),
            RayCaster::exact(0.125),
            RayCaster { order: CompositingOrder::BackToFront, rule: Rule::Left, ..RayCaster::default() },
            RayCaster { filter: Some(Filter::CatmullRom), ..RayCaster::default() },
            RayCaster { image_sampling: ImageSampling::Adaptive { threshold: 0.125 }, ..RayCaster::default() },
            RayCaster { image_sampling: ImageSampling::Coherent, ..RayCaster::default() },
            RayCaster {
                image_sampling: ImageSampling::Template { connectivity: Connectivity::Continuous },
                ..RayCaster::default()
            },
            RayCaster { rule: Rule::Exact, traversal: Traversal::Cells, ..RayCaster::default() },
            RayCaster { traversal: Traversal::Voxels, ..RayCaster::default() },
            RayCaster { vector: Vector::Off, ..RayCaster::default() },
            RayCaster { empty_space: EmptySpace::Octree, ..RayCaster::uniform(0.5) },
            RayCaster { step: Step::Local { error: 0.01 }, ..RayCaster::default() },
            RayCaster { step: Step::Vicinity { coarse: 4.0, fine: 0.5 }, ..RayCaster::default() },
            RayCaster { step: Step::Homogeneous { step: 0.5, error: 0.1 }, ..RayCaster::default() },
            RayCaster { step: Step::Variance { step: 0.5, error: 0.1 }, ..RayCaster::default() },
            RayCaster { step: Step::ErrorBound(0.1), ..RayCaster::default() },
            RayCaster { quality: Quality::Fine, ..RayCaster::default() },
            RayCaster { quality: Quality::Rmse(0.002), ..RayCaster::default() },
        ];
        for from in &casters {
            for to in &casters {
                assert_eq!(from.configure(&to.to_options()).unwrap(), *to);
            }
            assert_eq!(from.configure(&Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn numbers_go_with_what_has_them_alone() {
        for (word, number, needs) in [
            (("order", "back-to-front"), ("termination", 0.9), "order=front-to-back"),
            (("screen", "coherent"), ("screen-threshold", 0.1), "screen=adaptive"),
            (("steps", "uniform"), ("local-error", 0.5), "steps=local"),
            (("steps", "vicinity"), ("homogeneity", 0.1), "steps=homogeneous"),
            (("steps", "homogeneous"), ("homogeneity-rms", 0.1), "steps=variance"),
        ] {
            let error =
                configured(Options::new().with(word.0, word.1).with(number.0, number.1)).unwrap_err().to_string();
            assert!(error.contains(number.0) && error.contains(needs), "{error}");
        }
        assert_eq!(configured(Options::new().with("screen", "adaptive")).unwrap().image_sampling, ADAPTIVE);
    }

    #[test]
    fn a_number_chooses_its_kind_of_steps_and_no_other_takes_it() {
        let step = |options: Options| configured(options).map(|caster| caster.step);
        let one = |key: &str, x: f64| Options::new().with(key, x);
        assert_eq!(step(one("local-error", 0.01)).unwrap(), Step::Local { error: 0.01 });
        assert_eq!(step(one("coarse", 4.0)).unwrap(), Step::Vicinity { coarse: 4.0, fine: 0.2 });
        assert_eq!(step(one(MAX_ERROR, 0.01)).unwrap(), Step::ErrorBound(0.01));
        assert_eq!(step(one(STEP, 0.5).with("homogeneity", 0.1)).unwrap(), Step::Homogeneous { step: 0.5, error: 0.1 });
        let local = RayCaster { step: Step::Local { error: 0.01 }, ..RayCaster::default() };
        assert_eq!(local.configure(&one(STEP, 0.5)).unwrap().step, Step::Uniform(0.5));
        assert!(step(one(STEP, 0.5).with("local-error", 0.5)).is_err());
        assert!(step(one(STEP, 0.5).with(MAX_ERROR, 0.1)).is_err());
    }

    #[test]
    fn settings_that_do_not_go_together_are_refused() {
        for (key, word) in [("rule", "exact"), ("leaping", "octree")] {
            let error = configured(Options::new().with(key, word)).unwrap_err().to_string();
            assert!(error.contains(key), "{error}");
        }
        assert!(configured(Options::new().with("coarse", 0.1)).is_err());
        assert!(configured(Options::new().with(MAX_ERROR, 0.1).with("rule", "left")).is_err());
    }

    #[test]
    fn what_a_caster_is_by_default_can_be_set() {
        for spec in RayCaster::options().specs() {
            let set = Options([(spec.key.to_owned(), spec.default.clone())].into());
            let caster = if spec.key == "screen-threshold" {
                RayCaster { image_sampling: ADAPTIVE, ..RayCaster::default() }
            } else {
                RayCaster::default()
            };
            let value = caster.configure(&set).unwrap().to_options().0[spec.key].clone();
            assert_eq!(value, spec.default, "{}", spec.key);
        }
        assert_eq!(RayCaster::default().to_options().0["steps"], OptionValue::from("auto"));
    }
}
