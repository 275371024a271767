//! Voxels as splats.

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::{Placement, Voxel};

use crate::projection::SplatView;
use crate::source::Source;
use crate::splat::Splat;
use crate::visible::VisibleVoxels;

/// Spread of voxels.
pub(crate) struct Spread {
    /// Reach of kernels along the grid's axes, in voxels.
    pub(crate) reach: [f64; 3],
    /// In pixels.
    pub(crate) low_pass: f64,
    /// Subtracted from stored numbers.
    pub(crate) offset: f32,
    /// Number of the lattice's voxels before the placement's first.
    pub(crate) beyond: usize,
}

/// The visible voxels of a grid, in a view.
pub(crate) struct GridSplats<'a, T> {
    pub(crate) lattice: Lattice<'a, T>,
    pub(crate) visible: &'a VisibleVoxels,
    pub(crate) view: &'a SplatView,
    origin: DVec3,
    /// Change of place from one voxel to the next along each axis.
    steps: [DVec3; 3],
    spread: Spread,
    /// The axis whose layers are sheets, and the place of each in the order of sheets.
    sheets: Option<(usize, &'a [u32])>,
    /// Numbers of the first visible voxels of layers, where splats carry those in the place of values.
    numbers: Option<&'a [u32]>,
}

impl<'a, T: Voxel> GridSplats<'a, T> {
    pub(crate) fn new(
        lattice: Lattice<'a, T>,
        visible: &'a VisibleVoxels,
        view: &'a SplatView,
        placement: &Placement,
        spread: Spread,
        sheets: Option<(usize, &'a [u32])>,
        numbers: Option<&'a [u32]>,
    ) -> Self {
        let axes = placement.axes();
        let steps = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| view.place_of_vector(axis));
        let origin = view.place(placement.to_world(DVec3::splat(-(spread.beyond as f64))));
        Self { lattice, visible, view, origin, steps, spread, sheets, numbers }
    }
}

impl<T: Voxel> Source for GridSplats<'_, T> {
    fn chunks(&self) -> usize {
        self.visible.layers.len()
    }

    fn count(&self) -> u64 {
        self.visible.count()
    }

    fn splats(&self, chunk: usize, emit: &mut dyn FnMut(Splat, u32)) {
        let [nx, ny, _] = self.lattice.dims;
        let Spread { reach, low_pass, offset, .. } = self.spread;
        let whole = 1.0 / (reach[0] * reach[1] * reach[2]);
        let size = self.view.kernel.axes.determinant().abs().cbrt();
        let mut number = self.numbers.map(|starts| starts[chunk]);
        for run in &self.visible.layers[chunk] {
            let index = [usize::from(run.x), usize::from(run.y), chunk];
            let row = self.origin + self.steps[1] * index[1] as f64 + self.steps[2] * index[2] as f64;
            let samples = &self.lattice.samples[(chunk * ny + index[1]) * nx + index[0]..];
            for i in 0..usize::from(run.length) {
                let place = row + self.steps[0] * (index[0] + i) as f64;
                let (mut scale, mut weight) = (1.0, whole);
                if low_pass > 0.0 {
                    // Radii add in squares, in units of what a kernel's radius is on average.
                    let pixel = low_pass * self.view.pixel_at(place.z) * size;
                    scale = 1.0 / (1.0 + pixel * pixel).sqrt();
                    weight *= scale * scale * scale;
                }
                let sheet =
                    self.sheets.map_or(0, |(axis, order)| order[if axis == 0 { index[0] + i } else { index[axis] }]);
                let value = match &mut number {
                    Some(number) => {
                        *number += 1;
                        f32::from_bits(*number - 1)
                    }
                    None => samples[i].to_f32() - offset,
                };
                let (scale, weight) = (scale as f32, weight as f32);
                emit(Splat { place: place.as_vec3().to_array(), scale, weight, value }, sheet);
            }
        }
    }
}
