//! The options that say how long steps are: a word for their kind, and the numbers that belong to it.

use vr_core::{OptionError, OptionKind, OptionSpec, OptionValue, Options};

use crate::caster::{RayCaster, Step};

const STEPS: &str = "steps";
const STEP: &str = "step";
const LOCAL_ERROR: &str = "local-error";
#[cfg(feature = "classics")]
const HOMOGENEITY: &str = "homogeneity";
const MAX_ERROR: &str = "max-error";
#[cfg(feature = "classics")]
const COARSE: &str = "coarse";

/// Every kind of steps, and the numbers that it takes.
const KINDS: &[(&str, &[&str])] = &[
    ("auto", &[]),
    ("uniform", &[STEP]),
    ("local", &[LOCAL_ERROR]),
    #[cfg(feature = "classics")]
    ("vicinity", &[STEP, COARSE]),
    #[cfg(feature = "classics")]
    ("homogeneous", &[STEP, HOMOGENEITY]),
    ("tolerance", &[MAX_ERROR]),
];

/// The numbers: the largest allowed, what they are where none is given, and help.
const NUMBERS: &[(&str, f64, f64, &str)] = &[
    (STEP, RayCaster::LONGEST_STEP, 0.2, "length of a step, as a fraction of the smallest voxel edge"),
    (LOCAL_ERROR, 1.0, Step::ERROR, "RMSE that local steps aim at"),
    #[cfg(feature = "classics")]
    (HOMOGENEITY, 1.0, 1e-2, "largest error that all the long ones of homogeneous steps may make together on a ray"),
    (MAX_ERROR, 1.0, 4e-3, "largest error of the picture that steps of a tolerance promise; 1e-6 at the least"),
    #[cfg(feature = "classics")]
    (COARSE, RayCaster::LONGEST_STEP, 8.0, "length in voxels of the coarse steps of steps=vicinity"),
];

/// The kind of a step and its numbers, in the order of [`KINDS`].
fn parts(step: Step) -> (&'static str, Vec<f64>) {
    match step {
        Step::Auto => ("auto", vec![]),
        Step::Uniform(step) => ("uniform", vec![step]),
        Step::Local { error } => ("local", vec![error]),
        #[cfg(feature = "classics")]
        Step::Homogeneous { step, error } => ("homogeneous", vec![step, error]),
        Step::Tolerance(error) => ("tolerance", vec![error]),
        #[cfg(feature = "classics")]
        Step::Vicinity { coarse, fine } => ("vicinity", vec![fine, coarse]),
    }
}

/// The step of a kind, from its numbers by name.
fn build(kind: &str, number: impl Fn(&str) -> f64) -> Step {
    match kind {
        "auto" => Step::Auto,
        "uniform" => Step::Uniform(number(STEP)),
        "local" => Step::Local { error: number(LOCAL_ERROR) },
        #[cfg(feature = "classics")]
        "homogeneous" => Step::Homogeneous { step: number(STEP), error: number(HOMOGENEITY) },
        "tolerance" => Step::Tolerance(number(MAX_ERROR)),
        #[cfg(feature = "classics")]
        "vicinity" => Step::Vicinity { coarse: number(COARSE), fine: number(STEP) },
        _ => unreachable!("checked against the list"),
    }
}

fn numbers_of(kind: &str) -> &'static [&'static str] {
    KINDS.iter().find(|(word, _)| *word == kind).expect("every kind is listed").1
}

/// The numbers that a step has, by name.
fn held(step: Step) -> Vec<(&'static str, f64)> {
    let (kind, values) = parts(step);
    numbers_of(kind).iter().copied().zip(values).collect()
}

/// The options, with the default caster's kind.
pub(crate) fn specs() -> Vec<OptionSpec> {
    let kind = OptionSpec {
        key: STEPS,
        kind: OptionKind::Choice(&[
            "auto",
            "uniform",
            "local",
            #[cfg(feature = "classics")]
            "vicinity",
            #[cfg(feature = "classics")]
            "homogeneous",
            "tolerance",
        ]),
        default: parts(Step::default()).0.into(),
        help: "how long steps are: local where light is followed, else uniform; all alike; as what is in each place allows; alike, with coarse ones where nothing is visible; long \
               where the medium is nearly the same; as a promised error asks for",
    };
    let default = held(Step::default());
    let number = |&(key, most, otherwise, help): &(&'static str, f64, f64, &'static str)| {
        let value = default.iter().find(|(k, _)| *k == key).map_or(otherwise, |(_, x)| *x);
        OptionSpec { key, kind: OptionKind::Number { above: 0.0, most }, default: value.into(), help }
    };
    std::iter::once(kind).chain(NUMBERS.iter().map(number)).collect()
}

