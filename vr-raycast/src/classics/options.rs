//! Words and numbers of the options that classics add, and their settings for a study.

use vr_core::{DeclaredOption, NumberRange};

use super::Connectivity;
use crate::caster::{EmptySpace, ImageSampling, RayCaster, Rule, Step, Traversal};

/// Help of the option `steps`.
pub(crate) const STEPS_HELP: &str = "length of steps: uniform; local, as long as what is in each place allows; vicinity, coarse where nothing is visible; homogeneous, long where the medium hardly changes; variance, long also where it changes little in the mean, by an octree of means and variances; tolerance, as a promised error asks for; auto, local where light is followed (in large pictures one length for all, where that takes less time), else uniform";
/// Kinds of steps that have a length.
pub(crate) const STEPS_OF_ONE_LENGTH: &str = "steps=uniform, vicinity, homogeneous or variance";

const VICINITY: Step = Step::Vicinity { coarse: 8.0, fine: Step::OTHERWISE };
const HOMOGENEOUS: Step = Step::Homogeneous { step: Step::OTHERWISE, error: 1e-2 };
const VARIANCE: Step = Step::Variance { step: Step::OTHERWISE, error: 1e-2 };

/// Kinds of steps, with the numbers that they have where none are given.
pub(crate) const STEPS: [(&str, Step); 3] =
    [("vicinity", VICINITY), ("homogeneous", HOMOGENEOUS), ("variance", VARIANCE)];
/// Ways of leaping.
pub(crate) const LEAPINGS: [(&str, EmptySpace); 5] = [
    ("octree", EmptySpace::Octree),
    ("pyramid", EmptySpace::Pyramid),
    ("chessboard-cloud", EmptySpace::ChessboardCloud),
    ("boxes", EmptySpace::Boxes),
    ("polyhedron", EmptySpace::Polyhedron),
];
/// Traversals.
pub(crate) const TRAVERSALS: [(&str, Traversal); 1] = [("voxels", Traversal::Voxels)];
/// Screens.
pub(crate) const SCREENS: [ImageSampling; 5] = [
    ImageSampling::Coherent,
    ImageSampling::CBuffer,
    ImageSampling::Template { connectivity: Connectivity::Discrete },
    ImageSampling::Template { connectivity: Connectivity::Continuous },
    ImageSampling::Template { connectivity: Connectivity::Faces },
];

/// Options of steps. Each number makes steps the kind that has it, unless they are of one already.
pub(crate) fn step_options() -> [DeclaredOption<RayCaster>; 3] {
    [
        DeclaredOption::number_only_with(
            ("homogeneity", "largest error that all the long ones of homogeneous steps may make together on a ray"),
            NumberRange::above(0.0).up_to(1.0),
            ("steps=homogeneous", |c| c.step = HOMOGENEOUS),
            |c| if let Step::Homogeneous { error, .. } = c.step { Some(error) } else { None },
            |c: &mut RayCaster, error| {
                let step = c.step.length().unwrap_or(Step::OTHERWISE);
                c.step = Step::Homogeneous { step, error };
            },
        ),
        DeclaredOption::number_only_with(
            ("homogeneity-rms", "largest RMSE that all the long ones of steps by variance may make together"),
            NumberRange::above(0.0).up_to(1.0),
            ("steps=variance", |c| c.step = VARIANCE),
            |c| if let Step::Variance { error, .. } = c.step { Some(error) } else { None },
            |c: &mut RayCaster, error| {
                let step = c.step.length().unwrap_or(Step::OTHERWISE);
                c.step = Step::Variance { step, error };
            },
        ),
        DeclaredOption::<RayCaster>::number_only_with(
            ("coarse", "length of coarse steps, in voxels"),
            NumberRange::above(0.0).up_to(RayCaster::LONGEST_STEP),
            ("steps=vicinity", |c| c.step = VICINITY),
            |c| if let Step::Vicinity { coarse, .. } = c.step { Some(coarse) } else { None },
            |c, coarse| {
                let fine = c.step.length().unwrap_or(Step::OTHERWISE);
                c.step = Step::Vicinity { coarse, fine };
            },
        )
        .refuse(
            "must be longer than the fine step",
            |c| matches!(c.step, Step::Vicinity { coarse, fine } if coarse <= fine),
        ),
    ]
}

/// True if a ray walks from voxel to voxel under a rule that has no meaning there.
pub(crate) fn is_rule_beyond_voxels(caster: &RayCaster) -> bool {
    caster.traversal == Traversal::Voxels && !matches!(caster.rule, Rule::Auto | Rule::Midpoint)
}

/// Returns the named casters of a study.
pub(crate) fn settings() -> [(String, RayCaster); 3] {
    let template = ImageSampling::Template { connectivity: Connectivity::Continuous };
    let screens = [("coherent", ImageSampling::Coherent), ("c-buffer", ImageSampling::CBuffer), ("template", template)];
    screens.map(|(word, screen)| {
        (format!("midpoint 1 {word}"), RayCaster { image_sampling: screen, ..RayCaster::uniform(1.0) })
    })
}
