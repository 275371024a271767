//! A band of scan lines under all slices.

use fearless_simd::Simd;
use vr_core::cancel;
use vr_kernels::vector::{LANES, Vectorized};

use super::cells::{Edges, nearest, texels_between};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use crate::encode::{Run, Runs};
use crate::links::Links;
use crate::slices::{Row as SliceRow, Slice, Slices};

/// Neighbouring rows of the intermediate image.
pub(crate) struct Band<'a> {
    /// The first row's number.
    pub(crate) first: usize,
    /// Texels of a row.
    pub(crate) width: usize,
    /// Row by row.
    pub(crate) texels: &'a mut [[f32; 4]],
    /// Row by row, one more than there are texels in each.
    pub(crate) links: &'a mut [u16],
    /// Row by row, the depth of what a texel sees; infinite where it sees nothing.
    pub(crate) depths: &'a mut [f32],
    /// Row by row, the depth at which a surface ends a texel's ray; empty where there is no surface.
    pub(crate) stops: &'a [f32],
    /// One entry a row.
    pub(crate) lines: &'a mut [Line],
}

/// Working memory of a band's rows. Kept from band to band.
#[derive(Default)]
pub(crate) struct Scratch {
    width: usize,
    planes: Vec<f32>,
    /// Positions at which each row's rays enter the volume, and leave it; empty until a row's are needed.
    chords: Vec<[Vec<f64>; 2]>,
}

impl Scratch {
    fn resize(&mut self, rows: usize, width: usize) {
        self.width = width;
        self.planes.resize(rows * Row::length(width), 0.0);
        self.chords.resize_with(rows, Default::default);
        self.chords.iter_mut().flatten().for_each(Vec::clear);
    }

    /// A row's planes, which are nothing where the row has no sample yet, and its chords.
    #[inline(always)]
    fn row(&mut self, row: usize, line: Line) -> (&mut [f32], &mut [Vec<f64>; 2]) {
        let length = Row::length(self.width);
        let planes = &mut self.planes[row * length..][..length];
        if line.samples == 0 {
            planes.fill(0.0);
        }
        (planes, &mut self.chords[row])
    }
}

/// Summary of a row of texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// The first texel that was drawn on, and the one behind the last.
    pub(crate) drawn: [u32; 2],
    /// The first texel that has a depth, and the one behind the last.
    pub(crate) seen: [u32; 2],
    /// Number of samples that it took.
    pub(crate) samples: u32,
    /// Number of opaque texels.
    pub(crate) opaque: u32,
    /// Begin and end of the opaque texels where the last slice began.
    closed: [u32; 2],
}

impl Line {
    pub(crate) const EMPTY: Self =
        Self { drawn: [u32::MAX, 0], seen: [u32::MAX, 0], samples: 0, opaque: 0, closed: [0; 2] };
}

/// Compositing of one band.
pub(crate) struct Work<'a, 'b, K, const N: usize> {
    pub(crate) kernel: &'a K,
    pub(crate) slices: &'a Slices,
    pub(crate) runs: &'a Runs<N>,
    pub(crate) band: &'a mut Band<'b>,
    pub(crate) scratch: &'a mut Scratch,
}

