//! Steps of one ray, batch by batch.

use std::collections::VecDeque;

use crate::walk::{Lattice, SKIN, SLIVER};

/// Part of a ray in one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Distance along the ray at which it begins.
    pub(crate) from: f64,
    /// Distance at which it ends.
    pub(crate) to: f64,
    /// Number of the patch.
    pub(crate) patch: usize,
    /// Length of a step.
    pub(crate) step: f64,
    /// True if something in it can be seen.
    pub(crate) is_seen: bool,
}

/// Steps of one length in one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Batch {
    pub(crate) patch: usize,
    /// Distance at which the step of number 0 begins: one that does not depend on what can be seen.
    pub(crate) begin: f64,
    /// Length of each.
    pub(crate) length: f64,
    /// Number of the first one.
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// Distance of the middle of the step before, whether that can be seen or not; of the begin of the ray, before the first step.
    pub(crate) before: f64,
}

/// Largest number of a step in a batch: f32 counts them exactly.
const MAX_NUMBER: u32 = 1 << 20;

/// Cuts the parts of a ray into steps: those of the plain engine's `stretched_walk`, but for those whose middle lies where nothing can be seen.
///
/// Parts of one step that touch have one lattice. Where its next step ends beyond what is known of it, parts are asked for ahead.
#[derive(Debug, Default)]
pub(crate) struct StepBatches {
    /// Ends of the ray.
    ends: [f64; 2],
    /// Parts not done yet.
    ahead: VecDeque<Waiting>,
    /// Last part that was asked for.
    last: Option<Part>,
    /// True if there are no more parts.
    is_closed: bool,
    run: Run,
    /// True if the begin of the ray is to be sampled yet, and its end.
    samples_ends: [bool; 2],
    /// Distance of the middle of the last step, whether that can be seen or not; of the begin of the ray, before the first step.
    middle: f64,
}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    part: Part,
    /// True if its steps are those of the lattice of the part before.
    joins: bool,
    is_behind_vacuum: bool,
}

/// Lattice of steps, as far as it is known.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    from: f64,
    /// Number of the next step.
    next: u32,
    /// Patch, and number of the step with which the ray came into it.
    patch: Option<(usize, u32)>,
    /// True if a very short step is to be taken behind vacuum.
    has_skin: bool,
    /// Begin and length of what is left of the step that began with it.
    rest: Option<[f64; 2]>,
}

impl StepBatches {
    /// Begins with the parts of another ray, between two distances; these are sampled, too, as steps without a length, if `samples_ends`.
    pub(crate) fn begin(&mut self, ends: [f64; 2], samples_ends: bool) {
        self.ahead.clear();
        (self.ends, self.last, self.is_closed, self.run) = (ends, None, false, Run::default());
        (self.samples_ends, self.middle) = ([samples_ends; 2], ends[0]);
    }

    /// Returns the next batch of steps that can be seen, or an end of the ray that can, and is not in vacuum.
    pub(crate) fn next(&mut self, parts: &mut impl Iterator<Item = Part>) -> Option<Batch> {
        let [start, end] = self.ends;
        if std::mem::take(&mut self.samples_ends[0]) {
            self.pull(parts);
            let first = self.ahead.front().filter(|first| first.part.from == start && first.part.is_seen);
            if let Some(first) = first {
                let patch = first.part.patch;
                return Some(self.single(patch, [start, 0.0]));
            }
        }
        if let Some(batch) = self.next_steps(parts) {
            return Some(batch);
        }
        if std::mem::take(&mut self.samples_ends[1]) {
            let last = self.last.filter(|last| last.to >= end - SLIVER * last.step && last.is_seen)?;
            return Some(self.single(last.patch, [end, 0.0]));
        }
        None
    }

    /// Asks for one more part.
    fn pull(&mut self, parts: &mut impl Iterator<Item = Part>) {
        let [start, end] = self.ends;
        loop {
            let Some(part) = parts.next() else {
                self.is_closed = true;
                return;
            };
            // An end of the field is one of the ray, if only rounding keeps them apart.
            let is_at = |a: f64, b: f64| (a - b).abs() <= SLIVER * part.step;
            let from = if is_at(part.from, start) { start } else { part.from.max(start) };
            let to = if is_at(part.to, end) { end } else { part.to.min(end) };
            let touches = self.last.is_some_and(|last| part.from - last.to <= SLIVER * part.step.min(last.step));
            let joins = touches && self.last.is_some_and(|last| last.step == part.step) && !self.ahead.is_empty();
            let is_behind_vacuum = if self.last.is_some() { !touches } else { from > start };
            self.last = Some(part);
            if from < to {
                self.ahead.push_back(Waiting { part: Part { from, to, ..part }, joins, is_behind_vacuum });
                return;
            }
        }
    }

