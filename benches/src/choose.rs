//! The cheapest renderer and setting whose picture is within a given RMSE.

use std::time::{Duration, Instant};

use vr_core::{Control, Frame, Model, RenderError, Rendered, Scene, View};
use vr_physics::metrics::subgrid;

use crate::contestant::Contestant;
use crate::exact::{Exact, ExactCache, SUBGRID};
use crate::subject::reduced;

/// An RMSE from a sample of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RmseEstimate {
    /// Of the sample.
    pub rmse: f64,
    /// What the RMSE of the whole picture does not exceed, with a confidence of [`CONFIDENCE`].
    pub upper: f64,
    /// Pixels in the sample.
    pub pixels: usize,
}

/// Of [`RmseEstimate::upper`]: one-sided, by the normal distribution of means, as if pixels were drawn at random and without replacement; they are
/// spread evenly, which makes means more certain than that. It is that of one picture: of many that are tried, some pass by chance.
///
/// What lies in a few pixels alone, none of them in the sample, no sample knows of.
pub const CONFIDENCE: f64 = 0.95;
/// The quantile of the normal distribution that belongs to it.
const QUANTILE: f64 = 1.645;

impl RmseEstimate {
    /// From the exact solution of a sample of a frame's pixels.
    pub fn of(exact: &Exact, frame: &Frame) -> Self {
        let square = |e: [f64; 4]| {
            let square = e.iter().map(|c| c * c).sum::<f64>() / 4.0;
            if square.is_nan() { f64::INFINITY } else { square }
        };
        let squares: Vec<f64> = exact.signed(frame).into_iter().map(square).collect();
        let n = squares.len() as f64;
        let mean = squares.iter().sum::<f64>() / n;
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let all = f64::from(frame.size()[0]) * f64::from(frame.size()[1]);
        let left = (1.0 - n / all).max(0.0);
        let upper = mean + QUANTILE * (variance / n * left).sqrt();
        // What the solution itself may be off by comes on top. (Infinite errors leave no mean of squares.)
        let upper = upper.sqrt() + exact.certainty.value() / exact.scale();
        Self { rmse: mean.sqrt(), upper: if upper.is_nan() { f64::INFINITY } else { upper }, pixels: squares.len() }
    }
}

/// A contestant on a small picture.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    /// Its index.
    pub contestant: usize,
    /// The RMSE of the small picture.
    pub error: RmseEstimate,
    /// What it took.
    pub time: Duration,
    /// What the whole picture would take, preparation included, if time grew with the pixels.
    pub expected: Duration,
}

/// What was chosen.
pub struct Choice {
    /// The contestant's index.
    pub contestant: usize,
    /// Its picture.
    pub rendered: Rendered,
    /// Time of the preparation.
    pub prepare: Duration,
    /// Time of the picture.
    pub render: Duration,
    /// The RMSE of this picture.
    pub error: RmseEstimate,
    /// The exact pixels that it was measured on.
    pub exact: Exact,
    /// What the small pictures told.
    pub rehearsals: Vec<Rehearsal>,
    /// Contestants whose whole picture did not keep what their small one had promised, and its RMSE.
    pub disappointed: Vec<(usize, RmseEstimate)>,
}

/// Why nothing was chosen.
#[derive(Debug, thiserror::Error)]
pub enum ChoiceError {
    /// A scene or view that makes no sense, or cancellation.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Nobody comes so near.
    #[error("target RMSE: found {target:e}; nobody reaches it here: {best} comes nearest, with {error:.2e}")]
    OutOfReach {
        /// What was asked for.
        target: f64,
        /// Who comes nearest.
        best: String,
        /// How near.
        error: f64,
    },
    /// Nobody draws such scenes.
    #[error("no renderer can draw this scene")]
    Nobody,
}

