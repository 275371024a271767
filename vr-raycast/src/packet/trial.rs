//! Steps and rays of a picture, chosen by what a few rays show.

use std::sync::Arc;

use rayon::prelude::*;
use vr_core::image_order::ImageSample;
use vr_core::{Control, Counts, Layer, RenderError, Scene, View};

use super::engine::{PacketEngine, PacketFrame, PacketLengths};
use crate::caster::Rule;
use crate::leap::{ClearSpace, Visibility};
use crate::step_map::{CLEAR, Cuts, SHORTEST, StepMap};
use crate::tracer::{RaySample, Tracer};

/// Choice of steps and rays for pictures of a scene whose steps were left to the caster.
///
/// A local step takes longer than one of fixed length: its length is looked up, and its light takes an exponential. Where all that is visible asks for nearly
/// the same steps, nothing is gained by that; and what local steps go by is a guess, made without a look at the picture. So a few rays, spread over the
/// picture, are traced in steps of two lengths, one twice the other. The midpoint rule has order 2, so that the two differ by three times the error of the
/// shorter steps ([`ORDERS`]). From that follows the length that makes the error which is aimed at: *even steps*, where they take less time than local ones.
///
/// The same rays tell how much the picture bends, and so how many rays adaptive ones would leave out.
///
/// Rays between these may meet what none of them meets. Hence even steps are never longer than [`LONGEST`] allows, whatever the rays show.
#[derive(Debug)]
pub(crate) struct Trial {
    /// RMSE to aim at.
    error: f64,
    /// True if the transfer function jumps or has thin peaks.
    is_sharp: bool,
    /// Class of the shortest step that local steps take anywhere.
    shortest: i32,
    clear: Option<Arc<ClearSpace>>,
    /// The last engines that have been asked for, by the class of their steps; `None` where no table serves these.
    engines: Vec<(i32, Option<Arc<PacketEngine>>)>,
}

/// Steps and rays that were chosen for a picture.
#[derive(Debug)]
pub(crate) struct Choice {
    /// Engine that takes even steps; `None` where local ones are better.
    pub(crate) even: Option<Arc<PacketEngine>>,
    /// True if the rays of every pixel take less time than adaptive ones.
    pub(crate) every_pixel: bool,
}

/// Classes of lengths from one length to twice that.
const PER_OCTAVE: i32 = 8;
/// The longest even steps, in classes above the shortest local one, where the transfer function is continuous, and where it jumps or has thin peaks: 2.4 times that,
/// so that no place has more than six times the error that it would have; and 1.7 times (a head at 2 times has a pixel that is off by 2.7·10⁻², and by 1.9·10⁻² at these).
const LONGEST: [i32; 2] = [10, 6];
/// The shortest even steps, in classes below the shortest local one: half of it.
const SHORTEST_BELOW: i32 = 8;
/// The shorter steps of the trial, in classes above the shortest local one. The longer ones are twice as long, and still follow the field.
const FIRST: i32 = -2;
/// Part of the error that steps may make: adaptive rays add theirs.
const SHARE: f64 = 0.9;
/// Time of a sample of local steps, in samples of even ones: with one sample a step (1.2 to 2.1 in fog, blobs, a brain, a bonsai and a tooth), and with parabolas, of
/// two samples a step (0.9 and 1.0 in an engine and a head; a little more is taken for the smaller error of even steps).
const LOCAL_COSTS: [f64; 2] = [1.6, 1.1];
/// Samples of a local step, in the same cases.
const SAMPLES: [f64; 2] = [1.0, 2.0];
/// Order of the RMSE in the length of steps where the transfer function is continuous, and where it jumps or has thin peaks: a jump is misplaced by up to half a
/// step, on a part of the rays that is as small as the step.
const ORDERS: [f64; 2] = [2.0, 1.5];
/// Number of engines that are kept: views beside each other ask for the same ones.
const MAX_KEPT: usize = 8;
/// Groups of rays, across and down: few rays beside those of a picture, and enough to know its RMSE to a fifth.
const GROUPS: [u32; 2] = [8, 6];
/// Rays of a group, across and down: a packet.
const ACROSS: usize = 4;
/// Number of rays that must show something: of fewer, too little is known.
const MIN_SHOWN: usize = 64;
/// Part of the rays above which adaptive ones take longer than all: packets of scattered rays take two to three times as long.
const MAX_PART_OF_RAYS: f64 = 1.0 / 3.0;

