//! The marcher, and the projector on the hard case, through the checks that every renderer can be put through, over random meshes.

use vr_cells::{Attenuation, CellMarcher, CellProjector};
use vr_physics::check::strategies::mesh_scene;
use vr_physics::check::{self, Effort, Volumes};

#[test]
fn obeys_invariants() {
    let marcher = CellMarcher { termination: 1.0 };
    for report in check::obeys_invariants(&marcher, 1e-5, &Effort::cases(48).on(Volumes::Meshes))
        .unwrap_or_else(|e| panic!("{e}"))
    {
        println!("{report}");
    }
}

#[test]
fn tame_scenes_are_exact() {
    let effort = Effort::cases(200).on(Volumes::Meshes);
    let report = check::agrees_with_reference(&CellMarcher { termination: 1.0 }, |_, _| 1e-5, &effort);
    println!("{}", report.unwrap_or_else(|e| panic!("{e}")));
}

/// Jumps, walls and thresholds included; where something is shaded, normals turn within a cell.
#[test]
fn any_scene_is_exact() {
    let bound = |scene: &vr_core::Scene, _: &vr_core::View| match scene.shading {
        None => 1e-5,
        Some(_) => 1e-3,
    };
    let report =
        check::agrees_with_reference_on(&CellMarcher { termination: 1.0 }, mesh_scene(), bound, &Effort::cases(200));
    println!("{}", report.unwrap_or_else(|e| panic!("{e}")));
}

#[test]
fn slivers_are_survived() {
    let classic = CellProjector { attenuation: Attenuation::Linear, ..CellProjector::default() };
    let renderers: [&dyn vr_core::Documented; 4] =
        [&CellMarcher { termination: 1.0 }, &CellMarcher::default(), &CellProjector::default(), &classic];
    for renderer in renderers {
        let table = check::survives_documented_cases(renderer, &vr_physics::Reference::new(1e-7));
        println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
    }
}