impl<K: Kernel, const N: usize> Vectorized for Work<'_, '_, K, N> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { kernel, slices, runs, band, scratch } = self;
        let (rows, width) = (band.lines.len(), band.width);
        // Nothing is drawn yet, and every row takes samples.
        band.links.fill(0);
        band.lines.fill(Line::EMPTY);
        scratch.resize(rows, width);
        let mut open = vec![true; rows];
        let mut left = rows;
        // All slices, front to back, until every row is opaque.
        for (i, slice) in slices.slices.iter().enumerate() {
            if runs.layer_is_empty(slice.layer) {
                continue;
            }
            cancel::poll();
            let at_once = texels_between(K::COLUMNS, slice.map.scale);
            let first = slice.valid.first[1].max(band.first);
            let end = slice.valid.end[1].min(band.first + rows);
            for y in first..end {
                let row = y - band.first;
                let v = slice.map.offset.y + slice.map.scale * y as f64;
                // `as` saturates.
                let cell = (v as usize).min(runs.rows() - 1);
                let of_row = runs.row(slice.layer, cell);
                if of_row.is_empty() || !open[row] {
                    continue;
                }
                let mut texels = slices.row(i, y);
                let stops = if band.stops.is_empty() { &[] } else { &band.stops[row * width..][..width] };
                if !stops.is_empty() {
                    texels.whole = [0, 0];
                }
                let line = &mut band.lines[row];
                let (planes, chords) = scratch.row(row, *line);
                let mut crossing = Crossing {
                    kernel,
                    slices,
                    slice,
                    number: (i + 1) as f32,
                    stops,
                    y,
                    weights: weights((v - cell as f64) as f32, slice),
                    texels,
                    at_once,
                    row: Row::new(planes),
                    chords,
                    links: Links::new(&mut band.links[row * (width + 1)..][..width + 1]),
                    line,
                };
                crossing.runs(simd, of_row, runs.layout().size[0] - 1);
                if crossing.line.opaque as usize == width {
                    open[row] = false;
                    left -= 1;
                }
            }
            if left == 0 {
                break;
            }
        }
        // Planes become texels; a row without samples is empty.
        band.depths.fill(f32::INFINITY);
        let rows_of_texels = band.texels.chunks_exact_mut(width).zip(band.depths.chunks_exact_mut(width));
        for (row, (texels, depths)) in rows_of_texels.enumerate() {
            let line = band.lines[row];
            if line.samples == 0 {
                texels.fill([0.0; 4]);
                continue;
            }
            let (planes, chords) = scratch.row(row, line);
            let mut planes = Row::new(planes);
            kernel.end(simd, &mut planes);
            planes.write(texels);
            let stops = if band.stops.is_empty() { &[] } else { &band.stops[row * width..][..width] };
            let seen = finish(kernel, slices, band.first + row, &planes, (texels, depths), (stops, chords));
            band.lines[row].seen = seen;
        }
    }
}

/// Finishes the texels of row `y` that see something, and writes their depths. Returns the first of these texels, and the one behind the last.
fn finish<K: Kernel>(
    kernel: &K,
    slices: &Slices,
    y: usize,
    planes: &Row<'_>,
    (texels, depths): (&mut [[f32; 4]], &mut [f32]),
    (stops, chords): (&[f32], &mut [Vec<f64>; 2]),
) -> [u32; 2] {
    let mut seen = Line::EMPTY.seen;
    for (x, (texel, depth)) in texels.iter_mut().zip(depths).enumerate() {
        let place = planes.places()[x];
        if place == 0.0 {
            continue;
        }
        // `as` rounds down, and saturates.
        let slice = (place as usize).min(slices.slices.len()) - 1;
        let chord = if stops.is_empty() && slices.is_whole(slice, [x, y]) {
            [f64::NEG_INFINITY, f64::INFINITY]
        } else {
            let [front, back] = chords_of(slices, y, planes.width(), stops, chords);
            [front[x], back[x]]
        };
        let fraction = f64::from(place) - (slice + 1) as f64;
        let place = Seen { slices, slice, fraction, texel: [x, y], chord };
        *depth = kernel.finish(&place, texel) as f32;
        seen = [seen[0].min(x as u32), x as u32 + 1];
    }
    seen
}

/// Positions at which the rays of row `y` enter the volume and leave it, or meet a surface; with a vector's room behind the last. Found when
/// they are first asked for.
#[inline(always)]
fn chords_of<'a>(
    slices: &Slices,
    y: usize,
    width: usize,
    stops: &[f32],
    [front, back]: &'a mut [Vec<f64>; 2],
) -> [&'a [f64]; 2] {
    if front.is_empty() {
        slices.chords(y, width + LANES, front, back);
        for (back, &stop) in back.iter_mut().zip(stops) {
            *back = back.min(f64::from(stop));
        }
    }
    [front, back]
}

/// Share of a sample that is none, for it lies behind a surface.
const BEHIND: f32 = -1.0;

/// One slice under one row of texels.
struct Crossing<'a, 'b, K, const N: usize> {
    kernel: &'a K,
    slices: &'a Slices,
    slice: &'a Slice,
    /// The slice's number, from 1 on.
    number: f32,
    /// Depths at which surfaces end the row's rays; empty where there are none.
    stops: &'a [f32],
    y: usize,
    /// Weights of the edges of cells: of linear interpolation, and of values.
    weights: [[f32; N]; 2],
    texels: SliceRow,
    /// Texels that are added to at once.
    at_once: usize,
    row: Row<'b>,
    chords: &'b mut [Vec<f64>; 2],
    links: Links<'b>,
    line: &'b mut Line,
}

/// Weights of the edges of a row of cells, `down` from its upper edge, in a slice: of linear interpolation, and of values.
#[inline(always)]
fn weights<const N: usize>(down: f32, slice: &Slice) -> [[f32; N]; 2] {
    let linear = weights_at(down, slice.fraction);
    [linear, if slice.nearest { weights_at(nearest(down), nearest(slice.fraction)) } else { linear }]
}

