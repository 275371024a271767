//! Empty space of a prepared scene.

use std::sync::Arc;

use vr_core::{Compositing, GridVolume, Real, Scene};
use vr_kernels::ranges::RangeBlocks;

use super::{EDGE, ExactCloud, Leaper, Visibility, VisibleBlocks};
use crate::caster::{EmptySpace, RayCaster};
use crate::classify::Classifier;

/// Tells which values of a scene can be seen; `None` under an operator that depends on all of them.
pub(crate) fn visibility<R: Real>(scene: &Scene, classifier: &Classifier<R>) -> Option<Visibility<R>> {
    match scene.compositing {
        Compositing::First { threshold } => Some(Visibility::of_threshold(threshold, classifier.calibration)),
        Compositing::Over | Compositing::Accumulate { .. } => Some(Visibility::of_light(
            &classifier.transfer,
            classifier.calibration,
            classifier.table.as_ref().map(|(table, _)| table),
            classifier.profile.as_ref().and_then(|profile| profile.table.as_ref()),
        )),
        Compositing::Average | Compositing::Maximum | Compositing::Minimum => None,
    }
}

/// Finds the empty space of a scene, when it is prepared and again when its transfer function changes, in the structure of a caster, which
/// `classifier` is made for; `None` where all is sampled. `last` is the structure of the same scene when only the transfer function, or the compositing, was
/// another one.
#[cfg_attr(not(feature = "classics"), expect(unused_variables, reason = "the exact cloud keeps nothing"))]
pub(crate) fn empty_space<R: Real>(
    caster: &RayCaster,
    scene: &Scene,
    volume: &GridVolume,
    classifier: &Classifier<R>,
    last: Option<&Arc<dyn Leaper>>,
) -> Option<Arc<dyn Leaper>> {
    let leaps = caster.empty_space != EmptySpace::None || caster.step.finds_empty_space();
    // Other steps have maps of their own.
    if !(leaps && caster.step.is_on_lattice()) {
        return None;
    }
    let visibility = visibility(scene, classifier)?;
    #[cfg(feature = "classics")]
    if let Some(leaper) = crate::classics::leaper(caster, volume, &visibility, last) {
        return Some(leaper);
    }
    let blocks = VisibleBlocks::new(volume.dims(), &RangeBlocks::of_volume(volume, EDGE), &visibility);
    Some(Arc::new(ExactCloud::new(&blocks)))
}
