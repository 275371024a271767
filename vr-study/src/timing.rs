//! Comparable times of renderers: taken in turns, so that a machine that slows down slows all of them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use vr_core::{Control, Counts, Frame, GridVolume, Model, Prepared, RenderError, Scene, View, Volume};

use crate::candidate::Candidate;
use crate::clock_reference::ClockReference;
use crate::memory::{MemoryMeter, peak_of};
use crate::subject::Subject;

/// Amount of timing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Smallest number of rounds: in each, every candidate prepares the scene and draws frames of a turning camera.
    pub min_rounds: u32,
    /// Largest number of rounds.
    pub max_rounds: u32,
    /// Time for all rounds of a subject, after which no further one begins.
    pub patience: Duration,
}

/// Degrees that the camera turns from frame to frame.
const TURN: f64 = 10.0;
/// Time of a heavy frame: a candidate whose frames take this long draws one a round, without warming up.
const HEAVY: Duration = Duration::from_millis(40);
/// Number of rounds that are enough for heavy frames when time gets short.
const HEAVY_ROUNDS: usize = 2;
/// Time, and number of turns, for which the others draw two views in turns.
const STRETCH: Duration = Duration::from_millis(12);
const PAIRS: usize = 6;

/// Milliseconds: the median over the rounds, and their range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Milliseconds {
    /// The median.
    pub median: f64,
    /// The shortest.
    #[serde(rename = "least")]
    pub min: f64,
    /// The longest.
    #[serde(rename = "most")]
    pub max: f64,
}

impl Milliseconds {
    /// Sums up a list of at least one number.
    fn from_rounds(mut ms: Vec<f64>) -> Self {
        ms.sort_by(f64::total_cmp);
        let n = ms.len();
        Self { median: 0.5 * (ms[(n - 1) / 2] + ms[n / 2]), min: ms[0], max: ms[n - 1] }
    }
}

/// Times of one candidate on one subject.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Time of a frame, after preparation, the camera turning.
    pub frame: Milliseconds,
    /// Time of the preparation.
    pub prepare: Milliseconds,
    /// Number of rounds.
    pub rounds: usize,
}

/// Picture that a candidate drew of a subject, and its cost.
pub struct Drawn {
    /// The picture of the subject's view.
    pub frame: Frame,
    /// The model that the candidate integrates, where it is known to be another than the scene.
    pub model: Option<Model>,
    /// The work of that picture.
    pub counts: Counts,
    /// Times; `None` where nothing was timed.
    pub times: Option<Times>,
    /// Largest number of bytes that preparation and frames used beyond the scene; `None` where there is no meter.
    pub peak_bytes: Option<u64>,
}

/// Times of one candidate so far.
#[derive(Default)]
struct Rounds {
    prepare: Vec<Reading>,
    frame: Vec<Reading>,
    /// True if frames are [heavy](HEAVY).
    heavy: bool,
}

/// Time of a piece of work, and the time of the clock reference around it.
#[derive(Clone, Copy)]
struct Reading {
    time: Duration,
    clock_reference: Duration,
}

impl Reading {
    /// Returns the milliseconds that the work would have taken had the machine been as fast as when the clock reference took `usual`.
    fn corrected(self, usual: Duration) -> f64 {
        self.time.as_secs_f64() * 1e3 * usual.as_secs_f64() / self.clock_reference.as_secs_f64().max(1e-9)
    }
}

