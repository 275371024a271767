//! Positions of the slices of samples along the principal axis, and the texels that each covers.

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};
use vr_core::{Filter, GridVolume, Scene};

use crate::composite::cells::Columns;
use crate::factorization::{Factorization, SliceMap, permuted};
use crate::region::{HalfSpace, Region};
use crate::steepness::samples_filter_gradients;

/// A slice of samples: a layer of voxels, or what lies between two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slice {
    /// The layer; of those between two layers, the one at the lower index.
    pub(crate) layer: usize,
    /// Fraction of the way from that layer to the next, in [0, 1].
    pub(crate) fraction: f32,
    /// Position on the principal axis.
    w: f64,
    /// The same, growing from front to back.
    pub(crate) depth: f64,
    pub(crate) map: SliceMap,
    /// Texels to a cell.
    per_cell: f64,
    /// Shift from texels to cells, if they are equally wide: texel x lies in cell x + shift, each at the same place of it.
    pub(crate) shift: Option<isize>,
    /// That place.
    place: f32,
    /// True if samples are values of the nearest voxels.
    pub(crate) nearest: bool,
    /// Texels with a sample here.
    pub(crate) valid: Texels,
    /// Texels with a sample in the slices before and behind, too: those for which this one stands for a whole distance between slices.
    pub(crate) whole: Texels,
}

impl Slice {
    /// The first texel that lies in a cell, or behind its begin; 0 where that is left of the image.
    #[inline(always)]
    pub(crate) fn first_texel(&self, cell: u32) -> usize {
        match self.shift {
            // ⌈cell − offset⌉
            Some(shift) => (cell as isize - shift).max(0) as usize,
            // `as` saturates.
            None => ((f64::from(cell) - self.map.offset.x) * self.per_cell).ceil() as usize,
        }
    }

    /// Columns of the texels from x on in the run that begins at cell `start`, and whose last cell is number `last` from there.
    #[inline(always)]
    pub(crate) fn columns(&self, x: usize, start: u32, last: usize) -> Columns {
        if let Some(shift) = self.shift {
            // The last texel of all may lie on the far end of the last cell.
            let cell = ((x as isize + shift) as usize).wrapping_sub(start as usize);
            let first = cell.min(last);
            let begin = self.place + (cell - first) as f32;
            return Columns { first, begin, scale: 1.0, nearest: self.nearest };
        }
        let position = self.map.offset.x + self.map.scale * x as f64 - f64::from(start);
        // `as` saturates.
        let first = (position as usize).min(last);
        let begin = (position - first as f64) as f32;
        Columns { first, begin, scale: self.map.scale as f32, nearest: self.nearest }
    }
}

impl Slice {
    /// Cuts the texels `first..end` of row `y` to those whose point in this slice lies in a half space.
    fn above(&self, plane: &HalfSpace, y: usize, [first, end]: [usize; 2]) -> [usize; 2] {
        let SliceMap { offset, scale } = self.map;
        // normal·(u, v, w) − offset, as a function of x. What is as near to the plane as NEAR along a ray, none of which shears more than a
        // voxel a slice, is on it: `Slices::share` counts on that.
        let rate = plane.normal.x * scale;
        let at_zero = plane.normal.dot(DVec3::new(offset.x, offset.y + scale * y as f64, self.w)) - plane.offset;
        let at_zero = at_zero + NEAR * plane.normal.abs().element_sum();
        let meets = -at_zero / rate;
        // `as` saturates.
        let kept = if rate > 0.0 {
            [first.max(meets.ceil() as usize), end]
        } else if rate < 0.0 {
            let last = meets.floor();
            [first, if last < 0.0 { 0 } else { end.min(last as usize + 1) }]
        } else if at_zero < 0.0 {
            [0, 0]
        } else {
            [first, end]
        };
        if kept[0] < kept[1] { kept } else { [0, 0] }
    }
}

/// A rectangle of texels: the first column and row, and those behind the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Texels {
    pub(crate) first: [usize; 2],
    pub(crate) end: [usize; 2],
}

impl Texels {
    pub(crate) const NONE: Self = Self { first: [0; 2], end: [0; 2] };

