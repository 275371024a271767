//! A grid with colours along a ray: the values' line, and one of each channel.

use vr_core::field::{Chord, Cut, FieldLine, LineColor, LineModel};
use vr_core::filter::Reconstruction;
use vr_core::{Calibration, ColorGrid, Sampler, Voxel};

use crate::exact_ray::{ExactPlacement, IndexChord};
use crate::grid_line::{GradientSource, GridLine};
use vr_core::bound::{Bound, largest};

/// A grid's field along a ray, and the colours of its places.
pub(crate) struct ColoredLine<'a, T, F, C> {
    line: GridLine<'a, T, F>,
    channels: [GridLine<'a, u16, C>; 3],
}

impl<'a, T, F, C: Reconstruction> ColoredLine<'a, T, F, C> {
    /// Adds the colours of a grid, under their filter `C`, to the line of its values.
    pub(crate) fn new(
        line: GridLine<'a, T, F>,
        colors: &'a ColorGrid,
        placement: &ExactPlacement,
        chord: IndexChord,
    ) -> Self {
        let light = Calibration { slope: 1.0 / f64::from(ColorGrid::WHITE), intercept: 0.0 };
        let channel = |lattice| {
            let sampler = Sampler::<u16, C>::new(lattice, None);
            GridLine::along(light, placement, sampler, chord, GradientSource::None)
        };
        Self { line, channels: colors.channels().map(channel) }
    }
}

impl<T: Voxel, F: Reconstruction, C: Reconstruction> FieldLine for ColoredLine<'_, T, F, C> {
    fn chord(&self) -> Chord {
        self.line.chord()
    }

    // Colours change at no other places: their polynomials do at the faces of cells, or with the nearest filter half-way between two voxels as the values.
    fn breakpoints(&self, out: &mut Vec<f64>) {
        self.line.breakpoints(out);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        self.line.between(from, to)
    }

    fn color(&self, from: f64, to: f64) -> Option<LineColor> {
        let [red, green, blue] = self.channels.each_ref().map(|channel| channel.between(from, to));
        let models = [red?, green?, blue?];
        let error = models.iter().map(LineModel::error).fold(Bound::ZERO, Bound::max).value();
        Some(LineColor { channels: models.map(|model| model.field), error })
    }

    fn misplaced(&self, at: f64) -> f64 {
        largest([&self.line as &dyn FieldLine, &self.channels[0]].map(|line| line.misplaced(at)))
    }

    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        self.line.cuts(out);
    }
}
