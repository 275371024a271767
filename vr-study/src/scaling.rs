//! Growth of times with threads, with the volume and with the picture.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use vr_core::{Control, RenderError, Renderer, View};
use vr_physics::fit_order;

use crate::error::StudyError;
use crate::subject::{Subject, phantom_subject};

/// Quantity that grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grown {
    /// Number of threads.
    Threads,
    /// Voxels along each side of the volume.
    Volume,
    /// Pixels along each side of the picture.
    Picture,
}

impl Grown {
    /// All quantities.
    pub const ALL: [Self; 3] = [Self::Threads, Self::Volume, Self::Picture];

    /// Returns the name on an axis.
    pub fn word(self) -> &'static str {
        match self {
            Self::Threads => "threads",
            Self::Volume => "voxels along a side of the volume",
            Self::Picture => "pixels along a side of the picture",
        }
    }
}

/// Times of one renderer at its defaults as a quantity grows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// The renderer.
    pub renderer: String,
    /// The subject that is drawn.
    pub subject: String,
    /// Quantity that grows.
    pub grown: Grown,
    /// Sizes of the quantity, ascending.
    pub sizes: Vec<f64>,
    /// Milliseconds of a frame, the median of several.
    pub ms: Vec<f64>,
    /// Fitted exponent p of time ∝ sizeᵖ; `None` for a single size.
    pub exponent: Option<f64>,
}

/// Number of frames per size; the median of their times counts.
const FRAMES: usize = 5;
/// Time of a frame above which nothing larger is tried and no further frame drawn.
const PATIENCE: Duration = Duration::from_millis(500);
/// Number of voxels, and of pixels, along a side while the other grows.
const SAMPLES: usize = 64;
const PIXELS: u32 = 192;

/// Measures a growth on a phantom; `None` where the renderer cannot draw it.
///
/// # Errors
/// A renderer that fails, or cancellation.
pub fn grow(
    renderer: &dyn Renderer,
    phantom: &str,
    grown: Grown,
    (control, progress): (&Control, &dyn Fn(f64)),
) -> Result<Option<Growth>, StudyError> {
    let threads = control.threads();
    let sizes: Vec<usize> = match grown {
        Grown::Threads => doublings(1, threads).chain((!threads.is_power_of_two()).then_some(threads)).collect(),
        Grown::Volume => doublings(32, 256).collect(),
        Grown::Picture => doublings(64, 512).collect(),
    };
    let (mut measured, mut ms) = (Vec::new(), Vec::new());
    for (i, &size) in sizes.iter().enumerate() {
        let (samples, pixels) = match grown {
            Grown::Threads => (SAMPLES, PIXELS),
            Grown::Volume => (size, PIXELS),
            Grown::Picture => (SAMPLES, size as u32),
        };
        let subject = phantom_subject(phantom, samples, [pixels; 2])?;
        let own = if grown == Grown::Threads { control.clone().with_threads(size) } else { control.clone() };
        match median_frame(renderer, &subject, &own) {
            Ok(time) => {
                measured.push(size as f64);
                ms.push(time.as_secs_f64() * 1e3);
                // Four times as long, or eight times: not tried.
                if time > PATIENCE && grown != Grown::Threads {
                    break;
                }
            }
            Err(RenderError::Unsupported { .. }) => return Ok(None),
            Err(other) => return Err(other.into()),
        }
        progress((i + 1) as f64 / sizes.len() as f64);
    }
    let exponent = (ms.len() > 1).then(|| fit_order(&measured, &ms));
    let (renderer, subject) = (renderer.name().to_owned(), phantom.to_owned());
    Ok(Some(Growth { renderer, subject, grown, sizes: measured, ms, exponent }))
}

fn doublings(from: usize, to: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(from), |n| Some(2 * n)).take_while(move |&n| n <= to)
}

fn median_frame(renderer: &dyn Renderer, subject: &Subject, control: &Control) -> Result<Duration, RenderError> {
    let mut prepared = renderer.prepare(&subject.scene, control)?;
    let mut times = Vec::with_capacity(FRAMES);
    for k in 0..=FRAMES {
        let camera = subject.view.camera.orbit(10.0 * k as f64, 0.0);
        let view = View { camera, ..subject.view.clone() };
        let start = Instant::now();
        prepared.render(&view, control)?;
        let time = start.elapsed();
        // The first warms up, unless it was too long for that.
        if k > 0 || time > PATIENCE {
            times.push(time);
        }
        if time > PATIENCE {
            break;
        }
    }
    times.sort_unstable();
    Ok(times[times.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_double_up_to_the_last() {
        assert_eq!(doublings(32, 256).collect::<Vec<_>>(), [32, 64, 128, 256]);
        assert_eq!(doublings(1, 1).collect::<Vec<_>>(), [1]);
        assert_eq!(doublings(1, 6).collect::<Vec<_>>(), [1, 2, 4]);
    }
}
