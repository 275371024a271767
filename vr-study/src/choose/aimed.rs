//! Picture by a renderer that aims at an RMSE itself, judged on a sample of its pixels.

use std::time::{Duration, Instant};

use vr_core::{Control, Frame, Model, Options, Prepared, RenderError, Rendered, Scene, StudiedRenderer, View};
use vr_physics::metrics::subgrid;

use super::judge::MAX_SHARE;
use super::rmse::{RmseEstimate, mean_square, scale_of, squares};
use super::strata::{self, STRATA};
use super::{AimedPicture, BoundedRenderer};
use crate::reference::ReferenceCache;

/// Share of the target that is aimed at first: room for what a sample leaves open, and for rays that are left out.
const FIRST_SHARE: f64 = 0.7;
/// Number of pictures after which aiming is given up.
const TRIES: usize = 3;
/// Part of a picture's pixels that are compared, of an even grid and of the strata together; in small pictures, where it would be too few, [`MIN_COMPARED`].
const COMPARED: f64 = 1.0 / 128.0;
/// Smallest number of pixels that are compared.
const MIN_COMPARED: f64 = 192.0;
/// Part of a picture's pixels, those with the strongest contrasts, that are drawn again by a finer guide: where a picture is wrong in few pixels, it is in these.
const GUIDED: f64 = 1.0 / 16.0;
/// Aim of the guide, in aims of the picture.
const GUIDE_AIM: f64 = 1.0 / 8.0;

/// Draws a picture by a renderer that aims at the target, anew and aiming lower until its RMSE is within it, with the confidence of [`super::CONFIDENCE`]; `None` where the renderer cannot
/// aim at it, or neither aiming lower nor a promise of every pixel helps.
///
/// # Errors
/// Invalid scene or view, or cancellation.
pub(super) fn draw(
    target: f64,
    renderer: &dyn StudiedRenderer,
    bounded: &[BoundedRenderer],
    (scene, view): (&Scene, &View),
    (cache, control): (&ReferenceCache, &Control),
) -> Result<Option<AimedPicture>, RenderError> {
    let Some(option) = renderer.option_specs().into_iter().find(|option| option.aims) else { return Ok(None) };
    let mut judge = SampleJudge::new(target, bounded, scene, (cache, control))?;
    let mut aim = FIRST_SHARE * target.min(1.0);
    for tried in 1..=TRIES {
        let Ok(aiming) = renderer.with_options(&Options::new().with(option.key, aim)) else { return Ok(None) };
        let Some((rendered, times)) = timed(&*aiming, (scene, view), control)? else { return Ok(None) };
        let Ok(finer) = renderer.with_options(&Options::new().with(option.key, aim * GUIDE_AIM)) else {
            return Ok(None);
        };
        let mut guide = finer.prepare(scene, control)?;
        let Some(error) = judge.rmse(&rendered.frame, &mut *guide, view, control)? else { break };
        if error.upper <= target {
            return Ok(Some(AimedPicture { renderer: aiming, aim, tried, rendered, times, error }));
        }
        aim *= (0.7 * target / error.upper).clamp(0.05, 0.5);
    }
    // No aim is low enough, or nothing bounds some pixels: if every pixel can be promised to be within the target, the RMSE is.
    let Some(option) = renderer.option_specs().into_iter().find(|option| option.promises) else { return Ok(None) };
    let promised = target.min(1.0);
    let Ok(promising) = renderer.with_options(&Options::new().with(option.key, promised)) else { return Ok(None) };
    let Some((rendered, times)) = timed(&*promising, (scene, view), control)? else { return Ok(None) };
    if rendered.stats.counts.unbounded > 0 {
        return Ok(None);
    }
    let error = RmseEstimate { rmse: promised, upper: promised, pixels: rendered.frame.pixels().len(), proven: true };
    Ok(Some(AimedPicture { renderer: promising, aim: promised, tried: TRIES, rendered, times, error }))
}

/// Draws a picture; returns it with the times of its preparation and of itself, or `None` where the renderer does not take the scene.
fn timed(
    renderer: &dyn StudiedRenderer,
    (scene, view): (&Scene, &View),
    control: &Control,
) -> Result<Option<(Rendered, [Duration; 2])>, RenderError> {
    let start = Instant::now();
    let mut prepared = match renderer.prepare(scene, control) {
        Err(RenderError::Unsupported(_)) => return Ok(None),
        prepared => prepared?,
    };
    let prepare = start.elapsed();
    let start = Instant::now();
    let rendered = prepared.render(view, control)?;
    Ok(Some((rendered, [prepare, start.elapsed()])))
}

/// Largest part of the sample for which no bound may be found.
const MAX_UNBOUNDED: f64 = 0.02;
/// Part of the sample that is solved where that is done by the reference, which takes many times as long.
const SOLVED: f64 = 0.125;

/// Way to know pixels of a scene.
enum SampleJudge<'a> {
    /// By a renderer that proves them to be within an error.
    Bounded { prepared: Box<dyn Prepared>, max_error: f64 },
    /// By the reference.
    Reference { scene: &'a Scene, cache: &'a ReferenceCache },
}

/// Pixels that are known: the mean square of each one's errors in a frame, the unit of the picture's errors, and what the pixels themselves are off by, in that unit.
struct Known {
    squares: Vec<f64>,
    scale: f64,
    error: f64,
}

