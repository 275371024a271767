//! From what tiles gathered to the picture.

use glam::DVec3;
use vr_core::{Calibration, Compositing, Frame, GridVolume, Layer, Scene, View};
use vr_kernels::vector::Operator;

use crate::grid_gradients::{Gradients, world_gradient};
use crate::projection::SplatView;
use crate::splatter::Splatter;
use crate::tile::{Drawn, State};

/// The picture, as tiles join it.
pub(crate) struct Picture<'a> {
    renderer: &'a Splatter,
    scene: &'a Scene,
    view: &'a View,
    calibration: Calibration,
    operator: Operator,
    /// Smallest of a pixel's subpixels; none back to front, where light does not know what will be before it.
    depth: Option<Vec<f64>>,
    pixels: Vec<[f64; 4]>,
}

impl<'a> Picture<'a> {
    pub(crate) fn new(
        renderer: &'a Splatter,
        scene: &'a Scene,
        view: &'a View,
        calibration: Calibration,
        operator: Operator,
    ) -> Self {
        let count = view.size[0] as usize * view.size[1] as usize;
        let depth = (operator != Operator::Over).then(|| vec![f64::INFINITY; count]);
        Self { renderer, scene, view, calibration, operator, depth, pixels: vec![[0.0; 4]; count] }
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
                let rgba = self.tinted(self.picked(state, lane), state, lane, [x, y], splat_view);
                self.shaded(rgba, state, lane, [x, y], splat_view)
            };
            let at = (y / n) as usize * width + (x / n) as usize;
            if let Some(depth) = &mut self.depth {
                let seen = state.depth(self.operator, lane);
                if seen < f64::INFINITY {
                    let stretch = splat_view.stretch(splat_view.lateral(f64::from(x) + 0.5, f64::from(y) + 0.5));
                    depth[at] = depth[at].min((seen + splat_view.base) * stretch);
                }
            }
            let pixel = &mut self.pixels[at];
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

    /// Multiplies light of a picked value by the colour of its place, or of a mean by that of the ray, where voxels have colours.
    fn tinted(&self, rgba: [f64; 4], state: &State, lane: usize, pixel: [u32; 2], seen: &SplatView) -> [f64; 4] {
        let Some(colors) = self.scene.volume.colors().filter(|_| rgba[3] > 0.0) else { return rgba };
        let [x, y, z] = match self.operator {
            Operator::Average => state.light.map(|sum| f64::from(sum.0[lane]) / f64::from(state.length.0[lane])),
            _ => {
                let place = self.place(state, lane, pixel, seen);
                colors.color(index_in(colors.values(), place))
            }
        };
        let [r, g, b, alpha] = rgba;
        [r * x, g * y, b * z, alpha]
    }

    /// The place in the world of what a pixel sees.
    fn place(&self, state: &State, lane: usize, [x, y]: [u32; 2], seen: &SplatView) -> DVec3 {
        let [x, y] = [x, y].map(|i| f64::from(i) + 0.5);
        let ray = seen.rays.at(x, y);
        ray.origin + ray.direction * ((state.depth(self.operator, lane) + seen.base) * seen.stretch(seen.lateral(x, y)))
    }

    /// Shades the surface of a first hit, by the gradient where the ray meets it.
    fn shaded(&self, rgba: [f64; 4], state: &State, lane: usize, [x, y]: [u32; 2], seen: &SplatView) -> [f64; 4] {
        let (Operator::First { .. }, Some(shading)) = (self.operator, self.scene.reflection()) else { return rgba };
        if rgba[3] <= 0.0 {
            return rgba;
        }
        let place = self.place(state, lane, [x, y], seen);
        let world = match (self.scene.volume.value_grid(), self.scene.volume.points()) {
            (Some(grid), _) => {
                let gradients = Gradients::new(shading, self.renderer, grid);
                world_gradient(grid, gradients.at(grid, index_in(grid, place)))
            }
            (_, Some(points)) => points.gradient(place).unwrap_or_default(),
            _ => return rgba,
        };
        let [x, y] = [x, y].map(|i| f64::from(i) + 0.5);
        shading.along(&self.scene.lights, seen.rays.at(x, y).direction).shade(rgba, world.to_array())
    }

    /// The whole picture, over the scene's surfaces.
    pub(crate) fn finish(self, layer: Option<&Layer>) -> Frame {
        let over = |(i, rgba): (usize, [f64; 4])| layer.map_or(rgba, |l| l.under(i, rgba)).map(|x| x as f32);
        let nearest = |(i, depth): (usize, f64)| layer.map_or(depth, |l| depth.min(l.depth(i))) as f32;
        let depth = self.depth.map(|all| all.into_iter().enumerate().map(nearest).collect());
        Frame::new(self.view.size, self.pixels.into_iter().enumerate().map(over).collect(), depth)
    }
}

/// Position in a grid of a place in the world, or the nearest one that is in it.
fn index_in(grid: &GridVolume, place: DVec3) -> [f64; 3] {
    let placement = grid.placement();
    let index = placement.inverse_axes() * (place - placement.origin());
    let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
    index.clamp(DVec3::ZERO, last).to_array()
}
