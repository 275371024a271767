//! Indices of voxels into a palette: by value, and, where opacity follows the gradient, by its magnitude.

use vr_core::{GridVolume, Scene};

use crate::medium::GradientMedium;

/// Light and opacity of every index: 256 for each level of the gradient's magnitude, or 256 in all.
pub(crate) type Palette = Vec<[f32; 4]>;

/// Indices of a value.
pub(crate) const CODES: usize = 256;
/// Index, of 256, that stands for a missing voxel.
const MISSING: u8 = 255;

/// Indices of stored numbers: bytes as they are; anything else by the nearest of 255 levels over its range, one index standing for missing voxels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Codes {
    low: f64,
    step: f64,
    last: f64,
}

impl Codes {
    pub(crate) fn of(volume: &GridVolume) -> Self {
        let (low, high) = volume.value_stats().range.map_or((0.0, 0.0), |(l, h)| (f64::from(l), f64::from(h)));
        if volume.voxel_type().is_integer() && high - low <= 255.0 {
            return Self { low, step: 1.0, last: 255.0 };
        }
        let last = f64::from(MISSING - 1);
        Self { low, step: if high > low { (high - low) / last } else { 1.0 }, last }
    }

    pub(crate) fn index(&self, stored: f64) -> u8 {
        if stored.is_nan() { MISSING } else { ((stored - self.low) / self.step + 0.5).clamp(0.0, self.last) as u8 }
    }

    /// Light and opacity of every index, for slabs of a length.
    pub(crate) fn palette(&self, scene: &Scene, volume: &GridVolume, length: f64) -> Palette {
        let holes = volume.value_stats().has_missing();
        let medium = GradientMedium::new(scene, volume);
        let levels = medium.as_ref().map(Levels::of);
        let count = levels.map_or(1, |levels| levels.count());
        let entry = |i: usize| {
            let (level, code) = (i / CODES, i % CODES);
            if holes && code == usize::from(MISSING) {
                return [f32::NAN; 4];
            }
            let value = volume.calibration().value(self.low + code as f64 * self.step);
            let light = match (&medium, levels) {
                (Some(medium), Some(levels)) => medium.step(value, levels.magnitude(level as u8), length),
                _ => scene.transfer.step(value, length),
            };
            light.map(|x| x as f32)
        };
        (0..count * CODES).map(entry).collect()
    }

    /// Largest distance from a stored number to the one that stands for it.
    pub(crate) fn max_error(&self) -> f64 {
        if self.last == 255.0 { 0.0 } else { 0.5 * self.step }
    }

    /// The stored number that stands for a given one in a palette.
    pub(crate) fn level(&self, stored: f64) -> f64 {
        if stored.is_nan() { stored } else { self.low + f64::from(self.index(stored)) * self.step }
    }
}

/// Levels of the gradient's magnitude: 256 at equal distances over the range in which the medium changes, as Kniss, Kindlmann & Hansen 2001, *Interactive volume rendering
/// using multi-dimensional transfer functions and direct manipulation widgets*, keep it in a byte beside the value; one, where it changes nowhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    low: f64,
    step: f64,
}

impl Levels {
    pub(crate) fn of(medium: &GradientMedium<'_>) -> Self {
        let [low, high] = medium.ends();
        Self { low, step: (high - low) / 255.0 }
    }

    fn count(self) -> usize {
        if self.step > 0.0 { 256 } else { 1 }
    }

    /// The level nearest to a magnitude.
    pub(crate) fn level(self, magnitude: f64) -> u8 {
        if self.step > 0.0 { ((magnitude - self.low) / self.step + 0.5).clamp(0.0, 255.0) as u8 } else { 0 }
    }

    /// The magnitude that a level stands for.
    pub(crate) fn magnitude(self, level: u8) -> f64 {
        self.low + f64::from(level) * self.step
    }
}
