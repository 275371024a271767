//! Orders of convergence: those that are documented are seen, and each classic mistake fails.

use vr_core::{Control, Documented, StudiedRenderer};
use vr_physics::check::faulty_marcher::{Fault, Marcher};
use vr_raycast::RayCaster;
use vr_study::convergence::{Convergence, OrderCheck, Outcome, Refined};
use vr_study::reference::ReferenceCache;

fn proven(renderer: &dyn StudiedRenderer) -> Vec<Convergence> {
    let (cache, control) = (ReferenceCache::none(), Control::default());
    let results = OrderCheck { cache: &cache, control: &control }.check_claims(renderer, &|_| {}).unwrap();
    for c in &results {
        let errors: Vec<String> = c.errors.iter().map(|e| format!("{e:.1e}")).collect();
        println!(
            "{} {:<20} {:<15} {} {:.2?} {:?} {} {:?}",
            c.renderer,
            c.claim,
            c.refined.word(),
            c.expected,
            c.measured,
            c.outcome(),
            errors.join(" "),
            c.trouble
        );
    }
    results
}

#[test]
fn the_ray_caster_has_the_orders_that_it_documents() {
    let results = proven(&RayCaster::default());
    assert!(results.len() > 3 * RayCaster::default().convergence().len());
    for c in results {
        assert!(matches!(c.outcome(), Outcome::Holds | Outcome::Exact), "{c:?}");
    }
}

#[test]
fn a_right_marcher_passes() {
    assert!(proven(&Marcher::new(Fault::None)).iter().all(|c| c.outcome() == Outcome::Holds));
}

/// The refinements that fail under a fault.
fn failing(fault: Fault) -> Vec<Refined> {
    let results = proven(&Marcher::new(fault));
    results.iter().filter(|c| c.outcome() == Outcome::Fails).map(|c| c.refined).collect()
}

#[test]
fn a_shift_by_half_a_voxel_is_seen() {
    let failing = failing(Fault::HalfVoxelShift);
    assert!(failing.contains(&Refined::Step) && failing.contains(&Refined::Grid), "{failing:?}");
}

#[test]
fn a_dropped_last_step_is_seen() {
    assert!(failing(Fault::DroppedLastStep).contains(&Refined::Step));
}

#[test]
fn classification_before_interpolation_is_seen() {
    assert!(failing(Fault::PreClassification).contains(&Refined::Step));
}

#[test]
fn missing_opacity_correction_is_seen() {
    let failing = failing(Fault::NoOpacityCorrection);
    assert!(failing.contains(&Refined::Step) && failing.contains(&Refined::Grid), "{failing:?}");
}

#[test]
fn rays_through_the_corners_of_pixels_are_seen() {
    assert!(failing(Fault::PixelCorners).contains(&Refined::Pixels));
}

#[test]
fn a_panic_and_a_refusal_are_told_apart() {
    let outcomes = |fault| proven(&Marcher::new(fault)).iter().map(Convergence::outcome).collect::<Vec<_>>();
    assert!(outcomes(Fault::Panic).iter().all(|&o| o == Outcome::Fails));
    assert!(outcomes(Fault::RefusesEverything).iter().all(|&o| o == Outcome::Refused));
}