impl<'a> SampleJudge<'a> {
    /// Returns the first bounded renderer that takes the scene, or else the reference.
    fn new(
        target: f64,
        bounded: &[BoundedRenderer],
        scene: &'a Scene,
        (cache, control): (&'a ReferenceCache, &Control),
    ) -> Result<Self, RenderError> {
        for BoundedRenderer { renderer, max_error } in bounded.iter().filter(|b| b.max_error <= MAX_SHARE * target) {
            match renderer.prepare(scene, control) {
                Ok(prepared) => return Ok(Self::Bounded { prepared, max_error: *max_error }),
                Err(RenderError::Unsupported(_)) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(Self::Reference { scene, cache })
    }

    /// Returns the number of pixels to compare, of a picture of so many.
    fn sample(&self, all: usize) -> f64 {
        let count = (all as f64 * COMPARED).max(MIN_COMPARED);
        if let Self::Reference { .. } = self { (count * SOLVED).max(0.5 * MIN_COMPARED) } else { count }
    }

    /// Compares pixels of a frame; `None` where too many cannot be known.
    fn compare(
        &mut self,
        frame: &Frame,
        view: &View,
        places: &[[u32; 2]],
        control: &Control,
    ) -> Result<Option<Known>, RenderError> {
        match self {
            Self::Bounded { prepared, max_error } => {
                let Some(proven) = prepared.pixels(view, places, control)? else { return Ok(None) };
                // Those without a bound are drawn as well as can be.
                if proven.counts.unbounded as f64 > MAX_UNBOUNDED * places.len() as f64 {
                    return Ok(None);
                }
                let squares =
                    places.iter().zip(&proven.rgba).map(|(&place, pixel)| square(frame, place, pixel)).collect();
                // The whole picture's largest magnitude is at least that of these pixels.
                Ok(Some(Known { squares, scale: scale_of(&proven.rgba, *max_error), error: *max_error }))
            }
            Self::Reference { scene, cache } => {
                let reference = cache.solve((scene, view), &Model::Canonical, places.to_vec(), control)?;
                let scale = reference.scale();
                let squares = squares(&reference, frame).into_iter().map(|square| square * scale * scale).collect();
                Ok(Some(Known { squares, scale, error: reference.certainty.value() / scale }))
            }
        }
    }

    /// Returns the RMSE of a frame, by pixels of an even grid and as many of each stratum of pixels that may be wrong; `None` where some cannot be proven.
    ///
    /// Of the pixels with the strongest contrasts, all are compared with a guide: their mean of squares is that from the guide, and what the sample says that it is wrong by.
    fn rmse(
        &mut self,
        frame: &Frame,
        guide: &mut dyn Prepared,
        view: &View,
        control: &Control,
    ) -> Result<Option<RmseEstimate>, RenderError> {
        let (width, all) = (view.size[0] as usize, frame.pixels().len());
        let place = |i: usize| [(i % width) as u32, (i / width) as u32];
        // Compare the pixels with the strongest contrasts with the guide.
        let mut suspicion = strata::suspicion(frame, None);
        let foremost = strata::foremost(&suspicion, (GUIDED * all as f64) as usize);
        let places: Vec<[u32; 2]> = foremost.iter().map(|&i| place(i)).collect();
        let Some(guided) = guide.pixels(view, &places, control)? else { return Ok(None) };
        let mut known = vec![0.0; all];
        for (&i, guided) in foremost.iter().zip(&guided.rgba) {
            known[i] = square(frame, place(i), guided);
            suspicion[i] = suspicion[i].max(10.0 * (known[i] as f32).sqrt());
        }
        // Prove pixels of all strata.
        let count = self.sample(all);
        let stratum_of = strata::strata(&suspicion);
        let even = subgrid((0.5 * count).sqrt().ceil() as u32, view.size);
        let even = even.into_iter().map(|[x, y]| y as usize * width + x as usize);
        let chosen = strata::sample(&stratum_of, even, (0.5 * count / STRATA as f64).ceil() as usize);
        let places: Vec<[u32; 2]> = chosen.iter().map(|&i| place(i)).collect();
        let Some(Known { squares, scale, error }) = self.compare(frame, view, &places, control)? else {
            return Ok(None);
        };
        let left: Vec<f64> = chosen.iter().zip(&squares).map(|(&i, square)| square - known[i]).collect();
        let (mut mean, mut variance) = (known.iter().sum::<f64>() / all as f64, 0.0);
        for stratum in 0..STRATA as u8 {
            let size = stratum_of.iter().filter(|&&s| s == stratum).count() as f64;
            let own = || chosen.iter().zip(&left).filter(|(i, _)| stratum_of[**i] == stratum).map(|(_, s)| *s);
            let n = own().count() as f64;
            if n == 0.0 {
                continue;
            }
            let share = size / all as f64;
            let own_mean = own().sum::<f64>() / n;
            let spread = own().map(|s| (s - own_mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
            mean += share * own_mean;
            variance += share * share * spread / n * (1.0 - n / size);
        }
        Ok(Some(RmseEstimate::of_strata((mean.max(0.0), variance), scale, error, chosen.len())))
    }
}

/// Returns the mean square by which a pixel of a frame differs from another.
fn square(frame: &Frame, [x, y]: [u32; 2], other: &[f32; 4]) -> f64 {
    let found = &frame.pixels()[y as usize * frame.size()[0] as usize + x as usize];
    mean_square(std::array::from_fn(|c| f64::from(found[c]) - f64::from(other[c])))
}
