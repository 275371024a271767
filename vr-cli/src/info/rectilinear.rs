//! `vr info` of a rectilinear grid.

use serde::Serialize;
use vr_core::RectilinearGrid;
use vr_core::resample::Integral;
use vr_io::LoadedVolume;
use vr_look::Histogram;

use crate::info::facts::Facts;
use crate::info::lines::COLUMNS;
use crate::number;

/// Description of a rectilinear grid.
#[derive(Serialize)]
pub struct RectilinearInfo<'a> {
    #[serde(flatten)]
    facts: Facts<'a>,
    /// Values along x, y and z.
    dims: [usize; 3],
    /// Smallest, mean and largest step of each axis.
    steps: [[f64; 3]; 3],
    /// Cubic units that are not vacuum.
    total_volume: f64,
    /// Number of values that are missing.
    missing: usize,
    /// Smallest and largest value, if there is any.
    range: Option<[f64; 2]>,
    #[serde(skip)]
    histogram: Option<Histogram>,
}

impl<'a> RectilinearInfo<'a> {
    pub fn new(title: &'a str, loaded: &'a LoadedVolume, grid: &RectilinearGrid) -> Self {
        let range = grid.value_range();
        let stats = grid.lattice().value_stats();
        Self {
            facts: Facts::new(title, loaded, grid.bounds(), range),
            dims: grid.dims(),
            steps: grid.axes().each_ref().map(|axis| [axis.smallest_step(), axis.mean_step(), axis.largest_step()]),
            total_volume: Integral::of(&loaded.volume).map_or(f64::NAN, |integral| integral.volume),
            missing: stats.nan + stats.infinite,
            range: range.map(|(low, high)| [low, high]),
            histogram: Histogram::of(grid.lattice(), COLUMNS),
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut lines = self.facts.begin("values");
        lines.add("size", format!("{} values where uneven planes meet", number::triple(self.dims, "×")));
        lines.add("bounds", self.facts.bounds());
        for (axis, steps) in ["x", "y", "z"].into_iter().zip(self.steps) {
            let [least, mean, largest] = steps.map(number::value);
            lines.add(&format!("steps on {axis}"), format!("{least} to {largest}, {mean} in the mean"));
        }
        let filled = number::value(self.total_volume);
        lines.add("cells", format!("{filled} cubic units; {} values are missing", self.missing));
        if let Some([min, max]) = self.range.map(|range| range.map(number::value)) {
            lines.add("values", format!("{min} to {max}"));
        }
        self.facts.end(lines, self.histogram.as_ref(), "number of values")
    }
}