/// Lets every candidate draw a subject, and times it if `timing` is given. The reason of a refusal stands in the place of a picture.
///
/// Scenes are prepared from a copy of the volume each time, so that no candidate profits from what another has derived of it. Times are
/// corrected for how fast the machine was at the moment, by a clock reference: a small computation that is always the same. `control` runs
/// the timed work and reports no progress; `progress` is called with the share that is done, between frames.
///
/// # Errors
/// Any error but [`RenderError::Unsupported`].
pub fn draw_in_turns(
    candidates: &[Candidate],
    subject: &Subject,
    timing: Option<Timing>,
    meter: Option<&dyn MemoryMeter>,
    (control, progress): (&Control, &dyn Fn(f64)),
) -> Result<Vec<Result<Drawn, String>>, RenderError> {
    let started = Instant::now();
    let clock = Clock { clock_reference: ClockReference::new(), control };
    // Of all the work, the first round is a half where more will follow: how many do, the clock says.
    let first_share = if timing.is_some() { 0.5 } else { 1.0 };
    // The first round draws the picture that is judged, and meters its memory.
    let mut drawn = Vec::with_capacity(candidates.len());
    let mut rounds: Vec<Rounds> = Vec::new();
    for (i, candidate) in candidates.iter().enumerate() {
        let (first, peak_bytes) = peak_of(meter, || clock.first_round(candidate, subject, timing.is_some()));
        match first {
            Ok((mut first, round)) => {
                first.peak_bytes = peak_bytes;
                drawn.push(Ok(first));
                rounds.push(round);
            }
            Err(RenderError::Unsupported(refused)) => {
                drawn.push(Err(refused.what));
                rounds.push(Rounds::default());
            }
            Err(other) => return Err(other),
        }
        progress(first_share * (i + 1) as f64 / candidates.len() as f64);
    }
    let Some(timing) = timing else { return Ok(drawn) };
    // Further rounds only time, until they are enough or patience ends.
    for round in 1..timing.max_rounds.max(1) {
        if round >= timing.min_rounds && started.elapsed() > timing.patience {
            break;
        }
        for (i, candidate) in candidates.iter().enumerate().filter(|&(i, _)| drawn[i].is_ok()) {
            let late = round >= timing.min_rounds || started.elapsed() > timing.patience / 2;
            if rounds[i].heavy && late && rounds[i].frame.len() >= HEAVY_ROUNDS {
                continue;
            }
            let mut prepared = clock.prepare(candidate, subject, &mut rounds[i])?;
            clock.frames(&mut *prepared, &subject.view, &mut rounds[i])?;
            let spent = started.elapsed().as_secs_f64() / timing.patience.as_secs_f64();
            progress(first_share + (1.0 - first_share) * spent.min(1.0));
        }
    }
    // Correct all times to the median speed of the machine.
    let mut clock_references: Vec<Duration> =
        rounds.iter().flat_map(|r| &r.frame).map(|reading| reading.clock_reference).collect();
    clock_references.sort_unstable();
    let usual = clock_references.get(clock_references.len() / 2).copied().unwrap_or_default();
    for (result, rounds) in drawn.iter_mut().zip(&rounds) {
        if let Ok(drawn) = result {
            let of =
                |readings: &[Reading]| Milliseconds::from_rounds(readings.iter().map(|r| r.corrected(usual)).collect());
            let (frame, prepare) = (of(&rounds.frame), of(&rounds.prepare));
            drawn.times = Some(Times { frame, prepare, rounds: rounds.frame.len() });
        }
    }
    Ok(drawn)
}

/// Returns the scene with a volume that shares no derived structures.
fn alone(scene: &Scene) -> Scene {
    let volume = match &scene.volume {
        Volume::Grid(grid) => Volume::Grid(Arc::new(GridVolume::new(grid.values().clone(), grid.filter()))),
        other => other.clone(),
    };
    Scene { volume, ..scene.clone() }
}

/// Clock that times work beside the clock reference.
struct Clock<'a> {
    clock_reference: ClockReference,
    control: &'a Control,
}

