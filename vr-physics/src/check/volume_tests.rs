//! The checks on volumes that are no uniform grids: they pass a right renderer, and each mistake fails at least the check that is there for it.

use super::faulty_marcher::{Fault, Marcher};
use super::*;
use crate::Reference;

const OTHERS: [Volumes; 3] = [Volumes::Meshes, Volumes::AdaptiveMeshes, Volumes::RectilinearGrids];

fn effort(cases: u32, volumes: Volumes) -> Effort {
    Effort { shrink_steps: 300, ..Effort::cases(cases) }.on(volumes)
}

/// Steps of a 32nd of the spacing.
fn marcher(fault: Fault) -> Marcher {
    Marcher { fault, step: 1.0 / 32.0 }
}

fn agreement(fault: Fault, volumes: Volumes) -> Result<Report, CheckFailure> {
    agrees_with_reference(&marcher(fault), |_, _| 1e-2, &effort(48, volumes))
}

#[test]
fn a_right_renderer_passes() {
    for volumes in OTHERS {
        println!("{volumes:?}: {}", agreement(Fault::None, volumes).unwrap());
        for report in obeys_invariants(&Marcher::new(Fault::None), 1e-6, &effort(32, volumes)).unwrap() {
            println!("{volumes:?}: {report}");
        }
    }
}

#[test]
fn the_reference_passes_its_own_checks() {
    let reference = Reference::default();
    // Half a unit in the last place of a number up to 1, as the frame has it, and rounding in another world.
    let slack = 2.4e-7;
    for volumes in OTHERS {
        let report = agrees_with_reference(&reference, |_, _| 6e-8, &effort(48, volumes)).unwrap();
        assert_eq!((report.refused, report.skipped), (0, 0), "{report}");
        for report in obeys_invariants(&reference, slack, &effort(16, volumes)).unwrap() {
            println!("{volumes:?}: {report}");
        }
    }
}

#[test]
fn mistakes_are_seen() {
    let general = [Fault::NoOpacityCorrection, Fault::HalfVoxelShift, Fault::PixelCorners, Fault::Nan];
    for volumes in OTHERS {
        for fault in general {
            assert!(agreement(fault, volumes).is_err(), "{volumes:?}: {fault:?}");
        }
        let few = effort(24, volumes);
        assert!(invariants::is_free_of_scale(&Marcher::new(Fault::WorldStep), 1e-6, &few).is_err(), "{volumes:?}");
        assert!(invariants::ignores_threads(&Marcher::new(Fault::CountsThreads), &few).is_err(), "{volumes:?}");
        let failure = invariants::update_is_prepare(&Marcher::new(Fault::StaleVolume), &few).unwrap_err();
        assert!(failure.reason.contains("after a volume"), "{volumes:?}: {}", failure.reason);
    }
}

#[test]
fn mistakes_about_adaptive_meshes_and_uneven_axes_are_seen() {
    for (fault, volumes) in
        [(Fault::CoarsestLevel, Volumes::AdaptiveMeshes), (Fault::EvenAxes, Volumes::RectilinearGrids)]
    {
        let failure = agreement(fault, volumes).expect_err("the fault is seen");
        assert!(failure.reason.contains("largest error"), "{fault:?}: {}", failure.reason);
        assert!(agreement(fault, Volumes::Meshes).is_ok(), "{fault:?}: there is nothing to mistake");
    }
}
