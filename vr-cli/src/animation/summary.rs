//! Summary of an animation, for people and scripts.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;
use vr_study::figures::ErrorFigures;

use crate::error_bound::ErrorBound;
use crate::number;
use crate::scene_setup::Setup;

use super::film::Drawn;
use super::places::FramePlace;

/// Everything that is said about an animation.
pub struct Summary<'a> {
    /// The scene.
    pub setup: &'a Setup,
    /// Name of the renderer.
    pub renderer: &'a str,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f64,
    /// The work.
    pub drawn: &'a Drawn,
    /// Animations that were written.
    pub animations: &'a [PathBuf],
    /// Place of the frames, where they are kept.
    pub place: Option<&'a FramePlace>,
    /// Outcome of the error bound, where one was asked for.
    pub error_bound: Option<ErrorBound>,
    /// Time of everything.
    pub elapsed: Duration,
}

#[derive(Serialize)]
struct FrameError<'a> {
    frame: usize,
    #[serde(flatten)]
    figures: &'a ErrorFigures,
}

/// The same for scripts.
#[derive(Serialize)]
pub struct Json<'a> {
    volume: &'a str,
    renderer: &'a str,
    size: [u32; 2],
    frames: usize,
    drawn: usize,
    kept: usize,
    fps: f64,
    seconds: f64,
    prepare_seconds: f64,
    render_seconds: f64,
    rays: u64,
    samples: u64,
    errors: Vec<FrameError<'a>>,
    #[serde(rename = "promise")]
    error_bound: Option<ErrorBound>,
    outputs: Vec<String>,
    ffmpeg: Option<String>,
    notes: &'a [String],
}

impl Summary<'_> {
    /// Returns lines for people.
    pub fn text(&self) -> String {
        let [w, h] = self.setup.view.size;
        let Drawn { drawn, counts, prepare, render, errors } = self.drawn;
        let length = Duration::from_secs_f64(self.frames as f64 / self.fps);
        let mut text = format!("scene    {}, {w}x{h} pixels, {}\n", self.setup.title, self.renderer);
        text += &format!("frames   {}, {} at {} per second", self.frames, number::time(length), self.fps);
        match self.frames - drawn {
            0 => text.push('\n'),
            kept => text += &format!("; {kept} of them were there already\n"),
        }
        let each = if *drawn > 0 { *render / *drawn as u32 } else { Duration::ZERO };
        text += &format!(
            "time     {} in all: prepare {}, {} a frame\n",
            number::time(self.elapsed),
            number::time(*prepare),
            number::time(each)
        );
        let (rays, samples) = (number::count(counts.rays), number::count(counts.samples));
        text += &format!("work     {rays} rays, {samples} samples\n");
        if let Some(bound) = &self.error_bound {
            text += &bound.line();
            text.push('\n');
        }
        if let Some((worst, figures)) = errors.iter().max_by(|a, b| a.1.rmse.total_cmp(&b.1.rmse)) {
            let mean = errors.iter().map(|(_, figures)| figures.rmse).sum::<f64>() / errors.len() as f64;
            text += &format!(
                "error    RMSE {} in the mean of {} frames, {} at most, in frame {worst} (largest error {}), against the reference\n",
                number::small(mean),
                errors.len(),
                number::small(figures.rmse),
                number::small(figures.max)
            );
        }
        text += &format!("wrote    {}\n", self.outputs().join(", "));
        if let Some(line) = self.ffmpeg() {
            text += &format!("video    {line}\n");
        }
        text
    }

    /// Returns what scripts read.
    pub fn json(&self) -> Json<'_> {
        let Drawn { drawn, counts, prepare, render, errors } = self.drawn;
        Json {
            volume: &self.setup.title,
            renderer: self.renderer,
            size: self.setup.view.size,
            frames: self.frames,
            drawn: *drawn,
            kept: self.frames - drawn,
            fps: self.fps,
            seconds: self.elapsed.as_secs_f64(),
            prepare_seconds: prepare.as_secs_f64(),
            render_seconds: render.as_secs_f64(),
            rays: counts.rays,
            samples: counts.samples,
            errors: errors.iter().map(|(frame, figures)| FrameError { frame: *frame, figures }).collect(),
            error_bound: self.error_bound,
            outputs: self.outputs(),
            ffmpeg: self.ffmpeg(),
            notes: &self.setup.notes,
        }
    }

    fn outputs(&self) -> Vec<String> {
        let frames = self.place.map(pattern).into_iter();
        frames.chain(self.animations.iter().map(|path| path.display().to_string())).collect()
    }

    /// Returns the command that makes a video of frames that are kept.
    fn ffmpeg(&self) -> Option<String> {
        self.place.map(|place| ffmpeg(place, self.fps))
    }
}

/// Returns folder and pattern of frames.
fn pattern(place: &FramePlace) -> String {
    let is_here = place.folder == Path::new(".");
    let path = if is_here { PathBuf::from(&place.pattern) } else { place.folder.join(&place.pattern) };
    path.display().to_string()
}

/// Returns ffmpeg's command line. H.264 that every player takes has half the pixels of colour along each side (yuv420p), which needs even
/// sizes: an odd picture gets one more row or column. The colours are said to be BT.709's, for players assume others of small pictures.
fn ffmpeg(place: &FramePlace, fps: f64) -> String {
    let pattern = pattern(place);
    // A name that begins like an option is none.
    let pattern = if pattern.starts_with('-') { format!("./{pattern}") } else { pattern };
    let quoted = format!("'{}'", pattern.replace('\'', r"'\''"));
    format!(
        "ffmpeg -framerate {fps} -i {quoted} -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709' -c:v libx264 -crf 18 \
         -pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 -color_trc bt709 -movflags +faststart vr.mp4"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_video_s_line_is_fit_for_a_shell() {
        let place = |folder: &str, pattern: &str| FramePlace {
            folder: folder.into(),
            pattern: pattern.into(),
            is_temporary: false,
            is_own_folder: false,
        };
        let line = ffmpeg(&place("it's here", "f-%04d.png"), 24.0);
        assert!(line.starts_with(r"ffmpeg -framerate 24 -i 'it'\''s here/f-%04d.png' -vf 'pad="), "{line}");
        assert!(line.contains("-pix_fmt yuv420p") && line.ends_with(".mp4"));
        assert!(ffmpeg(&place(".", "-%d.png"), 12.5).contains("-framerate 12.5 -i './-%d.png'"));
    }
}