impl Clock<'_> {
    /// Prepares a subject's scene.
    fn prepare(
        &self,
        candidate: &Candidate,
        subject: &Subject,
        rounds: &mut Rounds,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        let scene = alone(&subject.scene);
        let clock_reference = self.clock_reference.take(self.control)?;
        let start = Instant::now();
        let prepared = candidate.configured.prepare(&scene, self.control)?;
        rounds.prepare.push(Reading { time: start.elapsed(), clock_reference });
        Ok(prepared)
    }

    /// Returns the picture of a subject, from a preparation of its own; and the first round, if anything is timed.
    fn first_round(
        &self,
        candidate: &Candidate,
        subject: &Subject,
        timed: bool,
    ) -> Result<(Drawn, Rounds), RenderError> {
        let mut rounds = Rounds::default();
        let mut prepared = self.prepare(candidate, subject, &mut rounds)?;
        let mut first = None;
        let reading = self.beside_clock_reference(|| {
            let start = Instant::now();
            first = Some(prepared.render(&subject.view, self.control)?);
            Ok(start.elapsed())
        })?;
        let rendered = first.expect("it was just drawn");
        if timed {
            let time = reading.time;
            // Where something else may have been in the way of the first frame, a second one tells.
            rounds.heavy = time > 3 * HEAVY || time > HEAVY && self.frame(&mut *prepared, &subject.view)? > HEAVY;
            if rounds.heavy {
                rounds.frame.push(reading);
            } else {
                self.frames(&mut *prepared, &subject.view, &mut rounds)?;
            }
        }
        let model = prepared.own_model(&subject.view)?;
        let (frame, counts) = (rendered.frame, rendered.stats.counts);
        Ok((Drawn { frame, model, counts, times: None, peak_bytes: None }, rounds))
    }

    fn frame(&self, prepared: &mut dyn Prepared, view: &View) -> Result<Duration, RenderError> {
        let start = Instant::now();
        prepared.render(view, self.control)?;
        Ok(start.elapsed())
    }

    /// Runs a piece of work; returns the time that it reports, and the mean time of the clock reference right before and right after it.
    fn beside_clock_reference(
        &self,
        work: impl FnOnce() -> Result<Duration, RenderError>,
    ) -> Result<Reading, RenderError> {
        let before = self.clock_reference.take(self.control)?;
        let time = work()?;
        let after = self.clock_reference.take(self.control)?;
        Ok(Reading { time, clock_reference: (before + after) / 2 })
    }

    /// Draws two views of a turning camera in turns, after a frame that counts nowhere; of each the shortest time counts, since what
    /// others on the machine take away only adds, and of the two the mean. Of heavy ones, the two are drawn in turns from round to round.
    fn frames(&self, prepared: &mut dyn Prepared, view: &View, rounds: &mut Rounds) -> Result<(), RenderError> {
        let turned = |turns: f64| View { camera: view.camera.orbit(turns * TURN, 0.0), ..view.clone() };
        let views = [view.clone(), turned(1.0)];
        let reading = if rounds.heavy {
            let view = &views[rounds.frame.len() % 2];
            self.beside_clock_reference(|| self.frame(prepared, view))?
        } else {
            self.frame(prepared, &turned(-1.0))?;
            self.beside_clock_reference(|| self.shortest_of_pairs(prepared, &views))?
        };
        rounds.frame.push(reading);
        Ok(())
    }

    /// Returns the mean of the shortest times of two views, drawn in turns for a [stretch](STRETCH).
    fn shortest_of_pairs(&self, prepared: &mut dyn Prepared, views: &[View; 2]) -> Result<Duration, RenderError> {
        let (start, mut shortest) = (Instant::now(), [Duration::MAX; 2]);
        for pair in 0..PAIRS {
            if pair > 0 && start.elapsed() > STRETCH {
                break;
            }
            for (shortest, view) in shortest.iter_mut().zip(views) {
                *shortest = (*shortest).min(self.frame(prepared, view)?);
            }
        }
        Ok((shortest[0] + shortest[1]) / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_corrected_by_the_clock_reference() {
        let ms = Duration::from_millis;
        // The machine was half as fast as usual.
        let reading = Reading { time: ms(20), clock_reference: ms(2) };
        assert!((reading.corrected(ms(1)) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn the_median_is_the_middle() {
        let of = |ms: &[f64]| Milliseconds::from_rounds(ms.to_vec());
        assert_eq!(of(&[7.0]), Milliseconds { median: 7.0, min: 7.0, max: 7.0 });
        assert_eq!(of(&[4.0, 9.0, 1.0, 2.0]), Milliseconds { median: 3.0, min: 1.0, max: 9.0 });
    }
}
