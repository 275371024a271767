//! Picture within a given RMSE: by a renderer that aims at it and is checked, or by the cheapest renderer and setting of all.

mod aimed;
mod judge;
mod rmse;
mod strata;

use std::time::{Duration, Instant};

use vr_core::{Control, Frame, RenderError, Rendered, Renderer, Scene, StudiedRenderer, View};

use crate::candidate::Candidate;
use crate::reference::ReferenceCache;
use crate::subject::reduced;

use judge::Judge;

pub use rmse::RmseEstimate;

/// Confidence of an [`RmseEstimate::upper`] that is not proven: it holds nineteen times in twenty. It is that of one picture: of many that are
/// tried, some pass by chance.
pub const CONFIDENCE: f64 = 0.95;

/// Renderer whose pixels are proven to be within an error, if it counts none as unbounded ([`vr_core::Counts::unbounded`]).
pub struct BoundedRenderer {
    /// The renderer, configured.
    pub renderer: Box<dyn Renderer>,
    /// The error, in units of max(1, the picture's largest magnitude).
    pub max_error: f64,
}

/// Result of a candidate on a small picture.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Index of the candidate.
    pub candidate: usize,
    /// The RMSE of the small picture.
    pub error: RmseEstimate,
    /// Time of the small picture.
    pub time: Duration,
    /// Time that the whole picture would take, preparation included, if time grew with the pixels.
    pub expected: Duration,
}

/// Candidate that was chosen, and its picture.
pub struct Choice {
    /// The candidate's index.
    pub candidate: usize,
    /// Picture of the candidate.
    pub rendered: Rendered,
    /// Times of the preparation and of the picture.
    pub times: [Duration; 2],
    /// The RMSE of this picture.
    pub error: RmseEstimate,
    /// The small pictures.
    pub trials: Vec<Trial>,
    /// Candidates whose whole picture missed the target that their small one had met, and its RMSE.
    pub missed: Vec<(usize, RmseEstimate)>,
}

/// Picture of a renderer that aimed at the target itself.
pub struct AimedPicture {
    /// The renderer, as it drew the picture.
    pub renderer: Box<dyn StudiedRenderer>,
    /// RMSE that it aimed at; of a picture whose error is proven, the largest error of a pixel that it promised.
    pub aim: f64,
    /// Number of aims that were tried.
    pub tried: usize,
    /// The picture.
    pub rendered: Rendered,
    /// Times of the preparation and of the picture.
    pub times: [Duration; 2],
    /// The RMSE of the picture.
    pub error: RmseEstimate,
}

/// Reason for which no candidate was chosen.
#[derive(Debug, thiserror::Error)]
pub enum ChoiceError {
    /// Invalid scene or view, or cancellation.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// No candidate reaches the target.
    #[error("target RMSE: found {target:e}; no setting reaches it here: {best} comes nearest, with {error:.2e}")]
    OutOfReach {
        /// The target.
        target: f64,
        /// The candidate that comes nearest.
        best: String,
        /// RMSE of that candidate.
        error: f64,
    },
    /// No candidate draws such scenes.
    #[error("no renderer can draw this scene")]
    NoRenderer,
}

/// Approximate number of pixels of the small picture.
const SMALL: f64 = 96.0 * 96.0;
/// Approximate number of pixels of the larger one.
const LARGER: f64 = 192.0 * 192.0;
/// Largest number of candidates that draw it.
const FINALISTS: usize = 12;
/// Time after which no further candidate is tried.
const PATIENCE: Duration = Duration::from_secs(20);

/// Draws a picture by a renderer that aims at an RMSE itself, and judges it by a sample of pixels in which those that may be wrong are not rare: proven by a bounded renderer, or by the
/// reference where none takes the scene. If it is not within the target, the renderer aims lower; if that does not help, it promises every pixel. `None` where it can do neither.
///
/// # Errors
/// Invalid scene or view, or cancellation.
pub fn draw_aimed(
    target: f64,
    renderer: &dyn StudiedRenderer,
    bounded: &[BoundedRenderer],
    seen: (&Scene, &View),
    (cache, control): (&ReferenceCache, &Control),
) -> Result<Option<AimedPicture>, RenderError> {
    aimed::draw(target, renderer, bounded, seen, (cache, control))
}

