//! Picture by a renderer that aims at an RMSE itself, judged on a sample of its pixels.

use std::time::Instant;

use vr_core::{Control, Frame, Options, Prepared, RenderError, Scene, StudiedRenderer, View};
use vr_physics::metrics::subgrid;

use super::judge::MAX_SHARE;
use super::rmse::{RmseEstimate, mean_square, scale_of};
use super::strata::{self, SHARES};
use super::{AimedPicture, BoundedRenderer};

/// Share of the target that is aimed at first: room for what a sample leaves open, and for rays that are left out.
const FIRST_SHARE: f64 = 0.7;
/// Number of pictures after which aiming is given up.
const TRIES: usize = 3;
/// Part of a picture's pixels that are compared, of an even grid and of the strata together; in small pictures, where it would be too few, [`LEAST`].
const COMPARED: f64 = 1.0 / 128.0;
/// Smallest number of pixels that are compared.
const LEAST: f64 = 192.0;
/// Part of a picture's pixels, those with the strongest contrasts, that are drawn again by a finer guide, and part of the picture's aim that this guide has: where a picture is wrong in few
/// pixels, it is in these.
const GUIDED: (f64, f64) = (1.0 / 16.0, 1.0 / 8.0);

/// Draws a picture by a renderer that aims at the target, anew and aiming lower until its RMSE is within it, with the confidence of [`super::CONFIDENCE`]; `None` where no renderer can
/// aim at it or bound the pixels of a sample, or where aiming lower does not help.
///
/// # Errors
/// Invalid scene or view, or cancellation.
pub(super) fn draw(
    target: f64,
    renderer: &dyn StudiedRenderer,
    bounded: &[BoundedRenderer],
    (scene, view): (&Scene, &View),
    control: &Control,
) -> Result<Option<AimedPicture>, RenderError> {
    let Some(option) = renderer.option_specs().into_iter().find(|option| option.aims) else { return Ok(None) };
    let Some(mut judge) = Judge::new(target, bounded, scene, control)? else { return Ok(None) };
    let mut aim = FIRST_SHARE * target.min(1.0);
    for tried in 1..=TRIES {
        let Ok(aiming) = renderer.with_options(&Options::new().with(option.key, aim)) else { return Ok(None) };
        let start = Instant::now();
        let mut prepared = match aiming.prepare(scene, control) {
            Err(RenderError::Unsupported(_)) => return Ok(None),
            prepared => prepared?,
        };
        let prepare = start.elapsed();
        let start = Instant::now();
        let rendered = prepared.render(view, control)?;
        let render = start.elapsed();
        let Ok(finer) = renderer.with_options(&Options::new().with(option.key, aim * GUIDED.1)) else {
            return Ok(None);
        };
        let mut guide = finer.prepare(scene, control)?;
        let Some(error) = judge.rmse(&rendered.frame, &mut *guide, view, control)? else { return Ok(None) };
        if error.upper <= target {
            return Ok(Some(AimedPicture { renderer: aiming, aim, tried, rendered, prepare, render, error }));
        }
        aim *= (0.7 * target / error.upper).clamp(0.05, 0.5);
    }
    Ok(None)
}

/// Largest part of the sample for which no bound may be found.
const MAX_UNBOUNDED: f64 = 0.02;

/// Renderer that proves pixels to be within an error.
struct Judge {
    prepared: Box<dyn Prepared>,
    max_error: f64,
}

impl Judge {
    /// Returns the first bounded renderer that takes the scene.
    fn new(
        target: f64,
        bounded: &[BoundedRenderer],
        scene: &Scene,
        control: &Control,
    ) -> Result<Option<Self>, RenderError> {
        for BoundedRenderer { renderer, max_error } in bounded.iter().filter(|b| b.max_error <= MAX_SHARE * target) {
            match renderer.prepare(scene, control) {
                Ok(prepared) => return Ok(Some(Self { prepared, max_error: *max_error })),
                Err(RenderError::Unsupported(_)) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(None)
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
        let square = |i: usize, other: &[f32; 4]| {
            let found = &frame.pixels()[i];
            mean_square(std::array::from_fn(|c| f64::from(found[c]) - f64::from(other[c])))
        };
        // Compare the pixels with the strongest contrasts with the guide.
        let mut suspicion = strata::suspicion(frame, None);
        let foremost = strata::foremost(&suspicion, (GUIDED.0 * all as f64) as usize);
        let places: Vec<[u32; 2]> = foremost.iter().map(|&i| place(i)).collect();
        let Some((guided, _)) = guide.pixels(view, &places, control)? else { return Ok(None) };
        let mut known = vec![0.0; all];
        for (&i, guided) in foremost.iter().zip(&guided) {
            known[i] = square(i, guided);
            suspicion[i] = suspicion[i].max(10.0 * (known[i] as f32).sqrt());
        }
        // Prove pixels of all strata.
        let count = (all as f64 * COMPARED).max(LEAST);
        let stratum_of = strata::strata(&suspicion);
        let even = subgrid((0.5 * count).sqrt().ceil() as u32, view.size);
        let even = even.into_iter().map(|[x, y]| y as usize * width + x as usize);
        let chosen = strata::sample(&stratum_of, even, (0.5 * count / SHARES as f64).ceil() as usize);
        let places: Vec<[u32; 2]> = chosen.iter().map(|&i| place(i)).collect();
        let Some((proven, counts)) = self.prepared.pixels(view, &places, control)? else { return Ok(None) };
        // Those without a bound are drawn as well as can be.
        if counts.unbounded as f64 > MAX_UNBOUNDED * chosen.len() as f64 {
            return Ok(None);
        }
        let left: Vec<f64> = chosen.iter().zip(&proven).map(|(&i, proven)| square(i, proven) - known[i]).collect();
        // The whole picture's largest magnitude is at least that of these pixels.
        let scale = scale_of(&proven, self.max_error);
        let (mut mean, mut variance) = (known.iter().sum::<f64>() / all as f64, 0.0);
        for stratum in 0..SHARES as u8 {
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
        Ok(Some(RmseEstimate::of_strata((mean.max(0.0), variance), scale, self.max_error, chosen.len())))
    }
}
