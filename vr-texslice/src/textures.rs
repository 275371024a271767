//! The textures of a volume: made when a view first needs them, kept within a budget.

use vr_core::filter::Lattice;
use vr_core::{AnyGrid, GridVolume, RenderError, UniformGrid, Voxel, memory, with_grid};

use crate::layout::Layout;
use crate::region::Region;
use crate::texture_slicer::TextureSlicer;

/// Stacks of 2D textures of values, one for each axis that a view has asked for. That along z is the volume as it lies.
#[derive(Default)]
pub(crate) struct Stacks {
    turned: [Option<AnyGrid>; 2],
}

impl Stacks {
    /// Makes the stack of an axis, unless there is one; returns true if it had to be made. Those of other axes go where the budget would not hold them.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] for a stack that is larger than the budget by itself.
    pub(crate) fn make(
        &mut self,
        renderer: &TextureSlicer,
        volume: &GridVolume,
        axis: usize,
    ) -> Result<bool, RenderError> {
        let bytes = volume.sample_bytes() as u64;
        hold("a stack of slices", bytes, renderer.bytes())?;
        if axis == 2 || self.turned[axis].is_some() {
            return Ok(false);
        }
        // The volume itself is the third of them.
        let others = 1 + self.turned.iter().flatten().count() as u64;
        if (others + 1) * bytes > renderer.bytes() {
            self.turned = [None, None];
        }
        memory::check("a stack of slices", bytes)?;
        self.turned[axis] = Some(with_grid!(volume.values(), g => turned(g, Layout::of_stack(axis, None).axes).into()));
        Ok(true)
    }

    /// The stack of an axis that has been made.
    pub(crate) fn of<'a>(&'a self, volume: &'a GridVolume, axis: usize) -> &'a AnyGrid {
        self.turned.get(axis).and_then(Option::as_ref).unwrap_or(volume.values())
    }
}

/// Refuses what a budget does not hold.
pub(crate) fn hold(what: &'static str, bytes: u64, limit: u64) -> Result<(), RenderError> {
    if bytes > limit { Err(RenderError::TooLarge { what, bytes, limit }) } else { Ok(()) }
}

/// A grid's samples with another order of axes.
fn turned<T: Voxel>(grid: &UniformGrid<T>, axes: [usize; 3]) -> UniformGrid<T> {
    let old = Lattice { samples: grid.samples(), dims: grid.dims() };
    let dims = axes.map(|a| old.dims[a]);
    let samples = Region::whole(dims).copied_along(axes, &old);
    UniformGrid::new(dims, samples, *grid.placement(), grid.calibration()).expect("as many samples as before")
}
