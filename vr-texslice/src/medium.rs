//! The medium where opacity follows the gradient.

use std::sync::Arc;

use glam::DVec3;
use vr_core::transfer::Mixture;
use vr_core::{GradientMethod, GridVolume, Real, Scene, Shading};
use vr_kernels::step_by_gradient;
use vr_kernels::tables::PreIntegrated;
use vr_kernels::vector::{Modulation, OpticsTable, PacketShading, RowMixture};

/// Extinction and emission by value and by the magnitude of the gradient: a factor on the extinction, or the rows of a transfer function.
pub(crate) struct GradientMedium<'a> {
    scene: &'a Scene,
    volume: &'a GridVolume,
    shading: Arc<Shading>,
}

/// The smallest factor that a segment's length is multiplied by and its emission divided by, so that neither underflows: a thinner medium lets 10⁻¹² of
/// the other's depth through.
const SMALLEST_FACTOR: f64 = 1e-12;

impl<'a> GradientMedium<'a> {
    /// The medium of a scene; `None` where opacity follows no gradient.
    pub(crate) fn new(scene: &'a Scene, volume: &'a GridVolume) -> Option<Self> {
        let shading = scene.gradient_shading().filter(|_| scene.has_gradient_opacity())?;
        Some(Self { scene, volume, shading })
    }

    /// True if the gradient mixes rows of the transfer function.
    pub(crate) fn has_rows(&self) -> bool {
        self.scene.transfer.has_rows()
    }

    /// Magnitude, in values per world unit, of a gradient of stored numbers.
    pub(crate) fn magnitude(&self, world: DVec3) -> f64 {
        world.length() * self.volume.calibration().slope.abs()
    }

    /// The smallest and the largest magnitude between which anything changes.
    pub(crate) fn ends(&self) -> [f64; 2] {
        let magnitudes = self.nodes();
        [magnitudes[0], magnitudes[magnitudes.len() - 1]]
    }

    /// Magnitudes between which extinction and emission are linear.
    fn nodes(&self) -> Vec<f64> {
        match self.has_rows() {
            true => self.scene.transfer.rows().iter().map(|row| row.gradient).collect(),
            false => self.shading.gradient_opacity.iter().map(|point| point.0).collect(),
        }
    }

    /// Light and opacity of a homogeneous step, `length` world units long, at a value and a magnitude.
    pub(crate) fn step(&self, value: f64, magnitude: f64, length: f64) -> [f64; 4] {
        step_by_gradient(&self.scene.transfer, &self.shading, [value, magnitude], length)
    }

    /// Light and opacity of a segment, `length` world units long, on which the stored number goes linearly from one to another, the magnitude being that of its middle
    /// all along; nothing where an end is missing. `tables`: one for each row, or that of the transfer function.
    ///
    /// Under a factor it is the segment as long as the factor makes it. Of rows, the means of extinction and emission over the segment are mixed, and it
    /// is a homogeneous step of these: where a colour changes along it, its order in depth is that of the step.
    pub(crate) fn segment<R: Real>(
        &self,
        tables: &[PreIntegrated<R>],
        [front, back]: [R; 2],
        magnitude: f64,
        length: f64,
    ) -> [f64; 4] {
        if front.is_nan() || back.is_nan() {
            return [0.0; 4];
        }
        if !self.has_rows() {
            return self.stretched(&tables[0], [front, back], self.shading.modulation(magnitude), length);
        }
        let mut mixture = Mixture::default();
        for (row, share) in self.scene.transfer.row_mix(magnitude).weights().into_iter().filter(|w| w.1 > 0.0) {
            let [r, g, b, kappa] = tables[row].mean(front, back).map(Real::to_f64);
            mixture.extinction += share * kappa;
            (0..3).for_each(|c| mixture.emission[c] += share * [r, g, b][c]);
        }
        mixture.step(length)
    }

    /// Light and opacity of a segment whose extinction is multiplied by a factor.
    fn stretched<R: Real>(
        &self,
        table: &PreIntegrated<R>,
        [front, back]: [R; 2],
        factor: f64,
        length: f64,
    ) -> [f64; 4] {
        let emits = self.scene.transfer.has_emission();
        if factor == 0.0 {
            return without_extinction(table, [front, back], emits, length);
        }
        let factor = if emits { factor.max(SMALLEST_FACTOR) } else { factor };
        let [r, g, b, alpha] = table.segment(front, back, R::from_f64(length * factor)).map(Real::to_f64);
        let share = if emits { 1.0 / factor } else { 1.0 };
        [r * share, g * share, b * share, alpha]
    }

