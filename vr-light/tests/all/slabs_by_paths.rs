//! Random paths against the deterministic solver of slabs: two methods that share no line.

use std::sync::Arc;

use glam::DVec3;
use vr_core::scattering::PhaseFunction;
use vr_core::{Control, Ray};
use vr_light::slab::{Illumination, Layer, Probes, Slab};
use vr_light::*;

/// Albedos and optical thicknesses of the tables that slabs are compared by.
const ALBEDOS: [f64; 6] = [0.2, 0.5, 0.8, 0.95, 0.99, 1.0];
const THICKNESSES: [f64; 6] = [0.1, 0.5, 1.0, 4.0, 12.0, 32.0];
/// Cosines of the directions that are looked in.
const COSINES: [f64; 3] = [1.0, 0.6, 0.2];
const PATHS: u64 = 8000;
/// Optical thickness up to which slabs are looked at from below, too: what gets through thicker ones is a matter of a few paths in millions, of which a mean over
/// thousands knows nothing, nor does its standard error.
const SEEN_THROUGH: f64 = 4.0;

/// Mean and standard error of the radiance along a ray.
fn mean(scene: &LightScene, ray: &Ray, pixel: u32) -> [f64; 2] {
    let mut film = Film::new([1, 1], 1).unwrap();
    let mut sample = [0.0; 2];
    for number in 0..PATHS {
        let mut random = RandomStream::new(2026, pixel, number);
        PathSampler::new(scene).sample(ray, &mut random, &Control::default(), &mut sample).unwrap();
        film.add(0, &sample);
    }
    [film.mean(0, 0), film.standard_error(0, 0)]
}

#[test]
fn radiance_from_slabs_is_that_of_the_solver() {
    let (mut cases, mut beyond) = (0, 0);
    for (g, albedo, thickness) in [0.0, 0.75]
        .into_iter()
        .flat_map(|g| ALBEDOS.map(|albedo| (g, albedo)))
        .flat_map(|(g, albedo)| THICKNESSES.map(|thickness| (g, albedo, thickness)))
    {
        let phase = PhaseFunction::henyey_greenstein(g).unwrap();
        // From above, at the normal: radiance has no azimuth then. A lamp of colour L sheds the flux π L.
        let solver = Slab::new(vec![Layer::new(thickness, albedo, phase.clone())]).unwrap();
        let light = Illumination::Beam { cosine: 1.0, flux: std::f64::consts::PI };
        let probes = Probes { depths: vec![], cosines: COSINES.to_vec() };
        let solved = solver.solve(&light, &probes, 1e-6).unwrap();
        let coefficients = Coefficients { absorption: 1.0 - albedo, scattering: albedo, emission: 0.0 };
        let side = f64::INFINITY;
        let bounds = (DVec3::new(-side, -side, 0.0), DVec3::new(side, side, thickness));
        let medium = Homogeneous::new(bounds, vec![coefficients], phase).unwrap();
        let lamp = LightSource::Directional { towards: DVec3::Z, color: Spectrum::grey(1.0) };
        let scene = LightScene::new(Some(Arc::new(medium)), 1).unwrap().with_lights(vec![lamp]).unwrap();
        for (i, cosine) in COSINES.into_iter().enumerate() {
            // Seen from above and from below. From below along the normal the lamp's own beam is a direction of its own: left out.
            for above in [true, false] {
                if !above && (cosine == 1.0 || thickness > SEEN_THROUGH) {
                    continue;
                }
                let sine = (1.0 - cosine * cosine).sqrt();
                let down = if above { -cosine } else { cosine };
                let origin = DVec3::new(0.0, 0.0, if above { thickness + 1.0 } else { -1.0 });
                let ray = Ray { origin, direction: DVec3::new(sine, 0.0, down) };
                let expected = if above { &solved.top.radiance_up[i] } else { &solved.bottom.radiance_down[i] };
                let [found, error] = mean(&scene, &ray, cases);
                cases += 1;
                if (found - expected.value).abs() > 3.0 * error + expected.error + 1e-12 {
                    beyond += 1;
                    eprintln!(
                        "g {g}, albedo {albedo}, thickness {thickness}, cosine {cosine}, above {above}: {found} ± {error} for {expected:?}"
                    );
                }
            }
        }
    }
    // Of normal means 0.27 % are beyond 3 standard errors, of those with a few bright paths somewhat more: one in a hundred is allowed.
    assert!(cases >= 200 && beyond * 100 <= cases, "{beyond} of {cases} beyond 3 standard errors");
}
