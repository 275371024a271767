//! Samples of a row of neighbouring rays, which all lie alike between the voxels.

use vr_core::{AnyGrid, Real, UniformGrid, Voxel, with_grid};

use super::base_plane::BasePlane;
use super::steps::{Place, TemplateSteps};
use crate::chord::Chord;
use crate::pipeline::SharedSamples;
use crate::run::{RUN, Run};

/// Rays of a row that are sampled together: whole rows of vector code.
pub(crate) const ACROSS: usize = 64;
/// Voxels of a row of a slice beyond the rays' own that are needed while the rays pass from the slice before to the one behind: they move by
/// two at most, and interpolate with one more; one for rounding.
const BEYOND: usize = 4;
const WIDTH: usize = ACROSS + BEYOND;

/// Samples of a row of neighbouring rays, at the template's places.
///
/// All rays have the same weights in a step, so that neighbours in memory are interpolated together. A run of steps is sampled for all rays of
/// the row when the first of them asks: no more than is asked for, but for neighbours that have ended.
pub(crate) struct RowSamples<'a, R> {
    plane: &'a BasePlane,
    steps: &'a TemplateSteps,
    grid: &'a AnyGrid,
    /// Lattice point along u and v of the first ray.
    first: [i64; 2],
    /// Ray that asks, counted from the first one.
    ray: usize,
    /// True for runs of steps that are sampled.
    sampled: Vec<bool>,
    /// Values of all rays, step by step.
    values: Vec<[R; ACROSS]>,
    /// Rows of two slices, two in each, by their parities.
    rows: [[VoxelRow<R>; 2]; 2],
}

/// Row of voxels along u, in the precision of the kernels; repeated beyond the volume's faces.
#[derive(Clone)]
struct VoxelRow<R> {
    /// Slice, counted from the face, and index along v; none at first.
    of: Option<(usize, i64)>,
    /// Index along u of the first voxel.
    first: i64,
    voxels: [R; WIDTH],
}

impl<'a, R: Real> RowSamples<'a, R> {
    /// Makes the memory for one row after another.
    pub(crate) fn new(plane: &'a BasePlane, steps: &'a TemplateSteps, grid: &'a AnyGrid) -> Self {
        let count = steps.begin.len();
        let row = VoxelRow { of: None, first: 0, voxels: [R::ZERO; WIDTH] };
        Self {
            plane,
            steps,
            grid,
            first: [0; 2],
            ray: 0,
            sampled: vec![false; count.div_ceil(RUN)],
            values: vec![[R::ZERO; ACROSS]; count],
            rows: [[row.clone(), row.clone()], [row.clone(), row]],
        }
    }

    /// Begins a row at the ray that starts at a lattice point.
    pub(crate) fn begin(&mut self, first: [i64; 2]) {
        self.first = first;
        self.sampled.fill(false);
        self.rows.iter_mut().flatten().for_each(|row| row.of = None);
    }

    /// Says which ray of the row asks.
    pub(crate) fn ask_for(&mut self, ray: usize) {
        self.ray = ray;
    }

    /// Samples a run of the template for all rays of the row.
    fn fill<T: Voxel>(&mut self, grid: &UniformGrid<T>, run: usize) {
        for number in run * RUN..((run + 1) * RUN).min(self.steps.places.len()) {
            // Voxel before the sample of the first ray, and the weights of the voxels behind it along u, v and w.
            let Place { whole, rest } = self.steps.places[number];
            let (u, v, slice) = (self.first[0] + whole[0], self.first[1] + whole[1], whole[2] as usize);
            if self.steps.beside {
                self.read(grid, slice, v);
                let row = &self.rows[slice % 2][v.rem_euclid(2) as usize];
                let at = (u - row.first) as usize;
                self.values[number].copy_from_slice(&row.voxels[at..at + ACROSS]);
                continue;
            }
            for (t, v) in [(slice, v), (slice, v + 1), (slice + 1, v), (slice + 1, v + 1)] {
                self.read(grid, t, v);
            }
            let [tu, tv, tw] = rest.map(R::from_f64);
            // Across the rows first, for one more ray than there are: its neighbour interpolates along u with it.
            let row = |t: usize, v: i64| {
                let row = &self.rows[t % 2][v.rem_euclid(2) as usize];
                let at = (u - row.first) as usize;
                &row.voxels[at..at + ACROSS + 1]
            };
            let [a, b, c, d] = [row(slice, v), row(slice, v + 1), row(slice + 1, v), row(slice + 1, v + 1)];
            let mut across = [R::ZERO; ACROSS + 1];
            for i in 0..=ACROSS {
                let (near, far) = (a[i] + tv * (b[i] - a[i]), c[i] + tv * (d[i] - c[i]));
                across[i] = near + tw * (far - near);
            }
            for (i, value) in self.values[number].iter_mut().enumerate() {
                *value = across[i] + tu * (across[i + 1] - across[i]);
            }
        }
    }

