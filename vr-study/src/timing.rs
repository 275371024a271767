//! Times of renderers that can be compared: taken in turns, so that a machine that slows down slows all of them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use vr_core::{Control, Counts, Frame, GridVolume, Model, Prepared, RenderError, Scene, View, Volume};

use crate::contestant::Contestant;
use crate::memory::{MemoryMeter, peak_of};
use crate::subject::Subject;
use crate::yardstick::Yardstick;

/// How much is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Rounds at the least: in each, every contestant prepares the scene and draws frames of a turning camera.
    pub least_rounds: u32,
    /// Rounds at most.
    pub most_rounds: u32,
    /// Time for all rounds of a subject, after which no further one begins.
    pub patience: Duration,
}

/// Degrees that the camera turns from frame to frame.
const TURN: f64 = 10.0;
/// A contestant whose frames take this long draws one a round, without warming up.
const HEAVY: Duration = Duration::from_millis(40);
/// Rounds that are enough for those, when time gets short.
const HEAVY_ROUNDS: usize = 2;
/// The others draw two views in turns, for this long or so often.
const STRETCH: Duration = Duration::from_millis(12);
const PAIRS: usize = 6;

/// Milliseconds, the median over the rounds and what lies around it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Milliseconds {
    /// The median.
    pub median: f64,
    /// The least.
    pub least: f64,
    /// The most.
    pub most: f64,
}

impl Milliseconds {
    /// Of at least one number.
    fn of(mut ms: Vec<f64>) -> Self {
        ms.sort_by(f64::total_cmp);
        let n = ms.len();
        Self { median: 0.5 * (ms[(n - 1) / 2] + ms[n / 2]), least: ms[0], most: ms[n - 1] }
    }
}

/// Times of one contestant on one subject.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// A frame, after preparation, the camera turning.
    pub frame: Milliseconds,
    /// The preparation.
    pub prepare: Milliseconds,
    /// Rounds.
    pub rounds: usize,
}

/// What a contestant made of a subject.
pub struct Drawn {
    /// The picture of the subject's view.
    pub frame: Frame,
    /// What the contestant integrates.
    pub model: Model,
    /// The work of that picture.
    pub counts: Counts,
    /// `None` where nothing was timed.
    pub times: Option<Times>,
    /// Bytes that preparation and frames needed at once beyond the scene, where somebody counts.
    pub peak_bytes: Option<u64>,
}

/// What was timed so far.
#[derive(Default)]
struct Rounds {
    prepare: Vec<Reading>,
    frame: Vec<Reading>,
    /// Whether frames are [heavy](HEAVY).
    heavy: bool,
}

/// A time, and what the yardstick took around it.
#[derive(Clone, Copy)]
struct Reading {
    time: Duration,
    yardstick: Duration,
}

impl Reading {
    /// What it would have taken had the machine been as fast as it was when the yardstick took `usual`.
    fn corrected(self, usual: Duration) -> f64 {
        self.time.as_secs_f64() * 1e3 * usual.as_secs_f64() / self.yardstick.as_secs_f64().max(1e-9)
    }
}

/// Lets every contestant draw a subject; times it where `timing` says how. Why one cannot draw stands in its place.
///
/// Scenes are prepared from a copy of the volume each time, so that nobody profits from what another had derived of it. Times are
/// corrected for how fast the machine was at the moment, by a yardstick: a small computation that is always the same. `control` runs
/// what is timed and tells nobody; `told` is told between frames.
///
/// # Errors
/// Any error but [`RenderError::Unsupported`].
pub fn draw_in_turns(
    contestants: &[Contestant],
    subject: &Subject,
    timing: Option<Timing>,
    meter: Option<&dyn MemoryMeter>,
    (control, told): (&Control, &dyn Fn(f64)),
) -> Result<Vec<Result<Drawn, String>>, RenderError> {
    let started = Instant::now();
    let clock = Clock { yardstick: Yardstick::new(), control };
    // Of all the work, the first round is a half where more will follow: how many do, the clock says.
    let first_share = if timing.is_some() { 0.5 } else { 1.0 };
    let mut drawn = Vec::with_capacity(contestants.len());
    let mut rounds: Vec<Rounds> = Vec::new();
    for (i, contestant) in contestants.iter().enumerate() {
        let (first, peak_bytes) = peak_of(meter, || clock.first_round(contestant, subject, timing.is_some()));
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
        told(first_share * (i + 1) as f64 / contestants.len() as f64);
    }
    let Some(timing) = timing else { return Ok(drawn) };
    for round in 1..timing.most_rounds.max(1) {
        if round >= timing.least_rounds && started.elapsed() > timing.patience {
            break;
        }
        for (i, contestant) in contestants.iter().enumerate().filter(|&(i, _)| drawn[i].is_ok()) {
            let late = round >= timing.least_rounds || started.elapsed() > timing.patience / 2;
            if rounds[i].heavy && late && rounds[i].frame.len() >= HEAVY_ROUNDS {
                continue;
            }
            let mut prepared = clock.prepare(contestant, subject, &mut rounds[i])?;
            clock.frames(&mut *prepared, &subject.view, &mut rounds[i])?;
            let spent = started.elapsed().as_secs_f64() / timing.patience.as_secs_f64();
            told(first_share + (1.0 - first_share) * spent.min(1.0));
        }
    }
    let mut yardsticks: Vec<Duration> = rounds.iter().flat_map(|r| &r.frame).map(|reading| reading.yardstick).collect();
    yardsticks.sort_unstable();
    let usual = yardsticks.get(yardsticks.len() / 2).copied().unwrap_or_default();
    for (result, rounds) in drawn.iter_mut().zip(&rounds) {
        if let Ok(drawn) = result {
            let of = |readings: &[Reading]| Milliseconds::of(readings.iter().map(|r| r.corrected(usual)).collect());
            let (frame, prepare) = (of(&rounds.frame), of(&rounds.prepare));
            drawn.times = Some(Times { frame, prepare, rounds: rounds.frame.len() });
        }
    }
    Ok(drawn)
}

