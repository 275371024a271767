//! The plain engine: one ray after another through the passes.

use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, GridVolume, IndexRay, Layer, Probe, Ray, RayShading, Rays, Real, View};

use crate::caster::Traversal;
use crate::chord::Chord;
use crate::classify::Classifier;
use crate::homogeneity::Homogeneity;
use crate::leap::EmptySpace;
use crate::operator::{Operator, Recording};
use crate::pace::PaceMap;
use crate::ray_value::RayValue;
use crate::run::Run;
use crate::shade::Shader;
use crate::tracer::{Traced, Tracer};
use crate::walk::{HomogeneousWalk, Lattice, LatticeWalk, LocalWalk, VisibleSteps, Walk, cell_walk, voxel_walk};

/// What a frame's rays share.
///
/// A run goes from pass to pass: walked, placed, sampled, classified, shaded, composited. Each pass is instantiated for what *it*
/// depends on (the sampling for voxel type and filter, the compositing for the operator, all for the precision) and chosen once per
/// run, so that there is a sum of instances and not their product.
pub(crate) struct Pipeline<'a, R, F> {
    pub(crate) volume: &'a GridVolume,
    pub(crate) traversal: Traversal,
    /// World length of the smallest voxel edge.
    pub(crate) voxel: f64,
    /// World length of a step, where all are alike; the longest, where steps end at cell faces; +∞: they end there only.
    pub(crate) step: f64,
    /// How long steps are, where they follow the data.
    pub(crate) pace: Option<&'a PaceMap>,
    /// Where long steps will do.
    pub(crate) homogeneity: Option<&'a Homogeneity>,
    /// Where nothing is visible, if that is to be left out of steps that are all alike.
    pub(crate) empty_space: Option<&'a EmptySpace>,
    /// From a step's begin to its sample, as a fraction of the step.
    pub(crate) offset: f64,
    pub(crate) classifier: &'a Classifier<R>,
    pub(crate) shader: Option<&'a Shader<R>>,
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    pub(crate) rays: Rays,
    /// Makes the compositing operator of a thread.
    pub(crate) operator: F,
}

/// What one thread needs to trace rays.
struct Scratch<R, O> {
    operator: O,
    run: Run<R>,
    /// Shading along the direction of the last ray: parallel rays share it.
    lights: Option<(DVec3, RayShading<R>)>,
}

impl<R: Real, O: Operator<R>, F: Fn() -> O + Sync> Tracer for Pipeline<'_, R, F> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<Traced>, counts: &mut Counts) {
        let mut scratch = Scratch { operator: (self.operator)(), run: Run::new(), lights: None };
        values.extend(spots.iter().enumerate().map(|(i, spot)| {
            let start = starts.map_or(0, |starts| starts[i]);
            self.trace_ray(&mut scratch, &self.rays.at(spot.x, spot.y), spot.pixel, start, counts)
        }));
    }
}

impl<R: Real, O: Operator<R>, F: Fn() -> O> Pipeline<'_, R, F> {
    /// Traces the ray through the centre of a pixel as any other, and tells all that is done for it. `own_kernel`: see [`Probe`].
    pub(crate) fn probe(&self, [x, y]: [u32; 2], own_kernel: bool) -> Probe {
        let fractions = self.classifier.profile.as_ref().and_then(|profile| profile.fractions());
        let operator = Recording::new((self.operator)(), self.volume.calibration(), fractions);
        let mut scratch = Scratch { operator, run: Run::new(), lights: None };
        let mut counts = Counts::default();
        let ray = self.rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let pixel = y as usize * self.view.size[0] as usize + x as usize;
        let Traced { rgba, depth } = self.trace_ray(&mut scratch, &ray, pixel, 0, &mut counts);
        Probe { rgba, depth, own_kernel, ended_early: counts.terminated > 0, steps: scratch.operator.into_steps() }
    }
}

