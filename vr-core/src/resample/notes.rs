//! Report of a resampling, in words.

use super::run::{Correction, Resampled};
use crate::number_text::number_text;
use crate::resample::Integral;

impl Resampled {
    /// Describes the steps taken and the error of each, one note a line.
    pub fn notes(&self) -> Vec<String> {
        let times = |dims: [String; 3]| dims.join("×");
        let spacing = self.grid.placement().spacing().to_array().map(number_text).join(" ");
        let vacuum = match self.vacuum {
            0 => "none is vacuum".to_owned(),
            _ => format!("{:.1} % of them are vacuum", 100.0 * self.vacuum_share()),
        };
        let (kind, filter, dims) = (self.kind, self.choices.filter, times(self.grid.dims().map(|n| n.to_string())));
        let mut notes =
            vec![format!("resampled: {kind} to {dims} voxels, {spacing} apart, by the filter {filter}; {vacuum}")];
        if let Some(wanted) = self.wanted {
            let (wanted, most) = (times(wanted.map(|n| n.to_string())), self.choices.max_finest);
            notes.push(format!(
                "resampled: its finest cells would take {wanted}; 'finest' stops at {most} voxels: name a size for more"
            ));
        }
        let Integral { value, is_exact, .. } = self.before;
        let how = if is_exact { "" } else { ", estimated" };
        let (before, after, error) = (number_text(value), number_text(self.after.value), self.integral_error());
        notes.push(format!("resampled: the integral was {before}{how}, and is {after}: off by {error:.1e} of it"));
        match self.correction {
            Some(Correction::Factor(factor)) => {
                notes.push(format!("resampled: every voxel times {factor:.6}, to conserve the integral"));
            }
            Some(Correction::Shift(shift)) => {
                let shift = number_text(shift);
                notes.push(format!(
                    "resampled: every voxel plus {shift}, to conserve the integral of values of both signs"
                ));
            }
            None => {}
        }
        notes
    }
}
