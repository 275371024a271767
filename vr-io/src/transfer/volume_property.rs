//! A volume property of VTK: opacity, colour and gradient opacity, each with points of its own, and shading. 3D Slicer's files and VTK's XML
//! hold it in three spellings.

use vr_core::{Filter, Shading};

use crate::error::FieldError;

use super::TransferFile;
use super::color_space::ColorSpace;
use super::curves::{colors, merge};
use super::opacity::opacities;

/// Parts of a volume property, not yet checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct VolumeProperty {
    /// Value, opacity, midpoint, sharpness.
    pub opacity: Vec<[f64; 4]>,
    /// Value, red, green, blue.
    pub color: Vec<[f64; 4]>,
    /// Gradient magnitude and opacity.
    pub gradient: Vec<[f64; 2]>,
    /// Ambient, diffuse, specular and power, where it is shaded.
    pub shading: Option<[f64; 4]>,
    /// True if voxels are boxes of one value.
    pub is_nearest: bool,
    /// World length that the opacities belong to.
    pub unit_distance: Option<f64>,
}

impl VolumeProperty {
    /// The transfer function of a file. `name_of` names the three parts, as messages call them: opacity, gradient opacity, colour.
    pub fn into_file(self, format: &'static str, parts: [&str; 3]) -> Result<TransferFile, FieldError> {
        let [of_opacity, of_gradient, of_color] = parts;
        for (points, part) in [(self.opacity.len(), of_opacity), (self.color.len(), of_color)] {
            if points == 0 {
                return Err(FieldError::new(part, "no points", "must have one at least"));
            }
        }
        let field = |part: &str, row: usize| format!("{part}, point {}", row + 1);
        let opacity = opacities(&self.opacity, |row, _| field(of_opacity, row))?;
        let color = colors(&self.color, ColorSpace::Rgb, |row, _| field(of_color, row))?;
        let gradient_per_voxel = self.gradient_factors(|row| field(of_gradient, row))?;
        let shading = self.shading.map(|[ambient, diffuse, specular, power]| {
            let shading = Shading { ambient, diffuse, specular, power, ..Shading::default() };
            let allowed = "must be finite and not negative";
            shading.validate().map_err(|e| FieldError::new(e.field, e.found, allowed)).map(|()| shading)
        });
        let shading = shading.transpose()?;
        let mut notes = Vec::new();
        if shading.is_some() || !gradient_per_voxel.is_empty() || self.is_nearest {
            let said = [
                (shading.is_some(), "shading"),
                (!gradient_per_voxel.is_empty(), "gradient opacity (as a factor on the extinction)"),
                (self.is_nearest, "nearest filter"),
            ];
            let said: Vec<&str> = said.iter().filter(|s| s.0).map(|s| s.1).collect();
            notes.push(format!("{} as the file has it, unless told otherwise", said.join(", ")));
        }
        Ok(TransferFile {
            shading,
            gradient_per_voxel,
            filter: self.is_nearest.then_some(Filter::Nearest),
            unit_distance: self.unit_distance,
            notes,
            ..TransferFile::of_points(format, merge(&color, &opacity), true)
        })
    }

    /// The factors on the extinction; none where all are 1, as in most files.
    fn gradient_factors(&self, field: impl Fn(usize) -> String) -> Result<Vec<(f64, f64)>, FieldError> {
        let mut factors: Vec<(f64, f64)> = Vec::new();
        let mut before = 0.0;
        for (row, &[magnitude, factor]) in self.gradient.iter().enumerate() {
            if !(magnitude >= before && magnitude.is_finite()) {
                let allowed = "magnitudes must be finite, not negative and in ascending order";
                return Err(FieldError::new(field(row), magnitude, allowed));
            }
            if !(0.0..=1.0).contains(&factor) {
                return Err(FieldError::new(field(row), factor, "opacities must be in [0, 1]"));
            }
            before = magnitude;
            // A jump is a steep slope here.
            let after = factors.last().map_or(0.0, |last| last.0 + 1e-6 * last.0.max(1e-6));
            factors.push((if factors.is_empty() { magnitude } else { magnitude.max(after) }, factor));
        }
        if factors.iter().all(|f| f.1 == 1.0) {
            factors.clear();
        }
        Ok(factors)
    }
}
