//! Pictures of packets beside those of the plain engine, for tests.

use proptest::prelude::*;
use vr_core::image_order::ImageSample;
use vr_core::{Compositing, Control, Rendered, Renderer, Scene, View};

use crate::caster::{RayCaster, Vector};
use crate::tracer::RaySample;

/// The picture of the plain engine.
pub(super) fn plain(caster: &RayCaster, scene: &Scene, view: &View) -> Rendered {
    let control = Control::default();
    let caster = RayCaster { vector: Vector::Off, ..caster.clone() };
    caster.prepare(scene, &control).unwrap().render(view, &control).unwrap()
}

/// The centres of all pixels.
pub(super) fn row_by_row(view: &View) -> Vec<ImageSample> {
    let [w, h] = view.size;
    let spot = |i: u32| ImageSample { pixel: i as usize, x: f64::from(i % w) + 0.5, y: f64::from(i / w) + 0.5 };
    (0..w * h).map(spot).collect()
}

/// Every bit of the samples.
pub(super) fn bits(values: &[RaySample]) -> Vec<[u32; 5]> {
    let of = |t: &RaySample| [t.rgba[0], t.rgba[1], t.rgba[2], t.rgba[3], t.depth].map(f32::to_bits);
    values.iter().map(of).collect()
}

/// Checks that two engines' pictures are the same but for `tolerance` times the brightest pixel, and depth where it is well defined.
pub(super) fn same(values: &[RaySample], plain: &Rendered, tolerance: f32) -> Result<(), TestCaseError> {
    let of = |numbers: &mut dyn Iterator<Item = f32>| numbers.fold(1.0f32, f32::max);
    // The darker picture tells: a mistake must not make room for itself.
    let brightest =
        of(&mut values.iter().flat_map(|t| t.rgba)).min(of(&mut plain.frame.pixels().as_flattened().iter().copied()));
    for (i, traced) in values.iter().enumerate() {
        let want = plain.frame.pixels()[i];
        for c in 0..4 {
            let off = (traced.rgba[c] - want[c]).abs();
            prop_assert!(
                off <= tolerance * brightest,
                "pixel {i}: {:?} for {want:?}, {}",
                traced.rgba,
                off / brightest
            );
        }
        let depth = plain.frame.depth().unwrap()[i];
        // Near a half that is just reached or just not, depth may be anything.
        if (traced.rgba[3] - 0.5).abs() > 1e-3 && traced.rgba[3] < 0.999 {
            let near = (traced.depth - depth).abs() <= 1e-3 * (1.0 + depth.abs());
            prop_assert!(traced.depth == depth || near, "pixel {i}: {} for {depth}", traced.depth);
        }
    }
    Ok(())
}

/// Checks that pixels that pick a value are those of another picture but for `allowed`, by their opacities alone unless `with_colors`. One ray of it that just reaches a
/// threshold, or just not, may be told either way.
pub(super) fn same_picks(
    pixels: impl Iterator<Item = [f32; 4]>,
    plain: &Rendered,
    (compositing, with_colors): (Compositing, bool),
    allowed: f32,
) -> Result<(), TestCaseError> {
    let mut beyond = 0;
    for (i, (found, want)) in pixels.zip(plain.frame.pixels()).enumerate() {
        let is_met = |pixel: &[f32; 4]| pixel[3] > 0.5;
        if matches!(compositing, Compositing::First { .. }) && is_met(&found) != is_met(want) {
            beyond += 1;
            continue;
        }
        for c in if with_colors { 0 } else { 3 }..4 {
            prop_assert!((found[c] - want[c]).abs() <= allowed, "pixel {i}: {found:?} for {want:?}");
        }
    }
    prop_assert!(beyond <= 1, "{beyond} pixels");
    Ok(())
}
