//! Study: every candidate on every subject.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vr_core::{Control, Counts, Frame, Model, RenderError};
use vr_physics::metrics::subgrid;

use crate::candidate::Candidate;
use crate::figures::ErrorFigures;
use crate::front::pareto_front;
use crate::memory::MemoryMeter;
use crate::picture::{encode_errors, encode_picture};
use crate::point::{Point, Refusal};
use crate::reference::{ReferenceCache, ReferencePixels};
use crate::subject::Subject;
use crate::timing::{Drawn, Timing, draw_in_turns};

/// Settings of a study.
pub struct Study<'a> {
    /// Candidates that take part.
    pub candidates: &'a [Candidate],
    /// Rounds that are timed; `None` for errors and counts alone.
    pub timing: Option<Timing>,
    /// Number of parts along each side of a picture, of each of which one pixel is compared with the reference.
    pub subgrid: u32,
    /// Number of such parts for errors against a renderer's own model, and against the field as a function.
    pub own_subgrid: u32,
    /// Reference pixels that were solved before.
    pub cache: &'a ReferenceCache,
    /// Meter of memory; `None` if memory is not measured.
    pub meter: Option<&'a dyn MemoryMeter>,
}

/// Result on one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SubjectResult {
    /// The subject's name.
    pub name: String,
    /// Description in a few words.
    pub title: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Points of the candidates that can draw the subject.
    pub points: Vec<Point>,
    /// Refusals of the others.
    pub refusals: Vec<Refusal>,
    /// The picture of the candidate with the smallest error.
    pub picture: Picture,
    /// Error maps of some candidates, interpolated between the pixels that were compared.
    pub error_maps: Vec<Picture>,
    /// Sentence on the commands of the pictures, where there is something to know.
    #[serde(default)]
    pub note: Option<String>,
}

/// Picture in a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// The candidate that drew it.
    #[serde(rename = "contestant")]
    pub candidate: String,
    /// PNG in base 64; of a picture that `vr` can draw again, with the record of it.
    pub png: String,
    /// Command that makes the picture, if there is one.
    #[serde(default)]
    pub command: Option<String>,
}

impl Study<'_> {
    /// Measures every candidate on a subject. `control` runs the timed work, `progress` is called with the share that is done, 0 to 1.
    ///
    /// # Errors
    /// A renderer that fails otherwise than by a refusal, or cancellation.
    pub fn measure(
        &self,
        subject: &Subject,
        (control, progress): (&Control, &dyn Fn(f64)),
    ) -> Result<SubjectResult, RenderError> {
        let view = (&subject.scene, &subject.view);
        let pixels = subgrid(self.subgrid, subject.view.size);
        let reference = self.cache.solve(view, &Model::Canonical, pixels, control)?;
        let few = subgrid(self.own_subgrid, subject.view.size);
        let function = match &subject.phantom {
            Some(phantom) => match ReferencePixels::solve_phantom(phantom, view, few.clone(), control) {
                Ok(reference) => Some(reference),
                Err(RenderError::Unsupported { .. }) => None,
                Err(other) => return Err(other),
            },
            None => None,
        };

        let drawn = draw_in_turns(self.candidates, subject, self.timing, self.meter, (control, progress))?;
        let (mut points, mut refusals, mut frames) = (Vec::new(), Vec::new(), Vec::new());
        let mut drawing = Vec::new();
        for (candidate, drawn) in self.candidates.iter().zip(drawn) {
            match drawn {
                Ok(drawn) => {
                    let own = |model| self.cache.solve(view, model, few.clone(), control);
                    let own = drawn.model.as_ref().map(own).transpose()?;
                    let own_error = own.map(|own| ErrorFigures::new(&own, &drawn.frame));
                    let error = ErrorFigures::new(&reference, &drawn.frame);
                    let function_error = function.as_ref().map(|f| ErrorFigures::new(f, &drawn.frame));
                    points.push(point(candidate, subject, &drawn, (error, own_error, function_error)));
                    frames.push(drawn.frame);
                    drawing.push(candidate);
                }
                Err(feature) => refusals.push(Refusal { candidate: candidate.name(), feature }),
            }
        }
        let (picture, error_maps) = pictures(&points, (&drawing, &frames), subject, (&reference, self.subgrid));
        let Subject { name, title, origin, .. } = subject.clone();
        let (size, note) = (subject.view.size, origin.note);
        Ok(SubjectResult { name, title, size, points, refusals, picture, error_maps, note })
    }
}

fn point(
    candidate: &Candidate,
    subject: &Subject,
    drawn: &Drawn,
    (error, own_error, function_error): (ErrorFigures, Option<ErrorFigures>, Option<ErrorFigures>),
) -> Point {
    Point {
        subject: subject.name.clone(),
        renderer: candidate.renderer.clone(),
        setting: candidate.setting.clone(),
        options: candidate.options.clone(),
        order: candidate.order,
        error_floor: candidate.error_floor,
        times: drawn.times,
        peak_bytes: drawn.peak_bytes,
        counts: named(drawn.counts),
        error,
        own_error,
        function_error,
    }
}

fn named(counts: Counts) -> BTreeMap<String, u64> {
    let Counts { rays, samples, skipped, terminated, unbounded, repeated, max_unbounded: _ } = counts;
    let all = [
        ("rays", rays),
        ("samples", samples),
        ("skipped", skipped),
        ("terminated", terminated),
        ("unbounded", unbounded),
        ("repeated", repeated),
    ];
    all.into_iter().map(|(name, n)| (name.to_owned(), n)).collect()
}

/// Largest number of error maps.
const MAPS: usize = 4;

/// Returns the picture with the smallest error, and error maps of candidates evenly chosen on the front: by samples where nothing was timed. Where not
/// every pixel was compared, their errors are spread on their logarithmic scale.
fn pictures(
    points: &[Point],
    (candidates, frames): (&[&Candidate], &[Frame]),
    subject: &Subject,
    (reference, parts): (&ReferencePixels, u32),
) -> (Picture, Vec<Picture>) {
    let [w, h] = subject.view.size;
    let (origin, background) = (&subject.origin, subject.scene.background);
    let best = (0..points.len()).min_by(|&a, &b| points[a].error.rmse.total_cmp(&points[b].error.rmse));
    let picture = best.map_or_else(
        || Picture { candidate: String::new(), png: String::new(), command: None },
        |i| {
            let record = origin.record_of(candidates[i], &points[i].error, [w, h]);
            let png = encode_picture(&frames[i], background, record);
            Picture {
                candidate: points[i].candidate(),
                png,
                command: origin.command(&subject.name, candidates[i], false),
            }
        },
    );
    let cost =
        |p: &Point| p.times.map_or_else(|| p.counts.get("samples").map_or(0.0, |&n| n as f64), |t| t.frame.median);
    let pairs: Vec<(f64, f64)> = points.iter().map(|p| (cost(p), p.error.rmse)).collect();
    let front = pareto_front(&pairs);
    let shown = front.len().min(MAPS);
    let maps = (0..shown).map(|k| {
        let i = front[if shown > 1 { k * (front.len() - 1) / (shown - 1) } else { 0 }];
        let errors = reference.error_map(&frames[i], parts);
        let command = origin.command(&subject.name, candidates[i], true);
        Picture { candidate: points[i].candidate(), png: encode_errors([w, h], &errors), command }
    });
    (picture, maps.collect())
}
