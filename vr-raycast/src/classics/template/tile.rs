//! The rays of a tile of the base plane, all one step further at a time.

use vr_core::{AnyGrid, Counts, UniformGrid, Voxel, with_grid};
use vr_kernels::tables::BakedTransfer;

use super::Connectivity;
use super::base_plane::BasePlane;

/// Pixels of a tile along u: whole rows of vector code.
pub(crate) const ACROSS: usize = 64;
/// Pixels of a tile along v.
pub(crate) const DOWN: usize = 16;
/// Voxels of a slice that a tile needs beyond its own, while its rays pass from the slice before to the one behind: they move by two at
/// most, and interpolate with one more; one for rounding.
const BEYOND: usize = 4;
const WIDTH: usize = ACROSS + BEYOND;
const HEIGHT: usize = DOWN + BEYOND;

/// Steps summed in f32 before they join the sums in f64, as in the plain engine.
const RUN: usize = 32;

/// Step of the template, the same for all rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TemplateStep {
    /// Position of the sample.
    pub(crate) t: f64,
    /// Begin and length of the step, in slices.
    pub(crate) begin: f64,
    pub(crate) length: f64,
    /// Index of the table for the length.
    pub(crate) table: usize,
}

/// Data that all tiles share.
pub(crate) struct TemplateRays<'a> {
    pub(crate) plane: &'a BasePlane,
    pub(crate) grid: &'a AnyGrid,
    pub(crate) connectivity: Connectivity,
    pub(crate) steps: &'a [TemplateStep],
    pub(crate) tables: &'a [BakedTransfer<f32>],
    /// Opacity at which no ray needs to go on.
    pub(crate) enough: f64,
}

/// Results of the rays of a tile, row by row: colours, and the positions where opacity reaches ½, in slices.
pub(crate) struct Tile {
    pub(crate) rgba: Vec<[f32; 4]>,
    pub(crate) depth: Vec<f32>,
}

/// The voxels of a slice that a tile needs, as f32; repeated beyond the volume's edges.
struct Slice {
    /// Number of the slice from the face; none at first.
    t: usize,
    /// Index of the first voxel along u and v.
    first: [i64; 2],
    voxels: Box<[[f32; WIDTH]; HEIGHT]>,
}

