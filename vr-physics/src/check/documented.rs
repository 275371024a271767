//! A renderer held to what it documents: settings, claims of convergence, and errors on hard cases.

use vr_core::{Configurable, Documented, DocumentedError, OptionError, Options};

use super::convergence::{Convergence, Refinement, converges};
use super::effort::Effort;
use super::hard_cases::{CaseOutcome, HardCases, survives_hard_cases};
use super::outcome::CheckFailure;
use crate::Reference;
use crate::cases::Case;

/// Every [named case](crate::cases) that the renderer does not refuse gives a finite picture within the error that it documents for it.
///
/// # Errors
/// The first case that fails, or that is drawn though no error is documented for it.
pub fn survives_documented_cases(renderer: &dyn Documented, reference: &Reference) -> Result<HardCases, CheckFailure> {
    let errors = renderer.hard_case_errors();
    let documented = |name: &str| errors.for_case(name);
    // Without a bound, the reference has nothing to do.
    let bound = |case: &Case| documented(case.name).unwrap_or(DocumentedError::Max(f64::INFINITY));
    let table = survives_hard_cases(renderer, bound, reference)?;
    let undocumented = table.results.iter().find(|r| r.outcome != CaseOutcome::Refused && documented(r.name).is_none());
    match undocumented {
        None => Ok(table),
        Some(result) => Err(CheckFailure {
            check: "survives the hard cases",
            renderer: renderer.name(),
            reason: format!("{}: drawn, and no error is documented", result.name),
            scene: None,
        }),
    }
}

/// Errors fall at the order of each claim of the renderer, as its option is halved. One result for each claim, by the claim's name.
///
/// # Errors
/// The first claim that fails, with a scene that shows it.
pub fn converges_as_documented<R: Configurable + Documented>(
    renderer: &R,
    effort: &Effort,
) -> Result<Vec<(String, Convergence)>, CheckFailure> {
    let held = |claim: vr_core::ConvergenceClaim| {
        let refinement = Refinement {
            options: claim.options,
            floor: claim.floor,
            ..Refinement::new(claim.key, claim.orders.smooth)
        };
        Ok((claim.name, converges(renderer, &refinement, effort)?))
    };
    renderer.convergence().into_iter().map(held).collect()
}

/// Every documented setting can be configured, and has a name and options of its own. Every claim of convergence leaves its option open,
/// and that option can be halved so many times.
///
/// # Errors
/// The setting or claim that fails.
pub fn documents_what_can_be_set<R: Configurable + Documented>(
    renderer: &R,
    halvings: u32,
) -> Result<(), CheckFailure> {
    let failure = |name: &str, reason: String| CheckFailure {
        check: "what is documented can be set",
        renderer: renderer.name(),
        reason: format!("'{name}': {reason}"),
        scene: None,
    };
    let set = |name: &str, options: &Options| {
        let validated = |r: R| -> Result<R, OptionError> { r.validate().map(|()| r) };
        renderer.configure(options).and_then(validated).map_err(|e| failure(name, e.to_string()))
    };
    // The settings.
    let settings = renderer.settings();
    for (i, setting) in settings.iter().enumerate() {
        set(&setting.name, &setting.options)?;
        let twin = settings[..i].iter().find(|s| s.name == setting.name || s.options == setting.options);
        if let Some(twin) = twin {
            return Err(failure(&setting.name, format!("has the name or the options of '{}'", twin.name)));
        }
    }
    // The claims.
    for claim in renderer.convergence() {
        if claim.options.0.contains_key(claim.key) {
            return Err(failure(&claim.name, format!("holds the option '{}' fixed that it refines", claim.key)));
        }
        for halving in 0..=halvings {
            let refined = claim.coarsest / f64::from(1 << halving);
            set(&claim.name, &claim.options.clone().with(claim.key, refined))?;
        }
    }
    Ok(())
}
