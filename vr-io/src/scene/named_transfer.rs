//! A transfer function that a scene file names, by preset or file, and what comes with it: shading, operator and filter.

use vr_core::{Compositing, ControlPoint, Filter, Light, OpacityRule, Shading, Volume};
use vr_look::FittedPreset;

use crate::transfer::TransferFile;

use super::scene_file::SceneFile;
use super::sections::{CompositingName, ShadingSection, TransferSection};
use super::transfer_points::TransferPoints;

/// Control points, and what is meant to go with them where the scene says nothing else.
pub(super) struct NamedTransfer {
    points: TransferPoints,
    shading: Option<Shading>,
    compositing: Option<Compositing>,
    filter: Option<Filter>,
    unit_distance: Option<f64>,
    opacity_rule: Option<OpacityRule>,
}

impl From<TransferPoints> for NamedTransfer {
    fn from(points: TransferPoints) -> Self {
        Self { points, shading: None, compositing: None, filter: None, unit_distance: None, opacity_rule: None }
    }
}

impl From<FittedPreset> for NamedTransfer {
    fn from(preset: FittedPreset) -> Self {
        let FittedPreset { points, shading, compositing, .. } = preset;
        Self { shading, compositing, ..TransferPoints::from(points).into() }
    }
}

impl NamedTransfer {
    /// The transfer function of a file for a volume: stretched over a range that the scene asks for, or over all values where the file has none
    /// of its own. `spacing` is the mean distance of the volume's voxels.
    pub fn of_file(file: &TransferFile, asked: Option<(f64, f64)>, values: (f64, f64), spacing: f64) -> Self {
        let range = asked.or_else(|| (!file.absolute).then_some(values));
        Self {
            points: file.transfer_points(range),
            shading: file.shading_at(spacing),
            compositing: None,
            filter: file.filter,
            unit_distance: file.unit_distance,
            opacity_rule: file.opacity_rule,
        }
    }

    /// The same in white for a volume that has colours, which are shown as they are.
    pub fn beside(mut self, volume: &Volume) -> Self {
        if volume.has_colors() {
            self.points = self.points.map(|p| ControlPoint { color: [1.0; 3], ..*p });
        }
        self
    }

    /// Writes into a section what it leaves open.
    pub fn complete(&self, section: &mut TransferSection) {
        section.unit_distance = section.unit_distance.or(self.unit_distance);
        if section.opacity_rule == OpacityRule::default() {
            section.opacity_rule = self.opacity_rule.unwrap_or_default();
        }
    }

    /// Writes into a scene what it leaves open, and returns the points.
    pub fn apply(self, file: &mut SceneFile, notes: &mut Vec<String>) -> TransferPoints {
        if self.compositing == Some(Compositing::Maximum) && file.render.compositing == CompositingName::Over {
            file.render.compositing = CompositingName::Maximum;
            notes.push("the preset is made for compositing = \"maximum\", which is taken".to_owned());
        }
        // Operators that pick a value show no surface.
        let is_lit = matches!(
            file.render.compositing,
            CompositingName::Over | CompositingName::First | CompositingName::Accumulate
        );
        if file.shading.is_none() && is_lit {
            file.shading = self.shading.map(|shading| ShadingSection::describe(&shading, &[Light::default()]));
        }
        file.volume.filter = file.volume.filter.or(self.filter);
        self.points
    }
}