impl TemplateRays<'_> {
    /// Draws the tile whose first pixel is `corner`, counted from the plane's first.
    pub(crate) fn tile(&self, corner: [usize; 2], counts: &mut Counts) -> Tile {
        let plane = self.plane;
        let across = ACROSS.min(plane.size[0] - corner[0]);
        let down = DOWN.min(plane.size[1] - corner[1]);
        let first = [0, 1].map(|a| plane.first[a] + corner[a] as i64);
        let mut total = vec![[0.0f64; 4]; ACROSS * DOWN];
        let mut run = vec![[0.0f32; 4]; ACROSS * DOWN];
        let mut depth = vec![f32::INFINITY; ACROSS * DOWN];
        let none = || Slice { t: usize::MAX, first: [0; 2], voxels: Box::new([[0.0; WIDTH]; HEIGHT]) };
        let mut slices = [none(), none()];
        let mut values = [0.0f32; ACROSS];
        let mut ended = [false; DOWN];
        let mut touched = false;
        for (number, step) in self.steps.iter().enumerate() {
            let moved = self.moved(step.t);
            let table = &self.tables[step.table];
            for row in 0..down {
                if ended[row] {
                    continue;
                }
                let inside = plane.pixels_inside(first[1] + row as i64, step.t, moved);
                let low = (inside.start - first[0]).clamp(0, across as i64) as usize;
                let high = (inside.end - first[0]).clamp(0, across as i64) as usize;
                if low >= high {
                    continue;
                }
                touched = true;
                counts.samples += (high - low) as u64;
                let values = &mut values[low..high];
                self.sample(values, [low, row], first, step.t, moved, &mut slices);
                let place = row * ACROSS + low;
                let sums = &mut run[place..place + values.len()];
                for (k, (sum, &value)) in sums.iter_mut().zip(values.iter()).enumerate() {
                    let light = table.step(value);
                    let before = sum[3];
                    let clear = 1.0 - before;
                    for c in 0..4 {
                        sum[c] += clear * light[c];
                    }
                    // Rare: once a ray.
                    let behind = total[place + k][3];
                    let opacity = |a: f32| behind + (1.0 - behind) * f64::from(a);
                    if sum[3] > before && opacity(sum[3]) >= 0.5 && depth[place + k] == f32::INFINITY {
                        // A homogeneous step: opacity grows by the logarithm of what is left. An opaque one is so from its begin on.
                        let (from, to) = (1.0 - opacity(before), 1.0 - opacity(sum[3]));
                        let share = libm::log(2.0 * from) / libm::log(from / to);
                        depth[place + k] = (step.begin + share.clamp(0.0, 1.0) * step.length) as f32;
                    }
                }
            }
            if (number + 1) % RUN == 0 || number + 1 == self.steps.len() {
                for row in 0..down {
                    let mut least = 1.0f64;
                    for i in row * ACROSS..row * ACROSS + across {
                        let clear = 1.0 - total[i][3];
                        for c in 0..4 {
                            total[i][c] += clear * f64::from(run[i][c]);
                        }
                        run[i] = [0.0; 4];
                        least = least.min(total[i][3]);
                    }
                    ended[row] = least >= self.enough;
                }
                if ended[..down].iter().all(|&e| e) {
                    break;
                }
            }
        }
        if touched {
            counts.rays += (across * down) as u64;
        }
        let rows = (0..down).flat_map(|row| row * ACROSS..row * ACROSS + across);
        Tile {
            rgba: rows.clone().map(|i| total[i].map(|x| x as f32)).collect(),
            depth: rows.map(|i| depth[i]).collect(),
        }
    }

    /// Returns the distance that rays have moved along u and v in slice t.
    fn moved(&self, t: f64) -> [f64; 2] {
        match self.connectivity {
            Connectivity::Continuous => self.plane.slope.map(|s| s * t),
            // To the nearest voxel; half a step goes up. By one at most per slice: voxels touch.
            Connectivity::Discrete => self.plane.slope.map(|s| (s * t + 0.5).floor()),
        }
    }

    /// Samples a row of neighbouring rays from pixel `low` of a row of the tile on.
    fn sample(
        &self,
        values: &mut [f32],
        [low, row]: [usize; 2],
        first: [i64; 2],
        t: f64,
        moved: [f64; 2],
        slices: &mut [Slice; 2],
    ) {
        let whole = moved.map(f64::floor);
        let [tu, tv] = [0, 1].map(|a| (moved[a] - whole[a]) as f32);
        let slice = (t.floor() as usize).min(self.plane.dims[2] - 1);
        let tw = (t - slice as f64) as f32;
        // Pixel (0, 0) of the tile is at this voxel.
        let at = [0, 1].map(|a| first[a] + whole[a] as i64);
        self.fetch(slice, first, slices);
        let n = values.len();
        let rows_of = |slices: &'_ [Slice; 2], t: usize| {
            let slice = &slices[t % 2];
            let [u, v] = [0, 1].map(|a| (at[a] - slice.first[a]) as usize);
            (v + row, u + low)
        };
        if self.connectivity == Connectivity::Discrete {
            let (v, u) = rows_of(slices, slice);
            values.copy_from_slice(&slices[slice % 2].voxels[v][u..u + n]);
            return;
        }
        let bilinear = |slices: &[Slice; 2], t: usize, values: &mut [f32]| {
            let (v, u) = rows_of(slices, t);
            let voxels = &slices[t % 2].voxels;
            let (near, far) = (&voxels[v][u..u + n + 1], &voxels[v + 1][u..u + n + 1]);
            for i in 0..n {
                let a = near[i] + tu * (near[i + 1] - near[i]);
                let b = far[i] + tu * (far[i + 1] - far[i]);
                values[i] = a + tv * (b - a);
            }
        };
        bilinear(slices, slice, values);
        if tw > 0.0 {
            self.fetch(slice + 1, first, slices);
            let mut behind = [0.0; ACROSS];
            bilinear(slices, slice + 1, &mut behind[..n]);
            for (value, behind) in values.iter_mut().zip(behind) {
                *value += tw * (behind - *value);
            }
        }
    }

    /// Reads a slice from the volume, unless it is there.
    fn fetch(&self, t: usize, first: [i64; 2], slices: &mut [Slice; 2]) {
        let slice = &mut slices[t % 2];
        if slice.t != t {
            slice.t = t;
            with_grid!(self.grid, grid => self.copy_slice(grid, first, slice));
        }
    }

    fn copy_slice<T: Voxel>(&self, grid: &UniformGrid<T>, first: [i64; 2], slice: &mut Slice) {
        let (plane, t) = (self.plane, slice.t);
        // From the slice before to the one behind, rays are between these; both ends of the template's rounding included.
        slice.first = [0, 1].map(|a| {
            let ends = [t as f64 - 1.0, t as f64 + 1.0].map(|t| (plane.slope[a] * t).floor());
            first[a] + ends[0].min(ends[1]) as i64
        });
        let grid_dims = grid.dims();
        let strides = [1, grid_dims[0], grid_dims[0] * grid_dims[1]];
        let [su, sv, sw] = plane.axes.map(|a| strides[a]);
        let samples = grid.samples();
        let start = plane.slice_index(t) * sw;
        let inside = |a: usize, i: i64| i.clamp(0, plane.dims[a] as i64 - 1) as usize;
        for (j, row) in slice.voxels.iter_mut().enumerate() {
            let start = start + inside(1, slice.first[1] + j as i64) * sv;
            for (i, voxel) in row.iter_mut().enumerate() {
                *voxel = samples[start + inside(0, slice.first[0] + i as i64) * su].to_f32();
            }
        }
    }
}
