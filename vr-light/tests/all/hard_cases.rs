//! Hard cases with a medium that scatters nothing: random paths meet the reference of emission and absorption.

use std::sync::Arc;

use vr_core::scattering::{Albedo, Scattering};
use vr_core::{Control, Model, Renderer, Scene};
use vr_light::LightRenderer;
use vr_physics::{Reference, cases};

/// A wall is 64 deep in a spacing: its colour is seen a 64th of a spacing inside, where it differs by so much.
const WALL: (&str, f64) = ("opaque-wall", 4e-3);

#[test]
fn paths_meet_the_reference_of_every_case() {
    let (control, renderer) = (Control::default(), LightRenderer { paths: 128, ..LightRenderer::default() });
    let (mut drawn, mut means, mut beyond) = (0, 0, 0);
    for case in cases::all() {
        let scattering = Scattering { albedo: Albedo::Constant([0.0; 3]), ..Scattering::default() };
        let scene = Scene { scattering: Some(Arc::new(scattering)), shading: None, ..case.scene };
        // Other operators, and opacity by the gradient.
        if renderer.supports(&scene, Some(&case.view)).is_err() {
            continue;
        }
        drawn += 1;
        let frame = renderer.prepare(&scene, &control).unwrap().render(&case.view, &control).unwrap().frame;
        let dark = Scene { scattering: None, ..scene };
        let solution = Reference::default().solve(&dark, &case.view, &Model::Canonical, &control).unwrap();
        let errors = frame.uncertainty().unwrap().components();
        let wall = if case.name == WALL.0 { WALL.1 } else { 0.0 };
        for c in 0..4 {
            // Of the whole picture: difference, variance, and what is allowed besides.
            let mut sums = [0.0; 3];
            for (i, (found, expected)) in frame.pixels().iter().zip(&solution.pixels).enumerate() {
                let allowed = expected.certainty.value() + 1e-6 * expected.rgba[c].abs().max(1.0) + wall;
                let (difference, error) = (f64::from(found[c]) - expected.rgba[c], f64::from(errors[i][c]));
                means += 1;
                beyond += usize::from(difference.is_nan() || difference.abs() > 3.0 * error + allowed);
                sums = [sums[0] + difference, sums[1] + error * error, sums[2] + allowed];
            }
            let limit = 5.0 * sums[1].sqrt() + sums[2];
            assert!(sums[0].abs() <= limit, "{}, component {c}: off by {} of {limit}", case.name, sums[0]);
        }
    }
    // 0.27 % of normal means are beyond 3 standard errors; a few paths do not know of what one in a hundred meets.
    assert!(drawn >= 18 && beyond * 100 <= means, "{drawn} cases, {beyond} of {means}");
}
