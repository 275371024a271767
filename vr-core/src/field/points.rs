//! Scattered points as a field.

use glam::DVec3;

use super::point_supports::joined;
use super::{Field, FieldLine, PointLine};
use crate::point_mixing::PointMixing;
use crate::point_set::PointSet;
use crate::ray::Ray;
use crate::view::Clip;

impl Field for PointSet {
    fn kind(&self) -> &'static str {
        "scattered points"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        Self::bounds(self)
    }

    fn spacing(&self) -> f64 {
        self.mean_spacing()
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        Some(Self::value_range(self))
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        self.field(at)
    }

    fn has_gradient(&self) -> bool {
        true
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        Self::gradient(self, at)
    }

    fn has_colors(&self) -> bool {
        self.colors().is_some()
    }

    fn color(&self, at: DVec3) -> Option<[f64; 3]> {
        self.color_at(at)
    }

    /// A mean begins and ends with the vacuum with a jump; a sum comes from 0 and goes to it.
    fn jumps(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        if self.mixing() == PointMixing::Mean {
            let crossings = self.crossings(ray, part);
            let chords = crossings.all.iter().map(|c| [c.nearest - c.half, c.nearest + c.half]).collect();
            let ends = joined(chords).into_iter().flatten().map(|s| s + crossings.offset);
            out.extend(ends.filter(|s| (part[0]..part[1]).contains(s)));
        }
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        let line = if gradients { PointLine::with_gradients } else { PointLine::new };
        Some(Box::new(line(self, ray, clip, far)?))
    }

    fn prepare_derived(&self) {
        Self::prepare_derived(self);
    }
}
