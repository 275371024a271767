//! Profile of a ray: the reference and the renderer's sum on parts of equal length.

use vr_core::RenderError;
use vr_physics::{RaySegment, Reference};

use super::account::RayAccount;
use super::rows::{exact_until, rgba};

/// The reference on a part of a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct RayPart {
    /// World distance along the ray at which it begins.
    pub from: f64,
    /// World distance along the ray at which it ends.
    pub to: f64,
    /// Smallest and largest calibrated value among those at its ends, and wherever the field has a face or crosses a knot in it;
    /// `None` in vacuum.
    pub values: Option<[f64; 2]>,
    /// Transparency of the part; 1 where no light is integrated.
    pub transparency: f64,
    /// Exact premultiplied RGBA of the ray up to its end; zero where no light is integrated.
    pub exact: [f64; 4],
}

impl RayAccount<'_> {
    /// Returns a stretch of the ray in parts of equal length.
    ///
    /// # Errors
    /// Errors of the reference, for a scene that it cannot solve.
    pub fn profile(&self, [from, to]: [f64; 2], parts: usize) -> Result<Vec<RayPart>, RenderError> {
        let border = |i: usize| from + (to - from) * i as f64 / parts as f64;
        let cuts: Vec<f64> = (0..=parts).map(border).collect();
        let segments = Reference::default().segments(self.scene, &self.view, &self.ray, &cuts)?;
        let up_to = |s: f64| segments.partition_point(|segment| 0.5 * (segment.from + segment.to) < s);
        let part = |ends: &[f64]| {
            let inside = &segments[up_to(ends[0])..up_to(ends[1])];
            RayPart {
                from: ends[0],
                to: ends[1],
                values: range(inside.iter().flat_map(|segment| segment.values)),
                transparency: inside.iter().filter_map(|segment| segment.light).map(|l| l.transparency).product(),
                exact: exact_until(&segments, ends[1]).map_or([0.0; 4], |light| rgba(&light)),
            }
        };
        Ok(cuts.windows(2).map(part).collect())
    }

    /// Returns the renderer's premultiplied RGBA so far, at a world distance along the ray; `None` from a renderer that lists no steps.
    /// Within a step, it is taken to be homogeneous.
    pub fn running_at(&self, s: f64) -> Option<[f64; 4]> {
        let rows = &self.rows;
        if rows.is_empty() {
            return None;
        }
        let running = |k: usize| rows[k].light.map_or([0.0; 4], |light| light.running);
        let k = rows.partition_point(|row| row.step.begin <= s);
        let before = if k > 1 { running(k - 2) } else { [0.0; 4] };
        let Some(k) = k.checked_sub(1) else { return Some(before) };
        let part = share(rows[k].step.transparency, ((s - rows[k].step.begin) / rows[k].step.length).min(1.0));
        Some(std::array::from_fn(|c| before[c] + part * (running(k)[c] - before[c])))
    }
}

/// True if a part of a ray absorbs or shines.
pub(super) fn is_seen(segment: &RaySegment) -> bool {
    segment.light.is_some_and(|l| l.transparency < 1.0 || l.light != [0.0; 3])
}

/// Returns the share of a homogeneous step of transparency θ that is seen up to the fraction x of its length: (1 − θˣ) / (1 − θ).
fn share(transparency: f64, x: f64) -> f64 {
    match transparency {
        1.0 => x,
        0.0 => 1.0,
        theta => (1.0 - theta.powf(x)) / (1.0 - theta),
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values
        .filter(|v| v.is_finite())
        .fold(None, |range: Option<[f64; 2]>, v| Some(range.map_or([v, v], |[low, high]| [low.min(v), high.max(v)])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::phantom_subject;
    use vr_core::Control;
    use vr_raycast::RayCaster;

    #[test]
    fn a_dense_step_is_seen_by_its_front() {
        assert_eq!((share(1.0, 0.25), share(0.0, 0.25), share(0.25, 0.5)), (0.25, 1.0, 0.5 / 0.75));
        assert!((share(0.5, 1.0) - 1.0).abs() < 1e-15);
        assert_eq!(range([3.0, f64::NAN, 1.0].into_iter()), Some([1.0, 3.0]));
    }

    #[test]
    fn parts_together_are_the_pixel() {
        let subject = phantom_subject("hydrogen", 16, [24, 24]).unwrap();
        let (scene, view, control) = (&subject.scene, &subject.view, Control::default());
        let account = RayAccount::of((scene, view), [12, 12], &RayCaster::default(), &control).unwrap();
        let parts = account.profile(account.chord().unwrap(), 50).unwrap();
        assert_eq!(parts.len(), 50);
        let transparency: f64 = parts.iter().map(|part| part.transparency).product();
        let last = parts.last().unwrap();
        assert!((1.0 - transparency - account.exact.rgba[3]).abs() < 1e-6 && transparency < 0.9, "{transparency}");
        for c in 0..4 {
            assert!((last.exact[c] - account.exact.rgba[c]).abs() < 1e-6, "{c}: {last:?} {:?}", account.exact.rgba);
            let running = account.running_at(last.to).unwrap();
            assert!((running[c] - account.rgba[c]).abs() < 1e-5, "{c}: {running:?} {:?}", account.rgba);
        }
        assert!(parts.windows(2).all(|two| two[0].to == two[1].from && two[0].exact[3] <= two[1].exact[3] + 1e-12));
        // Pixels that the picture does not have are refused.
        let none = RayAccount::of((scene, view), [24, 0], &RayCaster::default(), &control);
        assert!(none.err().unwrap().to_string().contains("pixel"));
    }
}
