//! Picture by a renderer that aims at an RMSE itself, judged on a sample of its pixels.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use vr_core::{Control, Frame, Model, Options, Prepared, RenderError, Scene, StudiedRenderer, View};
use vr_physics::metrics::subgrid;

use super::judge::preparing;
use super::rmse::{QUANTILE, RmseEstimate, mean_and_variance, mean_square, scale_of, squares};
use super::strata::{self, STRATA};
use super::{AimedPicture, BoundedRenderer, drawn_once};
use crate::reference::ReferenceCache;

/// Share of the target that is aimed at: room for what a sample leaves open, and for rays that are left out.
const AIM_SHARE: f64 = 0.5;
/// Number of pictures after which aiming is given up.
const TRIES: usize = 3;
/// How often an aim may be lowered before a picture is drawn, because single rays miss the target.
const LOOKS: usize = 2;
/// Part of a picture's pixels that are compared, of an even grid and of the strata together; in small pictures, where it would be too few, [`MIN_COMPARED`].
const COMPARED: f64 = 1.0 / 128.0;
/// Smallest number of pixels that are compared.
const MIN_COMPARED: f64 = 192.0;
/// Part of a picture's pixels, those with the strongest contrasts, that are drawn again by a finer guide: where a picture is wrong in few pixels, it is in these.
const GUIDED: f64 = 1.0 / 16.0;
/// Aim of the guide, in aims of the picture.
const GUIDE_AIM: f64 = 1.0 / 4.0;

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
    let mut aim = AIM_SHARE * target.min(1.0);
    for tried in 1..=TRIES {
        let aiming = aiming(&mut judge, (renderer, option.key, target), &mut aim, (scene, view), control)?;
        let Some(Aiming { renderer: aiming, mut prepared, prepare }) = aiming else { return Ok(None) };
        let start = Instant::now();
        let Some(rendered) = taken(prepared.render(view, control))? else { return Ok(None) };
        let times = [prepare, start.elapsed()];
        let Ok(finer) = renderer.with_options(&Options::new().with(option.key, aim * GUIDE_AIM)) else {
            return Ok(None);
        };
        let mut guide = finer.prepare(scene, control)?;
        let Some(error) = judge.rmse(&rendered.frame, &mut *guide, view, control)? else { break };
        if error.upper <= target {
            return Ok(Some(AimedPicture { renderer: aiming, aim, tried, rendered, times, error }));
        }
        aim *= (AIM_SHARE * target / error.upper).clamp(0.05, 0.5);
    }
    // No aim is low enough, or nothing bounds some pixels: if every pixel can be promised to be within the target, the RMSE is.
    let Some(option) = renderer.option_specs().into_iter().find(|option| option.promises) else { return Ok(None) };
    let promised = target.min(1.0);
    let Ok(promising) = renderer.with_options(&Options::new().with(option.key, promised)) else { return Ok(None) };
    let Some((rendered, times)) = taken(drawn_once(&*promising, (scene, view), control))? else { return Ok(None) };
    if rendered.stats.counts.unbounded > 0 {
        return Ok(None);
    }
    let error = RmseEstimate { rmse: promised, upper: promised, pixels: rendered.frame.pixels().len(), proven: true };
    Ok(Some(AimedPicture { renderer: promising, aim: promised, tried: TRIES, rendered, times, error }))
}

/// A renderer that aims at an RMSE, ready to draw.
struct Aiming {
    renderer: Box<dyn StudiedRenderer>,
    prepared: Box<dyn Prepared>,
    prepare: Duration,
}

