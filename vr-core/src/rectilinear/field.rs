//! A rectilinear grid as a field.

use glam::DVec3;

use super::gradients::CornerGradients;
use super::grid::RectilinearGrid;
use super::line::RectilinearLine;
use crate::field::{Field, FieldLine, Stretch};
use crate::filter::Reconstruction;
use crate::grid_volume::SamplerVisitor;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::shading::GradientMethod;
use crate::view::Clip;
use crate::voxel::Voxel;

/// The values at world positions, by one sampler.
struct ValuesAt<'a> {
    grid: &'a RectilinearGrid,
    at: &'a [DVec3],
    out: &'a mut [f64],
}

impl SamplerVisitor for ValuesAt<'_> {
    type Output = ();
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        let calibration = self.grid.lattice().calibration();
        for (out, &at) in self.out.iter_mut().zip(self.at) {
            let index = self.grid.to_index(at);
            *out = index.map_or(f64::NAN, |index| calibration.value(sampler.value(index.to_array())));
        }
    }
}

impl Field for RectilinearGrid {
    fn kind(&self) -> &'static str {
        "rectilinear grid"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds()
    }

    fn spacing(&self) -> f64 {
        self.mean_spacing()
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        self.value_range()
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        let stored = self.lattice().stored_at(self.to_index(at)?.to_array());
        (!stored.is_nan()).then(|| self.lattice().calibration().value(stored))
    }

    fn values(&self, at: &[DVec3], out: &mut [f64]) {
        self.lattice().with_sampler(ValuesAt { grid: self, at, out });
    }

    fn has_gradient(&self) -> bool {
        true
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        let index = self.to_index(at)?;
        let (stored, per_index) = self.lattice().stored_and_gradient_at(index.to_array());
        if stored.is_nan() {
            return None;
        }
        let (axes, dims) = (self.axes(), self.dims());
        let cell: [usize; 3] = std::array::from_fn(|a| (index[a] as usize).min(dims[a] - 2));
        let slope = self.lattice().calibration().slope;
        Some(
            slope
                * match self.gradient_method() {
                    GradientMethod::Analytic => {
                        DVec3::from(per_index) / DVec3::from_array(std::array::from_fn(|a| axes[a].width(cell[a])))
                    }
                    GradientMethod::CentralDifferences => {
                        let corners = self.lattice().with_lattice(CornerGradients { axes, cell });
                        let at: [f64; 3] = std::array::from_fn(|a| index[a] - cell[a] as f64);
                        let weight = |c: usize| {
                            (0..3).map(|a| if c >> a & 1 == 1 { at[a] } else { 1.0 - at[a] }).product::<f64>()
                        };
                        (0..8).map(|c| DVec3::from(corners[c]) * weight(c)).sum()
                    }
                },
        )
    }

    fn jumps(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        RectilinearLine::jumps(self, ray, part, out);
    }

    fn stretches(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<Stretch>) -> bool {
        self.append_stretches(ray, part, out);
        true
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        Some(Box::new(RectilinearLine::new(self, ray, clip, far, gradients)?))
    }

    fn prepare_derived(&self) {
        self.lattice().prepare_derived();
        self.bricks();
    }
}
