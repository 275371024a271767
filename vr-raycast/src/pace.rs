//! Pace of rays: the length of a step by what is around.

use std::sync::Arc;

use vr_core::rectilinear::Bricks;
use vr_core::{Real, Volume};
use vr_kernels::ranges::Visibility;

use crate::step_map::RangeSteps;

/// Rule by which rays go through a field that knows the parts of its lines: their steps, and what is left out.
#[derive(Clone, Debug)]
pub(crate) struct Pace<R> {
    pub(crate) lengths: Lengths,
    /// Values that can be seen; `None` if all are sampled.
    pub(crate) visibility: Option<Visibility<R>>,
}

/// Lengths of steps.
#[derive(Clone, Debug)]
pub(crate) enum Lengths {
    /// In proportion to the distance of the field's samples: `step` where it is `spacing`, in world units.
    Uniform { step: f64, spacing: f64 },
    /// By the range of the values in each part of the field, a box of `edge` cells along each side. The shortest side of a cell is `shortest` times the
    /// spacing of the samples.
    Local { steps: Arc<RangeSteps>, edge: f64, shortest: f64 },
}

impl Lengths {
    /// Returns the world length of a step where the field keeps within a range and its samples are so far apart.
    pub(crate) fn of(&self, range: [f32; 2], spacing: f64) -> f64 {
        match self {
            Self::Uniform { step, spacing: whole } => step * (spacing / whole),
            Self::Local { steps, edge, shortest } => steps.length(range, spacing * shortest, *edge),
        }
    }
}

impl<R: Real> Pace<R> {
    /// True if anything in a range of values can be seen.
    pub(crate) fn shows(&self, [low, high]: [f32; 2]) -> bool {
        self.visibility.as_ref().is_none_or(|visibility| visibility.shows(low, high))
    }
}

/// Returns the number of cells along the edge of a part of which a volume knows the range of values, and the shortest edge of a cell beside the spacing that
/// its rays tell; `None` if it knows no ranges, or has ways of its own.
pub(crate) fn cells_of_parts(volume: &Volume) -> Option<[f64; 2]> {
    match volume {
        Volume::Amr(grid) => Some([8.0, grid.finest_spacing().min_element() / grid.mean_spacing()]),
        Volume::Rectilinear(_) => Some([Bricks::EDGE as f64, 1.0]),
        Volume::Grid(_) | Volume::Color(_) | Volume::Points(_) | Volume::Cells(_) | Volume::Field(_) => None,
    }
}
