//! Control points and clips between keys: mixed of two, so that points stay in their order and opacities in their range.

use vr_core::{Clip, ControlPoint, ParameterError, Plane};

use super::spline::{ease, place};
use super::{Interpolation, Key, KeyFile, wrong};

/// Returns the control points at a time.
pub(super) fn points(file: &KeyFile, time: f64) -> Option<Vec<ControlPoint>> {
    let (a, b, w) = around(file, time, |key| key.points.as_ref())?;
    let three = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| mix(a[c], b[c], w));
    let point = |(a, b): (&ControlPoint, &ControlPoint)| ControlPoint {
        value: mix(a.value, b.value, w),
        color: three(a.color, b.color),
        opacity: mix(a.opacity, b.opacity, w),
        emission: a.emission.zip(b.emission).map(|(a, b)| three(a, b)),
    };
    Some(a.iter().zip(b).map(point).collect())
}

/// Returns crop box and planes at a time.
pub(super) fn clip(file: &KeyFile, time: f64) -> Option<Clip> {
    let (a, b, w) = around(file, time, |key| key.clip.as_ref())?;
    let plane = |(a, b): (&Plane, &Plane)| Plane {
        normal: a.normal * (1.0 - w) + b.normal * w,
        offset: mix(a.offset, b.offset, w),
    };
    Some(Clip {
        crop: a.crop.zip(b.crop).map(|(a, b)| (a.0 * (1.0 - w) + b.0 * w, a.1 * (1.0 - w) + b.1 * w)),
        planes: a.planes.iter().zip(&b.planes).map(plane).collect(),
    })
}

/// Refuses what cannot be mixed.
pub(super) fn check(file: &KeyFile) -> Result<(), ParameterError> {
    let number = |key: &Key| file.keys.iter().position(|other| other.time == key.time).unwrap_or(0);
    // As many points, all with emission or none.
    let shape =
        |points: &Vec<ControlPoint>| (points.len(), points.iter().map(|p| p.emission.is_some()).collect::<Vec<_>>());
    let mut first = None;
    for (key, points) in file.keys.iter().filter_map(|key| Some((key, key.points.as_ref()?))) {
        let field = format!("keys[{}].points", number(key));
        if points.is_empty() {
            return Err(wrong(&field, "no point", "a transfer function has at least one"));
        }
        if *first.get_or_insert_with(|| shape(points)) != shape(points) {
            let found = format!("{} points", points.len());
            return Err(wrong(
                &field,
                &found,
                "must be as many as in the first key that has points, all with emission or none",
            ));
        }
    }
    let shape = |clip: &Clip| (clip.crop.is_some(), clip.planes.len());
    let mut first = None;
    for (key, clip) in file.keys.iter().filter_map(|key| Some((key, key.clip.as_ref()?))) {
        if *first.get_or_insert_with(|| shape(clip)) != shape(clip) {
            let found =
                format!("{} planes, {}", clip.planes.len(), if clip.crop.is_some() { "a box" } else { "no box" });
            let allowed = "must have a box if the first key with a clip has one, and as many planes";
            return Err(wrong(&format!("keys[{}].clip", number(key)), &found, allowed));
        }
    }
    Ok(())
}

/// Returns what the keys on both sides of a time have, and the share of the later one.
fn around<'a, T>(file: &'a KeyFile, time: f64, part: impl Fn(&'a Key) -> Option<&'a T>) -> Option<(&'a T, &'a T, f64)> {
    let parts: Vec<(f64, &T)> = file.keys.iter().filter_map(|key| Some((key.time, part(key)?))).collect();
    let times: Vec<f64> = parts.iter().map(|(time, _)| *time).collect();
    let (k, u) = place(&times, time);
    let own = parts.get(k)?.1;
    let share = if file.interpolation == Interpolation::Linear { u } else { ease(u) };
    Some((own, parts.get(k + 1).map_or(own, |next| next.1), share))
}

/// At the ends, the ends themselves.
fn mix(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::super::parse_keys;
    use super::*;

    #[test]
    fn points_and_clips_are_mixed() {
        let text = r#"
            interpolation = "linear"
            [[keys]]
            points = [{ value = 1.0, color = [1, 0, 0], opacity = 0.2 }, { value = 3.0, color = [1, 1, 1], opacity = 1.0 }]
            [[keys]]
            time = 1.0
            clip = { planes = [{ normal = [0, 0, 2], offset = 5 }], box = [[0, 0, 0], [1, 1, 1]] }
            [[keys]]
            time = 2.0
            points = [{ value = 2.0, color = [0, 0, 1], opacity = 0.4 }, { value = 9.0, color = [1, 1, 1], opacity = 1.0 }]
            [[keys]]
            time = 3.0
            clip = { planes = [{ normal = [0, 2, 0], offset = 7 }], box = [[-1, 0, 0], [2, 1, 1]] }
        "#;
        let file = parse_keys(text, Path::new("")).unwrap();
        assert_eq!(file.points_at(0.0).as_ref(), file.keys[0].points.as_ref());
        assert_eq!(file.points_at(2.5).as_ref(), file.keys[2].points.as_ref());
        let half = file.points_at(1.0).unwrap();
        assert_eq!((half[0].value, half[0].color, half[1].value), (1.5, [0.5, 0.0, 0.5], 6.0));
        assert!((half[0].opacity - 0.3).abs() < 1e-15);
        assert_eq!(file.clip_at(0.0), file.keys[1].clip);
        assert_eq!(file.clip_at(3.0), file.keys[3].clip);
        let half = file.clip_at(2.0).unwrap();
        assert_eq!(half.planes, [Plane { normal: DVec3::new(0.0, 1.0, 1.0), offset: 6.0 }]);
        assert_eq!(half.crop, Some((DVec3::new(-0.5, 0.0, 0.0), DVec3::new(1.5, 1.0, 1.0))));
    }
}
