//! From what tiles gathered to the picture.

use vr_core::{Calibration, Compositing, Frame, Layer, Scene, View};

use crate::projection::SplatView;
use crate::tile::{Drawn, State};

/// The picture, as tiles join it.
pub(crate) struct Picture<'a> {
    scene: &'a Scene,
    view: &'a View,
    calibration: Calibration,
    pixels: Vec<[f64; 4]>,
}

impl<'a> Picture<'a> {
    pub(crate) fn new(scene: &'a Scene, view: &'a View, calibration: Calibration) -> Self {
        let count = view.size[0] as usize * view.size[1] as usize;
        Self { scene, view, calibration, pixels: vec![[0.0; 4]; count] }
    }

    /// Adds a tile; tiles must come in an order that is always the same.
    pub(crate) fn take(&mut self, tile: &Drawn, splat_view: &SplatView) {
        let n = self.view.supersampling;
        let share = 1.0 / f64::from(n * n);
        let width = self.view.size[0] as usize;
        tile.each(splat_view.size, |[x, y], state, lane| {
            let rgba = if self.scene.compositing.integrates_light() {
                let [r, g, b] = [0, 1, 2].map(|c| f64::from(state.light[c].0[lane]));
                [r, g, b, 1.0 - f64::from(state.clear.0[lane])]
            } else {
                self.picked(state, lane)
            };
            let pixel = &mut self.pixels[(y / n) as usize * width + (x / n) as usize];
            for c in 0..4 {
                pixel[c] += share * rgba[c];
            }
        });
    }

    /// Light and opacity of a value, as they are given.
    fn picked(&self, state: &State, lane: usize) -> [f64; 4] {
        let (value, length) = (f64::from(state.value.0[lane]), f64::from(state.length.0[lane]));
        let stored = match self.scene.compositing {
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
        at.pixel()
    }

    /// The whole picture, over the scene's surfaces.
    pub(crate) fn finish(self, layer: Option<&Layer>) -> Frame {
        let over = |(i, rgba): (usize, [f64; 4])| layer.map_or(rgba, |l| l.under(i, rgba)).map(|x| x as f32);
        Frame::new(self.view.size, self.pixels.into_iter().enumerate().map(over).collect(), None)
    }
}
