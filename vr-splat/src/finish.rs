//! From what tiles gathered to the picture.

use vr_core::{Calibration, Compositing, Frame, IndexRay, Rays, Scene, View};

use crate::projection::SplatView;
use crate::tile::{Drawn, State};

/// The picture, as tiles join it.
pub(crate) struct Picture<'a> {
    scene: &'a Scene,
    view: &'a View,
    calibration: Calibration,
    /// Where states hold sums over whole kernels: what was subtracted from the numbers that were summed.
    sums: Option<f32>,
    pixels: Vec<[f64; 4]>,
}

impl<'a> Picture<'a> {
    pub(crate) fn new(scene: &'a Scene, view: &'a View, calibration: Calibration, sums: Option<f32>) -> Self {
        let count = view.size[0] as usize * view.size[1] as usize;
        Self { scene, view, calibration, sums, pixels: vec![[0.0; 4]; count] }
    }

    /// Adds a tile; tiles must come in an order that is always the same.
    pub(crate) fn take(&mut self, tile: &Drawn, splat_view: &SplatView) {
        let n = self.view.samples;
        let share = 1.0 / f64::from(n * n);
        let width = self.view.size[0] as usize;
        tile.each(splat_view.size, |[x, y], state, lane| {
            let rgba = if self.scene.compositing.integrates_light() {
                let [r, g, b] = [0, 1, 2].map(|c| f64::from(state.light[c].0[lane]));
                [r, g, b, 1.0 - f64::from(state.clear.0[lane])]
            } else {
                self.picked(state, lane, &splat_view.rays, [x, y])
            };
            let pixel = &mut self.pixels[(y / n) as usize * width + (x / n) as usize];
            for c in 0..4 {
                pixel[c] += share * rgba[c];
            }
        });
    }

    /// Light and opacity of a value, as they are given.
    fn picked(&self, state: &State, lane: usize, rays: &Rays, [x, y]: [u32; 2]) -> [f64; 4] {
        let (value, length) = (f64::from(state.value.0[lane]), f64::from(state.length.0[lane]));
        let stored = match self.scene.compositing {
            Compositing::Average if self.sums.is_some() => {
                let offset = f64::from(self.sums.unwrap_or_default());
                let Some(grid) = self.scene.volume.uniform() else { return [0.0; 4] };
                let ray = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let far = f64::INFINITY;
                let chord = IndexRay::new(&ray, grid.placement(), grid.dims(), &self.view.clip, far);
                let Some(chord) = chord else { return [0.0; 4] };
                (value + offset * length) / chord.length() - offset
            }
            _ if length <= 0.0 => return [0.0; 4],
            Compositing::Average => value / length,
            Compositing::First { .. } if state.clear.0[lane] > 0.0 => return [0.0; 4],
            _ => value,
        };
        let at = self.scene.transfer.at(self.calibration.value(stored));
        if let Compositing::First { .. } = self.scene.compositing {
            let [r, g, b] = at.color;
            return [r, g, b, 1.0];
        }
        let [r, g, b] = at.color.map(|c| c * at.opacity);
        [r, g, b, at.opacity]
    }

    /// The whole picture, over the view's layer.
    pub(crate) fn finish(self) -> Frame {
        let layer = self.view.layer.as_deref();
        let over = |(i, rgba): (usize, [f64; 4])| layer.map_or(rgba, |l| l.under(i, rgba)).map(|x| x as f32);
        Frame::new(self.view.size, self.pixels.into_iter().enumerate().map(over).collect(), None)
    }
}
