//! One ray through the passes.

use glam::DVec3;
use vr_core::{Counts, Filter, IndexRay, Ray, RayShading, Real, UniformVolume, View};

use crate::chord::Chord;
use crate::classify::Classifier;
use crate::operator::Operator;
use crate::ray_value::RayValue;
use crate::run::Run;
use crate::shade::Shader;
use crate::steps::Steps;

/// What a frame's rays share.
///
/// A run goes from pass to pass: placed, sampled, classified, shaded, composited. Each pass is instantiated for what *it* depends on
/// (the sampling for voxel type and filter, the compositing for the operator, all for the precision) and chosen once per
/// run, so that there is a sum of instances and not their product.
pub(crate) struct Pipeline<'a, R> {
    pub(crate) volume: &'a UniformVolume,
    pub(crate) filter: Filter,
    /// Length of a step in world units.
    pub(crate) step: f64,
    /// From a step's begin to its sample, as a fraction of the step.
    pub(crate) offset: f64,
    pub(crate) classifier: &'a Classifier<R>,
    pub(crate) shader: Option<&'a Shader<R>>,
    pub(crate) view: &'a View,
}

/// What one thread needs to trace rays.
pub(crate) struct Scratch<R, O> {
    operator: O,
    run: Run<R>,
    /// Shading along the direction of the last ray: parallel rays share it.
    lights: Option<(DVec3, RayShading<R>)>,
}

impl<R: Real, O: Operator<R>> Scratch<R, O> {
    pub(crate) fn new(operator: O) -> Self {
        Self { operator, run: Run::new(), lights: None }
    }
}

impl<R: Real> Pipeline<'_, R> {
    /// Traces a ray through a pixel.
    pub(crate) fn trace<O: Operator<R>>(
        &self,
        scratch: &mut Scratch<R, O>,
        ray: &Ray,
        pixel: usize,
        counts: &mut Counts,
    ) -> RayValue {
        let layer = self.view.layer.as_deref();
        let far = layer.map_or(f64::INFINITY, |l| l.depth(pixel));
        let part = IndexRay::new(ray, self.volume.placement(), self.volume.dims(), &self.view.clip, far);
        let value = part.map_or(RayValue::NOTHING, |part| {
            let steps = Steps::new(part.start, part.end, self.step);
            let chord = Chord { volume: self.volume, filter: self.filter, ray: part, steps };
            self.along(scratch, ray, &chord, counts)
        });
        layer.map_or(value, |l| value.over(l, pixel))
    }

    fn along<O: Operator<R>>(
        &self,
        scratch: &mut Scratch<R, O>,
        ray: &Ray,
        chord: &Chord<'_>,
        counts: &mut Counts,
    ) -> RayValue {
        let Scratch { operator, run, lights } = scratch;
        let shader = self.shader.filter(|_| O::LIGHT || O::SURFACE).map(|shader| {
            if lights.as_ref().is_none_or(|(direction, _)| *direction != ray.direction) {
                *lights = Some((ray.direction, shader.shading().along(ray.direction)));
            }
            (shader, &lights.as_ref().expect("just made").1)
        });
        counts.rays += 1;
        operator.begin(chord);
        let runs = chord.runs();
        // The ends of the chord, where an operator wants them, are two more runs of one sample each.
        let ends = usize::from(O::ENDS);
        for i in 0..runs + 2 * ends {
            let index = if O::BACKWARDS { runs - 1 - i } else { i.wrapping_sub(ends) };
            if O::ENDS && i == 0 {
                chord.place_point(run, chord.ray.start);
            } else if index == runs {
                chord.place_point(run, chord.ray.end);
            } else {
                chord.place(run, index, self.offset);
            }
            chord.sample(run);
            counts.samples += run.len as u64;
            if O::LIGHT {
                self.classifier.classify(run);
                if let Some((shader, lights)) = shader {
                    shader.shade(lights, chord, run, self.classifier);
                }
            }
            if operator.take(run, chord).is_break() {
                counts.terminated += u64::from(i + 1 < runs + 2 * ends);
                break;
            }
        }
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