impl<R: Real, F> Pipeline<'_, R, F> {
    /// Traces a ray through a pixel from step `start` of its lattice on.
    fn trace_ray<O: Operator<R>>(
        &self,
        scratch: &mut Scratch<R, O>,
        ray: &Ray,
        pixel: usize,
        start: u32,
        counts: &mut Counts,
    ) -> Traced {
        let layer = self.layer;
        let far = layer.map_or(f64::INFINITY, |l| l.depth(pixel));
        let part = IndexRay::new(ray, self.volume.placement(), self.volume.dims(), &self.view.clip, far);
        let value = part.map_or(Traced::NOTHING, |part| {
            let dims = self.volume.dims();
            let walk = match (self.traversal, self.pace, self.homogeneity) {
                (Traversal::Cells, ..) => Walk::Listed(cell_walk(&part, dims, self.step, start, O::BACKWARDS)),
                (Traversal::Voxels, ..) => Walk::Listed(voxel_walk(&part, dims, start, O::BACKWARDS)),
                (Traversal::Samples, Some(map), _) => Walk::Local(LocalWalk::new(map, part, self.voxel)),
                (Traversal::Samples, None, Some(map)) => {
                    Walk::Homogeneous(HomogeneousWalk::new(map, part, self.step, self.voxel))
                }
                (Traversal::Samples, None, None) => {
                    let lattice = Lattice::new(part.start, part.end, self.step);
                    let visible = VisibleSteps::new(lattice, start, u32::from(O::BRACKETS), &part, self.empty_space);
                    Walk::Lattice(LatticeWalk::new(lattice, visible, O::BACKWARDS))
                }
            };
            let chord = Chord { volume: self.volume, ray: part };
            self.along(scratch, ray, &chord, walk, counts).into()
        });
        layer.map_or(value, |l| value.over(l, pixel))
    }

    fn along<O: Operator<R>>(
        &self,
        scratch: &mut Scratch<R, O>,
        ray: &Ray,
        chord: &Chord<'_>,
        mut walk: Walk<'_>,
        counts: &mut Counts,
    ) -> RayValue {
        let Scratch { operator, run, lights } = scratch;
        let shader = self.shader.filter(|_| O::LIGHT || O::SURFACE).map(|shader| {
            if lights.as_ref().is_none_or(|(direction, _)| *direction != ray.direction) {
                *lights = Some((ray.direction, shader.along(ray.direction)));
            }
            (shader, &lights.as_ref().expect("just made").1)
        });
        counts.rays += 1;
        operator.begin(chord);
        let mut ended = false;
        if O::ENDS {
            chord.place_point(run, chord.ray.start);
            chord.sample(run);
            counts.samples += 1;
            ended = operator.take(run, chord).is_break();
        }
        while !ended && walk.next(&mut run.steps) {
            chord.place(run, self.offset);
            if let Some(places) = walk.places() {
                run.place_at(places);
            }
            counts.samples += match &self.classifier.profile {
                Some(profile) if O::LIGHT => profile.sample(chord, run),
                _ => {
                    chord.sample(run);
                    run.len() as u64
                }
            };
            if O::LIGHT {
                self.classifier.classify(run);
                if let Some((shader, lights)) = shader {
                    shader.shade(lights, chord, run, self.classifier);
                }
            }
            ended = operator.take(run, chord).is_break();
        }
        if O::ENDS && !ended {
            chord.place_point(run, chord.ray.end);
            chord.sample(run);
            counts.samples += 1;
            // What comes last ends nothing early.
            let _ = operator.take(run, chord);
        }
        counts.skipped += walk.skipped();
        // Only where something was left.
        counts.terminated += u64::from(ended && walk.next(&mut run.steps));
        let mut value = operator.finish(chord);
        if let Some((shader, lights)) = shader
            && O::SURFACE
            && value.depth < f64::INFINITY
        {
            shader.shade_surface(lights, chord, run, &mut value);
        }
        value
    }
}