    /// Shading for kernels that makes samples anew by a gradient per step of texture coordinates, of which c is the index along axis `axes[c]`; by tables of the
    /// rows, where there are any.
    pub(crate) fn packet_shading(&self, axes: [usize; 3], tables: &Arc<[OpticsTable]>) -> PacketShading {
        let (matrix, scale) = self.volume.placement().scaled_gradient_matrix(self.volume.calibration().slope);
        let to_world = std::array::from_fn(|row| axes.map(|a| matrix.col(a)[row] as f32));
        PacketShading {
            shading: Arc::clone(&self.shading),
            lights: Vec::new(),
            to_world,
            modulation: Modulation::new(&self.shading, scale),
            rows: RowMixture::new(&self.scene.transfer, Arc::clone(tables), scale),
            reflects: false,
        }
    }
}

/// Light and opacity of a segment that absorbs nothing.
pub(crate) fn without_extinction<R: Real>(
    table: &PreIntegrated<R>,
    [front, back]: [R; 2],
    emits: bool,
    length: f64,
) -> [f64; 4] {
    if !emits {
        return [0.0; 4];
    }
    let [r, g, b, _] = table.mean(front, back).map(|q| q.to_f64() * length);
    [r, g, b, 0.0]
}

/// True if a scene's fragments look at gradients of the interpolant itself, for opacity or for what they reflect.
pub(crate) fn follows_interpolant(scene: &Scene) -> bool {
    let looks = scene.reflection().is_some() || scene.has_gradient_opacity();
    looks && scene.gradient_shading().is_some_and(|shading| shading.gradient == GradientMethod::Analytic)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::phantom;
    use vr_core::{ControlPoint, OpacityRule, TransferFunction};

    fn scene(transfer: TransferFunction, gradient_opacity: Vec<(f64, f64)>) -> Scene {
        let volume = phantom::sample::<u8>(&*phantom::by_name("blobs").unwrap(), [4; 3]).unwrap();
        let shading = Shading { gradient_opacity, ..Shading::default() };
        Scene { shading: Some(shading.into()), ..Scene::new(volume.into(), transfer) }
    }

    fn points(emission: Option<[f64; 3]>, opacity: f64) -> Vec<ControlPoint> {
        [(0.0, 0.2), (1.0, 1.0)]
            .map(|(v, a)| ControlPoint { emission, ..ControlPoint::new(v, [1.0, 0.5, 0.25], a * opacity) })
            .to_vec()
    }

    /// A constant value along a segment makes it a step, whatever its factor.
    #[test]
    fn a_segment_at_one_value_is_a_step() {
        for emission in [None, Some([0.3, 0.2, 0.1])] {
            let plain = TransferFunction::new(points(emission, 0.7), OpacityRule::Power, 1.0).unwrap();
            let rows = vec![(1.0, points(emission, 0.1)), (3.0, points(emission, 0.9))];
            let rows = TransferFunction::of_rows(rows, OpacityRule::Power, 1.0).unwrap();
            for scene in [scene(plain, vec![(1.0, 0.0), (3.0, 1.5)]), scene(rows, Vec::new())] {
                let volume = scene.volume.grid().unwrap();
                let medium = GradientMedium::new(&scene, volume).unwrap();
                let one = std::slice::from_ref(&*scene.transfer);
                let of_rows: Vec<_> = scene.transfer.rows().iter().map(|row| row.transfer.clone()).collect();
                let functions = if medium.has_rows() { &of_rows[..] } else { one };
                let table =
                    |t: &TransferFunction| PreIntegrated::<f64>::new(t, volume.calibration(), (0.0, 255.0), 4096);
                let tables: Vec<_> = functions.iter().map(table).collect();
                for (stored, magnitude) in [(50.0, 0.0), (128.0, 1.0), (200.0, 1.2), (230.0, 2.7), (17.0, 9.0)] {
                    let step = medium.step(volume.calibration().value(stored), magnitude, 0.4);
                    let segment = medium.segment(&tables, [stored, stored], magnitude, 0.4);
                    // The curvature of κ over an interval of the table.
                    assert!((0..4).all(|c| (step[c] - segment[c]).abs() < 1e-5), "{step:?} {segment:?}");
                }
            }
        }
    }
}
