//! Walk of one ray over the steps of a template.

use vr_core::IndexRay;

use super::base_plane::BasePlane;
use super::steps::{TemplatePart, TemplateSteps};
use crate::leap::Leaper;
use crate::operator::Needs;
use crate::run::{RUN, Steps};
use crate::walk::{SequenceWalk, StepSequence, VisibleSteps};

/// Walk of one ray over the steps of a template.
pub(crate) struct TemplateWalk<'a> {
    walk: SequenceWalk<'a, TemplatePart<'a>>,
    /// Voxels that the steps stand for, where samples lie beside the ray.
    voxels: Option<Box<Voxels<'a>>>,
}

/// Voxels that the steps of one ray stand for.
struct Voxels<'a> {
    plane: &'a BasePlane,
    steps: &'a TemplateSteps,
    /// Lattice point along u and v that the ray starts at.
    start: [i64; 2],
    /// Numbers of the last run's steps, and the index-space positions of their voxels.
    numbers: [u32; RUN],
    len: usize,
    places: [[f64; 3]; RUN],
}

impl<'a> TemplateWalk<'a> {
    /// Begins the walk of the ray that starts at a lattice point of the base plane, over the part of it that lies in volume and clip.
    pub(crate) fn new(
        plane: &'a BasePlane,
        steps: &'a TemplateSteps,
        leaper: Option<&'a dyn Leaper>,
        (start, part): ([i64; 2], &IndexRay),
        needs: Needs,
    ) -> Self {
        let own = steps.of_part(part);
        let visible = VisibleSteps::new(own.clone(), own.numbers().start, u32::from(needs.brackets), part, leaper);
        let none = || Box::new(Voxels { plane, steps, start, numbers: [0; RUN], len: 0, places: [[0.0; 3]; RUN] });
        Self { walk: SequenceWalk::new(own, visible, needs.backwards), voxels: steps.beside.then(none) }
    }

    /// Fills the next run; returns false if all are walked.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        let goes_on = self.walk.next(steps);
        if let Some(voxels) = &mut self.voxels {
            (voxels.numbers, voxels.len) = (steps.number, steps.len);
        }
        goes_on
    }

    /// Returns the positions of the samples of the last run, if they are not on the ray.
    pub(crate) fn places(&mut self) -> Option<&[[f64; 3]]> {
        let Voxels { plane, steps, start, numbers, len, places } = self.voxels.as_deref_mut()?;
        for (place, &number) in places.iter_mut().zip(&numbers[..*len]) {
            *place = plane.voxel(*start, steps.places[number as usize].whole);
        }
        Some(&places[..*len])
    }

    /// Returns the number of steps left out so far because nothing in them is visible.
    pub(crate) fn skipped(&self) -> u64 {
        self.walk.skipped()
    }
}
