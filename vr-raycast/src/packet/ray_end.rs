//! Limits at which the rays of a packet end early.

use vr_core::{Compositing, Scene};

use crate::caster::{CompositingOrder, RayCaster};

/// Limits at which a ray that gathers light, front to back, ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayEnd {
    /// Amount at which it ends: no more than this could be added to any component.
    pub(super) negligible: f64,
    /// Opacity at which it is cut; 1 where it is not.
    pub(super) cut: f64,
}

impl RayEnd {
    /// Returns the limits that a caster and a scene ask for; `None` for the other order, and for operators that gather no light.
    pub(super) fn new(caster: &RayCaster, scene: &Scene) -> Option<Self> {
        let CompositingOrder::FrontToBack { termination } = caster.order else { return None };
        match scene.compositing {
            Compositing::Over => Some(Self { negligible: 1.0 - termination, cut: 1.0 }),
            // A cut sum is ended by its cut alone.
            Compositing::Accumulate { level } => Some(Self { negligible: 0.0, cut: level }),
            _ => None,
        }
    }
}
