//! Sixteen rays cut by a grid's box and a clip, in f64, in loops that the compiler makes vector code of.

use glam::{DMat3, DVec3};

use super::LANES;
use vr_core::Clip;
use vr_core::Placement;
use vr_core::Rays;

/// The parts of sixteen rays inside a box and a clip, in index space: each as [`vr_core::IndexRay`] has it, component by component.
///
/// A ray of which nothing is left has its ends the wrong way round.
#[derive(Clone, Copy, Debug)]
pub struct Chords {
    /// Index-space position at s = 0, axis by axis.
    pub origin: [[f64; LANES]; 3],
    /// Index steps per world unit of s.
    pub direction: [[f64; LANES]; 3],
    /// Distance at which each ray enters.
    pub start: [f64; LANES],
    /// Distance at which it leaves.
    pub end: [f64; LANES],
    /// World distance from the rays' own origins to s = 0.
    pub offset: [f64; LANES],
    /// Unit vectors along the rays, in the world.
    pub along: [[f64; LANES]; 3],
}

impl Chords {
    /// Chords of the rays through points of the image (x and y, in pixels), cut by the box of a grid, the clip, and at world distances `far`.
    #[inline(always)]
    pub fn new(
        rays: &Rays,
        [x, y]: [&[f64; LANES]; 2],
        placement: &Placement,
        dims: [usize; 3],
        clip: &Clip,
        far: &[f64; LANES],
    ) -> Self {
        let rays = rays.packet(x, y);
        let (from, along) = (rays.origin, rays.direction);
        let corner = placement.origin().to_array();
        let extent = dims.map(|n| (n - 1) as f64);
        let to_middle = (placement.axes() * (0.5 * DVec3::from_array(extent))).to_array();

        // The origin moves to the point nearest the middle of the box.
        let (mut offset, mut base) = ([0.0; LANES], [[0.0; LANES]; 3]);
        for i in 0..LANES {
            let m: [f64; 3] = std::array::from_fn(|a| (corner[a] - from[a][i]) + to_middle[a]);
            offset[i] = m[0] * along[0][i] + m[1] * along[1][i] + m[2] * along[2][i];
        }
        for a in 0..3 {
            for i in 0..LANES {
                base[a][i] = (from[a][i] - corner[a]) + along[a][i] * offset[i];
            }
        }
        // Rays in index space.
        let inverse = placement.inverse_axes();
        let (origin, direction) = (times(&inverse, &base), times(&inverse, &along));

        // Cut them by the far distance, the box and the clip.
        let (mut start, mut end) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            (start[i], end[i]) = (-offset[i], far[i] - offset[i]);
        }
        for a in 0..3 {
            keep_between(&mut start, &mut end, &origin[a], &direction[a], 0.0, extent[a]);
        }
        if clip.crop.is_some() || !clip.planes.is_empty() {
            clip_chords(clip, &mut start, &mut end, &from, &along, &offset);
        }
        Self { origin, direction, start, end, offset, along }
    }
}

/// Cuts rays by a crop box and planes.
fn clip_chords(
    clip: &Clip,
    start: &mut [f64; LANES],
    end: &mut [f64; LANES],
    from: &[[f64; LANES]; 3],
    along: &[[f64; LANES]; 3],
    offset: &[f64; LANES],
) {
    let world: [[f64; LANES]; 3] =
        std::array::from_fn(|a| std::array::from_fn(|i| from[a][i] + along[a][i] * offset[i]));
    if let Some((low, high)) = clip.crop {
        for a in 0..3 {
            keep_between(start, end, &world[a], &along[a], low[a], high[a]);
        }
    }
    for plane in &clip.planes {
        let n = plane.normal.to_array();
        let dot = |v: &[[f64; LANES]; 3], i: usize| n[0] * v[0][i] + n[1] * v[1][i] + n[2] * v[2][i];
        let at = std::array::from_fn(|i| dot(&world, i) - plane.offset);
        let slope = std::array::from_fn(|i| dot(along, i));
        keep_between(start, end, &at, &slope, 0.0, f64::INFINITY);
    }
}

/// A matrix times sixteen vectors.
#[inline(always)]
fn times(matrix: &DMat3, v: &[[f64; LANES]; 3]) -> [[f64; LANES]; 3] {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|c| c.to_array());
    let mut product = [[0.0; LANES]; 3];
    for a in 0..3 {
        for i in 0..LANES {
            product[a][i] = x[a] * v[0][i] + y[a] * v[1][i] + z[a] * v[2][i];
        }
    }
    product
}

/// Keeps the s with low ≤ x + s·slope ≤ high, ray by ray; a ray parallel to the slab stays whole or goes whole.
#[inline(always)]
fn keep_between(
    start: &mut [f64; LANES],
    end: &mut [f64; LANES],
    x: &[f64; LANES],
    slope: &[f64; LANES],
    low: f64,
    high: f64,
) {
    for i in 0..LANES {
        let parallel = slope[i] == 0.0;
        // Divisions are what a packet's set-up waits for.
        let inverse = 1.0 / if parallel { 1.0 } else { slope[i] };
        let (a, b) = ((low - x[i]) * inverse, (high - x[i]) * inverse);
        let inside = low <= x[i] && x[i] <= high;
        let enter = if a < b { a } else { b };
        let leave = if a < b { b } else { a };
        let enter = if parallel { f64::NEG_INFINITY } else { enter };
        let outside = if inside { f64::INFINITY } else { f64::NEG_INFINITY };
        let leave = if parallel { outside } else { leave };
        start[i] = if enter > start[i] { enter } else { start[i] };
        end[i] = if leave < end[i] { leave } else { end[i] };
    }
}