    /// Returns the next batch of steps that can be seen.
    fn next_steps(&mut self, parts: &mut impl Iterator<Item = Part>) -> Option<Batch> {
        let mut found: Option<Batch> = None;
        loop {
            if self.ahead.len() < 2 && !self.is_closed {
                // One is always known ahead, so that it is known which joins.
                self.pull(parts);
                continue;
            }
            let Some(&Waiting { part, joins, is_behind_vacuum }) = self.ahead.front() else { return found };
            if !joins {
                if found.is_some() {
                    return found;
                }
                self.run = Run { from: part.from, has_skin: is_behind_vacuum, ..Run::default() };
                self.ahead[0].joins = true;
            }
            let anchor = match self.run.patch {
                Some((patch, anchor)) if patch == part.patch => anchor,
                _ if found.is_some() => return found,
                _ => {
                    self.run.patch = Some((part.patch, self.run.next));
                    self.run.next
                }
            };

            // Steps with their middle in this part, and the end of the lattice, as far as they must be known.
            let (from, step) = (self.run.from, part.step);
            let middles = ceil((part.to - from) / step - 0.5);
            // One step more: if it is the last one, and shorter, its middle may lie here.
            let needed = from + (f64::from(middles) + 1.0) * step;
            let (known, is_closed) = self.known_end();
            if !is_closed && known < needed {
                self.pull(parts);
                continue;
            }
            let is_last = self.ahead.get(1).is_none_or(|next| !next.joins);
            let lattice = is_closed.then(|| Lattice::new(from, known, step));
            let whole = lattice.map_or(u32::MAX, |l| if l.last == step { l.count } else { l.count - 1 });
            let until = if is_last { whole } else { middles.min(whole) };
            let is_mine = |[begin, length]: [f64; 2]| is_last || begin + 0.5 * length < part.to;

            // Behind vacuum, a very short step and the rest of the first one.
            if self.run.has_skin && self.run.next == 0 {
                let (skin, first) = (SKIN * step, if whole == 0 { lattice.map_or(step, |l| l.last) } else { step });
                self.run.has_skin = false;
                if first > 2.0 * skin {
                    self.run.rest = Some([from + skin, first - skin]);
                    let skin = self.single(part.patch, [from, skin]);
                    if part.is_seen {
                        return Some(skin);
                    }
                }
            }
            if let Some(rest) = self.run.rest {
                if is_mine(rest) {
                    (self.run.rest, self.run.next) = (None, 1);
                    let rest = self.single(part.patch, rest);
                    if part.is_seen {
                        return Some(rest);
                    }
                } else {
                    self.ahead.pop_front();
                }
                continue;
            }
            // Whole steps.
            if until > self.run.next {
                let number = self.run.next - anchor;
                let first = number % MAX_NUMBER;
                let count = (until - self.run.next).min(MAX_NUMBER - first);
                let goes_on = found.is_some_and(|batch| batch.first + batch.count == first);
                match &mut found {
                    Some(batch) if part.is_seen && goes_on => batch.count += count,
                    Some(batch) => return Some(*batch),
                    None if part.is_seen => {
                        let begin = from + f64::from(anchor + (number - first)) * step;
                        let before = self.middle;
                        found = Some(Batch { patch: part.patch, begin, length: step, first, count, before });
                    }
                    None => {}
                }
                self.run.next += count;
                self.middle = from + (f64::from(self.run.next) - 0.5) * step;
                continue;
            }
            // A shorter one at the end.
            if let Some(lattice) = lattice.filter(|l| self.run.next == whole && whole < l.count) {
                let last = [lattice.begin(whole), lattice.last];
                if is_mine(last) {
                    if found.is_some() {
                        return found;
                    }
                    self.run.next += 1;
                    let last = self.single(part.patch, last);
                    if part.is_seen {
                        return Some(last);
                    }
                    continue;
                }
            }
            self.ahead.pop_front();
        }
    }

    /// Batch of one step, which comes next on the ray.
    fn single(&mut self, patch: usize, [begin, length]: [f64; 2]) -> Batch {
        let before = std::mem::replace(&mut self.middle, begin + 0.5 * length);
        Batch { patch, begin, length, first: 0, count: 1, before }
    }

