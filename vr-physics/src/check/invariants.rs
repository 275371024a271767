//! Invariants that hold for the pictures of any renderer, whatever the correct picture is.

use vr_core::{Control, Frame, RenderError, Renderer, View};

use super::drawn::draw;
use super::effort::{Effort, Verdict};
use super::outcome::{CheckFailure, Report};
use super::test_scene::TestScene;
use super::transformed::{quarter_turned, scaled_world, with_emission_times, without_highlights};
pub use super::updates::update_is_prepare;
use crate::Metrics;

/// All of the invariants: [`stays_in_range`], [`is_linear_in_emission`], [`is_free_of_scale`], [`turns_with_its_data`],
/// [`ignores_threads`], [`forgets_earlier_frames`], [`update_is_prepare`]. Where rounding is allowed, it may be `tolerance` relative to max(1, largest
/// magnitude of the picture).
///
/// # Errors
/// The first failure, with a scene that shows it.
pub fn obeys_invariants(renderer: &dyn Renderer, tolerance: f64, effort: &Effort) -> Result<Vec<Report>, CheckFailure> {
    Ok(vec![
        stays_in_range(renderer, tolerance, effort)?,
        is_linear_in_emission(renderer, tolerance, effort)?,
        is_free_of_scale(renderer, tolerance, effort)?,
        turns_with_its_data(renderer, tolerance, effort)?,
        ignores_threads(renderer, effort)?,
        forgets_earlier_frames(renderer, effort)?,
        update_is_prepare(renderer, effort)?,
    ])
}

/// Every number is finite, opacity lies in [0, 1], no light is negative; and an unshaded medium whose emission is κ·c is nowhere
/// brighter than its brightest colour behind the same opacity (up to `tolerance`).
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn stays_in_range(renderer: &dyn Renderer, tolerance: f64, effort: &Effort) -> Result<Report, CheckFailure> {
    effort.over("stays in range", renderer, effort.any_scene(), |test| {
        let frame = draw(renderer, test, &Control::default())?;
        let (scene, mut excess) = (&test.scene, 0.0f64);
        let bounded = scene.shading.is_none() && !scene.transfer.has_emission();
        for &p in frame.pixels() {
            let valid = p.iter().all(|c| c.is_finite() && *c >= 0.0) && p[3] <= 1.0;
            if !valid {
                return Ok(Verdict::Broken(format!("pixel {p:?}")));
            }
            let [r, g, b, alpha] = p.map(f64::from);
            excess = excess.max(r.max(g).max(b) - alpha * scene.transfer.brightest());
        }
        let excess = if bounded { excess } else { 0.0 };
        let allowed = tolerance * scene.transfer.brightest().max(1.0);
        Ok(Verdict::within(excess, allowed, || "brighter than the brightest colour behind the same opacity".to_owned()))
    })
}

/// Thrice the emission is thrice the light at the same opacity; and the light of two media that differ in their emission alone
/// adds up to that of the medium that emits both.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn is_linear_in_emission(renderer: &dyn Renderer, tolerance: f64, effort: &Effort) -> Result<Report, CheckFailure> {
    effort.over("is linear in emission", renderer, effort.any_scene(), |test| {
        let test = without_highlights(test);
        let of = |factor: &dyn Fn(usize) -> f64| {
            let frame = draw(renderer, &with_emission_times(&test, factor), &Control::default())?;
            Ok::<_, RenderError>(wide(&frame))
        };
        let (one, three) = (of(&|_| 1.0)?, of(&|_| 3.0)?);
        let (even, odd) = (of(&|i| ((i + 1) % 2) as f64)?, of(&|i| (i % 2) as f64)?);
        let light = |f: &dyn Fn(usize, usize) -> f64| {
            let pixel = |i| [f(i, 0), f(i, 1), f(i, 2), one[i][3]];
            (0..one.len()).map(pixel).collect::<Vec<[f64; 4]>>()
        };
        let deviation = |expected: &[[f64; 4]], found: &[[f64; 4]]| {
            let peak = expected.iter().flatten().fold(1.0, |m: f64, c| m.max(c.abs()));
            let off = expected.iter().flatten().zip(found.iter().flatten()).map(|(e, f)| (e - f).abs());
            off.fold(0.0, worst) / peak
        };
        let scaled = deviation(&light(&|i, c| 3.0 * one[i][c]), &three);
        let summed = light(&|i, c| even[i][c] + odd[i][c]);
        let superposed = deviation(&summed, &one);
        let opacity =
            one.iter().zip(even.iter().zip(&odd)).map(|(o, (a, b))| (o[3] - a[3]).abs().max((o[3] - b[3]).abs()));
        let deviation = [scaled, superposed].into_iter().chain(opacity).fold(0.0, worst);
        Ok(Verdict::within(deviation, tolerance, || "deviation from linearity".to_owned()))
    })
}

