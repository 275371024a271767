//! Plain engine: one ray after another through the passes.

use glam::DVec3;
use vr_core::cancel::SparsePoll;
use vr_core::field::Stretch;
use vr_core::image_order::ImageSample;
use vr_core::{Clip, Counts, IndexRay, Layer, Probe, Ray, RayShading, Rays, Real, Scene, View};

use crate::caster::CompositingOrder;
use crate::chord::Chord;
use crate::classify::Classifier;
use crate::operator::{Needs, Operator, Recording, operator};
use crate::pace::Pace;
use crate::packet::FrameSetup;
use crate::place_colors::PlaceColors;
use crate::ray_value::RayValue;
use crate::run::Run;
use crate::shade::Shader;
use crate::source::Source;
use crate::tracer::{RaySample, Tracer};
use crate::walk::{StretchSteps, Walk, Walks, cut_walk, stretched_walk};

/// Data that a frame's rays share.
///
/// A run goes from pass to pass: walked, placed, sampled, classified, shaded, composited. Each pass is instantiated for what *it*
/// depends on (the sampling for voxel type and filter, all for the precision) and chosen once per run, so that there is a sum of
/// instances and not their product.
pub(crate) struct Pipeline<'a, R> {
    pub(crate) scene: &'a Scene,
    pub(crate) source: &'a Source,
    pub(crate) colors: Option<PlaceColors<'a>>,
    pub(crate) walks: Walks<'a>,
    /// Pace of rays through fields that know their stretches; `None` for grids.
    pub(crate) pace: Option<Pace<R>>,
    /// Place of a step's sample, as a fraction of the step.
    pub(crate) offset: f64,
    pub(crate) classifier: &'a Classifier<R>,
    pub(crate) shader: Option<&'a Shader<R>>,
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    pub(crate) rays: Rays,
    pub(crate) order: CompositingOrder,
}

/// Working memory of one thread that traces rays.
pub(crate) struct Scratch<'o, R> {
    operator: &'o mut dyn Operator<R>,
    run: Run<R>,
    /// Shading along the direction of the last ray: parallel rays share it.
    lights: Option<(DVec3, RayShading<R>)>,
}

impl<R: Real> Scratch<'_, R> {
    /// Returns the input that the operator asks for.
    pub(crate) fn needs(&self) -> Needs {
        self.operator.needs()
    }
}

/// Samples that rays take together.
pub(crate) trait SharedSamples<R> {
    /// Fills the values of a run that need not be placed.
    fn sample(&mut self, chord: &Chord<'_>, run: &mut Run<R>);
}

/// Part of a ray in volume and clip, and the way to trace it.
pub(crate) struct RayPart<'a, 's, R> {
    /// World direction.
    pub(crate) direction: DVec3,
    pub(crate) part: IndexRay,
    pub(crate) walk: Walk<'a>,
    /// Samples of the steps' places, where other rays share them.
    pub(crate) shared: Option<&'s mut dyn SharedSamples<R>>,
}

/// Shading of surfaces that another engine found.
pub(crate) struct SurfaceLook<'a, R = f32> {
    source: &'a Source,
    shader: &'a Shader<R>,
    run: Box<Run<R>>,
    /// Shading along the direction of the last ray.
    lights: Option<(DVec3, RayShading<R>)>,
}

impl<R: Real> SurfaceLook<'_, R> {
    /// Shades the surface that a ray meets at the depth of a value. Where rounding has put that place into vacuum, its gradient is that of the depth `behind`.
    pub(crate) fn shade(&mut self, ray: &Ray, value: &mut RayValue, behind: f64) {
        let lights = lights_along(&mut self.lights, self.shader, ray.direction);
        let grid = match self.source {
            Source::Grid(grid) => grid,
            Source::Other(field) => {
                let gradient = |depth: f64| field.gradient(ray.origin + ray.direction * depth);
                let found = gradient(value.depth).or_else(|| gradient(behind)).unwrap_or_default();
                self.shader.reflect_by(lights, found.map(R::from_f64), value);
                return;
            }
        };
        let Some(part) = IndexRay::new(ray, grid.placement(), grid.dims(), &Clip::default(), f64::INFINITY) else {
            return;
        };
        let chord = Chord { source: self.source, colors: None, ray: part };
        self.shader.shade_surface(lights, &chord, &mut self.run, value);
    }
}