    /// End of the lattice of the first part, as far as it is known, and true if it goes no further.
    fn known_end(&self) -> (f64, bool) {
        let mut end = self.ahead[0].part.to;
        for next in self.ahead.iter().skip(1) {
            if !next.joins {
                return (end, true);
            }
            end = next.part.to;
        }
        (end, self.is_closed)
    }
}

/// Smallest whole number that is not below another, 0 at least: where a machine has no instruction for it, several times as fast as the standard library's.
#[inline]
fn ceil(x: f64) -> u32 {
    let cut = x as u32;
    cut.saturating_add(u32::from(f64::from(cut) < x))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use vr_core::IndexRay;
    use vr_core::field::Stretch;

    use super::*;
    use crate::run::Steps;
    use crate::walk::{StretchSteps, stretched_walk};

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

        /// The steps of the plain engine, but for those whose middle lies in a part of which nothing can be seen.
        #[test]
        fn batches_are_the_steps_of_the_plain_engine(
            lengths in prop::collection::vec((0.0f64..3.0, 0usize..3, 0usize..2, any::<bool>(), prop::bool::weighted(0.1)), 1..12),
            (begin, end) in (-1.0f64..3.0, 4.0f64..20.0),
            step in 0.05f64..2.0,
        ) {
            let (mut stretches, mut parts, mut at) = (Vec::new(), Vec::new(), 0.0);
            let ray = IndexRay { origin: glam::DVec3::ZERO, direction: glam::DVec3::X, start: begin, end, offset: 0.0 };
            for (length, pace, patch, is_seen, gap) in lengths {
                at += if gap { 0.7 } else { 0.0 };
                let spacing = [1.0, 1.0, 2.0][pace];
                let (from, to) = (at, at + length);
                at = to;
                // A field is asked for the ray's part alone.
                let (from, to) = (from.max(begin), to.min(end));
                if from < to {
                    stretches.push(Stretch { from, to, spacing, range: [0.0, f32::from(u8::from(is_seen))] });
                    parts.push(Part { from, to, patch, step: step * spacing, is_seen });
                }
            }
            let length = |stretch: &Stretch| step * stretch.spacing;
            let rule = StretchSteps { length: &length, shows: &|_| true, before: 0, backwards: false };
            let (mut walk, _) = stretched_walk(&ray, &stretches, &rule);
            let (mut steps, mut every, mut want) = (Steps::new(), Vec::new(), Vec::new());
            let seen = |s: f64| parts.iter().any(|p: &Part| p.is_seen && p.from - 1e-9 <= s && s < p.to + 1e-9);
            while walk.next(&mut steps) {
                let all = (0..steps.len).map(|k| [steps.begin[k], steps.length[k]]);
                every.extend(all.clone());
                want.extend(all.filter(|[begin, length]| seen(begin + 0.5 * length)));
            }
            let (mut batches, mut source, mut got) = (StepBatches::default(), parts.iter().copied(), Vec::new());
            batches.begin([begin, end], false);
            let middles: Vec<f64> = [begin].into_iter().chain(every.iter().map(|[begin, length]| begin + 0.5 * length)).collect();
            while let Some(batch) = batches.next(&mut source) {
                let first = batch.begin + (f64::from(batch.first) + 0.5) * batch.length;
                let before = middles.iter().rfind(|&&middle| middle < first - 1e-9);
                prop_assert!(before.is_none_or(|before| (batch.before - before).abs() < 1e-9), "{:?} for {:?}", batch, before);
                for k in batch.first..batch.first + batch.count {
                    let step = [batch.begin + f64::from(k) * batch.length, batch.length];
                    // In its patch, or within rounding of it.
                    let middle = step[0] + 0.5 * step[1];
                    let own = parts.iter().any(|p| {
                        p.patch == batch.patch && p.is_seen && p.from - 1e-9 <= middle && middle <= p.to + 1e-9
                    });
                    prop_assert!(own, "{:?} of {:?}", step, batch);
                    got.push(step);
                }
            }
            prop_assert_eq!(got.len(), want.len(), "{:?} for {:?}", got, want);
            for (g, w) in got.iter().zip(&want) {
                prop_assert!((g[0] - w[0]).abs() < 1e-9 && (g[1] - w[1]).abs() < 1e-9, "{:?} for {:?}", g, w);
            }
        }
    }
}