/// Pixels of the small picture, about.
const SMALL: f64 = 96.0 * 96.0;
/// Pixels of the larger one, about.
const LARGER: f64 = 192.0 * 192.0;
/// Contestants that draw it at most.
const FINALISTS: usize = 12;
/// Parts along each side of the small picture that a pixel is taken of.
const SMALL_SUBGRID: u32 = 40;
/// No further contestant rehearses after this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// Draws a small picture with every contestant, and a larger one with those that were within the target, to see how their time grows; then
/// the whole one with the cheapest of them; and if that one is not within the target, with the next.
///
/// # Errors
/// See [`ChoiceError`].
pub fn draw_within(
    target: f64,
    contestants: &[Contestant],
    (scene, view): (&Scene, &View),
    cache: &ExactCache,
    (control, told): (&Control, &dyn Fn(f64)),
) -> Result<Choice, ChoiceError> {
    let small = reduced(view, SMALL);
    let truth = cache.solve((scene, &small), &Model::Canonical, subgrid(SMALL_SUBGRID, small.size), control)?;
    let pixels = |v: &View| f64::from(v.size[0]) * f64::from(v.size[1]);
    let growth = pixels(view) / pixels(&small);
    let started = Instant::now();
    let mut rehearsals = Vec::new();
    for (i, contestant) in contestants.iter().enumerate() {
        match timed(contestant, scene, &small, control) {
            Ok((prepare, time, frame)) => {
                let error = RmseEstimate::of(&truth, &frame);
                rehearsals.push(Rehearsal { contestant: i, error, time, expected: prepare + time.mul_f64(growth) });
            }
            Err(RenderError::Unsupported { .. }) => {}
            Err(other) => return Err(other.into()),
        }
        told(0.5 * (i + 1) as f64 / contestants.len() as f64);
        // Not before somebody is within the target.
        if started.elapsed() > PATIENCE && rehearsals.iter().any(|r: &Rehearsal| r.error.upper <= target) {
            break;
        }
    }
    let mut order: Vec<Rehearsal> = rehearsals.iter().filter(|r| r.error.upper <= target).cloned().collect();
    order.sort_by_key(|r| r.expected);
    let larger = reduced(view, LARGER);
    if pixels(&larger) > pixels(&small) {
        let others = order.split_off(FINALISTS.min(order.len()));
        for rehearsal in &mut order {
            let (prepare, time, _) = timed(&contestants[rehearsal.contestant], scene, &larger, control)?;
            // A straight line through the two times: what a frame needs once, however large it is, does not grow.
            let slope = (time.as_secs_f64() - rehearsal.time.as_secs_f64()) / (pixels(&larger) - pixels(&small));
            let rest = slope.max(0.0) * (pixels(view) - pixels(&larger));
            rehearsal.expected = prepare + time + Duration::from_secs_f64(rest);
        }
        order.sort_by_key(|r| r.expected);
        order.extend(others);
    }
    let order: Vec<usize> = order.iter().map(|r| r.contestant).collect();

    let exact = cache.solve((scene, view), &Model::Canonical, subgrid(SUBGRID, view.size), control)?;
    let mut disappointed: Vec<(usize, RmseEstimate)> = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        told(0.5 + 0.5 * k as f64 / order.len() as f64);
        let start = Instant::now();
        let mut prepared = contestants[i].configured.prepare(scene, control)?;
        let prepare = start.elapsed();
        let start = Instant::now();
        let rendered = prepared.render(view, control)?;
        let render = start.elapsed();
        let error = RmseEstimate::of(&exact, &rendered.frame);
        if error.upper <= target {
            return Ok(Choice { contestant: i, rendered, prepare, render, error, exact, rehearsals, disappointed });
        }
        disappointed.push((i, error));
    }
    let small_ones = rehearsals.iter().map(|r| (r.contestant, r.error.upper));
    let whole_ones = disappointed.iter().map(|(i, e)| (*i, e.upper));
    let known = whole_ones.chain(small_ones.filter(|(i, _)| disappointed.iter().all(|(d, _)| d != i)));
    match known.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((i, error)) => Err(ChoiceError::OutOfReach { target, best: contestants[i].name(), error }),
        None => Err(ChoiceError::Nobody),
    }
}

/// Time of the preparation, the smaller time of two frames after one that warms up, and the frame.
fn timed(
    contestant: &Contestant,
    scene: &Scene,
    view: &View,
    control: &Control,
) -> Result<(Duration, Duration, Frame), RenderError> {
    let start = Instant::now();
    let mut prepared = contestant.configured.prepare(scene, control)?;
    let prepare = start.elapsed();
    // The first frame makes what later ones share.
    let mut rendered = prepared.render(view, control)?;
    let mut render = Duration::MAX;
    for _ in 0..2 {
        let start = Instant::now();
        rendered = prepared.render(view, control)?;
        render = render.min(start.elapsed());
    }
    Ok((prepare, render, rendered.frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contestant::contestants;
    use crate::subject::phantom_subject;
    use vr_core::Renderer;
    use vr_physics::Reference;
    use vr_raycast::RayCaster;

    fn chosen(target: f64) -> Result<(String, Choice), ChoiceError> {
        let renderers: Vec<Box<dyn Renderer>> = vec![Box::new(RayCaster::default()), Box::new(Reference::default())];
        let contestants = contestants(&renderers).unwrap();
        let subject = phantom_subject("blobs", 24, [64, 48]).unwrap();
        let control = Control::default();
        let told: (&Control, &dyn Fn(f64)) = (&control, &|_| {});
        let choice = draw_within(target, &contestants, (&subject.scene, &subject.view), &ExactCache::none(), told)?;
        Ok((contestants[choice.contestant].name(), choice))
    }

    #[test]
    fn what_is_chosen_keeps_the_target_on_every_pixel() {
        let subject = phantom_subject("blobs", 24, [64, 48]).unwrap();
        let all = subgrid(u32::MAX, subject.view.size);
        let truth = Exact::solve((&subject.scene, &subject.view), &Model::Canonical, all, &Control::default()).unwrap();
        for target in [1e-2, 1e-3, 1e-5] {
            let (name, choice) = chosen(target).unwrap();
            let whole = truth.judge(&choice.rendered.frame).rmse;
            assert!(choice.error.upper <= target && choice.error.rmse <= choice.error.upper, "{name}");
            assert!(whole <= target, "{name}: {whole:.2e} for {target:.0e}");
        }
    }

    #[test]
    fn what_nobody_reaches_is_said() {
        let error = chosen(1e-12).map(|(name, _)| name).unwrap_err();
        assert!(error.to_string().contains("comes nearest"), "{error}");
    }

    #[test]
    fn all_pixels_leave_nothing_to_guess() {
        let subject = phantom_subject("fog", 8, [6, 5]).unwrap();
        let all = subgrid(u32::MAX, subject.view.size);
        let view = (&subject.scene, &subject.view);
        let exact = Exact::solve(view, &Model::Canonical, all, &Control::default()).unwrap();
        let frame = Frame::new([6, 5], vec![[0.5; 4]; 30], None);
        let estimate = RmseEstimate::of(&exact, &frame);
        assert!((estimate.rmse - exact.judge(&frame).rmse).abs() < 1e-12 && estimate.upper - estimate.rmse < 1e-9);
    }
}
