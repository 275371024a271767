//! Cameras of a turntable.

use vr_look::{fit_together, pivot_of};

use crate::args::{Axis, TurnArgs};

use super::shot::Shot;
use super::stage::Stage;

/// Returns the frames of a turn. A whole turn, or several, closes: the last frame is one step before the first. A part of one ends at its
/// end. A free camera sees everything visible all the time, from one distance.
pub fn shots(turn: TurnArgs, stage: &Stage<'_>, count: usize) -> Vec<Shot> {
    let axis = match turn.axis {
        Axis::Up => stage.up,
        Axis::Along(vector) => vector,
    };
    let closes = turn.turn != 0.0 && turn.turn % 360.0 == 0.0;
    let steps = if closes { count } else { count.saturating_sub(1).max(1) };
    let angle = |frame: usize| turn.turn * frame as f64 / steps as f64;
    let pivot = match pivot_of(&stage.visible, axis) {
        Some(pivot) if stage.is_free => pivot,
        _ => stage.camera.target,
    };
    let cameras: Vec<_> = (0..count).map(|frame| stage.camera.turned(pivot, axis, angle(frame))).collect();
    let cameras = if stage.is_free { fit_together(&cameras, pivot, &stage.visible, stage.aspect) } else { cameras };
    cameras.into_iter().map(Shot::of).collect()
}
