//! The renderer's settings.

use vr_core::Classification;

use crate::input::SplatInput;
use crate::kernel::{Shape, SplatKernel};

/// A renderer that splats.
#[derive(Clone, Debug, PartialEq)]
pub struct Splatter {
    /// Buffers in which splats are gathered before they are composited.
    pub buffers: Buffers,
    /// Order of splatting and classification.
    pub classification: Classification,
    /// Kernel that spreads a voxel; the default stands for that of the grid's [`Filter`](vr_core::Filter). Scattered points have kernels of their own.
    pub kernel: SplatKernel,
    /// Distance between sheets parallel to the image: in smallest voxel edges, or in half mean radii of points; 0.02 to 64.
    pub slice_spacing: f64,
    /// In pixels, how far every footprint is widened against aliasing: a radius of R pixels becomes √(R² + low_pass²). 0 takes the ray through
    /// a pixel's centre as it is.
    pub low_pass: f64,
    /// Order in which the volume's own sheets are composited.
    pub order: CompositingOrder,
    /// Opacity in (0, 1] at which pixels take no more; 1: never. What is left out changes no pixel by more than 1 − termination: where light is brighter
    /// than 1, more is drawn accordingly.
    pub termination: f64,
}

/// Buffers in which splats are gathered before they are composited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Buffers {
    /// Sheets parallel to the image, each with the sections of kernels that lie in it (Mueller & Crawfis 1998).
    #[default]
    Image,
    /// The volume's own sheets along the axis that the view goes most along, each with the whole kernels of its voxels (Westover 1990).
    Axis,
    /// None: every sample is composited as it is, nearest first (Westover 1990).
    Samples,
}

/// Order in which sheets are composited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompositingOrder {
    /// Each under what is there.
    #[default]
    FrontToBack,
    /// Each over what is there; nothing can end early. The volume's own sheets alone.
    BackToFront,
}

impl Default for Splatter {
    fn default() -> Self {
        Self {
            buffers: Buffers::default(),
            classification: Classification::default(),
            kernel: SplatKernel::default(),
            slice_spacing: 1.0,
            low_pass: 0.0,
            order: CompositingOrder::default(),
            termination: 0.9999,
        }
    }
}

impl Splatter {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "splat";

    /// The renderer with the kernel that is a grid's filter, unless another was asked for.
    pub(crate) fn spreading(&self, input: &SplatInput) -> Self {
        match input {
            SplatInput::Grid(grid) if self.kernel == SplatKernel::default() => {
                Self { kernel: SplatKernel::new(Shape::of_filter(grid.filter())), ..self.clone() }
            }
            _ => self.clone(),
        }
    }

    /// True if a termination was asked for: neither the default, nor 1, at which no pixel ends early.
    pub(crate) fn sets_termination(&self) -> bool {
        ![Self::default().termination, 1.0].contains(&self.termination)
    }
}