/// Prepares a renderer with an aim. Rays of an even grid of pixels are traced first, and the aim is lowered where they miss the target: a whole picture in vain would take far longer. `None` where the renderer does not
/// take the scene.
fn aiming(
    judge: &mut SampleJudge<'_>,
    (renderer, key, target): (&dyn StudiedRenderer, &'static str, f64),
    aim: &mut f64,
    (scene, view): (&Scene, &View),
    control: &Control,
) -> Result<Option<Aiming>, RenderError> {
    let mut looks = 0;
    loop {
        let Ok(renderer) = renderer.with_options(&Options::new().with(key, *aim)) else { return Ok(None) };
        let start = Instant::now();
        let Some(mut prepared) = taken(renderer.prepare(scene, control))? else { return Ok(None) };
        let prepare = start.elapsed();
        looks += 1;
        if looks <= LOOKS
            && let Some(rmse) = judge.rays(&mut *prepared, view, control)?
            && rmse > target
        {
            *aim *= (AIM_SHARE * target / rmse).clamp(0.05, 0.5);
            continue;
        }
        return Ok(Some(Aiming { renderer, prepared, prepare }));
    }
}

/// Returns what was drawn; `None` where the renderer does not take the scene.
fn taken<T>(drawn: Result<T, RenderError>) -> Result<Option<T>, RenderError> {
    match drawn {
        Err(RenderError::Unsupported(_)) => Ok(None),
        drawn => drawn.map(Some),
    }
}

/// Largest part of the sample for which no bound may be found.
const MAX_UNBOUNDED: f64 = 0.02;
/// Part of the sample that is solved where that is done by the reference, which takes many times as long.
const SOLVED: f64 = 0.125;

/// Way to know pixels of a scene.
enum SampleJudge<'a> {
    /// By a renderer that proves them to be within an error.
    Bounded { prover: Prover, max_error: f64 },
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
        if let Some(first) = preparing(target, bounded, scene, control).next() {
            return first.map(|(prepared, max_error)| Self::Bounded {
                prover: Prover { prepared, proven: HashMap::new(), unbounded: 0 },
                max_error,
            });
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
            Self::Bounded { prover, max_error } => {
                let Some(pixels) = prover.pixels(view, places, control)? else { return Ok(None) };
                let squares = places.iter().zip(&pixels).map(|(&place, pixel)| square(frame, place, pixel)).collect();
                // The whole picture's largest magnitude is at least that of these pixels.
                Ok(Some(Known { squares, scale: scale_of(&pixels, *max_error), error: *max_error }))
            }
            Self::Reference { scene, cache } => {
                let reference = cache.solve((scene, view), &Model::Canonical, places.to_vec(), control)?;
                let scale = reference.scale();
                let squares = squares(&reference, frame).into_iter().map(|square| square * scale * scale).collect();
                Ok(Some(Known { squares, scale, error: reference.certainty.value() / scale }))
            }
        }
    }

    /// Returns an even grid of pixels to compare.
    fn even(&self, view: &View) -> Vec<[u32; 2]> {
        let [width, height] = view.size.map(|n| n as usize);
        subgrid((0.5 * self.sample(width * height)).sqrt().ceil() as u32, view.size)
    }

    /// Returns the RMSE of rays on the even grid; `None` where that is no quick look.
    fn rays(&mut self, drawing: &mut dyn Prepared, view: &View, control: &Control) -> Result<Option<f64>, RenderError> {
        let places = self.even(view);
        let Self::Bounded { prover, max_error } = self else { return Ok(None) };
        let Some(pixels) = prover.pixels(view, &places, control)? else { return Ok(None) };
        let Some(drawn) = drawing.pixels(view, &places, control)? else { return Ok(None) };
        let squares = drawn.rgba.iter().zip(&pixels).map(|(found, proven)| difference(found, proven));
        let mean = squares.sum::<f64>() / places.len() as f64;
        Ok(Some(mean.sqrt() / scale_of(&pixels, *max_error)))
    }

    /// Returns the RMSE of a frame, by pixels of an even grid and as many of each stratum of pixels that may be wrong; `None` where some cannot be proven.
    ///
    /// All pixels with the strongest contrasts are compared with a guide as well, which is nearly right. There the sample only has to tell by how much the squares from the guide are wrong, and that
    /// varies far less than the squares themselves (a difference estimator).
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
        let even = self.even(view).into_iter().map(|[x, y]| y as usize * width + x as usize);
        let chosen = strata::sample(&stratum_of, even, (0.5 * count / STRATA as f64).ceil() as usize);
        let places: Vec<[u32; 2]> = chosen.iter().map(|&i| place(i)).collect();
        let Some(Known { squares, scale, error }) = self.compare(frame, view, &places, control)? else {
            return Ok(None);
        };
        let left: Vec<f64> = chosen.iter().zip(&squares).map(|(&i, square)| square - known[i]).collect();
        let (mut mean, mut variance) = (known.iter().sum::<f64>() / all as f64, 0.0);
        for (size, own) in strata::by_stratum(&stratum_of, &chosen, &left) {
            if own.is_empty() {
                continue;
            }
            let (share, n) = (size as f64 / all as f64, own.len() as f64);
            let [own_mean, spread] = mean_and_variance(&own);
            mean += share * own_mean;
            variance += share * share * spread / n * (1.0 - n / size as f64);
        }
        let mean = mean.max(0.0);
        let upper = mean + QUANTILE * variance.sqrt();
        Ok(Some(RmseEstimate::of_means([mean, upper], (scale, error), chosen.len())))
    }
}

/// A renderer that proves pixels of one view, each once.
struct Prover {
    prepared: Box<dyn Prepared>,
    proven: HashMap<[u32; 2], [f32; 4]>,
    /// How many of these have no bound, and are drawn as well as can be.
    unbounded: u64,
}

impl Prover {
    /// Returns pixels within the renderer's error; `None` where it has no bound for too many of those asked for so far.
    fn pixels(
        &mut self,
        view: &View,
        places: &[[u32; 2]],
        control: &Control,
    ) -> Result<Option<Vec<[f32; 4]>>, RenderError> {
        let new: Vec<[u32; 2]> = places.iter().copied().filter(|place| !self.proven.contains_key(place)).collect();
        if !new.is_empty() {
            let Some(found) = self.prepared.pixels(view, &new, control)? else { return Ok(None) };
            self.unbounded += found.counts.unbounded;
            self.proven.extend(new.into_iter().zip(found.rgba));
        }
        if self.unbounded as f64 > MAX_UNBOUNDED * self.proven.len() as f64 {
            return Ok(None);
        }
        Ok(Some(places.iter().map(|place| self.proven[place]).collect()))
    }
}

/// Returns the mean square by which a pixel of a frame differs from another.
fn square(frame: &Frame, [x, y]: [u32; 2], other: &[f32; 4]) -> f64 {
    difference(&frame.pixels()[y as usize * frame.size()[0] as usize + x as usize], other)
}

/// Returns the mean square by which pixels differ.
fn difference(found: &[f32; 4], other: &[f32; 4]) -> f64 {
    mean_square(std::array::from_fn(|c| f64::from(found[c]) - f64::from(other[c])))
}
