//! Positions of sheets: parallel to the image, or the volume's own.

use glam::DVec3;
use vr_core::{GridVolume, ParameterError, Projection, Scene, View, Volume};

use crate::input::{SplatInput, kernel_space, unit};
use crate::projection::SplatView;
use crate::splatter::{Buffers, CompositingOrder, Splatter};

/// Largest number of sheets, and of those that one kernel may be in: they are held at once.
const MAX_SHEETS: f64 = 1e6;
const MAX_AT_ONCE: f64 = 2048.0;

/// Smallest integral of a sample's kernel along a ray, in units of the view, that lets it be picked on its own: a thousandth of a voxel's edge. Less may
/// be what rounding makes of a ray along the kernel's face.
pub(crate) const MIN_MET: f64 = 1e-3;

/// Voxels by which a place in one of the volume's own layers is taken for one behind it, where cells are looked up.
pub(crate) const AT_LAYER: f64 = 1e-3;

/// True if a grid's box cuts rays. Where values are classified in sheets parallel to the image, or picked, it does, as in the canonical pixel; else
/// kernels are integrated over all of space.
pub(crate) fn is_boxed(renderer: &Splatter, scene: &Scene, input: &SplatInput) -> bool {
    let in_image_sheets = renderer.buffers == Buffers::Image && !renderer.splats_light();
    matches!(input, SplatInput::Grid(_)) && (in_image_sheets || !scene.compositing.integrates_light())
}

/// True if kernels are evaluated in the middle of sheets: for values of a grid in sheets parallel to the image. Weights are divided out there, so that a
/// sheet's value is that of the field in its middle. Light, and values of points, are integrated over each sheet.
pub(crate) fn takes_middles(renderer: &Splatter, input: &SplatInput) -> bool {
    matches!(input, SplatInput::Grid(_)) && renderer.buffers == Buffers::Image && !renderer.splats_light()
}

/// The view of all that may be drawn.
pub(crate) fn splat_view(
    renderer: &Splatter,
    scene: &Scene,
    input: &SplatInput,
    view: &View,
) -> Result<SplatView, ParameterError> {
    let unit = unit(input);
    match input {
        SplatInput::Grid(grid) => {
            let cube = renderer.kernel.shape.is_separable();
            let mut bounds = scene.volume.bounds();
            if !is_boxed(renderer, scene, input) {
                let axes = grid.placement().axes();
                let reach = renderer.kernel.reach();
                let beyond = axes.x_axis.abs() * reach[0] + axes.y_axis.abs() * reach[1] + axes.z_axis.abs() * reach[2];
                bounds = (bounds.0 - beyond, bounds.1 + beyond);
            }
            SplatView::new(view, unit, Some(kernel_space(renderer, grid)), cube, bounds, renderer.low_pass)
        }
        SplatInput::Points(_) => SplatView::new(view, unit, None, false, scene.volume.bounds(), renderer.low_pass),
    }
}

/// Largest depth of a corner of a volume.
fn deepest(volume: &Volume, view: &SplatView) -> f64 {
    let (low, high) = volume.bounds();
    let corner = |i: usize| {
        let pick = |a: usize| if i >> a & 1 == 0 { low[a] } else { high[a] };
        view.place(DVec3::new(pick(0), pick(1), pick(2))).z
    };
    (0..8).map(corner).fold(0.0, f64::max)
}

/// Factor by which a low-pass widens a voxel's kernel at a depth: the squares of radii add, in units of the kernel's mean radius.
pub(crate) fn widening(renderer: &Splatter, view: &SplatView, depth: f64) -> f64 {
    let size = view.kernel.axes.determinant().abs().cbrt();
    1f64.hypot(renderer.low_pass * view.pixel_at(depth) * size)
}

/// Reach of voxels' kernels, in voxels along each axis, with a low-pass: that of the widest in a view, rounded up to whole voxels, so that views that differ little share
/// their visible cells.
pub(crate) fn reach_in_view(renderer: &Splatter, volume: &Volume, view: &SplatView) -> [f64; 3] {
    let widening = widening(renderer, view, deepest(volume, view));
    renderer.kernel.reach().map(|reach| (reach * widening).ceil())
}

/// Sheets parallel to the image.
pub(crate) struct ImageSheets {
    /// From one to the next, in the view's units.
    pub(crate) distance: f64,
    pub(crate) count: u32,
    /// A power of two, no less than the largest number that one kernel is in.
    pub(crate) ring: u32,
}

impl ImageSheets {
    pub(crate) fn new(
        renderer: &Splatter,
        volume: &Volume,
        input: &SplatInput,
        view: &SplatView,
    ) -> Result<Self, ParameterError> {
        let distance = renderer.slice_spacing;
        let deepest = deepest(volume, view);
        // Half the depth of the deepest kernel, widened as it is at the far end.
        let half = match input {
            SplatInput::Grid(_) => view.half_depth() * widening(renderer, view, deepest),
            SplatInput::Points(points) => {
                let max_radius = points.radii().iter().fold(0.0f32, |m, &r| m.max(r));
                (f64::from(max_radius) / view.unit).hypot(renderer.low_pass * view.pixel_at(deepest))
            }
        };
        let (count, ring) = (((deepest + half) / distance).ceil() + 1.0, (2.0 * half / distance).ceil() + 2.0);
        if renderer.buffers == Buffers::Image && (count > MAX_SHEETS || ring > MAX_AT_ONCE) {
            let allowed = "must leave at most a million sheets, and every kernel in at most 2048 of them";
            return Err(ParameterError::new("render.slice-distance", distance, allowed));
        }
        let count = count.min(MAX_SHEETS) as u32;
        Ok(Self { distance, count, ring: (ring.min(MAX_AT_ONCE) as u32).min(count).next_power_of_two() })
    }
}

/// The volume's own sheets.
pub(crate) struct OwnSheets {
    /// The axis that they are layers of.
    pub(crate) axis: usize,
    /// Place of each layer in the order of compositing.
    pub(crate) order: Vec<u32>,
    /// The layers in the order of compositing.
    pub(crate) layers: Vec<u32>,
}

impl OwnSheets {
    /// For the axis that the view goes most along, in voxels.
    pub(crate) fn new(renderer: &Splatter, grid: &GridVolume, view: &View) -> Result<Self, ParameterError> {
        let frame = view.camera.frame()?;
        let inverse = grid.placement().inverse_axes();
        let along = inverse * frame.z_axis;
        let axis = (0..3).fold(0, |best, a| if along[a].abs() > along[best].abs() { a } else { best });
        let eye = match view.camera.projection {
            Projection::Perspective { .. } => (inverse * (view.camera.eye - grid.placement().origin()))[axis],
            // So far away that it is in front of all of them.
            Projection::Orthographic { .. } => -1e9f64.copysign(along[axis]),
        };
        let mut layers: Vec<u32> = (0..grid.dims()[axis] as u32).collect();
        // Away from the eye, every ray goes one way: of two layers as near, none meets both.
        layers.sort_by(|&a, &b| (f64::from(a) - eye).abs().total_cmp(&(f64::from(b) - eye).abs()));
        if renderer.order == CompositingOrder::BackToFront {
            layers.reverse();
        }
        let mut order = vec![0; layers.len()];
        for (turn, &layer) in layers.iter().enumerate() {
            order[layer as usize] = turn as u32;
        }
        Ok(Self { axis, order, layers })
    }
}
