//! The cheapest renderer and setting whose picture is within a given RMSE.

mod judge;
mod rmse;
mod strata;

use std::time::{Duration, Instant};

use vr_core::{Control, Frame, RenderError, Rendered, Renderer, Scene, View};

use crate::contestant::Contestant;
use crate::exact::ExactCache;
use crate::subject::reduced;

use judge::Judge;

pub use rmse::RmseEstimate;

/// How often [`RmseEstimate::upper`] holds, of one that is not proven: nineteen times in twenty. It is that of one picture: of many that are
/// tried, some pass by chance.
pub const CONFIDENCE: f64 = 0.95;

/// A renderer whose pixels are proven to be within an error, if it counts none as unbounded ([`vr_core::Counts::unbounded`]).
pub struct Prover {
    /// It, configured.
    pub renderer: Box<dyn Renderer>,
    /// The error, in units of max(1, the picture's largest magnitude).
    pub max_error: f64,
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
/// No further contestant rehearses after this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// Draws a small picture with every contestant, and a larger one with those that were within the target, to see how their time grows; then
/// the whole one with the cheapest of them; and if that one is not within the target, with the next.
///
/// Pictures are judged on all their pixels by one of which every pixel is proven, where a prover can draw the scene, or where exact pixels are
/// cheap; else on a sample of pixels in which those that may be wrong are not rare.
///
/// # Errors
/// See [`ChoiceError`].
pub fn draw_within(
    target: f64,
    contestants: &[Contestant],
    provers: &[Prover],
    (scene, view): (&Scene, &View),
    cache: &ExactCache,
    (control, told): (&Control, &dyn Fn(f64)),
) -> Result<Choice, ChoiceError> {
    let small = reduced(view, SMALL);
    let judge = Judge::of_small(target, provers, (scene, &small), cache, control)?;
    let pixels = |v: &View| f64::from(v.size[0]) * f64::from(v.size[1]);
    let growth = pixels(view) / pixels(&small);
    let started = Instant::now();
    let mut rehearsals = Vec::new();
    for (i, contestant) in contestants.iter().enumerate() {
        match timed(contestant, scene, &small, control) {
            Ok((prepare, time, frame)) => {
                let error = judge.rmse(&frame, None, (scene, &small), cache, control)?;
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

    let judge = Judge::of_whole(target, provers, (scene, view), control)?;
    let mut guides = Guides::new(&rehearsals, contestants);
    let mut disappointed: Vec<(usize, RmseEstimate)> = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        told(0.5 + 0.5 * k as f64 / order.len() as f64);
        let start = Instant::now();
        let mut prepared = contestants[i].configured.prepare(scene, control)?;
        let prepare = start.elapsed();
        let start = Instant::now();
        let rendered = prepared.render(view, control)?;
        let render = start.elapsed();
        let finer = if judge.needs_a_guide() { guides.beside(i, (scene, view), control)? } else { None };
        let error = judge.rmse(&rendered.frame, finer, (scene, view), cache, control)?;
        if error.upper <= target {
            return Ok(Choice { contestant: i, rendered, prepare, render, error, rehearsals, disappointed });
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

/// Fine pictures that others are compared with, to see where they may be wrong: those of the contestants that were nearest on the small picture.
struct Guides<'a> {
    /// Two at most, the nearest first.
    nearest: Vec<(usize, Option<Frame>)>,
    contestants: &'a [Contestant],
}

impl<'a> Guides<'a> {
    fn new(rehearsals: &[Rehearsal], contestants: &'a [Contestant]) -> Self {
        let mut nearest: Vec<&Rehearsal> = rehearsals.iter().collect();
        nearest.sort_by(|a, b| a.error.rmse.total_cmp(&b.error.rmse).then(a.expected.cmp(&b.expected)));
        // One that takes far longer than all others (an exact one) is no guide, but what it would be a guide to.
        let mut times: Vec<Duration> = nearest.iter().map(|r| r.expected).collect();
        times.sort_unstable();
        let longest = times.get(times.len() / 2).map_or(Duration::ZERO, |&median| 30 * median);
        nearest.retain(|r| r.expected <= longest);
        Self { nearest: nearest.iter().take(2).map(|r| (r.contestant, None)).collect(), contestants }
    }

    /// The finest picture that is not of the same contestant.
    fn beside(
        &mut self,
        contestant: usize,
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Option<&Frame>, RenderError> {
        let Some((i, frame)) = self.nearest.iter_mut().find(|(i, _)| *i != contestant) else { return Ok(None) };
        if frame.is_none() {
            *frame = Some(self.contestants[*i].configured.prepare(scene, control)?.render(view, control)?.frame);
        }
        Ok(frame.as_ref())
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
    use crate::exact::Exact;
    use crate::subject::phantom_subject;
    use vr_core::{Model, StudiedRenderer};
    use vr_physics::Reference;
    use vr_physics::metrics::subgrid;
    use vr_raycast::RayCaster;

    /// The ray caster, under a promise of an eighth of the target.
    pub(super) fn provers(target: f64) -> Vec<Prover> {
        let max_error = (target / 8.0).max(1e-6);
        let renderer = RayCaster::default().with_max_error(max_error).unwrap().unwrap();
        vec![Prover { renderer, max_error }]
    }

    fn chosen(target: f64) -> Result<(String, Choice), ChoiceError> {
        let renderers: Vec<Box<dyn StudiedRenderer>> =
            vec![Box::new(RayCaster::default()), Box::new(Reference::default())];
        let contestants = contestants(&renderers).unwrap();
        let subject = phantom_subject("blobs", 24, [64, 48]).unwrap();
        let control = Control::default();
        let told: (&Control, &dyn Fn(f64)) = (&control, &|_| {});
        let provers = provers(target);
        let choice =
            draw_within(target, &contestants, &provers, (&subject.scene, &subject.view), &ExactCache::none(), told)?;
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
}