    /// Reads a row of voxels, unless it is there.
    fn read<T: Voxel>(&mut self, grid: &UniformGrid<T>, slice: usize, v: i64) {
        let row = &mut self.rows[slice % 2][v.rem_euclid(2) as usize];
        if row.of == Some((slice, v)) {
            return;
        }
        let plane = self.plane;
        // From the slice before to the one behind, rays are between these; both ends of the template's rounding included.
        let ends = [slice as f64 - 1.0, slice as f64 + 1.0].map(|t| (plane.slope[0] * t).floor());
        (row.of, row.first) = (Some((slice, v)), self.first[0] + ends[0].min(ends[1]) as i64);
        let dims = grid.dims();
        let strides = [1, dims[0], dims[0] * dims[1]];
        let [su, sv, sw] = plane.axes.map(|a| strides[a]);
        let inside = |a: usize, i: i64| i.clamp(0, plane.dims[a] as i64 - 1) as usize;
        let voxels = &grid.samples()[plane.slice_index(slice) * sw + inside(1, v) * sv..];
        // Voxels of the volume lie in the middle, and its first and last ones stand for those beyond.
        let at = |i: i64| R::from_f32(voxels[i as usize * su].to_f32());
        let count = plane.dims[0] as i64;
        let [low, high] = [-row.first, count - row.first].map(|i| i.clamp(0, WIDTH as i64) as usize);
        row.voxels[..low].fill(at(0));
        row.voxels[high..].fill(at(count - 1));
        let middle = &mut row.voxels[low..high];
        if su == 1 {
            let first = (row.first + low as i64) as usize;
            for (to, voxel) in middle.iter_mut().zip(&voxels[first.min(voxels.len())..]) {
                *to = R::from_f32(voxel.to_f32());
            }
        } else {
            for (to, i) in middle.iter_mut().zip(row.first + low as i64..) {
                *to = at(i);
            }
        }
    }
}

impl<R: Real> SharedSamples<R> for RowSamples<'_, R> {
    fn sample(&mut self, chord: &Chord<'_>, run: &mut Run<R>) {
        let (len, number) = (run.len(), run.steps.number[0] as usize / RUN);
        if !self.sampled[number] {
            self.sampled[number] = true;
            with_grid!(self.grid, grid => self.fill(grid, number));
        }
        let (numbers, ray) = (&run.steps.number[..len], self.ray % ACROSS);
        let (first, last) = (numbers[0] as usize, numbers[len - 1] as usize);
        if last - first + 1 == len {
            // Nothing was left out between: one bound to check.
            for (value, values) in run.value[..len].iter_mut().zip(&self.values[first..=last]) {
                *value = values[ray];
            }
        } else {
            for (value, &number) in run.value[..len].iter_mut().zip(numbers) {
                *value = self.values[number as usize][ray];
            }
        }
        // A step that is cut by the ray's end has its sample elsewhere. A voxel stands for it, cut or not.
        if !self.steps.beside {
            for j in [0, len - 1] {
                if run.steps.length[j] != self.steps.length[run.steps.number[j] as usize] {
                    let [x, y, z] = chord.position(run.distance(j));
                    chord.values([&[x], &[y], &[z]], &mut run.value[j..=j]);
                }
            }
        }
    }
}
