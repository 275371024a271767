//! Stretches of rays on which everything is linear.

use super::segments::{Segments, bends};

/// Optical depth of a stretch at most: beyond it the rule of four points misses 5·10⁻⁶ of a change of colour.
const DEPTH: f32 = 2.5;
/// Equal parts of a thick stretch at most; thicker ones are left to the plain code, which ends where nothing is left to be seen.
const PARTS: f32 = 16.0;
/// Largest opacity under the power rule: nearer to a wall the logarithm needs the plain code.
const NEAR_WALL: f32 = 0.99;
/// Halvings of a stretch on which the logarithm bends.
const HALVINGS: u32 = 6;

/// A stretch: the parts of its piece of the transfer function at both ends, its length in units of depth along the ray, and the piece's number.
///
/// Four numbers of four bytes, so that sixteen stretches are turned into vectors by loads of one row each.
pub(crate) type Row = [f32; 4];

/// Stretches of up to sixteen rays, and their light.
#[derive(Default)]
pub(crate) struct Stretches {
    pub(crate) rows: Vec<Row>,
    /// Depths at which each begins and ends.
    pub(crate) depths: Vec<[f32; 2]>,
    /// Light and opacity of each.
    pub(crate) light: Vec<[f32; 4]>,
    /// Those that are left to the plain code.
    pub(crate) hard: Vec<Hard>,
}

/// A stretch that is left to the plain code.
pub(crate) struct Hard {
    pub(crate) number: usize,
    pub(crate) values: [f32; 2],
    /// Length of its ray for each unit of depth.
    pub(crate) scale: f32,
}

/// What a ray has of its own.
#[derive(Clone, Copy)]
pub(crate) struct Cut<'a> {
    pub(crate) segments: &'a Segments,
    /// Length of the ray for each unit of depth.
    pub(crate) scale: f32,
}

impl Stretches {
    pub(crate) fn clear(&mut self) {
        self.rows.clear();
        self.depths.clear();
        self.hard.clear();
    }

    /// Adds what lies between two depths, on which the value is linear; `piece` is the one that held last.
    #[inline(always)]
    pub(crate) fn add(&mut self, cut: &Cut<'_>, depths: [f32; 2], values: [f32; 2], piece: &mut usize) {
        let pieces = &cut.segments.pieces[..];
        let [first, last] = values;
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
                self.push(cut, index, depths, values);
            }
        } else {
            *piece = self.cut(cut, depths, values, index);
        }
    }

    /// Adds the parts of what passes points of the transfer function; returns the last piece.
    #[inline(never)]
    fn cut(&mut self, cut: &Cut<'_>, depths: [f32; 2], [first, last]: [f32; 2], mut index: usize) -> usize {
        let pieces = &cut.segments.pieces;
        let rises = last > first;
        // A falling value leaves the piece below the point at which it stands.
        if last < first && index > 0 && pieces[index].from == first {
            index -= 1;
        }
        let (mut depth, mut value) = (depths[0], first);
        loop {
            let piece = &pieces[index];
            let bound = if rises && last >= piece.to {
                Some(piece.to)
            } else if !rises && last < piece.from {
                Some(piece.from)
            } else {
                None
            };
            let (next, end) = match bound {
                Some(bound) => {
                    let t = ((bound - first) / (last - first)).clamp(0.0, 1.0);
                    ((depths[0] + (depths[1] - depths[0]) * t).clamp(depth, depths[1]), bound)
                }
                None => (depths[1], last),
            };
            if next > depth && !piece.is_clear {
                self.push(cut, index, [depth, next], [value, end]);
            }
            if bound.is_none() {
                return index;
            }
            (depth, value) = (next, end);
            index = if rises { index + 1 } else { index - 1 };
        }
    }

    /// Adds what lies in one piece, in parts where it is thick or bends.
    #[inline(always)]
    fn push(&mut self, cut: &Cut<'_>, index: usize, depths: [f32; 2], values: [f32; 2]) {
        let piece = &cut.segments.pieces[index];
        let length = (depths[1] - depths[0]) * cut.scale;
        let parts = values.map(|v| ((v - piece.from) * piece.per_value).clamp(0.0, 1.0));
        // A piece without a lower end has no parts: −∞ times 0.
        let parts = if piece.per_value == 0.0 { [0.0; 2] } else { parts };
        if piece.bends || piece.steepest * length > DEPTH {
            self.push_hard(cut, index, depths, values, parts, HALVINGS);
        } else {
            self.rows.push([parts[0], parts[1], length, f32::from_bits(index as u32)]);
            self.depths.push(depths);
        }
    }

    #[inline(never)]
    fn push_hard(
        &mut self,
        cut: &Cut<'_>,
        index: usize,
        depths: [f32; 2],
        values: [f32; 2],
        parts: [f32; 2],
        halvings: u32,
    ) {
        let piece = &cut.segments.pieces[index];
        let opacities = parts.map(|t| cut.segments.opacity(index, t));
        let between = |[a, b]: [f32; 2], t: f32| a + (b - a) * t;
        if piece.bends && opacities[0].max(opacities[1]) > NEAR_WALL || piece.steepest == f32::INFINITY {
            self.hard.push(Hard { number: self.rows.len(), values, scale: cut.scale });
            self.rows.push([0.0, 0.0, 0.0, f32::from_bits(index as u32)]);
            self.depths.push(depths);
            return;
        }
        if piece.bends && halvings > 0 && bends(opacities[0], opacities[1]) {
            let [depth, value, part] = [depths, values, parts].map(|ends| between(ends, 0.5));
            self.push_hard(cut, index, [depths[0], depth], [values[0], value], [parts[0], part], halvings - 1);
            self.push_hard(cut, index, [depth, depths[1]], [value, values[1]], [part, parts[1]], halvings - 1);
            return;
        }
        let length = (depths[1] - depths[0]) * cut.scale;
        let count = (cut.segments.extinction(opacities[0].max(opacities[1])) * length / DEPTH).ceil().max(1.0);
        if count > PARTS {
            self.hard.push(Hard { number: self.rows.len(), values, scale: cut.scale });
            self.rows.push([0.0, 0.0, 0.0, f32::from_bits(index as u32)]);
            self.depths.push(depths);
            return;
        }
        for i in 0..count as u32 {
            let at = [i as f32 / count, (i + 1) as f32 / count];
            let [from, to] = at.map(|t| between(parts, t));
            self.rows.push([from, to, length / count, f32::from_bits(index as u32)]);
            self.depths.push(at.map(|t| between(depths, t)));
        }
    }
}
