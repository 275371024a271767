//! Stretches of rays on which everything is linear.

use super::segments::{Segments, bends};

/// Optical depth of a stretch at most: beyond it the rule of four points misses 5·10⁻⁶ of a change of colour.
const DEPTH: f32 = 2.5;
/// Equal parts of a thick stretch at most; thicker ones are left to the plain code, which ends where nothing is left to be seen.
const PARTS: f32 = 16.0;
/// Largest opacity under the power rule: nearer to a wall the logarithm needs the plain code.
const NEAR_WALL: f32 = 0.99;
/// Halvings at most of a stretch on which the logarithm bends, or the normal turns.
const HALVINGS: u32 = 6;
/// Light at stake where a normal turns, times the fourth power of the sine: a highlight is missed by about as much.
const SEEN_TURN: f32 = 1e-6;

/// A stretch: the parts of its piece of the transfer function at both ends, its length in units of depth along the ray, and the piece's number.
///
/// Four numbers of four bytes, so that sixteen stretches are turned into vectors by loads of one row each.
pub(crate) type Row = [f32; 4];

/// A place on a ray: its depth, and the attributes of the mesh there: the value, and the gradient where something is shaded.
///
/// In `f64`: lengths and parts of the transfer function are small differences.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot<const N: usize> {
    pub(crate) depth: f64,
    pub(crate) attributes: [f64; N],
}

impl<const N: usize> Spot<N> {
    /// The place at a part of the way to another.
    #[inline(always)]
    pub(crate) fn towards(&self, other: &Self, part: f64) -> Self {
        let mut spot = *self;
        spot.depth += (other.depth - self.depth) * part;
        for (x, to) in spot.attributes.iter_mut().zip(other.attributes) {
            *x += (to - *x) * part;
        }
        spot
    }

    /// The gradient; zero where nothing is shaded.
    #[inline(always)]
    fn gradient(&self) -> [f32; 4] {
        match self.attributes[..] {
            [_, x, y, z] => [x, y, z, 0.0].map(|x| x as f32),
            _ => [0.0; 4],
        }
    }
}

/// Stretches of the rays of a march, and their light.
#[derive(Default)]
pub(crate) struct Stretches<const N: usize> {
    pub(crate) rows: Vec<Row>,
    /// Depths at which each begins and ends.
    pub(crate) depths: Vec<[f64; 2]>,
    /// Gradients at both ends; none where nothing is shaded.
    pub(crate) gradients: Vec<[[f32; 4]; 2]>,
    /// Lane of each; none where nothing is shaded.
    pub(crate) lanes: Vec<u32>,
    /// Light and opacity of each.
    pub(crate) light: Vec<[f32; 4]>,
    /// Those that are left to the plain code.
    pub(crate) hard: Vec<Hard<N>>,
}

/// A stretch that is left to the plain code.
pub(crate) struct Hard<const N: usize> {
    pub(crate) number: usize,
    /// Number of its ray.
    pub(crate) ray: usize,
    pub(crate) ends: [Spot<N>; 2],
}

/// The ray whose stretches are added.
#[derive(Clone, Copy)]
pub(crate) struct Cut<'a> {
    pub(crate) segments: &'a Segments,
    /// Length of the ray for each unit of depth.
    pub(crate) scale: f64,
    /// Transparency of all that the ray has passed, or more.
    pub(crate) clear: f32,
    pub(crate) ray: usize,
    pub(crate) lane: usize,
}

impl Cut<'_> {
    /// Length between two places.
    #[inline(always)]
    fn length<const N: usize>(&self, [start, end]: &[Spot<N>; 2]) -> f32 {
        ((end.depth - start.depth) * self.scale) as f32
    }
}

/// A stretch of a ray whose values lie in one piece of the transfer function.
#[derive(Clone, Copy)]
struct InPiece<const N: usize> {
    index: usize,
    ends: [Spot<N>; 2],
    parts: [f32; 2],
}

impl<const N: usize> InPiece<N> {
    /// Returns the stretch between two parts of this one.
    #[inline(always)]
    fn between(&self, from: f32, to: f32) -> Self {
        let [a, b] = &self.ends;
        let part = |t: f32| self.parts[0] + (self.parts[1] - self.parts[0]) * t;
        let ends = [from, to].map(|t| a.towards(b, f64::from(t)));
        Self { index: self.index, ends, parts: [part(from), part(to)] }
    }
}

impl<const N: usize> Stretches<N> {
    pub(crate) fn clear(&mut self) {
        self.rows.clear();
        self.depths.clear();
        self.gradients.clear();
        self.lanes.clear();
        self.hard.clear();
    }

    /// Adds what lies between two places, between which everything is linear; `piece` is the one that held last.
    #[inline(always)]
    pub(crate) fn add(&mut self, cut: &Cut<'_>, ends: [Spot<N>; 2], piece: &mut usize) {
        let pieces = &cut.segments.pieces[..];
        let [first, last] = [ends[0].attributes[0], ends[1].attributes[0]];
        let mut index = *piece;
        while index > 0 && first < pieces[index].from {
            index -= 1;
        }
        while index + 1 < pieces.len() && first >= pieces[index].to {
            index += 1;
        }
        *piece = index;
        let here = &pieces[index];
        if here.from <= last && last < here.to {
            if !here.is_clear {
                self.push(cut, index, ends);
            }
        } else {
            *piece = self.cut(cut, ends, index);
        }
    }