/// Draws a small picture with every candidate, and a larger one with those that were within the target, to see how their time grows; then
/// the whole one with the cheapest of them; and if that one is not within the target, with the next.
///
/// Pictures are judged on all their pixels by one of which every pixel is proven, where a bounded renderer can draw the scene, or where reference
/// pixels are cheap; else on a sample of pixels in which those that may be wrong are not rare.
///
/// # Errors
/// See [`ChoiceError`].
pub fn draw_within(
    target: f64,
    candidates: &[Candidate],
    bounded: &[BoundedRenderer],
    (scene, view): (&Scene, &View),
    cache: &ReferenceCache,
    (control, progress): (&Control, &dyn Fn(f64)),
) -> Result<Choice, ChoiceError> {
    // A small picture with every candidate.
    let small = reduced(view, SMALL);
    let judge = Judge::of_small(target, bounded, (scene, &small), cache, control)?;
    let pixels = |v: &View| f64::from(v.size[0]) * f64::from(v.size[1]);
    let growth = pixels(view) / pixels(&small);
    let started = Instant::now();
    let mut trials = Vec::new();
    for (i, candidate) in candidates.iter().enumerate() {
        match timed(candidate, scene, &small, control) {
            Ok((prepare, time, frame)) => {
                let error = judge.rmse(&frame, None, (scene, &small), cache, control)?;
                trials.push(Trial { candidate: i, error, time, expected: prepare + time.mul_f64(growth) });
            }
            Err(RenderError::Unsupported { .. }) => {}
            Err(other) => return Err(other.into()),
        }
        progress(0.5 * (i + 1) as f64 / candidates.len() as f64);
        // Not before a candidate is within the target.
        if started.elapsed() > PATIENCE && trials.iter().any(|r: &Trial| r.error.upper <= target) {
            break;
        }
    }
    let mut order: Vec<Trial> = trials.iter().filter(|r| r.error.upper <= target).cloned().collect();
    order.sort_by_key(|r| r.expected);
    // A larger picture with the cheapest of those within the target: their expected times.
    let larger = reduced(view, LARGER);
    if pixels(&larger) > pixels(&small) {
        let others = order.split_off(FINALISTS.min(order.len()));
        for trial in &mut order {
            let (prepare, time, _) = timed(&candidates[trial.candidate], scene, &larger, control)?;
            // A straight line through the two times: what a frame needs once, however large it is, does not grow.
            let slope = (time.as_secs_f64() - trial.time.as_secs_f64()) / (pixels(&larger) - pixels(&small));
            let rest = slope.max(0.0) * (pixels(view) - pixels(&larger));
            trial.expected = prepare + time + Duration::from_secs_f64(rest);
        }
        order.sort_by_key(|r| r.expected);
        order.extend(others);
    }
    let order: Vec<usize> = order.iter().map(|r| r.candidate).collect();

    // The whole picture with the cheapest, then with the next, until one is within the target.
    let judge = Judge::of_whole(target, bounded, (scene, view), control)?;
    let mut guides = Guides::new(&trials, candidates);
    let mut missed: Vec<(usize, RmseEstimate)> = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        progress(0.5 + 0.5 * k as f64 / order.len() as f64);
        let (rendered, times) = drawn_once(&*candidates[i].configured, (scene, view), control)?;
        let finer = if judge.needs_a_guide() { guides.beside(i, (scene, view), control)? } else { None };
        let error = judge.rmse(&rendered.frame, finer, (scene, view), cache, control)?;
        if error.upper <= target {
            return Ok(Choice { candidate: i, rendered, times, error, trials, missed });
        }
        missed.push((i, error));
    }
    let small_ones = trials.iter().map(|r| (r.candidate, r.error.upper));
    let whole_ones = missed.iter().map(|(i, e)| (*i, e.upper));
    let known = whole_ones.chain(small_ones.filter(|(i, _)| missed.iter().all(|(d, _)| d != i)));
    match known.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((i, error)) => Err(ChoiceError::OutOfReach { target, best: candidates[i].name(), error }),
        None => Err(ChoiceError::NoRenderer),
    }
}

/// Fine pictures that others are compared with, to see where they may be wrong: those of the candidates that were nearest on the small picture.
struct Guides<'a> {
    /// Pictures, at most two, the nearest first.
    nearest: Vec<(usize, Option<Frame>)>,
    candidates: &'a [Candidate],
}

impl<'a> Guides<'a> {
    fn new(trials: &[Trial], candidates: &'a [Candidate]) -> Self {
        let mut nearest: Vec<&Trial> = trials.iter().collect();
        nearest.sort_by(|a, b| a.error.rmse.total_cmp(&b.error.rmse).then(a.expected.cmp(&b.expected)));
        // One that takes far longer than all others (a reference) is no guide, but what it would be a guide to.
        let mut times: Vec<Duration> = nearest.iter().map(|r| r.expected).collect();
        times.sort_unstable();
        let longest = times.get(times.len() / 2).map_or(Duration::ZERO, |&median| 30 * median);
        nearest.retain(|r| r.expected <= longest);
        Self { nearest: nearest.iter().take(2).map(|r| (r.candidate, None)).collect(), candidates }
    }