/// The scene with a volume of its own.
fn alone(scene: &Scene) -> Scene {
    let volume = match &scene.volume {
        Volume::Grid(grid) => Volume::Grid(Arc::new(GridVolume::new(grid.values().clone(), grid.filter()))),
        other => other.clone(),
    };
    Scene { volume, ..scene.clone() }
}

/// What times.
struct Clock<'a> {
    yardstick: Yardstick,
    control: &'a Control,
}

impl Clock<'_> {
    /// Prepares a subject's scene.
    fn prepare(
        &self,
        contestant: &Contestant,
        subject: &Subject,
        rounds: &mut Rounds,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        let scene = alone(&subject.scene);
        let yardstick = self.yardstick.take(self.control)?;
        let start = Instant::now();
        let prepared = contestant.configured.prepare(&scene, self.control)?;
        rounds.prepare.push(Reading { time: start.elapsed(), yardstick });
        Ok(prepared)
    }

    /// The picture of a subject, from a preparation of its own; and the first round, if anything is timed.
    fn first_round(
        &self,
        contestant: &Contestant,
        subject: &Subject,
        timed: bool,
    ) -> Result<(Drawn, Rounds), RenderError> {
        let mut rounds = Rounds::default();
        let mut prepared = self.prepare(contestant, subject, &mut rounds)?;
        let mut first = None;
        let reading = self.between_yardsticks(|| {
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
        let model = prepared.model(&subject.view)?;
        let (frame, counts) = (rendered.frame, rendered.stats.counts);
        Ok((Drawn { frame, model, counts, times: None, peak_bytes: None }, rounds))
    }

    fn frame(&self, prepared: &mut dyn Prepared, view: &View) -> Result<Duration, RenderError> {
        let start = Instant::now();
        prepared.render(view, self.control)?;
        Ok(start.elapsed())
    }

    /// What a piece of work says that it took, and what the yardstick took right before and right after.
    fn between_yardsticks(&self, work: impl FnOnce() -> Result<Duration, RenderError>) -> Result<Reading, RenderError> {
        let before = self.yardstick.take(self.control)?;
        let time = work()?;
        let after = self.yardstick.take(self.control)?;
        Ok(Reading { time, yardstick: (before + after) / 2 })
    }

    /// Draws two views of a turning camera in turns, after a frame that counts nowhere; of each the least time counts, since what
    /// others on the machine take away only adds, and of the two the mean. Of heavy ones, the two are drawn in turns from round to round.
    fn frames(&self, prepared: &mut dyn Prepared, view: &View, rounds: &mut Rounds) -> Result<(), RenderError> {
        let turned = |turns: f64| View { camera: view.camera.orbit(turns * TURN, 0.0), ..view.clone() };
        let views = [view.clone(), turned(1.0)];
        let reading = if rounds.heavy {
            let view = &views[rounds.frame.len() % 2];
            self.between_yardsticks(|| self.frame(prepared, view))?
        } else {
            self.frame(prepared, &turned(-1.0))?;
            self.between_yardsticks(|| self.least_of_pairs(prepared, &views))?
        };
        rounds.frame.push(reading);
        Ok(())
    }

    /// The mean of the least times of two views, drawn in turns for a [stretch](STRETCH).
    fn least_of_pairs(&self, prepared: &mut dyn Prepared, views: &[View; 2]) -> Result<Duration, RenderError> {
        let (start, mut least) = (Instant::now(), [Duration::MAX; 2]);
        for pair in 0..PAIRS {
            if pair > 0 && start.elapsed() > STRETCH {
                break;
            }
            for (least, view) in least.iter_mut().zip(views) {
                *least = (*least).min(self.frame(prepared, view)?);
            }
        }
        Ok((least[0] + least[1]) / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_corrected_by_the_yardstick() {
        let ms = Duration::from_millis;
        // The machine was half as fast as usual.
        let reading = Reading { time: ms(20), yardstick: ms(2) };
        assert!((reading.corrected(ms(1)) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn the_median_is_the_middle() {
        let of = |ms: &[f64]| Milliseconds::of(ms.to_vec());
        assert_eq!(of(&[7.0]), Milliseconds { median: 7.0, least: 7.0, most: 7.0 });
        assert_eq!(of(&[4.0, 9.0, 1.0, 2.0]), Milliseconds { median: 3.0, least: 1.0, most: 9.0 });
    }
}
