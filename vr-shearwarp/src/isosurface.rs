//! The surface on which a field reaches a threshold, between the slices of a texel's ray.

use vr_core::{Filter, GradientMethod, GridVolume, Scene};

use crate::composite::kernel::Seen;
use crate::factorization::IndexView;

/// Scene and view in which a surface is met.
pub(crate) struct Isosurface<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) volume: &'a GridVolume,
    pub(crate) view: &'a IndexView,
    /// Threshold in calibrated values.
    pub(crate) threshold: f64,
    /// −1 where larger values have smaller stored numbers.
    pub(crate) sign: f64,
}

/// Halvings of the distance between slices, in which a ray leaves vacuum or meets a jump.
const HALVINGS: u32 = 30;
/// Part of a voxel by which a point on a face of vacuum, which belongs to that, is moved off it.
const NUDGE: f64 = 1e-7;

impl Isosurface<'_> {
    /// Colour and depth of the surface, given the first sample that reaches the threshold.
    ///
    /// Between that and the sample before, or the point at which the ray enters the volume, values are taken to be linear: depths are of order 2 in
    /// the distance between slices. Where the nearest voxels are taken, a jump between the two is found itself.
    pub(crate) fn met(&self, seen: &Seen<'_>) -> ([f64; 4], f64) {
        let threshold = self.volume.calibration().stored(self.threshold);
        let last = seen.depth_of_slice();
        let mut first = (last - seen.slices.spacing).max(seen.chord[0]).min(last);
        let (mut before, at_last) = (self.inside(seen, first, NUDGE), self.inside(seen, last, -NUDGE));
        if before.is_nan() {
            // Where the ray leaves vacuum it enters the volume.
            let mut end = last;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (first + end);
                if self.stored(seen, middle).is_nan() { first = middle } else { end = middle }
            }
            (first, before) = (end, self.inside(seen, end, NUDGE));
        }
        let missing = self.sign * (threshold - before);
        let (depth, value) = if missing <= 0.0 {
            (first, self.volume.calibration().value(before))
        } else if self.volume.filter() == Filter::Nearest {
            // The field jumps at a face between two voxels: the threshold is met there, by the value behind it.
            let (mut end, mut met) = (last, at_last);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (first + end);
                let value = self.inside(seen, middle, -NUDGE);
                if self.sign * (value - threshold) >= 0.0 { (end, met) = (middle, value) } else { first = middle }
            }
            (end, self.volume.calibration().value(met))
        } else {
            let rise = self.sign * (at_last - before);
            // Codes of floats are rounded: the sample may not quite reach the threshold.
            (first + (last - first) * if rise > missing { missing / rise } else { 1.0 }, self.threshold)
        };
        let mut rgb = self.scene.transfer.at(value).color;
        if let Some(colors) = self.scene.volume.colors() {
            let tint = colors.color(seen.index(depth, self.volume.dims()));
            rgb = std::array::from_fn(|c| rgb[c] * tint[c]);
        }
        let [r, g, b] = rgb;
        (self.shaded(seen, depth, [r, g, b, 1.0]), depth)
    }

    /// Shades the surface by the gradient at a depth.
    fn shaded(&self, seen: &Seen<'_>, depth: f64, rgba: [f64; 4]) -> [f64; 4] {
        let Some(shading) = self.scene.reflection() else { return rgba };
        let index = seen.index(depth, self.volume.dims());
        let gradient = match shading.gradient {
            GradientMethod::CentralDifferences => self.volume.central_differences_at(index),
            GradientMethod::Analytic => self.volume.stored_and_gradient_at(index).1,
        };
        let f = &seen.slices.factorization;
        let [x, y] = seen.texel.map(|i| i as f64);
        let along = (f.sign * self.view.world_vector(f.step(x, y))).normalize();
        let world = self.volume.placement().gradient_to_world(gradient.into());
        shading.along(&self.scene.lights, along).shade(rgba, world.to_array())
    }

    /// Stored number at a depth; where that is vacuum, a little beside it.
    fn inside(&self, seen: &Seen<'_>, depth: f64, beside: f64) -> f64 {
        let exact = self.stored(seen, depth);
        if exact.is_nan() { self.stored(seen, depth + beside) } else { exact }
    }

    fn stored(&self, seen: &Seen<'_>, depth: f64) -> f64 {
        self.volume.stored_at(seen.index(depth, self.volume.dims()))
    }
}
