//! Rows of the table: the renderer's steps, each beside the reference.

use vr_core::field::Cut;
use vr_core::{Probe, ProbedStep, Scene};
use vr_physics::{RaySegment, SegmentLight};

use super::account::level;

/// Step of the renderer beside the reference.
#[derive(Clone, Debug)]
pub struct Row {
    /// Number of the step, from 0 at the front.
    pub number: usize,
    /// The step as the renderer lists it.
    pub step: ProbedStep,
    /// κ per world unit that the transfer function has for each of its samples; NaN in vacuum.
    pub extinction: Vec<f64>,
    /// Axis and index coordinate of the faces that the ray crosses in it, or at its end.
    pub faces: Vec<(usize, f64)>,
    /// Knots of the transfer function that the exact value crosses in it, or at its end.
    pub knots: Vec<f64>,
    /// True if the exact field is vacuum in a part of it, and not in another.
    pub meets_vacuum: bool,
    /// Light of the step, where light is integrated.
    pub light: Option<RowLight>,
}

/// The light of a step, and of the ray up to its end.
#[derive(Clone, Copy, Debug)]
pub struct RowLight {
    /// Colour that the step shows, b / (1 − θ); where emission is given on its own, that: b per world unit. Zero for no light.
    pub color: [f64; 3],
    /// Premultiplied RGBA so far, by the renderer.
    pub running: [f64; 4],
    /// Optical depth so far, by the renderer.
    pub depth: f64,
    /// Premultiplied RGBA so far, exactly.
    pub exact: [f64; 4],
    /// Optical depth so far, exactly.
    pub exact_depth: f64,
    /// `running` − `exact` of the component with the largest final error.
    pub error: f64,
    /// Change of `error` since the step before.
    pub change: f64,
}

/// Sets steps beside the reference, which has to be cut where they begin and end. Errors are those of component `channel`.
pub fn rows(scene: &Scene, probe: &Probe, segments: &[RaySegment], channel: usize) -> Vec<Row> {
    let level = level(scene.compositing);
    let deepest = -(-level).ln_1p();
    let running = probe.running(level);
    let (mut depth, mut error_before) = (0.0, 0.0);
    let mut rows = Vec::with_capacity(probe.steps.len());
    for (number, (step, running)) in probe.steps.iter().zip(running).enumerate() {
        let inside = inside(segments, step);
        let at_end = exact_until(segments, step.end());
        let light = scene.compositing.integrates_light().then(|| {
            depth = f64::min(depth + step.depth(), deepest);
            let (exact, exact_depth) = at_end.map_or(([0.0; 4], 0.0), |light| (rgba(&light), light.depth));
            let error = running[channel] - exact[channel];
            let change = error - error_before;
            error_before = error;
            RowLight { color: color(scene, step), running, depth, exact, exact_depth, error, change }
        });
        let cuts = || inside.iter().flat_map(|segment| &segment.front);
        let within = within(segments, step);
        let vacuum = within.iter().filter(|segment| segment.values[0].is_nan()).count();
        rows.push(Row {
            number,
            extinction: step.samples.iter().map(|sample| extinction(scene, sample.value)).collect(),
            faces: cuts()
                .filter_map(|cut| if let Cut::Face { axis, at } = *cut { Some((axis, at)) } else { None })
                .collect(),
            knots: cuts().filter_map(|cut| if let Cut::Knot { value } = *cut { Some(value) } else { None }).collect(),
            meets_vacuum: vacuum > 0 && vacuum < within.len(),
            light,
            step: step.clone(),
        });
    }
    rows
}

/// Returns the premultiplied RGBA of the ray up to the end of a part.
pub fn rgba(light: &SegmentLight) -> [f64; 4] {
    let [r, g, b] = light.radiance;
    [r, g, b, light.opacity()]
}

/// Returns the exact light of the ray up to a distance at which it is cut; `None` before its first part ends.
pub fn exact_until(segments: &[RaySegment], s: f64) -> Option<SegmentLight> {
    let ended = segments.partition_point(|segment| segment.to <= s + rounding(segments, s));
    segments[..ended].last()?.light
}

/// Returns the bound of the rounding of a distance.
fn rounding(segments: &[RaySegment], s: f64) -> f64 {
    let length = segments.last().map_or(0.0, |last| last.to - segments[0].from);
    2e-12 * length + 8.0 * f64::EPSILON * s.abs()
}

