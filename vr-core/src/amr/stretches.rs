//! Stretches of a ray through an adaptive mesh.

use glam::DVec3;

use super::bricks::EDGE;
use super::grid::AmrGrid;
use super::line::AmrLine;
use crate::box_tree::LocalLine;
use crate::field::Stretch;
use crate::ray::Ray;

/// A ray inside a brick that holds leaves.
#[derive(Clone, Copy)]
struct Crossing {
    from: f64,
    to: f64,
    level: u32,
    has_vacuum: bool,
    range: [f32; 2],
}

impl AmrGrid {
    /// Appends the stretches of a ray between two world distances that are not vacuum, ascending: one for each brick that it crosses, where no finer one
    /// is.
    pub(super) fn stretches_along(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<Stretch>) {
        let (low, high) = self.bounds();
        let offset = (0.5 * low + 0.5 * high - ray.origin).dot(ray.direction);
        let (base, direction) = (ray.origin + ray.direction * offset, ray.direction);
        let Some(part) = inside(base, direction, [low, high], part.map(|s| s - offset)) else { return };

        // Of several levels, the finest one holds.
        let crossings = self.crossings(base, direction, part);
        let mut seen: Vec<Crossing> = Vec::with_capacity(crossings.len());
        let sliver = 1e-9 * self.finest_spacing().min_element();
        let levels = crossings.chunk_by(|a, b| a.level == b.level);
        for of_level in levels {
            seen = if seen.is_empty() { of_level.to_vec() } else { filled(&seen, of_level, sliver) };
        }
        for crossing in seen {
            let Crossing { from, to, level, has_vacuum, range } = crossing;
            let spacing = self.spacing_of(level as usize).element_sum() / 3.0;
            let mut push = |from: f64, to: f64| {
                if from < to {
                    out.push(Stretch { from, to, spacing, range });
                }
            };
            let [from, to] = [from, to].map(|s| s + offset);
            if !has_vacuum {
                push(from, to);
                continue;
            }
            let mut parts = Vec::new();
            AmrLine::solid_parts(self, ray, [from, to], &mut parts);
            parts.into_iter().for_each(|[from, to]| push(from, to));
        }
    }

    /// Crossings of a ray with bricks, those of the finest level first, and of each level along the ray.
    fn crossings(&self, base: DVec3, direction: DVec3, part: [f64; 2]) -> Vec<Crossing> {
        let (tree, bricks) = (self.tree(), self.bricks());
        let line = LocalLine { origin: base - tree.middle(), direction, ends: part };
        let mut crossings = Vec::new();
        let mut faces = Vec::new();
        tree.each_along(&line, |number| {
            let level = self.blocks[number].level;
            let nodes = self.nodes_of_block(number);
            let [low, high] = nodes.map(|n| self.position(level, n));
            let Some([from, to]) = inside(base, direction, [low, high], part) else { return };
            // Faces between bricks.
            let edge = self.spacing_of(level) * EDGE as f64;
            let rate = direction / edge;
            let start = (base - low) / edge;
            let cells = self.blocks[number].cells(self.centring);
            let last = cells.map(|n| (n as i64 + EDGE - 1) / EDGE - 1);
            faces.clear();
            faces.push(from);
            for a in (0..3).filter(|&a| rate[a] != 0.0 && last[a] > 0) {
                faces.extend((1..=last[a]).map(|k| (k as f64 - start[a]) / rate[a]).filter(|&s| s > from && s < to));
            }
            faces.push(to);
            faces.sort_unstable_by(f64::total_cmp);
            for pair in faces.windows(2).filter(|pair| pair[0] < pair[1]) {
                let middle = start + rate * (0.5 * (pair[0] + pair[1]));
                let at = std::array::from_fn(|a| (middle[a].floor() as i64).clamp(0, last[a]));
                let brick = bricks.at(self, number, at);
                if brick.has_leaf {
                    let (level, has_vacuum, range) = (level as u32, brick.has_vacuum, brick.range);
                    crossings.push(Crossing { from: pair[0], to: pair[1], level, has_vacuum, range });
                }
            }
        });
        crossings
            .sort_unstable_by(|a, b| b.level.cmp(&a.level).then(a.from.total_cmp(&b.from)).then(a.to.total_cmp(&b.to)));
        // Blocks of one level that share cells, and faces that a ray runs along.
        crossings.dedup_by(|next, kept| {
            let same = next.level == kept.level && next.from < kept.to;
            if same {
                let doubt = next.to > kept.to;
                kept.range = [kept.range[0].min(next.range[0]), kept.range[1].max(next.range[1])];
                kept.has_vacuum |= next.has_vacuum;
                kept.to = if doubt { next.to } else { kept.to };
            }
            same
        });
        crossings
    }
}

/// Part of a line between two distances that is inside a box; `None` if nothing of positive length is.
fn inside(base: DVec3, direction: DVec3, [low, high]: [DVec3; 2], [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
    for a in 0..3 {
        let [near, far] = [low[a] - base[a], high[a] - base[a]];
        if direction[a] != 0.0 {
            let [s, t] = [near / direction[a], far / direction[a]];
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        } else if near > 0.0 || far < 0.0 {
            return None;
        }
    }
    (from < to).then_some([from, to])
}

/// Fills the gaps between some crossings by those of a coarser level; both ascending. Gaps of less than `sliver` are rounding.
fn filled(fine: &[Crossing], coarse: &[Crossing], sliver: f64) -> Vec<Crossing> {
    let mut all = Vec::with_capacity(fine.len() + coarse.len());
    let (mut next, mut reached) = (0, f64::NEG_INFINITY);
    for crossing in coarse {
        reached = reached.max(crossing.from);
        while let Some(finer) = fine.get(next).filter(|finer| finer.from < crossing.to) {
            if finer.from > reached + sliver {
                all.push(Crossing { from: reached, to: finer.from, ..*crossing });
            }
            reached = reached.max(finer.to);
            all.push(*finer);
            next += 1;
        }
        if crossing.to > reached + sliver {
            all.push(Crossing { from: reached, ..*crossing });
            reached = crossing.to;
        }
    }
    all.extend_from_slice(&fine[next..]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_between_finer_crossings_are_filled() {
        let at = |level: u32, from: f64, to: f64| Crossing { from, to, level, has_vacuum: false, range: [0.0; 2] };
        let fine = [at(1, 0.0, 1.0), at(1, 2.0, 5.0), at(1, 9.0, 10.0)];
        let coarse = [at(0, 0.5, 3.0), at(0, 3.0, 4.5), at(0, 4.5, 7.0), at(0, 8.0, 9.0 + 1e-12)];
        let all: Vec<_> = filled(&fine, &coarse, 1e-9).iter().map(|c| (c.level, c.from, c.to)).collect();
        let expected = [(1, 0.0, 1.0), (0, 1.0, 2.0), (1, 2.0, 5.0), (0, 5.0, 7.0), (0, 8.0, 9.0), (1, 9.0, 10.0)];
        assert_eq!(all, expected);
    }
}