/// The options of a step.
pub(crate) fn to_options(step: Step) -> Options {
    let options = Options::new().with(STEPS, parts(step).0);
    held(step).into_iter().fold(options, |options, (key, x)| options.with(key, x))
}

/// Whether an option is read here.
pub(crate) fn owns(key: &str) -> bool {
    key == STEPS || NUMBERS.iter().any(|(k, ..)| *k == key)
}

/// The step that (checked) options ask for. A number that belongs to another kind than the step had chooses that kind, unless `steps`
/// says which.
///
/// # Errors
/// A number that the kind asked for has no use for, or numbers that no kind takes together.
pub(crate) fn step_of(old: Step, options: &Options) -> Result<Step, OptionError> {
    let given: Vec<(&str, f64)> = NUMBERS
        .iter()
        .filter_map(|(key, ..)| match options.0.get(*key) {
            Some(OptionValue::Number(x)) => Some((*key, *x)),
            _ => None,
        })
        .collect();
    let takes = |kind: &str, key: &str| numbers_of(kind).contains(&key);
    let takes_all = |kind: &str| given.iter().all(|(key, _)| takes(kind, key));
    let old_kind = parts(old).0;
    let kind = match options.0.get(STEPS) {
        Some(OptionValue::Word(word)) => word.as_str(),
        _ if takes_all(old_kind) => old_kind,
        _ => {
            let kinds = || KINDS.iter().map(|(word, _)| *word);
            // Where none takes all of them, the first one's, to complain in the name of.
            let of_first = || kinds().find(|word| given.first().is_some_and(|(key, _)| takes(word, key)));
            kinds().find(|word| takes_all(word)).or_else(of_first).unwrap_or(old_kind)
        }
    };
    if let Some((key, x)) = given.iter().find(|(key, _)| !takes(kind, key)) {
        let allowed = format!("steps are '{kind}': must be absent");
        return Err(OptionError::Value {
            renderer: RayCaster::NAME,
            key: (*key).into(),
            found: x.to_string(),
            allowed,
        });
    }
    let old = held(old);
    Ok(build(kind, |key| {
        let of = |list: &[(&str, f64)]| list.iter().find(|(k, _)| *k == key).map(|(_, x)| *x);
        let otherwise = || NUMBERS.iter().find(|(k, ..)| *k == key).expect("every number is listed").2;
        of(&given).or_else(|| of(&old)).unwrap_or_else(otherwise)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_everywhere() {
        let all = specs();
        let OptionKind::Choice(words) = all[0].kind else { panic!("a choice") };
        assert_eq!(words, KINDS.iter().map(|(word, _)| *word).collect::<Vec<_>>());
        for (kind, numbers) in KINDS {
            assert!(numbers.iter().all(|key| NUMBERS.iter().any(|(k, ..)| k == key)));
            let step = step_of(Step::default(), &Options::new().with(STEPS, *kind)).unwrap();
            assert_eq!((parts(step).0, parts(step).1.len()), (*kind, numbers.len()));
            // Back from every other kind.
            for (other, _) in KINDS {
                let from = step_of(Step::default(), &Options::new().with(STEPS, *other)).unwrap();
                assert_eq!(step_of(from, &to_options(step)).unwrap(), step);
            }
        }
    }

    #[test]
    fn a_number_chooses_its_kind_and_no_other_takes_it() {
        let step = |options: Options| step_of(Step::default(), &options);
        assert_eq!(step(Options::new().with(LOCAL_ERROR, 0.01)).unwrap(), Step::Local { error: 0.01 });
        assert_eq!(step(Options::new().with(COARSE, 4.0)).unwrap(), Step::Vicinity { coarse: 4.0, fine: 0.2 });
        let local = Step::Local { error: 0.01 };
        assert_eq!(step_of(local, &Options::new().with(STEP, 0.5)).unwrap(), Step::Uniform(0.5));
        let error = step(Options::new().with(STEPS, "uniform").with(LOCAL_ERROR, 0.5)).unwrap_err().to_string();
        assert!(error.contains(LOCAL_ERROR) && error.contains("uniform"), "{error}");
        assert!(step(Options::new().with(STEP, 0.5).with(LOCAL_ERROR, 0.5)).is_err());
        assert_eq!(step(Options::new().with(MAX_ERROR, 0.01)).unwrap(), Step::Tolerance(0.01));
        let homogeneous = Step::Homogeneous { step: 0.5, error: 0.1 };
        assert_eq!(step(Options::new().with(STEP, 0.5).with(HOMOGENEITY, 0.1)).unwrap(), homogeneous);
        assert!(step(Options::new().with(STEP, 0.5).with(MAX_ERROR, 0.1)).is_err());
    }
}