    fn and(self, other: Self) -> Self {
        let first = std::array::from_fn(|a| self.first[a].max(other.first[a]));
        let end: [usize; 2] = std::array::from_fn(|a| self.end[a].min(other.end[a]));
        if first[0] < end[0] && first[1] < end[1] { Self { first, end } } else { Self::NONE }
    }
}

/// All slices of a factorization, front to back, and what they fill.
#[derive(Clone, Debug)]
pub(crate) struct Slices {
    pub(crate) slices: Vec<Slice>,
    /// Part of a voxel from slice to slice.
    pub(crate) spacing: f64,
    /// Slices to a voxel.
    per_voxel: f64,
    /// First and last depth that a ray can see.
    pub(crate) depths: [f64; 2],
    pub(crate) factorization: Factorization,
    low: DVec3,
    high: DVec3,
    /// Half spaces that cut the box, in coordinates (u, v, w).
    planes: Vec<HalfSpace>,
}

/// Samples of slices, and where slices may lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampling {
    /// True if samples are values of the nearest voxels.
    pub(crate) nearest: bool,
    /// True if layers of voxels are to be half way between slices.
    pub(crate) off_layers: bool,
}

impl Sampling {
    /// Samples of a volume under its filter, in slices so many voxels apart.
    ///
    /// Filters' gradients jump at the layers. Values of the nearest voxels jump half way between layers: off the layers, no slice of an even number to a voxel
    /// lies there, and of an odd number none does anyway.
    pub(crate) fn of(scene: &Scene, volume: &GridVolume, spacing: f64) -> Self {
        let nearest = volume.filter() == Filter::Nearest;
        let even = (1.0 / spacing).round() % 2.0 == 0.0;
        Self { nearest, off_layers: samples_filter_gradients(scene) || (nearest && even) }
    }
}

/// Texels of one row that have a sample in a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Row {
    /// The first with a sample, and the one behind the last.
    pub(crate) valid: [usize; 2],
    /// The same of those whose sample stands for a whole distance between slices.
    pub(crate) whole: [usize; 2],
}

/// Distance from a face up to which a point is on it.
pub(crate) const NEAR: f64 = 1e-9;
/// A slice this near the eye is not seen.
const NEAREST: f64 = 1e-6;

impl Slices {
    /// The slices of a part of the index space, `spacing` voxels apart, of a volume with `layers` layers along the axis.
    ///
    /// They lie the same way seen from either end: among them are the layers, where the spacing is 1/n; or, if they are to be off the layers, these
    /// are half way between them.
    pub(crate) fn new(
        factorization: Factorization,
        region: &Region,
        layers: usize,
        spacing: f64,
        Sampling { nearest, off_layers }: Sampling,
    ) -> Self {
        let [low, high] = region.corners().map(|v| permuted(v, factorization.axes));
        let turned = |p: &HalfSpace| HalfSpace { normal: permuted(p.normal, factorization.axes), ..*p };
        let planes = region.planes.iter().map(turned).collect();
        let length = (layers - 1) as f64;
        let steps = (length / spacing + NEAR).floor() - if off_layers { 1.0 } else { 0.0 };
        let anchor = 0.5 * (length - steps * spacing);
        // A corner of a crop box that is meant to lie in a slice may miss it by rounding.
        let first = ((low.z - anchor) / spacing - NEAR).ceil() as i64;
        let last = ((high.z - anchor) / spacing + NEAR).floor() as i64;
        let mut slices: Vec<Slice> = (first..=last)
            .map(|i| {
                let w = (anchor + i as f64 * spacing).clamp(low.z, high.z);
                // Slices between layers belong to the one below them, the last one to the last pair.
                let layer = if spacing == 1.0 { w as usize } else { (w as usize).min(layers - 2) };
                let map = factorization.slice(w);
                let valid = if factorization.eye().is_some_and(|eye| (w - eye.z) * factorization.sign < NEAREST) {
                    Texels::NONE
                } else {
                    texels(&map, [low, high], factorization.size)
                };
                let fraction = (w - layer as f64) as f32;
                Slice {
                    layer,
                    fraction,
                    w,
                    depth: w * factorization.sign,
                    map,
                    per_cell: 1.0 / map.scale,
                    shift: (map.scale == 1.0).then(|| map.offset.x.floor() as isize),
                    place: (map.offset.x - map.offset.x.floor()) as f32,
                    nearest,
                    valid,
                    whole: Texels::NONE,
                }
            })
            .collect();
        if factorization.sign < 0.0 {
            slices.reverse();
        }
        slices.retain(|s| s.valid != Texels::NONE);
        for i in 1..slices.len().saturating_sub(1) {
            slices[i].whole = slices[i].valid.and(slices[i - 1].valid).and(slices[i + 1].valid);
        }
        let [front, back] = if factorization.sign > 0.0 { [low.z, high.z] } else { [-high.z, -low.z] };
        let front = factorization.eye().map_or(front, |eye| front.max(eye.z * factorization.sign + NEAREST));
        Self { slices, spacing, per_voxel: 1.0 / spacing, depths: [front, back], factorization, low, high, planes }
    }