/// Weights of the edges of a row of cells, `down` from its upper edge and `behind` its first layer.
#[inline(always)]
fn weights_at<const N: usize>(down: f32, behind: f32) -> [f32; N] {
    let mut weights = [0.0; N];
    for (n, weight) in weights.iter_mut().enumerate() {
        let across = if n % 2 == 0 { 1.0 - down } else { down };
        let along = if N == 2 {
            1.0
        } else if n < 2 {
            1.0 - behind
        } else {
            behind
        };
        *weight = across * along;
    }
    weights
}

impl<K: Kernel, const N: usize> Crossing<'_, '_, K, N> {
    #[inline(always)]
    fn runs<S: Simd>(&mut self, simd: S, runs: &[Run<N>], last: usize) {
        let (slice, [first, end_of_row]) = (self.slice, self.texels.valid);
        // Up to here, from where the runs began, all is opaque.
        let mut open = first;
        if K::CLOSES && self.line.opaque > 0 {
            // Slices begin at about the same texel, and many links would be followed from there anew.
            let [from, to] = self.line.closed.map(|x| x as usize);
            let known = (from..to).contains(&first);
            open = self.links.next_open(if known { to } else { first });
            self.line.closed = [if known { from } else { first } as u32, open as u32];
        }
        for run in runs {
            if open >= end_of_row {
                return;
            }
            let behind = run.start + run.len;
            let end = if behind as usize == last { usize::MAX } else { slice.first_texel(behind) };
            let end = end.min(end_of_row);
            if end <= open {
                continue;
            }
            let first = slice.first_texel(run.start).max(open);
            if first < end {
                open = self.run(simd, run, first, end);
            }
        }
    }

    /// The texels `x..end` of a run, as far as they are not opaque; returns the first texel that later runs can be about.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, run: &Run<N>, mut x: usize, end: usize) -> usize {
        let mut at = [0; N];
        for n in 0..N {
            at[n] = run.at[n] as usize;
        }
        let [weights, of_voxels] = self.weights;
        let edges = Edges { at, last: run.len as usize - 1, weights, of_voxels };
        let some_opaque = K::CLOSES && self.line.opaque > 0;
        let unit = self.slice.shift.is_some();
        let mut shares = [1.0; LANES];
        loop {
            if some_opaque {
                x = self.links.next_open(x);
            }
            if x >= end {
                return x;
            }
            // Opaque texels in between come along, and stay as they are: to leave them out costs more.
            let n = (end - x).min(self.at_once);
            let columns = self.slice.columns(x, run.start, edges.last);
            let chunk = Chunk { x, y: self.y, n, slice: self.number };
            let whole = x >= self.texels.whole[0] && x + n <= self.texels.whole[1];
            if !whole {
                self.shares(x, &mut shares[..n]);
            }
            let shares = (!whole).then_some(&shares);
            // One call for each kind of chunk, so that the compiler inlines it. Not by force: functions that are forced inline are simplified only as a
            // whole, which takes half as long again to compile.
            let (kernel, row) = (self.kernel, &mut self.row);
            let Added { samples, mut closed } = if unit {
                simd.vectorize(
                    #[inline(always)]
                    || kernel.add::<S, N, true>(simd, &edges, columns, chunk, shares, row),
                )
            } else {
                simd.vectorize(
                    #[inline(always)]
                    || kernel.add::<S, N, false>(simd, &edges, columns, chunk, shares, row),
                )
            };
            let drawn = &mut self.line.drawn;
            *drawn = [drawn[0].min(x as u32), drawn[1].max((x + n) as u32)];
            self.line.samples += samples;
            while K::CLOSES && closed != 0 {
                self.links.close(x + closed.trailing_zeros() as usize);
                self.line.opaque += 1;
                closed &= closed - 1;
            }
            x += n;
        }
    }

    /// Shares that the samples of texels from x on stand for, in distances between slices; negative where there is none, behind a surface.
    #[inline(always)]
    fn shares(&mut self, x: usize, shares: &mut [f32]) {
        let [front, back] = chords_of(self.slices, self.y, self.row.width(), self.stops, self.chords);
        for ((share, &front), &back) in shares.iter_mut().zip(&front[x..]).zip(&back[x..]) {
            let (depth, chord) = (self.slice.depth, [front, back]);
            let behind = self.slices.is_behind(depth, chord);
            *share = if behind { BEHIND } else { self.slices.share(depth, chord) as f32 };
        }
    }
}
