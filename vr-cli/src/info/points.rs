//! `vr info` of scattered points.

use serde::Serialize;
use vr_core::PointSet;
use vr_io::LoadedVolume;

use crate::info::facts::Facts;
use crate::number;

/// Description of scattered points.
#[derive(Serialize)]
pub struct PointsInfo<'a> {
    #[serde(flatten)]
    facts: Facts<'a>,
    points: usize,
    kernel: &'static str,
    /// Combination of values where kernels overlap.
    mixing: &'static str,
    /// True if points have colours.
    colors: bool,
    /// Smallest and largest radius of the points.
    radius: [f32; 2],
    weight_sum: f64,
    /// Smallest and largest value that a point carries.
    values: [f32; 2],
    /// Bounds of the field that the points make.
    field: [f64; 2],
}

impl<'a> PointsInfo<'a> {
    pub fn new(title: &'a str, loaded: &'a LoadedVolume, points: &PointSet) -> Self {
        let (min, max) = points.value_range();
        Self {
            facts: Facts::new(title, loaded, points.bounds(), Some((min, max))),
            points: points.count(),
            kernel: points.kernel().name(),
            mixing: points.mixing().name(),
            colors: points.colors().is_some(),
            radius: ends(points.radii()),
            weight_sum: points.weights().iter().map(|&w| f64::from(w)).sum(),
            values: ends(points.values()),
            field: [min, max],
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut lines = self.facts.begin("positions");
        let colors = if self.colors { ", with colours" } else { "" };
        lines.add("size", format!("{} points, spread by a {} kernel{colors}", self.points, self.kernel));
        lines.add("bounds", format!("{}, with all supports", self.facts.bounds()));
        let range = |[low, high]: [f64; 2]| format!("{} to {}", number::value(low), number::value(high));
        lines.add("radii", range(self.radius.map(f64::from)));
        lines.add("weights", format!("{} in all", number::value(self.weight_sum)));
        lines.add("values", range(self.values.map(f64::from)));
        lines.add("field", format!("{} of what is spread, within {}", self.mixing, range(self.field)));
        self.facts.end(lines, None, "")
    }
}

/// Returns the smallest and largest of the numbers.
fn ends(numbers: &[f32]) -> [f32; 2] {
    numbers.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}