/// Length of the steps of a class, in voxels.
///
/// One class in eight would be near a small ratio of whole numbers, and has the length of the class below; [`SHORTEST`] tells the reason.
fn voxels(class: i32) -> f64 {
    let class = if class.rem_euclid(PER_OCTAVE) == 1 { class - 1 } else { class };
    SHORTEST * libm::exp2(f64::from(class) / f64::from(PER_OCTAVE))
}

/// Class of the steps that local steps take by a byte of their map.
fn class_of_byte(byte: usize) -> i32 {
    byte as i32 * PER_OCTAVE / 2
}

impl Trial {
    /// Returns the choice for an engine with local steps that aim at an RMSE; `None` where no steps of one length can take their place.
    pub(crate) fn new(local: &PacketEngine, scene: &Scene, rule: Rule, error: f64) -> Option<Self> {
        let PacketLengths::Local { map, .. } = &local.lengths else { return None };
        let jumps = !matches!(map.cuts(), Cuts::None);
        if jumps || scene.volume.colors().is_some() || scene.transfer.has_rows() {
            return None;
        }
        // The mean step, along rays that cross all visible blocks.
        let mut blocks = [0u32; CLEAR as usize];
        map.bytes().iter().filter(|&&byte| byte < CLEAR).for_each(|&byte| blocks[usize::from(byte)] += 1);
        let visible = || blocks.iter().enumerate().filter(|(_, count)| **count > 0);
        let shortest = class_of_byte(visible().next()?.0);
        let count: f64 = visible().map(|(_, &count)| f64::from(count)).sum();
        let steps: f64 = visible().map(|(byte, &count)| f64::from(count) / voxels(class_of_byte(byte))).sum();
        let is_sharp = rule == Rule::Quadratic;
        let case = usize::from(is_sharp);
        if count / steps > voxels(shortest + LONGEST[case]) * SAMPLES[case] * LOCAL_COSTS[case] {
            return None;
        }
        let clear = clear_space(local, scene, map).map(Arc::new);
        Some(Self { error, is_sharp, shortest, clear, engines: Vec::new() })
    }

    /// Returns the choice for a view, where adaptive rays would be `spacing` pixels apart at first, and have a threshold; `None` where too little shows. It depends on
    /// scene and view alone.
    ///
    /// # Errors
    /// A view that makes no sense; a cancelled picture.
    pub(crate) fn choose(
        &mut self,
        (local, scene): (&PacketEngine, &Scene),
        seen @ (view, _): (&View, Option<&Layer>),
        (spacing, threshold): (usize, f64),
        control: &Control,
    ) -> Result<Option<Choice>, RenderError> {
        let spots = spots(view, spacing);
        let traced = |engine: &PacketEngine| -> Result<(Vec<RaySample>, u64), RenderError> {
            let frame = PacketFrame::new(engine, &engine.volume, seen)?;
            control.check()?;
            Ok(control.run(|| by_groups(&frame, &spots)))
        };
        let (first, case) = (self.shortest + FIRST, usize::from(self.is_sharp));
        let [fine, coarse] = [first, first + PER_OCTAVE].map(|class| self.engine(local, scene, class));
        let (Some(fine), Some(coarse)) = (fine, coarse) else { return Ok(None) };
        let ((fine, samples), (coarse, _)) = (traced(&fine)?, traced(&coarse)?);
        let Some(difference) = rms_difference(&fine, &coarse) else { return Ok(None) };
        // Find the length that makes the error, and what it costs.
        let rmse = difference / (libm::exp2(ORDERS[case]) - 1.0);
        let octaves = libm::log2(SHARE * self.error / rmse.max(f64::MIN_POSITIVE)) / ORDERS[case];
        let wanted = first + libm::round((octaves * f64::from(PER_OCTAVE)).clamp(-64.0, 64.0)) as i32;
        let class = wanted.min(self.shortest + LONGEST[case]);
        let cost = samples as f64 * voxels(first) / voxels(class);
        let is_better = || -> Result<bool, RenderError> {
            let allowed = class >= self.shortest - SHORTEST_BELOW;
            Ok(allowed && cost <= LOCAL_COSTS[case] * traced(local)?.1 as f64)
        };
        Ok(Some(Choice {
            even: if is_better()? { self.engine(local, scene, class) } else { None },
            every_pixel: part_of_rays(&fine, threshold as f32) > MAX_PART_OF_RAYS,
        }))
    }

