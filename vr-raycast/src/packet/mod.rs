//! The vector engine: packets of sixteen rays, one a lane, on whatever vectors the machine has.

mod elementary;
mod field;
mod lanes;
mod leap;
mod level;
mod local_engine;
mod local_march;
mod march;
mod setup;
mod sums;
mod table;

pub(crate) use local_engine::{LocalEngine, LocalFrame};

use vr_core::{Compositing, Filter, Scene, UniformVolume};

use crate::caster::{Classification, Order, Precision, RayCaster, Rule};
use crate::table_range::single_precision_resolves;

/// Whether the vector engine draws local steps of this scene; if not, the plain one does.
pub(crate) fn supports_local(caster: &RayCaster, scene: &Scene, volume: &UniformVolume) -> bool {
    scene.compositing == Compositing::Over
        && scene.shading.is_none()
        && matches!(caster.order, Order::FrontToBack { .. })
        && caster.rule == Rule::Midpoint
        && caster.filter_of(scene) == Filter::Trilinear
        && caster.classification == Classification::Table
        && caster.precision == Precision::F32
        && volume.vacuum_cells().is_none()
        && volume.census().range.is_some()
        && volume.dims().iter().product::<usize>() <= i32::MAX as usize
        && single_precision_resolves(volume, &scene.transfer)
}