/// Returns the parts that begin in a step, or at its end.
fn inside<'s>(segments: &'s [RaySegment], step: &ProbedStep) -> &'s [RaySegment] {
    let up_to = |s: f64| segments.partition_point(|segment| segment.from <= s + rounding(segments, s));
    &segments[up_to(step.begin)..up_to(step.end()).max(up_to(step.begin))]
}

/// Returns the parts that a step consists of.
fn within<'s>(segments: &'s [RaySegment], step: &ProbedStep) -> &'s [RaySegment] {
    let before = |s: f64| segments.partition_point(|segment| 0.5 * (segment.from + segment.to) < s);
    &segments[before(step.begin)..before(step.end())]
}

fn extinction(scene: &Scene, value: f64) -> f64 {
    if value.is_nan() { f64::NAN } else { scene.transfer.extinction_at(value) }
}

fn color(scene: &Scene, step: &ProbedStep) -> [f64; 3] {
    let share = if scene.transfer.has_emission() { step.length } else { 1.0 - step.transparency };
    if share == 0.0 { [0.0; 3] } else { step.light.map(|b| b / share) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{
        Calibration, Camera, Control, ControlPoint, OpacityRule, Placement, Rays, Renderer, TransferFunction,
        UniformGrid, View,
    };
    use vr_physics::Reference;
    use vr_raycast::RayCaster;

    /// Returns a ramp 0 to 4 along z, seen from the far end, with a knot at 1.5.
    fn ramp() -> (Scene, View) {
        let samples: Vec<f32> = (0..20).map(|i| (i / 4) as f32).collect();
        let grid =
            UniformGrid::new([2, 2, 5], samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
        let point = |value, opacity| ControlPoint::new(value, [1.0, 0.5, 0.0], opacity);
        let points = vec![point(0.0, 0.0), point(1.5, 0.5), point(4.0, 0.5)];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        let scene = Scene::new(grid.unwrap().into(), transfer);
        let view = View::new(Camera::framing(scene.volume.bounds(), 0.0, 0.0, None), [1, 1]);
        (scene, view)
    }

    #[test]
    fn steps_stand_beside_what_is_true_of_them() {
        let (scene, view) = ramp();
        let control = Control::default();
        let probe =
            RayCaster::exact(1.0).prepare(&scene, &control).unwrap().probe(&view, [0, 0], &control).unwrap().unwrap();
        assert_eq!(probe.steps.len(), 4);
        let ray = Rays::new(&view).unwrap().at(0.5, 0.5);
        let cuts: Vec<f64> = probe.steps.iter().flat_map(|step| [step.begin, step.end()]).collect();
        let segments = Reference::default().segments(&scene, &view, &ray, &cuts).unwrap();
        let rows = rows(&scene, &probe, &segments, 3);
        let faces: Vec<_> = rows.iter().map(|row| row.faces.clone()).collect();
        // The last one ends where the volume does, which is no face between cells.
        assert_eq!(faces, [vec![(2, 3.0)], vec![(2, 2.0)], vec![(2, 1.0)], vec![]]);
        let knots: Vec<_> = rows.iter().map(|row| row.knots.clone()).collect();
        assert_eq!(knots, [vec![], vec![], vec![1.5], vec![]]);
        // Constant, then the kink in the middle of a step: κ = 1/2 in front of it, a ramp behind.
        let light: Vec<RowLight> = rows.iter().map(|row| row.light.unwrap()).collect();
        for (l, want) in light.iter().zip([0.5, 1.0, 1.25 + 5.0 / 24.0, 1.25 + 9.0 / 24.0]) {
            assert!((l.exact_depth - want).abs() < 1e-9, "{l:?} {want}");
        }
        assert!(light[1].error.abs() < 1e-12 && light[2].error > 1e-3);
        assert!((light[3].error - light.iter().map(|l| l.change).sum::<f64>()).abs() < 1e-15);
        assert_eq!(rows[0].extinction, [0.5]);
        assert!((light[0].color[1] - 0.5).abs() < 1e-15 && light[0].color[2] == 0.0);
        assert!(exact_until(&segments, segments[0].from).is_none());
    }
}