    /// Returns the engine with steps of a class, if there is one.
    fn engine(&mut self, local: &PacketEngine, scene: &Scene, class: i32) -> Option<Arc<PacketEngine>> {
        let known = self.engines.iter().position(|(known, _)| *known == class);
        if let Some(at) = known {
            return self.engines[at].1.clone();
        }
        if self.engines.len() == MAX_KEPT {
            self.engines.remove(0);
        }
        let engine = local.in_even_steps(scene, self.clear.clone(), voxels(class)).map(Arc::new);
        self.engines.push((class, engine.clone()));
        engine
    }
}

/// Finds the clear space of an engine with a map of steps, which knows clear blocks whatever the filter.
fn clear_space(local: &PacketEngine, scene: &Scene, map: &StepMap) -> Option<ClearSpace> {
    let volume = &local.volume;
    if ClearSpace::knows_cells(volume) {
        let visibility = Visibility::of_light(&scene.transfer, volume.calibration(), None, None);
        return PacketEngine::clear_space(volume, &visibility, StepMap::EDGE);
    }
    let space = ClearSpace::of_blocks(StepMap::EDGE, map.blocks(), |block| map.bytes()[block] >= CLEAR);
    space.has_any().then_some(space)
}

/// Returns groups of rays through pixels that are `spacing` apart, row by row. One group lies in each of equal parts of the view, at places that do not repeat (the additive
/// recurrence of M. Roberts 2018, *The unreasonable effectiveness of quasirandom sequences*).
fn spots(view: &View, spacing: usize) -> Vec<ImageSample> {
    let [w, h] = view.size.map(|n| n as usize);
    let mut spots = Vec::new();
    for group in 0..GROUPS[0] * GROUPS[1] {
        let corner = |at: u32, of: u32, pixels: usize, ratio: f64| {
            let place = (f64::from(at) + (f64::from(group) * ratio).fract()) / f64::from(of);
            (place * pixels.saturating_sub(spacing * (ACROSS - 1)) as f64) as usize
        };
        let left = corner(group % GROUPS[0], GROUPS[0], w, 0.754_877_666_246_692_8);
        let top = corner(group / GROUPS[0], GROUPS[1], h, 0.569_840_290_998_053_3);
        for ray in 0..ACROSS * ACROSS {
            let x = (left + spacing * (ray % ACROSS)).min(w - 1);
            let y = (top + spacing * (ray / ACROSS)).min(h - 1);
            spots.push(ImageSample { pixel: y * w + x, x: x as f64 + 0.5, y: y as f64 + 0.5 });
        }
    }
    spots
}