    /// Adds the parts of what passes points of the transfer function; returns the last piece.
    #[inline(never)]
    fn cut(&mut self, cut: &Cut<'_>, ends: [Spot<N>; 2], mut index: usize) -> usize {
        let pieces = &cut.segments.pieces;
        let [start, end] = &ends;
        let [first, last] = [start.attributes[0], end.attributes[0]];
        let rises = last > first;
        // A falling value leaves the piece below the point at which it stands.
        if last < first && index > 0 && pieces[index].from == first {
            index -= 1;
        }
        let mut here = *start;
        loop {
            let piece = &pieces[index];
            let bound = if rises && last >= piece.to {
                Some(piece.to)
            } else if !rises && last < piece.from {
                Some(piece.from)
            } else {
                None
            };
            let next = match bound {
                Some(bound) => {
                    let mut next = start.towards(end, ((bound - first) / (last - first)).clamp(0.0, 1.0));
                    next.attributes[0] = bound;
                    next.depth = next.depth.clamp(here.depth, end.depth);
                    next
                }
                None => *end,
            };
            if next.depth > here.depth && !piece.is_clear {
                self.push(cut, index, [here, next]);
            }
            if bound.is_none() {
                return index;
            }
            here = next;
            index = if rises { index + 1 } else { index - 1 };
        }
    }

    /// Adds what lies in one piece, in parts where one rule does not follow the light.
    #[inline(always)]
    fn push(&mut self, cut: &Cut<'_>, index: usize, ends: [Spot<N>; 2]) {
        let piece = &cut.segments.pieces[index];
        let length = cut.length(&ends);
        // A piece without a lower end has no parts: −∞ times 0.
        let part = |end: &Spot<N>| ((end.attributes[0] - piece.from) * piece.per_value).clamp(0.0, 1.0) as f32;
        let parts = if piece.per_value == 0.0 { [0.0; 2] } else { [part(&ends[0]), part(&ends[1])] };
        let stretch = InPiece { index, ends, parts };
        if piece.bends || piece.steepest * length > DEPTH || N > 1 {
            self.push_in_parts(cut, &stretch, HALVINGS);
        } else {
            self.keep(cut, &stretch);
        }
    }

    /// Adds a stretch, in halves where the logarithm bends or the normal turns, and in equal parts where it is thick.
    #[inline(never)]
    fn push_in_parts(&mut self, cut: &Cut<'_>, stretch: &InPiece<N>, halvings: u32) {
        let piece = &cut.segments.pieces[stretch.index];
        let opacities = stretch.parts.map(|t| cut.segments.opacity(stretch.index, t));
        let most = opacities[0].max(opacities[1]);
        if piece.bends && most > NEAR_WALL || piece.steepest == f32::INFINITY {
            return self.leave(cut, stretch);
        }
        let length = cut.length(&stretch.ends);
        let bent = piece.bends && bends(opacities[0], opacities[1]);
        // Light at stake: no more than what is left, nor than the largest optical depth.
        let at_stake = |turn: f32| cut.clear * (cut.segments.extinction_at_most(most) * length).min(1.0) * turn * turn;
        let turns = N > 1 && at_stake(turn(&stretch.ends)) > SEEN_TURN;
        if halvings > 0 && (bent || turns) {
            self.push_in_parts(cut, &stretch.between(0.0, 0.5), halvings - 1);
            return self.push_in_parts(cut, &stretch.between(0.5, 1.0), halvings - 1);
        }
        if piece.steepest * length <= DEPTH {
            return self.keep(cut, stretch);
        }
        let count = (cut.segments.extinction(most) * length / DEPTH).ceil().max(1.0);
        if count > PARTS {
            return self.leave(cut, stretch);
        }
        for i in 0..count as u32 {
            self.keep(cut, &stretch.between(i as f32 / count, (i + 1) as f32 / count));
        }
    }

    /// Adds a stretch that one rule follows.
    #[inline(always)]
    fn keep(&mut self, cut: &Cut<'_>, stretch: &InPiece<N>) {
        let [start, end] = &stretch.ends;
        let length = cut.length(&stretch.ends);
        self.rows.push([stretch.parts[0], stretch.parts[1], length, f32::from_bits(stretch.index as u32)]);
        self.depths.push([start.depth, end.depth]);
        if N > 1 {
            self.gradients.push([start.gradient(), end.gradient()]);
            self.lanes.push(cut.lane as u32);
        }
    }

    /// Adds a stretch that is left to the plain code: to the vectors it is one without length.
    fn leave(&mut self, cut: &Cut<'_>, stretch: &InPiece<N>) {
        self.hard.push(Hard { number: self.rows.len(), ray: cut.ray, ends: stretch.ends });
        self.keep(cut, stretch);
        let last = self.rows.len() - 1;
        self.rows[last] = [0.0, 0.0, 0.0, f32::from_bits(stretch.index as u32)];
    }
}

/// Square of the sine of the angle by which the gradient turns between two places; 1 beyond a right angle.
#[inline(always)]
fn turn<const N: usize>(ends: &[Spot<N>; 2]) -> f32 {
    let [a, b] = [ends[0].gradient(), ends[1].gradient()];
    let dot = |a: [f32; 4], b: [f32; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cosine = dot(a, b);
    if cosine <= 0.0 { 1.0 } else { (1.0 - cosine * cosine / (dot(a, a) * dot(b, b))).max(0.0) }
}