    /// Returns the finest picture that is not of the same candidate.
    fn beside(
        &mut self,
        candidate: usize,
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Option<&Frame>, RenderError> {
        let Some((i, frame)) = self.nearest.iter_mut().find(|(i, _)| *i != candidate) else { return Ok(None) };
        if frame.is_none() {
            *frame = Some(self.candidates[*i].configured.prepare(scene, control)?.render(view, control)?.frame);
        }
        Ok(frame.as_ref())
    }
}

/// Prepares a scene and draws a view of it; returns the picture, and the times of both.
fn drawn_once(
    renderer: &dyn Renderer,
    (scene, view): (&Scene, &View),
    control: &Control,
) -> Result<(Rendered, [Duration; 2]), RenderError> {
    let start = Instant::now();
    let mut prepared = renderer.prepare(scene, control)?;
    let prepare = start.elapsed();
    let start = Instant::now();
    let rendered = prepared.render(view, control)?;
    Ok((rendered, [prepare, start.elapsed()]))
}

/// Draws the scene; returns the time of the preparation, the smaller time of two frames after one that warms up, and the frame.
fn timed(
    candidate: &Candidate,
    scene: &Scene,
    view: &View,
    control: &Control,
) -> Result<(Duration, Duration, Frame), RenderError> {
    let start = Instant::now();
    let mut prepared = candidate.configured.prepare(scene, control)?;
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
    use crate::candidate::candidates;
    use crate::reference::ReferencePixels;
    use crate::subject::phantom_subject;
    use vr_core::{Filter, Model};
    use vr_physics::Reference;
    use vr_physics::metrics::subgrid;
    use vr_raycast::RayCaster;

    /// Returns the ray caster under an error bound of an eighth of the target.
    pub(super) fn bounded(target: f64) -> Vec<BoundedRenderer> {
        let max_error = (target / 8.0).max(1e-6);
        let renderer = RayCaster::default().with_max_error(max_error).unwrap().unwrap();
        vec![BoundedRenderer { renderer, max_error }]
    }

    fn chosen(target: f64) -> Result<(String, Choice), ChoiceError> {
        let renderers: Vec<Box<dyn StudiedRenderer>> =
            vec![Box::new(RayCaster::default()), Box::new(Reference::default())];
        let candidates = candidates(&renderers).unwrap();
        let subject = phantom_subject("blobs", 24, [64, 48]).unwrap();
        let control = Control::default();
        let progress: (&Control, &dyn Fn(f64)) = (&control, &|_| {});
        let bounded = bounded(target);
        let choice = draw_within(
            target,
            &candidates,
            &bounded,
            (&subject.scene, &subject.view),
            &ReferenceCache::none(),
            progress,
        )?;
        Ok((candidates[choice.candidate].name(), choice))
    }

    #[test]
    fn what_is_chosen_keeps_the_target_on_every_pixel() {
        let subject = phantom_subject("blobs", 24, [64, 48]).unwrap();
        let all = subgrid(u32::MAX, subject.view.size);
        let reference =
            ReferencePixels::solve((&subject.scene, &subject.view), &Model::Canonical, all, &Control::default())
                .unwrap();
        for target in [1e-2, 1e-3, 1e-5] {
            let (name, choice) = chosen(target).unwrap();
            let whole = reference.judge(&choice.rendered.frame).rmse;
            assert!(choice.error.upper <= target && choice.error.rmse <= choice.error.upper, "{name}");
            assert!(whole <= target, "{name}: {whole:.2e} for {target:.0e}");
        }
    }

    #[test]
    fn what_is_aimed_at_is_kept_on_all_pixels() {
        let control = Control::default();
        let cache = ReferenceCache::none();
        for (name, filter) in [("blobs", Filter::Trilinear), ("blobs", Filter::CatmullRom), ("fog", Filter::Trilinear)]
        {
            // No renderer bounds the pixels of a wide filter: the reference solves some.
            let subject = phantom_subject(name, 16, [64, 48]).unwrap();
            let scene = subject.scene.with_filter(filter);
            let all = subgrid(u32::MAX, subject.view.size);
            let reference = ReferencePixels::solve((&scene, &subject.view), &Model::Canonical, all, &control).unwrap();
            for target in [2e-2, 2e-3] {
                let seen = (&scene, &subject.view);
                let caster = RayCaster::default();
                let aimed = draw_aimed(target, &caster, &bounded(target), seen, (&cache, &control)).unwrap();
                let aimed = aimed.expect("a ray caster aims");
                let whole = reference.judge(&aimed.rendered.frame).rmse;
                assert!(aimed.error.upper <= target && !aimed.error.proven && aimed.aim < target);
                assert!(whole <= target, "{name}: {whole:.2e} for {target:.0e}");
                let again = aimed.renderer.prepare(&scene, &control).unwrap().render(&subject.view, &control).unwrap();
                assert_eq!(again.frame, aimed.rendered.frame, "the renderer is as it drew");
            }
            let exact = Reference::default();
            let none = draw_aimed(1e-2, &exact, &bounded(1e-2), (&scene, &subject.view), (&cache, &control));
            assert!(none.unwrap().is_none(), "it has no steps to choose");
        }
    }

    #[test]
    fn a_target_out_of_reach_is_refused() {
        let error = chosen(1e-12).map(|(name, _)| name).unwrap_err();
        assert!(error.to_string().contains("comes nearest"), "{error}");
    }
}
