//! From what a pixel has gathered to the pixel.

use glam::DVec3;
use vr_core::{ColorGrid, Compositing, GridVolume, Scene};
use vr_kernels::vector::Operator;

use crate::compression::Compressed;
use crate::draw::{Pixel, State};
use crate::fragments::Fragments;
use crate::gradients::ExactGradients;

/// Inputs for finishing pixels.
pub(crate) struct Finish<'a> {
    pub(crate) operator: Operator,
    pub(crate) scene: &'a Scene,
    pub(crate) volume: &'a GridVolume,
    /// The texture, where that is not the volume itself.
    pub(crate) compressed: Option<&'a Compressed>,
}

/// Halvings of the slab in which a threshold is passed: 10⁻⁹ of it is left, which is below the rounding of an f32 depth.
const HALVINGS: u32 = 30;

impl Finish<'_> {
    /// Pixel `i` of sixteen whose ray met the volume.
    pub(crate) fn pixel(&self, rays: &Fragments, state: &State, i: usize) -> Pixel {
        let [sum, lost, _] = &state.sums;
        let value = state.value.0[i];
        match self.operator {
            Operator::Under { .. } => {
                let rgba = std::array::from_fn(|c| f64::from(sum[c].0[i] - lost[c].0[i]));
                Pixel { rgba, depth: rays.distance_at(i, state.half(i)) }
            }
            Operator::Over => {
                let half = state.half_from_behind(i);
                let depth = if half.is_finite() { rays.distance_at(i, half) } else { f64::INFINITY };
                Pixel { rgba: std::array::from_fn(|c| f64::from(sum[c].0[i])), depth }
            }
            Operator::Extreme { .. } if value == f32::NEG_INFINITY => Pixel::NOTHING,
            Operator::Extreme { sign } => {
                let depth = rays.distance_at(i, state.other.0[i]);
                let tint = self.colors().map(|colors| colors.color(self.index(rays, i, depth)));
                Pixel { depth, ..self.picked(f64::from(value * sign), tint) }
            }
            Operator::Average if state.other.0[i] == 0.0 => Pixel::NOTHING,
            Operator::Average => {
                let mean = (f64::from(value) - f64::from(state.lost.0[i])) / f64::from(state.other.0[i]);
                let tint = |c: usize| f64::from(sum[c].0[i]) / f64::from(state.other.0[i]);
                self.picked(mean, self.colors().map(|_| [0, 1, 2].map(tint)))
            }
            Operator::First { .. } if value == f32::INFINITY => Pixel::NOTHING,
            Operator::First { sign, .. } => self.first(rays, i, state, f64::from(sign)),
        }
    }

    fn colors(&self) -> Option<&ColorGrid> {
        self.scene.volume.colors().map(|colors| &**colors)
    }

    /// (α·c, α) of a stored number, in a colour where voxels have any.
    fn picked(&self, stored: f64, tint: Option<[f64; 3]>) -> Pixel {
        let [r, g, b, alpha] = self.scene.transfer.at(self.volume.calibration().value(stored)).pixel();
        let [x, y, z] = tint.unwrap_or([1.0; 3]);
        Pixel { rgba: [r * x, g * y, b * z, alpha], ..Pixel::NOTHING }
    }

    /// The point at which the threshold is passed, found between the sample that passed and the one before it.
    fn first(&self, rays: &Fragments, i: usize, state: &State, sign: f64) -> Pixel {
        let Compositing::First { threshold } = self.scene.compositing else { return Pixel::NOTHING };
        let threshold = self.volume.calibration().stored(threshold);
        let stored = |s: f64| {
            let at = self.index(rays, i, s);
            self.compressed.map_or_else(|| self.volume.stored_at(at), |compressed| compressed.value_at(self.volume, at))
        };
        let (mut below, mut reached) = (rays.distance_at(i, state.other.0[i]), rays.distance_at(i, state.value.0[i]));
        // Where a ray enters, both are the same.
        for _ in 0..if below < reached { HALVINGS } else { 0 } {
            let middle = 0.5 * (below + reached);
            // False in vacuum.
            if sign * stored(middle) >= sign * threshold { reached = middle } else { below = middle }
        }
        let [r, g, b] = self.scene.transfer.at(self.volume.calibration().value(stored(reached))).color;
        let tint = self.colors().map_or([1.0; 3], |colors| colors.color(self.index(rays, i, reached)));
        let mut rgba = [r * tint[0], g * tint[1], b * tint[2], 1.0];
        if let Some(shading) = self.scene.reflection() {
            let at = self.index(rays, i, reached);
            let (volume, compressed) = (self.volume, self.compressed);
            let world = ExactGradients { volume, compressed, method: shading.gradient }.at(at);
            let along = DVec3::from(rays.chords.along.map(|a| a[i]));
            rgba = shading.along(&self.scene.lights, along).shade(rgba, world.to_array());
        }
        Pixel { rgba, depth: reached }
    }

    /// Index-space position at a world distance along a ray, inside the box.
    fn index(&self, rays: &Fragments, i: usize, distance: f64) -> [f64; 3] {
        let dims = self.volume.dims();
        let at = rays.index_at(i, distance);
        std::array::from_fn(|a| at[a].clamp(0.0, (dims[a] - 1) as f64))
    }
}
