//! Times of renderers that can be compared: taken in turns, so that a machine that slows down slows all of them.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use vr_core::{Control, Counts, Frame, Model, Prepared, RenderError, Scene, View, Volume, with_grid};

use crate::contestant::Contestant;
use crate::memory::{MemoryMeter, peak_of};
use crate::subject::Subject;

/// How much is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Rounds at the least: in each, every contestant prepares the scene and draws two frames.
    pub least_rounds: u32,
    /// Rounds at most.
    pub most_rounds: u32,
    /// Time for all rounds of a subject, after which no further one begins.
    pub patience: Duration,
}

/// Degrees that the camera turns from frame to frame.
const TURN: f64 = 10.0;
/// A contestant whose first frame takes this long draws one frame a round, without warming up, and in few rounds.
const HEAVY: Duration = Duration::from_millis(60);
const HEAVY_ROUNDS: usize = 2;

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
    /// Of at least one duration.
    fn of(times: &[Duration]) -> Self {
        let mut ms: Vec<f64> = times.iter().map(|t| t.as_nanos() as f64 / 1e6).collect();
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

/// The durations so far.
#[derive(Default)]
struct Rounds {
    prepare: Vec<Duration>,
    frame: Vec<Duration>,
}

/// Lets every contestant draw a subject; times it where `timing` says how. Why one cannot draw stands in its place.
///
/// Scenes are prepared from a copy of the volume each time, so that nobody profits from what another had derived of it. `control` runs
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
    let rounds_to_do = timing.map_or(1, |t| t.least_rounds.max(1));
    let mut drawn = Vec::with_capacity(contestants.len());
    let mut rounds: Vec<Rounds> = Vec::new();
    for (i, contestant) in contestants.iter().enumerate() {
        let (first, peak_bytes) = peak_of(meter, || first_round(contestant, subject, timing.is_some(), control));
        match first {
            Ok((mut first, round)) => {
                first.peak_bytes = peak_bytes;
                drawn.push(Ok(first));
                rounds.push(round);
            }
            Err(RenderError::Unsupported { feature, .. }) => {
                drawn.push(Err(feature));
                rounds.push(Rounds::default());
            }
            Err(other) => return Err(other),
        }
        told((i + 1) as f64 / contestants.len() as f64 / f64::from(rounds_to_do));
    }
    let Some(timing) = timing else { return Ok(drawn) };
    for round in 1..timing.most_rounds.max(1) {
        if round >= timing.least_rounds && started.elapsed() > timing.patience {
            break;
        }
        for (i, contestant) in contestants.iter().enumerate().filter(|&(i, _)| drawn[i].is_ok()) {
            let heavy = rounds[i].frame[0] > HEAVY;
            if heavy && rounds[i].frame.len() >= HEAVY_ROUNDS {
                continue;
            }
            let (_, _, mut prepared) = prepare(contestant, subject, &mut rounds[i], control)?;
            timed_frames(&mut *prepared, &subject.view, heavy, &mut rounds[i], control)?;
            let share = (f64::from(round) + (i + 1) as f64 / contestants.len() as f64) / f64::from(rounds_to_do);
            told(share.min(1.0));
        }
    }
    for (result, rounds) in drawn.iter_mut().zip(&rounds) {
        if let Ok(drawn) = result {
            let (frame, prepare) = (Milliseconds::of(&rounds.frame), Milliseconds::of(&rounds.prepare));
            drawn.times = Some(Times { frame, prepare, rounds: rounds.frame.len() });
        }
    }
    Ok(drawn)
}

/// The scene with a volume of its own.
fn alone(scene: &Scene) -> Scene {
    let copy = |u: &vr_core::UniformVolume| with_grid!(u.grid(), g => Volume::from(g.clone()));
    let volume = scene.volume.uniform().map_or_else(|| scene.volume.clone(), copy);
    Scene { volume, ..scene.clone() }
}

type Ready = (Scene, Duration, Box<dyn Prepared>);

fn prepare(
    contestant: &Contestant,
    subject: &Subject,
    rounds: &mut Rounds,
    control: &Control,
) -> Result<Ready, RenderError> {
    let scene = alone(&subject.scene);
    let start = Instant::now();
    let prepared = contestant.configured.prepare(&scene, control)?;
    let time = start.elapsed();
    rounds.prepare.push(time);
    Ok((scene, time, prepared))
}

fn first_round(
    contestant: &Contestant,
    subject: &Subject,
    timed: bool,
    control: &Control,
) -> Result<(Drawn, Rounds), RenderError> {
    let mut rounds = Rounds::default();
    let (_, _, mut prepared) = prepare(contestant, subject, &mut rounds, control)?;
    let start = Instant::now();
    let rendered = prepared.render(&subject.view, control)?;
    let first = start.elapsed();
    let model = prepared.model(&subject.view);
    let heavy = first > HEAVY;
    if heavy || !timed {
        rounds.frame.push(first);
    } else {
        timed_frames(&mut *prepared, &subject.view, heavy, &mut rounds, control)?;
    }
    let drawn = Drawn { frame: rendered.frame, model, counts: rendered.stats.counts, times: None, peak_bytes: None };
    Ok((drawn, rounds))
}

/// The mean of two frames of a turning camera, after one that counts nowhere; of slow ones, the first alone.
fn timed_frames(
    prepared: &mut dyn Prepared,
    view: &View,
    heavy: bool,
    rounds: &mut Rounds,
    control: &Control,
) -> Result<(), RenderError> {
    let at = |turns: f64| View { camera: view.camera.orbit(turns * TURN, 0.0), ..view.clone() };
    if !heavy {
        prepared.render(&at(-1.0), control)?;
    }
    let views = if heavy { vec![view.clone()] } else { vec![view.clone(), at(1.0)] };
    let mut sum = Duration::ZERO;
    for view in &views {
        let start = Instant::now();
        prepared.render(view, control)?;
        sum += start.elapsed();
    }
    rounds.frame.push(sum / views.len() as u32);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        let of = |ms: &[u64]| Milliseconds::of(&ms.iter().map(|&t| Duration::from_millis(t)).collect::<Vec<_>>());
        assert_eq!(of(&[7]), Milliseconds { median: 7.0, least: 7.0, most: 7.0 });
        assert_eq!(of(&[4, 9, 1, 2]), Milliseconds { median: 3.0, least: 1.0, most: 9.0 });
    }
}