/// Shading along a direction: that of the last ray, if it had the same.
fn lights_along<'l, R: Real>(
    last: &'l mut Option<(DVec3, RayShading<R>)>,
    shader: &Shader<R>,
    along: DVec3,
) -> &'l RayShading<R> {
    if last.as_ref().is_none_or(|(direction, _)| *direction != along) {
        *last = Some((along, shader.along(along)));
    }
    &last.as_ref().expect("just made").1
}

impl<R: Real> Tracer for Pipeline<'_, R> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let mut operator = self.operator();
        let mut scratch = self.scratch(operator.as_mut());
        values.extend(spots.iter().enumerate().map(|(i, spot)| {
            let start = starts.map_or(0, |starts| starts[i]);
            self.trace_ray(&mut scratch, &self.rays.at(spot.x, spot.y), spot.pixel, start, counts)
        }));
    }
}

impl<'a, R: Real> Pipeline<'a, R> {
    /// Shading of surfaces, where the scene is shaded.
    pub(crate) fn surface_look(&self) -> Option<SurfaceLook<'a, R>> {
        let shader = self.shader?;
        Some(SurfaceLook { source: self.source, shader, run: Box::new(Run::new()), lights: None })
    }

    /// Set-up of packets that take the rays of this engine, in steps of a world length; `forward` is the direction of the view.
    pub(crate) fn packet_setup(&self, step: f64, forward: DVec3) -> FrameSetup<'_> {
        FrameSetup {
            rays: &self.rays,
            placement: self.source.placement(),
            dims: self.source.dims(),
            clip: &self.view.clip,
            layer: self.layer,
            step,
            offset: self.offset,
            forward,
        }
    }

    /// Colour of the place at a distance along a ray, from its own origin; white where there is none.
    pub(crate) fn color_at(&self, ray: &Ray, depth: f64) -> [f64; 3] {
        let (placement, dims) = (self.source.placement(), self.source.dims());
        let index = placement.to_index(ray.origin + ray.direction * depth).to_array();
        let at: [f64; 3] = std::array::from_fn(|a| index[a].clamp(0.0, (dims[a] - 1) as f64));
        self.colors.map_or([1.0; 3], |colors| colors.at(at))
    }

    pub(crate) fn operator(&self) -> Box<dyn Operator<R>> {
        operator(self.scene, self.source.calibration(), self.order)
    }

    /// Returns the memory of one thread.
    pub(crate) fn scratch<'o>(&self, operator: &'o mut dyn Operator<R>) -> Scratch<'o, R> {
        Scratch { operator, run: Run::new(), lights: None }
    }

    /// Traces the ray through the centre of a pixel like any other, and records its steps; [`Probe`] explains `own_kernel`.
    pub(crate) fn probe(&self, [x, y]: [u32; 2], own_kernel: bool) -> Probe {
        let fractions = self.classifier.profile.as_ref().and_then(|profile| profile.fractions());
        let mut recording = Recording::new(self.operator(), self.source.calibration(), fractions);
        let mut scratch = self.scratch(&mut recording);
        let mut counts = Counts::default();
        let ray = self.rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let pixel = y as usize * self.view.size[0] as usize + x as usize;
        let RaySample { rgba, depth } = self.trace_ray(&mut scratch, &ray, pixel, 0, &mut counts);
        Probe { rgba, depth, own_kernel, ended_early: counts.terminated > 0, steps: recording.into_steps() }
    }

    /// Traces a ray through a pixel from step `start` of its lattice on.
    fn trace_ray(
        &self,
        scratch: &mut Scratch<'_, R>,
        ray: &Ray,
        pixel: usize,
        start: u32,
        counts: &mut Counts,
    ) -> RaySample {
        let layer = self.layer;
        let far = layer.map_or(f64::INFINITY, |l| l.depth(pixel));
        let part = IndexRay::new(ray, self.source.placement(), self.source.dims(), &self.view.clip, far);
        let value = part.map_or(RaySample::NOTHING, |part| {
            let walk = self.walk(ray, part, start, scratch.needs(), counts);
            self.trace_part(scratch, RayPart { direction: ray.direction, part, walk, shared: None }, counts).into()
        });
        layer.map_or(value, |l| value.over(l, pixel))
    }

    /// Begins the walk of a ray through the volume.
    fn walk(&self, ray: &Ray, part: IndexRay, start: u32, needs: Needs, counts: &mut Counts) -> Walk<'_> {
        let step = self.walks.step;
        if let Some(pace) = &self.pace
            && let Some(stretches) = self.source.stretches(ray, &part)
        {
            let shows = |range: [f32; 2]| pace.shows(range);
            let length = |stretch: &Stretch| pace.lengths.of(stretch.range, stretch.spacing);
            let before = usize::from(needs.brackets);
            let rule = StretchSteps { length: &length, shows: &shows, before, backwards: needs.backwards };
            let (walk, skipped) = stretched_walk(&part, &stretches, &rule);
            counts.skipped += skipped;
            return Walk::Listed(walk);
        }
        let jumps = self.source.jumps(ray, &part);
        if jumps.is_empty() {
            self.walks.along(part, start, u32::from(needs.brackets), needs.backwards)
        } else {
            Walk::Listed(cut_walk(&part, step, &jumps, needs.backwards))
        }
    }

    /// Traces the part of a ray that lies in volume and clip, whatever set its steps.
    pub(crate) fn trace_part(
        &self,
        scratch: &mut Scratch<'_, R>,
        RayPart { direction, part, mut walk, shared }: RayPart<'_, '_, R>,
        counts: &mut Counts,
    ) -> RayValue {
        let chord = &Chord { source: self.source, colors: self.colors, ray: part };
        let Scratch { operator, run, lights } = scratch;
        let needs = operator.needs();
        let shader = self.shader.filter(|_| needs.light || needs.surface);
        let shader = shader.map(|shader| (shader, lights_along(lights, shader, direction)));
        // Rays share one sample a step at most, and know it without its place.
        let several = self.classifier.profile.as_ref().is_some_and(|p| needs.light && p.fractions().is_some());
        let mut shared = shared.filter(|_| !several);
        let is_placed = shared.is_none() || shader.is_some() || self.colors.is_some();
        counts.rays += 1;
        operator.begin(chord);
        let mut ended = false;
        if needs.ends {
            chord.place_point(run, chord.ray.start);
            chord.sample(run);
            counts.samples += 1;
            ended = operator.take(run, chord).is_break();
        }
        let mut poll = SparsePoll::default();
        while !ended && walk.next(&mut run.steps) {
            poll.turn();
            run.offset = self.offset;
            if is_placed {
                chord.place(run, self.offset);
                if let Some(places) = walk.places() {
                    run.place_at(places);
                }
            }
            counts.samples += match (&mut shared, &self.classifier.profile) {
                (None, Some(profile)) if needs.light => profile.sample(chord, run),
                (shared, _) => {
                    match shared {
                        Some(shared) => shared.sample(chord, run),
                        None => chord.sample(run),
                    }
                    run.len() as u64
                }
            };
            #[cfg(feature = "classics")]
            if let Some(means) = walk.means() {
                for (value, &mean) in run.value[..run.steps.len].iter_mut().zip(means).filter(|(_, m)| !m.is_nan()) {
                    *value = R::from_f64(f64::from(mean));
                }
            }
            if needs.light {
                self.classifier.classify(run);
                chord.colors(run, false);
                match shader {
                    Some((shader, lights)) => shader.shade(lights, chord, run, self.classifier),
                    None => chord.tint(run),
                }
            } else if needs.colors {
                chord.colors(run, true);
            }
            ended = operator.take(run, chord).is_break();
        }
        if needs.ends && !ended {
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
        if chord.colors.is_some() && !needs.light && value.depth < f64::INFINITY {
            // What was picked has the colour of its place.
            let color = chord.color_at(value.depth - chord.ray.offset);
            (0..3).for_each(|c| value.rgba[c] *= color[c]);
        }
        if let Some((shader, lights)) = shader
            && needs.surface
            && value.depth < f64::INFINITY
        {
            shader.shade_surface(lights, chord, run, &mut value);
        }
        value
    }
}
