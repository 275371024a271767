//! Template: the steps that all rays of a view share.

use std::ops::Range;

use glam::DVec3;
use vr_core::IndexRay;

use super::Connectivity;
use super::base_plane::BasePlane;
use crate::run::Steps;
use crate::walk::{Lattice, StepSequence, cell_steps};

/// Steps that all rays of a view share, in world distances from the base plane, from there to the last slice.
#[derive(Clone, Debug)]
pub(crate) struct TemplateSteps {
    pub(crate) begin: Vec<f64>,
    pub(crate) length: Vec<f64>,
    /// Positions of the samples.
    pub(crate) places: Vec<Place>,
    /// True if samples are voxels, which lie beside the ray.
    pub(crate) beside: bool,
    sliver: f64,
}

/// Position of a sample from the voxel that a ray starts at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Whole index steps along u, v and w: the last before the sample, so that there is another slice behind.
    pub(crate) whole: [i64; 3],
    /// The rest of each, 0 to 1.
    pub(crate) rest: [f64; 3],
}

/// Fraction of a template's length below which a part of a step is rounding and falls to its neighbour.
const SLIVER: f64 = 1e-12;

impl TemplateSteps {
    /// Makes the template of a base plane. `longest` is the world length of a step, or of the longest in a cell; `offset` is the place of a
    /// step's sample, as a fraction of the step.
    pub(crate) fn new(connectivity: Connectivity, plane: &BasePlane, longest: f64, offset: f64) -> Self {
        let last = plane.dims[2] - 1;
        let depth = last as f64 * plane.slice;
        let steps: Vec<(f64, f64)> = match connectivity {
            Connectivity::Continuous => {
                let lattice = Lattice::new(0.0, depth, longest);
                (0..lattice.count).map(|k| (lattice.begin(k), lattice.length_of(k))).collect()
            }
            // Cells of one ray, in a grid that it leaves by the last slice alone.
            Connectivity::Faces => {
                let [u, v] = plane.slope;
                let from = |slope: f64| if slope < 0.0 { (last + 1) as f64 } else { 0.0 };
                let (origin, direction) = (DVec3::new(from(u), from(v), 0.0), DVec3::new(u, v, 1.0) / plane.slice);
                let ray = IndexRay { origin, direction, start: 0.0, end: depth, offset: 0.0 };
                cell_steps(&ray, [last + 2, last + 2, last + 1], longest)
            }
            // From the middle between two slices to the next; whole ones of one length to the last bit, which a table is for.
            Connectivity::Discrete => {
                let length = |t: usize| if t == 0 || t == last { 0.5 * plane.slice } else { plane.slice };
                (0..=last).map(|t| ((t as f64 - 0.5).max(0.0) * plane.slice, length(t))).collect()
            }
        };
        let place = |(number, &(begin, length)): (usize, &(f64, f64))| match connectivity {
            Connectivity::Continuous | Connectivity::Faces => {
                let t = ((begin + offset * length) / plane.slice).min(last as f64);
                let at = [plane.slope[0] * t, plane.slope[1] * t, t];
                let whole = [at[0].floor(), at[1].floor(), t.floor().min((last - 1) as f64)];
                Place { whole: whole.map(|x| x as i64), rest: std::array::from_fn(|a| at[a] - whole[a]) }
            }
            // To the nearest voxel; half a voxel goes up. By one at most per slice: voxels touch.
            Connectivity::Discrete => {
                let nearest = plane.slope.map(|slope| (slope * number as f64 + 0.5).floor() as i64);
                Place { whole: [nearest[0], nearest[1], number as i64], rest: [0.0; 3] }
            }
        };
        let places = steps.iter().enumerate().map(place).collect();
        let (begin, length) = steps.into_iter().unzip();
        Self { begin, length, places, beside: connectivity == Connectivity::Discrete, sliver: SLIVER * depth }
    }

    /// Returns the steps of the part of a ray that lies in volume and clip.
    pub(crate) fn of_part(&self, part: &IndexRay) -> TemplatePart<'_> {
        let first = self.begin.partition_point(|&b| b <= part.start + self.sliver).max(1) - 1;
        let end = self.begin.partition_point(|&b| b < part.end - self.sliver).max(first + 1);
        // Steps that are whole up to rounding are whole: tables hold for their length, and samples are shared.
        let from = |k: usize| {
            let is_cut = k == first && part.start - self.begin[k] > self.sliver;
            if is_cut { part.start } else { self.begin[k] }
        };
        let step = |k: usize| {
            let whole_end = self.begin[k] + self.length[k];
            let begin = from(k);
            if k + 1 == end && whole_end - part.end > self.sliver {
                (begin, part.end - begin)
            } else if begin > self.begin[k] {
                (begin, whole_end - begin)
            } else {
                (begin, self.length[k])
            }
        };
        TemplatePart { steps: self, numbers: first as u32..end as u32, ends: [step(first), step(end - 1)] }
    }
}

/// Steps of the template that a part of a ray takes; the first and the last one end where it does.
#[derive(Clone, Debug)]
pub(crate) struct TemplatePart<'a> {
    steps: &'a TemplateSteps,
    numbers: Range<u32>,
    /// Begin and length of the first step and of the last.
    ends: [(f64, f64); 2],
}

impl StepSequence for TemplatePart<'_> {
    fn numbers(&self) -> Range<u32> {
        self.numbers.clone()
    }

    fn begin(&self, number: u32) -> f64 {
        if number == self.numbers.start { self.ends[0].0 } else { self.steps.begin[number as usize] }
    }

    fn push(&self, numbers: Range<u32>, steps: &mut Steps) {
        let (at, len) = (steps.len, numbers.len());
        let of_template = numbers.start as usize..numbers.end as usize;
        steps.begin[at..at + len].copy_from_slice(&self.steps.begin[of_template.clone()]);
        steps.length[at..at + len].copy_from_slice(&self.steps.length[of_template]);
        for (number, k) in steps.number[at..at + len].iter_mut().zip(numbers.clone()) {
            *number = k;
        }
        steps.len += len;
        if len > 0 && numbers.end == self.numbers.end {
            (steps.begin[at + len - 1], steps.length[at + len - 1]) = self.ends[1];
        }
        if len > 0 && numbers.start == self.numbers.start {
            (steps.begin[at], steps.length[at]) = self.ends[0];
        }
    }

    fn steps_in(&self, begin: f64, end: f64) -> Range<u32> {
        let step = |s: f64| self.steps.begin.partition_point(|&b| b <= s).saturating_sub(1) as u32;
        step(begin).max(self.numbers.start)..(step(end) + 1).min(self.numbers.end)
    }
}