/// Traces groups of rays on all threads; returns their values, and the number of samples.
fn by_groups(tracer: &dyn Tracer, spots: &[ImageSample]) -> (Vec<RaySample>, u64) {
    let traced = |spots: &[ImageSample]| {
        let (mut values, mut counts) = (Vec::with_capacity(spots.len()), Counts::default());
        tracer.trace(spots, None, &mut values, &mut counts);
        (values, counts.samples)
    };
    let parts: Vec<_> = spots.par_chunks(4 * ACROSS * ACROSS).with_max_len(1).map(traced).collect();
    let samples = parts.iter().map(|(_, samples)| samples).sum();
    (parts.into_iter().flat_map(|(values, _)| values).collect(), samples)
}

fn shows(value: &RaySample) -> bool {
    value.rgba.iter().any(|&c| c > 0.0)
}

/// Returns the root mean square by which the light of rays differs in steps of two lengths; `None` where too few rays show anything, or some
/// show what is no number.
fn rms_difference(fine: &[RaySample], coarse: &[RaySample]) -> Option<f64> {
    let pairs = || fine.iter().zip(coarse);
    let square = |(a, b): (&RaySample, &RaySample)| {
        (0..3).map(|c| (f64::from(a.rgba[c]) - f64::from(b.rgba[c])).powi(2)).sum::<f64>()
    };
    let shown = pairs().filter(|(a, b)| shows(a) || shows(b)).count();
    let sum: f64 = pairs().map(square).sum();
    (shown >= MIN_SHOWN && sum.is_finite()).then(|| (sum / (3 * fine.len()) as f64).sqrt())
}