/// A world s times as large with κ/s and q/s gives the same picture: to the last bit for powers of two, within `tolerance` for
/// s = 3. Depths are s times as large.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn is_free_of_scale(renderer: &dyn Renderer, tolerance: f64, effort: &Effort) -> Result<Report, CheckFailure> {
    let exact = effort.over("is free of scale, powers of two", renderer, effort.any_scene(), |test| {
        let original = draw(renderer, test, &Control::default())?;
        // 2^±66 ≈ 7·10^±19.
        for exponent in [-66, 1, 66] {
            let s = libm::ldexp(1.0, exponent);
            let scaled = draw(renderer, &scaled_world(test, s), &Control::default())?;
            if let Some(difference) = first_difference(&original, &scaled, s as f32) {
                return Ok(Verdict::Broken(format!("the world 2^{exponent} times as large: {difference}")));
            }
        }
        Ok(Verdict::Held { measured: 0.0, allowed: 0.0 })
    })?;
    let rounded = effort.over("is free of scale", renderer, effort.tame_scene(), |test| {
        let original = draw(renderer, test, &Control::default())?;
        let scaled = draw(renderer, &scaled_world(test, 3.0), &Control::default())?;
        let deviation = Metrics::of(&wide(&original), scaled.pixels()).max;
        Ok(Verdict::within(deviation, tolerance, || "deviation in a world 3 times as large".to_owned()))
    })?;
    Ok(Report { held: rounded.held + exact.held, refused: rounded.refused + exact.refused, ..rounded })
}

/// Voxels, camera and clip turned together by 90° about each axis give the same picture within `tolerance`.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn turns_with_its_data(renderer: &dyn Renderer, tolerance: f64, effort: &Effort) -> Result<Report, CheckFailure> {
    effort.over("turns with its data", renderer, effort.tame_scene(), |test| {
        let original = wide(&draw(renderer, test, &Control::default())?);
        let mut deviation = 0.0;
        for axis in 0..3 {
            let turned = draw(renderer, &quarter_turned(test, axis), &Control::default())?;
            deviation = worst(deviation, Metrics::of(&original, turned.pixels()).max);
        }
        Ok(Verdict::within(deviation, tolerance, || "deviation after a quarter turn".to_owned()))
    })
}

/// One thread and three make the same picture, to the last bit.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn ignores_threads(renderer: &dyn Renderer, effort: &Effort) -> Result<Report, CheckFailure> {
    let (one, three) = (Control::default().with_threads(1), Control::default().with_threads(3));
    effort.over("ignores the number of threads", renderer, effort.any_scene(), |test| {
        // More than one tile of rays, so that there is something to share out.
        let view = View { size: [40, 40], ..test.view.clone() };
        let test = TestScene { view, ..test.clone() };
        let (a, b) = (draw(renderer, &test, &one)?, draw(renderer, &test, &three)?);
        Ok(identical(&a, &b, "three threads instead of one"))
    })
}

/// A frame does not depend on the frames and scenes before it, to the last bit: another view in between changes nothing, and
/// neither does an update to another scene and back.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn forgets_earlier_frames(renderer: &dyn Renderer, effort: &Effort) -> Result<Report, CheckFailure> {
    let control = Control::default();
    effort.over("forgets earlier frames", renderer, effort.any_scene(), |test| {
        let fresh = draw(renderer, test, &control)?;
        let mut prepared = renderer.prepare(&test.scene, &control)?;
        let [width, height] = test.view.size;
        let camera = test.view.camera.orbit(40.0, 10.0);
        let elsewhere = View { camera, size: [height + 1, width], ..test.view.clone() };
        prepared.render(&elsewhere, &control)?;
        let again = prepared.render(&test.view, &control)?.frame;
        if let Verdict::Broken(reason) = identical(&fresh, &again, "after another view") {
            return Ok(Verdict::Broken(reason));
        }
        prepared.update(&with_emission_times(test, |i| 0.5 * i as f64).scene, &control)?;
        prepared.render(&test.view, &control)?;
        prepared.update(&quarter_turned(test, 0).scene, &control)?;
        prepared.render(&elsewhere, &control)?;
        prepared.update(&test.scene, &control)?;
        let updated = prepared.render(&test.view, &control)?.frame;
        Ok(identical(&fresh, &updated, "after an update to other scenes and back"))
    })
}

/// The larger number; NaN if one is, so that it cannot pass for small.
fn worst(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

fn wide(frame: &Frame) -> Vec<[f64; 4]> {
    frame.pixels().iter().map(|p| p.map(f64::from)).collect()
}

pub(super) fn identical(expected: &Frame, found: &Frame, when: &str) -> Verdict {
    match first_difference(expected, found, 1.0) {
        Some(difference) => Verdict::Broken(format!("{when}: {difference}")),
        None => Verdict::Held { measured: 0.0, allowed: 0.0 },
    }
}

/// The first pixel that is not the same to the last bit, its depth `depth_scale` times as large.
fn first_difference(expected: &Frame, found: &Frame, depth_scale: f32) -> Option<String> {
    let bits = |p: &[f32; 4]| p.map(f32::to_bits);
    let at = |i: usize| [i as u32 % expected.size()[0], i as u32 / expected.size()[0]];
    let colors = expected.pixels().iter().zip(found.pixels()).enumerate();
    let mut different = colors.filter(|(_, (a, b))| bits(a) != bits(b));
    if let Some((i, (a, b))) = different.next() {
        return Some(format!("pixel {:?} is {b:?} instead of {a:?}", at(i)));
    }
    if let (a, b) = (expected.depth().is_some(), found.depth().is_some())
        && a != b
    {
        let has = |depth| if depth { "has a depth" } else { "has none" };
        return Some(format!("the picture {} where the other {}", has(b), has(a)));
    }
    let depths = expected.depth().unwrap_or_default().iter().zip(found.depth().unwrap_or_default()).enumerate();
    let mut different = depths.filter(|(_, (a, b))| (**a * depth_scale).to_bits() != b.to_bits());
    different.next().map(|(i, (a, b))| format!("depth of pixel {:?} is {b} instead of {}", at(i), a * depth_scale))
}