    /// Axes of the volume that are u, v and w.
    #[cfg(test)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        self.factorization.axes
    }

    /// The depths at which the ray of a point of the image enters the box and leaves it; not above each other where it misses.
    pub(crate) fn chord(&self, x: f64, y: f64) -> [f64; 2] {
        let f = &self.factorization;
        let (slope, at) = (f.slope(x, y), f.origin + f.spacing * DVec2::new(x, y));
        let [[a, b], [c, d]] = [0, 1].map(|a| self.between_faces(a, at[a], slope[a]));
        let chord = [self.depths[0].max(a).max(c), self.depths[1].min(b).min(d)];
        self.planes.iter().fold(chord, |chord, plane| self.clipped(chord, plane, at, slope))
    }

    /// Cuts a chord to a half space. The ray is given by where it meets the plane of the image, and its slope.
    fn clipped(&self, [front, back]: [f64; 2], plane: &HalfSpace, at: DVec2, slope: DVec2) -> [f64; 2] {
        let f = &self.factorization;
        let above = plane.normal.dot(at.extend(f.plane)) - plane.offset;
        let rate = plane.normal.dot(slope.extend(1.0)) * f.sign;
        let meets = f.plane * f.sign - above / rate;
        if rate > 0.0 {
            [front.max(meets), back]
        } else if rate < 0.0 {
            [front, back.min(meets)]
        } else if above < 0.0 {
            [f64::INFINITY, f64::NEG_INFINITY]
        } else {
            [front, back]
        }
    }

    /// Texels of row `y` that have a sample in the i-th slice.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize, y: usize) -> Row {
        let slice = &self.slices[i];
        let of = |texels: &Texels| {
            if (texels.first[1]..texels.end[1]).contains(&y) { [texels.first[0], texels.end[0]] } else { [0, 0] }
        };
        let row = Row { valid: of(&slice.valid), whole: of(&slice.whole) };
        if self.planes.is_empty() { row } else { self.cut_row(i, y, row) }
    }

    /// True if the i-th slice has a sample at a texel that stands for a whole distance between slices.
    #[inline(always)]
    pub(crate) fn is_whole(&self, i: usize, [x, y]: [usize; 2]) -> bool {
        let Texels { first, end } = self.slices[i].whole;
        let inside = x >= first[0] && x < end[0] && y >= first[1] && y < end[1];
        inside && (self.planes.is_empty() || (self.row(i, y).whole[0]..self.row(i, y).whole[1]).contains(&x))
    }

    /// Cuts a row of texels to the half spaces.
    fn cut_row(&self, i: usize, y: usize, Row { mut valid, mut whole }: Row) -> Row {
        let around = i.saturating_sub(1)..(i + 2).min(self.slices.len());
        for plane in &self.planes {
            valid = self.slices[i].above(plane, y, valid);
            // Whole where the slices on both sides have a sample, too.
            whole = self.slices[around.clone()].iter().fold(whole, |row, slice| slice.above(plane, y, row));
        }
        Row { valid, whole }
    }

    /// Interval of a ray between the two faces across u (0) or v (1), given the point at which it meets the plane of the image, and its slope.
    #[inline(always)]
    fn between_faces(&self, a: usize, at: f64, slope: f64) -> [f64; 2] {
        let f = &self.factorization;
        let (plane, slope) = (f.plane * f.sign, slope * f.sign);
        let (low, high) = (self.low[a] - at, self.high[a] - at);
        // A ray along the faces is between them for ever, or never: no 0/0.
        let never = if low > 0.0 || high < 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
        let inverse = 1.0 / slope;
        let (p, q) = (plane + low * inverse, plane + high * inverse);
        let along = slope == 0.0;
        [if along { never } else { p.min(q) }, if along { -never } else { p.max(q) }]
    }

    /// The part of the distance between slices that a sample stands for: half of that to the next on either side, where there is one, or all to
    /// where the ray enters or leaves.
    #[inline(always)]
    pub(crate) fn share(&self, depth: f64, chord: [f64; 2]) -> f64 {
        let [before, behind] = self.reach(depth, chord);
        ((before + behind) * self.per_voxel).clamp(0.0, 2.0)
    }

    /// The depths between which a sample stands for the medium.
    #[inline(always)]
    pub(crate) fn interval(&self, depth: f64, chord: [f64; 2]) -> [f64; 2] {
        let [before, behind] = self.reach(depth, chord);
        [depth - before, depth + behind]
    }

    /// Distances before and behind a sample over which it stands for the medium.
    #[inline(always)]
    fn reach(&self, depth: f64, [front, back]: [f64; 2]) -> [f64; 2] {
        // As near as texels are to a face for a slice to be there: see `texels`.
        let before = if depth - self.spacing >= front - NEAR { 0.5 * self.spacing } else { depth - front };
        let behind = if depth + self.spacing <= back + NEAR { 0.5 * self.spacing } else { back - depth };
        [before, behind]
    }

    /// True if a sample lies behind the end of a chord that a surface cut.
    #[inline(always)]
    pub(crate) fn is_behind(&self, depth: f64, [_, back]: [f64; 2]) -> bool {
        depth > back + NEAR
    }

    /// The chords of the first `n` texels of a row.
    #[inline(always)]
    pub(crate) fn chords(&self, y: usize, n: usize, front: &mut Vec<f64>, back: &mut Vec<f64>) {
        let f = &self.factorization;
        let (at, slope) = (f.origin + f.spacing * DVec2::new(0.0, y as f64), f.slope(0.0, y as f64));
        let bend = f.slope(1.0, y as f64).x - slope.x;
        let [first, last] = self.between_faces(1, at.y, slope.y);
        let [first, last] = [first.max(self.depths[0]), last.min(self.depths[1])];
        front.resize(n, 0.0);
        back.resize(n, 0.0);
        for (x, (front, back)) in front.iter_mut().zip(&mut *back).enumerate() {
            let x = x as f64;
            let [enters, leaves] = self.between_faces(0, at.x + f.spacing * x, slope.x + bend * x);
            (*front, *back) = (first.max(enters), last.min(leaves));
        }
        for plane in &self.planes {
            for (x, (front, back)) in front.iter_mut().zip(&mut *back).enumerate() {
                let x = x as f64;
                let (at, slope) = (at + DVec2::new(f.spacing * x, 0.0), slope + DVec2::new(bend * x, 0.0));
                [*front, *back] = self.clipped([*front, *back], plane, at, slope);
            }
        }
    }
}

/// The texels that a slice covers.
fn texels(map: &SliceMap, [low, high]: [DVec3; 2], size: [usize; 2]) -> Texels {
    let at = |a: usize, c: f64| (c - map.offset[a]) / map.scale;
    let all = Texels { first: [0; 2], end: size };
    // `as` saturates.
    let first = std::array::from_fn(|a| (at(a, low[a]) - NEAR).ceil().max(0.0) as usize);
    let end = std::array::from_fn(|a| (at(a, high[a]) + NEAR).floor().max(-1.0) as isize as usize)
        .map(|e: usize| e.wrapping_add(1));
    Texels { first, end }.and(all)
}
