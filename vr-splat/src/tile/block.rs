//! Sixteen rays: a square of four by four pixels.

use glam::DVec3;
use vr_core::{Clip, Layer, Placement, Ray, Rays};
use vr_kernels::vector::{Chords, LANES, Lanes};

use crate::projection::SplatView;

/// Pixels along the edge of a block.
pub(crate) const EDGE: u32 = 4;

/// Sixteen rays, as splats meet them.
#[derive(Clone, Copy)]
pub(crate) struct Block {
    /// X and Y.
    pub(crate) lateral: [Lanes; 2],
    /// N: change in kernel space per unit of depth, along the ray.
    pub(crate) along: [Lanes; 3],
    /// The view's x and y axes in kernel space, times N.
    pub(crate) across: [Lanes; 2],
    /// 1 / |N|².
    pub(crate) inverse_square: Lanes,
    /// |N|, and 1 over that.
    pub(crate) speed: Lanes,
    pub(crate) inverse_speed: Lanes,
    /// World length per unit of depth.
    pub(crate) stretch: Lanes,
    /// Depths behind the view's base between which there may be something; the wrong way round where there is nothing.
    pub(crate) near: Lanes,
    pub(crate) far: Lanes,
    /// Interval of depths in which no ray is cut, of those that are not empty.
    pub(crate) uncut: [f32; 2],
    /// Index-space position in a grid at depth 0, and its change per unit of depth.
    pub(crate) index: [[Lanes; 3]; 2],
}

/// Bounds that cut rays.
pub(crate) struct Bounds<'a> {
    pub(crate) clip: &'a Clip,
    pub(crate) layer: Option<&'a Layer>,
    /// Subpixels along the edge of a pixel.
    pub(crate) samples: u32,
    /// A grid in which positions are looked up.
    pub(crate) grid: Option<(&'a Placement, [usize; 3])>,
    /// True if its box cuts the rays, too.
    pub(crate) boxed: bool,
}

impl Block {
    pub(crate) const EMPTY: Self = Self {
        lateral: [Lanes::ZERO; 2],
        along: [Lanes::ZERO; 3],
        across: [Lanes::ZERO; 2],
        inverse_square: Lanes::ZERO,
        speed: Lanes::ZERO,
        inverse_speed: Lanes::ZERO,
        stretch: Lanes::ZERO,
        near: Lanes::ZERO,
        far: Lanes::ZERO,
        uncut: [0.0; 2],
        index: [[Lanes::ZERO; 3]; 2],
    };

    /// The rays of the block whose first pixel is (column, row); those beyond the picture have nothing.
    pub(crate) fn set_up(&mut self, view: &SplatView, bounds: &Bounds<'_>, column: u32, row: u32) {
        let axes = view.kernel.axes;
        let pixels: [[u32; 2]; LANES] = std::array::from_fn(|i| [column + i as u32 % EDGE, row + i as u32 / EDGE]);
        let inside = |[x, y]: [u32; 2]| x < view.size[0] && y < view.size[1];
        let mut stretch = [0.0; LANES];
        for i in 0..LANES {
            let [x, y] = view.lateral(f64::from(pixels[i][0]) + 0.5, f64::from(pixels[i][1]) + 0.5);
            stretch[i] = view.stretch([x, y]);
            let n = if view.perspective { axes.x_axis * x + axes.y_axis * y + axes.z_axis } else { axes.z_axis };
            let square = n.length_squared();
            (self.lateral[0].0[i], self.lateral[1].0[i]) = (x as f32, y as f32);
            for a in 0..3 {
                self.along[a].0[i] = n[a] as f32;
            }
            (self.across[0].0[i], self.across[1].0[i]) = (axes.x_axis.dot(n) as f32, axes.y_axis.dot(n) as f32);
            self.inverse_square.0[i] = (1.0 / square) as f32;
            self.speed.0[i] = square.sqrt() as f32;
            self.inverse_speed.0[i] = (1.0 / square.sqrt()) as f32;
            self.stretch.0[i] = stretch[i] as f32;
        }
        let far = pixels.map(|[x, y]| match bounds.layer {
            Some(layer) if inside([x, y]) => {
                let across = view.size[0] / bounds.samples;
                layer.depth((y / bounds.samples * across + x / bounds.samples) as usize)
            }
            _ => f64::INFINITY,
        });
        let (near, far) = self.ends(view, bounds, &pixels, &stretch, &far);
        for i in 0..LANES {
            let (near, far) = if inside(pixels[i]) { (near[i], far[i]) } else { (1.0, 0.0) };
            // Within f32, and far from its end.
            (self.near.0[i], self.far.0[i]) = (near.max(-1e30) as f32, far.min(1e30) as f32);
        }
        let ends = self.near.0.iter().zip(&self.far.0).filter(|(near, far)| near < far);
        self.uncut =
            ends.fold([f32::NEG_INFINITY, f32::INFINITY], |[from, to], (near, far)| [from.max(*near), to.min(*far)]);
    }

