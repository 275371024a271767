//! JSON object of the account. Numbers that are infinite, or do not exist, are `null`.

use serde::Serialize;
use vr_core::field::Cut;
use vr_physics::{Certainty, RaySegment};
use vr_study::ray::{CHANNELS, RayAccount, Row};

use crate::scene_setup::Setup;

/// JSON object of the account of a pixel.
#[derive(Serialize)]
pub struct Json<'a> {
    volume: &'a str,
    size: [u32; 2],
    pixel: [u32; 2],
    renderer: &'static str,
    compositing: &'static str,
    origin: [f64; 3],
    direction: [f64; 3],
    /// Distances along the ray at which it enters and leaves the volume.
    inside: Option<[f64; 2]>,
    rgba: [f64; 4],
    depth: Option<f32>,
    exact: ExactJson,
    /// Difference of `rgba` from the reference.
    error: [f64; 4],
    /// Component whose errors the steps list.
    worst: &'static str,
    /// True if frames are drawn by the kernel that listed the steps; `null`, like the next two, from a renderer that cannot list them.
    own_kernel: Option<bool>,
    ended_early: Option<bool>,
    steps: Option<Vec<StepJson<'a>>>,
    left_out: f64,
    segments: Vec<SegmentJson<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct ExactJson {
    rgba: [f64; 4],
    depth: f64,
    error: f64,
    error_is: &'static str,
}

#[derive(Serialize)]
struct StepJson<'a> {
    begin: f64,
    length: f64,
    samples: Vec<SampleJson>,
    faces: Vec<FaceJson>,
    knots: &'a [f64],
    meets_vacuum: bool,
    #[serde(flatten)]
    light: Option<StepLightJson>,
}

#[derive(Serialize)]
struct SampleJson {
    at: f64,
    index: [f64; 3],
    value: f64,
    extinction: f64,
}

#[derive(Serialize)]
struct FaceJson {
    axis: usize,
    at: f64,
}

#[derive(Serialize)]
struct StepLightJson {
    color: [f64; 3],
    transparency: f64,
    light: [f64; 3],
    running: [f64; 4],
    running_depth: f64,
    exact: [f64; 4],
    exact_depth: f64,
    error: f64,
    change: f64,
}

#[derive(Serialize)]
struct SegmentJson<'a> {
    from: f64,
    to: f64,
    front: Vec<CutJson>,
    values: &'a [f64; 2],
    #[serde(flatten)]
    light: Option<SegmentLightJson>,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum CutJson {
    Entry,
    Face { axis: usize, at: f64 },
    Knot { value: f64 },
    Step,
}

#[derive(Serialize)]
struct SegmentLightJson {
    transparency: f64,
    light: [f64; 3],
    running: [f64; 4],
    running_depth: f64,
    running_error: f64,
}

impl<'a> Json<'a> {
    /// Returns the object of an account.
    pub fn new(setup: &'a Setup, account: &'a RayAccount<'a>) -> Self {
        let probe = account.probe.as_ref();
        let (error, error_is) = match account.exact.certainty {
            Certainty::Bound(e) => (e, "bound"),
            Certainty::Estimate(e) => (e, "estimate"),
        };
        Self {
            volume: &setup.title,
            size: account.view.size,
            pixel: account.pixel,
            renderer: account.renderer,
            compositing: account.scene.compositing.name(),
            origin: account.ray.origin.to_array(),
            direction: account.ray.direction.to_array(),
            inside: account.chord(),
            rgba: account.rgba,
            depth: account.depth,
            exact: ExactJson { rgba: account.exact.rgba, depth: account.exact.depth, error, error_is },
            error: account.error(),
            worst: CHANNELS[account.channel()],
            own_kernel: probe.map(|probe| probe.own_kernel),
            ended_early: probe.map(|probe| probe.ended_early),
            steps: probe.map(|_| account.rows.iter().map(step).collect()),
            left_out: account.left_out(),
            segments: account.segments.iter().map(segment).collect(),
            notes: &setup.notes,
        }
    }
}

fn step(row: &Row) -> StepJson<'_> {
    let samples = row.step.samples.iter().zip(&row.extinction);
    StepJson {
        begin: row.step.begin,
        length: row.step.length,
        samples: samples
            .map(|(s, &extinction)| SampleJson { at: s.at, index: s.index, value: s.value, extinction })
            .collect(),
        faces: row.faces.iter().map(|&(axis, at)| FaceJson { axis, at }).collect(),
        knots: &row.knots,
        meets_vacuum: row.meets_vacuum,
        light: row.light.map(|l| StepLightJson {
            color: l.color,
            transparency: row.step.transparency,
            light: row.step.light,
            running: l.running,
            running_depth: l.depth,
            exact: l.exact,
            exact_depth: l.exact_depth,
            error: l.error,
            change: l.change,
        }),
    }
}

fn segment(segment: &RaySegment) -> SegmentJson<'_> {
    let cut = |cut: &Cut| match *cut {
        Cut::Entry => CutJson::Entry,
        Cut::Face { axis, at } => CutJson::Face { axis, at },
        Cut::Knot { value } => CutJson::Knot { value },
        Cut::Asked => CutJson::Step,
    };
    SegmentJson {
        from: segment.from,
        to: segment.to,
        front: segment.front.iter().map(cut).collect(),
        values: &segment.values,
        light: segment.light.map(|l| {
            let [r, g, b] = l.radiance;
            SegmentLightJson {
                transparency: l.transparency,
                light: l.light,
                running: [r, g, b, l.opacity()],
                running_depth: l.depth,
                running_error: l.running.value(),
            }
        }),
    }
}