/// Estimates how many of the rays that show something adaptive ones of a threshold would trace, as a part of all.
///
/// Adaptive rays begin with one pixel in sixteen. They add three where the picture bends by more than the threshold, and the remaining twelve where it still does at half the spacing. A smooth
/// picture bends a quarter as much there, so that this is a bend of four thresholds now.
fn part_of_rays(groups: &[RaySample], threshold: f32) -> f64 {
    let (mut shown, mut bent, mut sharp) = (0, 0, 0);
    for group in groups.chunks_exact(ACROSS * ACROSS) {
        for (x, y) in (1..ACROSS - 1).flat_map(|y| (1..ACROSS - 1).map(move |x| (x, y))) {
            let at = y * ACROSS + x;
            let bend = |step: usize, c: usize| {
                (group[at - step].rgba[c] + group[at + step].rgba[c] - 2.0 * group[at].rgba[c]).abs()
            };
            let bend = (0..4).map(|c| bend(1, c) + bend(ACROSS, c)).fold(0.0, f32::max);
            shown += u32::from(shows(&group[at]));
            bent += u32::from(bend > threshold);
            sharp += u32::from(bend > 4.0 * threshold);
        }
    }
    let part = |count: u32| f64::from(count.min(shown)) / f64::from(shown.max(1));
    (1.0 + 3.0 * part(bent) + 12.0 * part(sharp)) / 16.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::{RayCaster, Step};
    use crate::engine::Engine;
    use glam::DVec3;
    use vr_core::Camera;
    use vr_core::phantom;

    fn with_alpha(of: impl Fn(f32, f32) -> f32) -> Vec<RaySample> {
        let ray = |i: usize| [0.0, 0.0, 0.0, of((i % ACROSS) as f32, (i / ACROSS) as f32)];
        (0..ACROSS * ACROSS).map(|i| RaySample { rgba: ray(i), depth: 1.0 }).collect()
    }

    /// A phantom of 32³ voxels, and a view of it.
    fn scene(name: &str) -> (Scene, View) {
        let scene = phantom::by_name(name).unwrap().scene(32).unwrap();
        let camera = Camera::framing(scene.volume.bounds(), 30.0, 20.0, None);
        (scene, View::new(camera, [256, 256]))
    }

    /// Length of an engine's steps, in voxels.
    fn length(engine: &PacketEngine) -> f64 {
        engine.step / engine.volume.placement().spacing().min_element()
    }

    fn packets(scene: &Scene, error: f64) -> PacketEngine {
        let caster = RayCaster { step: Step::Local { error }, ..RayCaster::default() };
        let source = crate::capabilities::check(&caster, scene).unwrap();
        let Ok(Engine::Packets(engine, _)) = Engine::new(&caster, scene, &source, None) else {
            panic!("packets draw this scene")
        };
        *engine
    }

    #[test]
    fn no_length_is_near_a_small_ratio() {
        let ratios = [0.125, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0];
        for class in 0..80 {
            let length = voxels(class);
            assert!(ratios.iter().all(|ratio| (length / ratio - 1.0).abs() > 0.015), "{class}: {length}");
        }
    }

    #[test]
    fn rays_lie_in_the_view() {
        for size in [[1, 1], [3, 500], [256, 256], [640, 480]] {
            let view = View::new(Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 30.0, 20.0, None), size);
            for spot in spots(&view, 4) {
                let [x, y] = [spot.x as usize, spot.y as usize];
                assert!(x < size[0] as usize && y < size[1] as usize && spot.pixel == y * size[0] as usize + x);
            }
        }
    }

    #[test]
    fn rays_are_counted_where_the_picture_bends() {
        // Nothing bends; all does, but not at half the distance; all does.
        let slope = with_alpha(|x, y| 0.1 + 0.1 * x + 0.05 * y);
        let bowl = with_alpha(|x, y| 0.01 * (x * x + y * y));
        assert_eq!(part_of_rays(&slope, 0.01), 1.0 / 16.0);
        assert_eq!(part_of_rays(&bowl, 0.03), 4.0 / 16.0);
        assert_eq!(part_of_rays(&bowl, 0.009), 1.0);
        assert_eq!(part_of_rays(&with_alpha(|_, _| 0.0), 0.01), 1.0 / 16.0);
    }

    #[test]
    fn even_steps_make_the_error_that_is_aimed_at() {
        let control = Control::default();
        for name in ["fog", "blobs"] {
            let (scene, view) = scene(name);
            for error in [4e-3, 1e-3, 2.5e-4] {
                let local = packets(&scene, error);
                let mut trial = Trial::new(&local, &scene, Rule::Midpoint, error).expect("all places are alike");
                let rmse = |engine: &PacketEngine| {
                    let fine = local.in_even_steps(&scene, None, length(engine) / 8.0).unwrap();
                    let traced = |engine: &PacketEngine| {
                        let frame = PacketFrame::new(engine, &engine.volume, (&view, None)).unwrap();
                        // Other pixels than those of the trial.
                        let spots: Vec<ImageSample> = (0..1024)
                            .map(|i| [4 + 8 * (i % 32), 4 + 8 * (i / 32)])
                            .map(|[x, y]| ImageSample { pixel: y * 256 + x, x: x as f64 + 0.5, y: y as f64 + 0.5 })
                            .collect();
                        by_groups(&frame, &spots).0
                    };
                    rms_difference(&traced(engine), &traced(&fine)).unwrap()
                };
                let choice = trial.choose((&local, &scene), (&view, None), (4, 0.04), &control).unwrap().unwrap();
                let even = choice.even.expect("local steps are no better");
                let found = rmse(&even);
                println!("{name}, {error}: {found:.1e} in steps of {}", length(&even));
                assert!(found <= 1.5 * error, "{name}: {found} for {error}");
                let longest = voxels(trial.shortest + LONGEST[0]);
                assert!(found >= 0.4 * error || length(&even) > 0.99 * longest, "{name}: {found} for {error}");
            }
        }
    }

    #[test]
    fn too_little_that_shows_tells_nothing() {
        let (scene, mut view) = scene("blobs");
        view.camera = Camera::framing((DVec3::splat(-1e4), DVec3::splat(1e4)), 30.0, 20.0, None);
        let local = packets(&scene, 1e-3);
        let mut trial = Trial::new(&local, &scene, Rule::Midpoint, 1e-3).unwrap();
        let choice = trial.choose((&local, &scene), (&view, None), (4, 0.04), &Control::default()).unwrap();
        assert!(choice.is_none());
    }
}