    /// Between which depths rays are cut off by the clip, the layer, the eye, and the grid's box.
    fn ends(
        &mut self,
        view: &SplatView,
        bounds: &Bounds<'_>,
        pixels: &[[u32; 2]; LANES],
        stretch: &[f64; LANES],
        far: &[f64; LANES],
    ) -> ([f64; LANES], [f64; LANES]) {
        let centres = [0, 1].map(|a| pixels.map(|p| f64::from(p[a]) + 0.5));
        let depth = |i: usize, s: f64| s / stretch[i] - view.base;
        let Some((placement, dims)) = bounds.grid else {
            return free_ends(&view.rays, bounds.clip, &centres, far, depth);
        };
        let chords = Chords::new(&view.rays, [&centres[0], &centres[1]], placement, dims, bounds.clip, far);
        for i in 0..LANES {
            // From world distances from the middle of the box to depths.
            let at_base = stretch[i] * view.base - chords.offset[i];
            for a in 0..3 {
                let (from, step) = (chords.origin[a][i], chords.direction[a][i]);
                self.index[0][a].0[i] = (from + step * at_base) as f32;
                self.index[1][a].0[i] = (step * stretch[i]) as f32;
            }
        }
        if bounds.boxed {
            (
                std::array::from_fn(|i| depth(i, chords.start[i] + chords.offset[i])),
                std::array::from_fn(|i| depth(i, chords.end[i] + chords.offset[i])),
            )
        } else {
            free_ends(&view.rays, bounds.clip, &centres, far, depth)
        }
    }

    /// Number of the rays along which there may be something.
    pub(crate) fn rays(&self) -> u32 {
        (0..LANES).filter(|&i| self.near.0[i] < self.far.0[i]).count() as u32
    }
}

/// The ends of rays that no box cuts.
fn free_ends(
    rays: &Rays,
    clip: &Clip,
    centres: &[[f64; LANES]; 2],
    far: &[f64; LANES],
    depth: impl Fn(usize, f64) -> f64,
) -> ([f64; LANES], [f64; LANES]) {
    if *clip == Clip::default() {
        return (std::array::from_fn(|i| depth(i, 0.0)), std::array::from_fn(|i| depth(i, far[i])));
    }
    let packet = rays.packet(&centres[0], &centres[1]);
    let (mut start, mut end) = ([1.0; LANES], [0.0; LANES]);
    for i in 0..LANES {
        let vector = |v: &[[f64; LANES]; 3]| DVec3::new(v[0][i], v[1][i], v[2][i]);
        let ray = Ray { origin: vector(&packet.origin), direction: vector(&packet.direction) };
        if let Some([from, to]) = ray.inside(clip) {
            (start[i], end[i]) = (depth(i, from), depth(i, to.min(far[i])));
        }
    }
    (start, end)
}

/// Unit vectors along the rays of the block whose first pixel is (column, row), in the world.
pub(crate) fn directions(view: &SplatView, column: u32, row: u32) -> [[f64; LANES]; 3] {
    let x = std::array::from_fn(|i| f64::from(column + i as u32 % EDGE) + 0.5);
    let y = std::array::from_fn(|i| f64::from(row + i as u32 / EDGE) + 0.5);
    view.rays.packet(&x, &y).direction
}
