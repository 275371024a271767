//! Volumes that are taken for others.

use vr_core::amr::AmrBlock;
use vr_core::rectilinear::{Axis, Centering};
use vr_core::{AmrGrid, RectilinearGrid, Scene, Volume};

use super::fault::Fault;
use crate::check::transformed_volume::values as rectilinear_values;

/// The scene as the marcher takes it.
pub(super) fn mistaken(fault: Fault, scene: &Scene) -> Scene {
    let volume = match (fault, &scene.volume) {
        (Fault::CoarsestLevel, Volume::Amr(mesh)) => coarsest_level(mesh).into(),
        (Fault::EvenAxes, Volume::Rectilinear(grid)) => on_even_axes(grid).into(),
        (_, volume) => volume.clone(),
    };
    Scene { volume, ..scene.clone() }
}

fn coarsest_level(mesh: &AmrGrid) -> AmrGrid {
    let blocks: Vec<AmrBlock> = mesh.blocks_of(0).to_vec();
    AmrGrid::new(mesh.origin(), mesh.spacing_of(0), Vec::new(), blocks, mesh.centring()).expect("a level of a mesh")
}

fn on_even_axes(grid: &RectilinearGrid) -> RectilinearGrid {
    let even = |axis: &Axis| {
        let (first, step) = (axis.ends()[0], axis.mean_step());
        (0..axis.places().len()).map(|k| first + k as f64 * step).collect()
    };
    let axes = grid.axes().each_ref().map(even);
    RectilinearGrid::new(axes, rectilinear_values(grid), Centering::Points).expect("axes that rise")
}
