//! Closed forms, balances and symmetries.

use vr_core::scattering::PhaseFunction;
use vr_light::slab::{Ground, Illumination, Layer, Probes, Slab};

use super::milne::exponential_integral;
use super::{DIFFUSE, beam, lobe, near, shares, solve};

#[test]
fn without_scattering_light_is_absorbed_by_beers_law() {
    for thickness in [0.0, 1e-9, 0.1, 1.0, 30.0] {
        let layer = Layer::new(thickness, 0.0, PhaseFunction::Rayleigh);
        for cosine in [0.05, 0.5, 1.0] {
            let [r, t] = shares(&layer, &beam(cosine));
            near(r, 0.0, 1e-15);
            near(t, (-thickness / cosine).exp(), 1e-14);
        }
        // 2 E₃(τ) of uniform light.
        let [_, t] = shares(&layer, &DIFFUSE);
        near(t, 2.0 * exponential_integral(3, thickness), 1e-8);
    }
}

#[test]
fn conservative_slabs_lose_nothing() {
    for phase in [PhaseFunction::Isotropic, PhaseFunction::Rayleigh, lobe(0.75), lobe(-0.6), lobe(0.9)] {
        for thickness in [1e-6, 0.3, 10.0, 1e4] {
            for light in [DIFFUSE, beam(1.0), beam(0.2)] {
                let [r, t] = shares(&Layer::new(thickness, 1.0, phase.clone()), &light);
                near(r + t, 1.0, 1e-9);
            }
        }
    }
}

#[test]
fn a_slab_cut_into_layers_is_the_same_slab() {
    let layer = |thickness| Layer::new(thickness, 0.9, lobe(0.6));
    let probes = Probes { depths: vec![0.7, 2.0], cosines: vec![0.2, 0.9] };
    let whole = solve(&[layer(3.0)], &beam(0.6), &probes);
    let cut = solve(&[layer(0.5), layer(0.0), layer(1.5), layer(1.0)], &beam(0.6), &probes);
    near(whole.top.up.value, cut.top.up.value, 1e-10);
    for (a, b) in whole.levels.iter().zip(&cut.levels) {
        near(a.down.value, b.down.value, 1e-10);
        near(a.fluence.value, b.fluence.value, 1e-10);
        near(a.radiance_down[0].value, b.radiance_down[0].value, 1e-10);
    }
}

#[test]
fn what_leaves_the_net_flux_is_absorbed() {
    let slab = Slab::new(vec![Layer::new(4.0, 0.8, lobe(0.5))]).unwrap();
    let slab = slab.with_ground(Ground { albedo: 0.3, emission: 0.0 }).unwrap();
    // Simpson's rule over the fluence.
    let n = 32;
    let depths: Vec<f64> = (0..=n).map(|i| 1.0 + f64::from(i) / f64::from(n)).collect();
    let solution = slab.solve(&beam(0.5), &Probes { depths, cosines: vec![] }, 1e-8).unwrap();
    let levels = &solution.levels;
    let net = |i: usize| levels[i].direct.value + levels[i].down.value - levels[i].up.value;
    let weight = |i: usize| if i == 0 || i == n as usize { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    let fluence: f64 =
        (0..=n as usize).map(|i| weight(i) * levels[i].fluence.value).sum::<f64>() / (3.0 * f64::from(n));
    near(net(0) - net(n as usize), 0.2 * fluence, 1e-7);
    // The whole balance: reflected, absorbed by the medium, absorbed by the ground.
    let ground = (solution.bottom.direct.value + solution.bottom.down.value) * 0.7;
    near(solution.reflected().value + solution.absorbed.value + ground, 1.0, 1e-9);
}

#[test]
fn a_furnace_is_uniform() {
    let b = 2.5;
    let hot = |thickness, albedo, phase| Layer { source: b, ..Layer::new(thickness, albedo, phase) };
    let layers = vec![hot(0.5, 0.99, lobe(0.8)), hot(3.0, 0.2, PhaseFunction::Isotropic), hot(1.0, 1.0, lobe(-0.3))];
    let slab = Slab::new(layers).unwrap().with_ground(Ground { albedo: 0.4, emission: 0.6 * b }).unwrap();
    let probes = Probes { depths: vec![0.0, 0.2, 2.0, 4.5], cosines: vec![1e-3, 0.3, 1.0] };
    let solution = slab.solve(&Illumination::Diffuse { radiance: b }, &probes, 1e-9).unwrap();
    for level in solution.levels.iter().chain([&solution.top, &solution.bottom]) {
        for radiance in level.radiance_up.iter().chain(&level.radiance_down) {
            near(radiance.value, b, 1e-10);
        }
        near(level.fluence.value, 4.0 * std::f64::consts::PI * b, 1e-9);
    }
}

/// Kirchhoff: what an isothermal slab emits is what it absorbs of uniform light of that radiance; in the black limit that is all.
#[test]
fn emission_is_absorption() {
    for (thickness, albedo) in [(0.01, 0.5), (1.0, 0.9), (50.0, 0.0)] {
        let layer = Layer { source: 1.0, ..Layer::new(thickness, albedo, lobe(0.75)) };
        let dark = solve(std::slice::from_ref(&layer), &Illumination::Dark, &Probes::default());
        let [r, t] = shares(&Layer { source: 0.0, ..layer }, &DIFFUSE);
        let emissivity = dark.emitted_up.value / std::f64::consts::PI;
        near(emissivity, 1.0 - r - t, 1e-9);
        near(dark.emitted_down.value, dark.emitted_up.value, 1e-12);
    }
}

#[test]
fn light_can_go_back() {
    let [a, b] = [Layer::new(1.0, 0.9, lobe(0.7)), Layer::new(0.5, 0.3, PhaseFunction::Isotropic)];
    // Radiance at one cosine under a beam of irradiance 1 at another, times its cosine.
    let through = |layers: &[Layer], from: f64, to: f64| {
        let light = Illumination::Beam { cosine: from, flux: from };
        let solution = solve(layers, &light, &Probes { depths: vec![], cosines: vec![to] });
        [to * solution.top.radiance_up[0].value, to * solution.bottom.radiance_down[0].value]
    };
    let [r1, t1] = through(&[a.clone(), b.clone()], 0.3, 0.8);
    let [r2, _] = through(&[a.clone(), b.clone()], 0.8, 0.3);
    let [_, t2] = through(&[b, a], 0.8, 0.3);
    near(r1, r2, 1e-10);
    near(t1, t2, 1e-10);
}

#[test]
fn a_lambertian_ground_alone_and_an_albedo_of_one() {
    let ground = Slab::new(vec![]).unwrap().with_ground(Ground { albedo: 0.6, emission: 0.0 }).unwrap();
    let solution = ground.solve(&beam(0.4), &Probes { depths: vec![], cosines: vec![0.9] }, 1e-9).unwrap();
    near(solution.reflected().value, 0.6, 1e-13);
    near(solution.top.radiance_up[0].value, 0.6 / std::f64::consts::PI, 1e-13);
    // A white ground beneath a conservative slab sends everything back.
    let cloud = Slab::new(vec![Layer::new(5.0, 1.0, lobe(0.8))]).unwrap();
    let white = cloud.with_ground(Ground { albedo: 1.0, emission: 0.0 }).unwrap();
    near(white.solve(&beam(0.4), &Probes::default(), 1e-8).unwrap().reflected().value, 1.0, 1e-9);
}

#[test]
fn wrong_numbers_are_refused_by_name() {
    let field = |result: Result<_, vr_core::ParameterError>| result.map(|_: ()| ()).unwrap_err().field;
    let layer = |thickness, albedo, source| Layer { source, ..Layer::new(thickness, albedo, PhaseFunction::Isotropic) };
    for (wrong, key) in [
        (layer(-1.0, 0.5, 0.0), "thickness"),
        (layer(f64::NAN, 0.5, 0.0), "thickness"),
        (layer(f64::INFINITY, 0.5, 0.0), "thickness"),
        (layer(1.0, 1.5, 0.0), "albedo"),
        (layer(1.0, f64::NAN, 0.0), "albedo"),
        (layer(1.0, 0.5, -1.0), "source"),
    ] {
        assert_eq!(field(Slab::new(vec![wrong]).map(|_| ())), format!("slab.layers[0].{key}"));
    }
    let slab = Slab::new(vec![layer(1.0, 0.5, 0.0)]).unwrap();
    let ask = |light, depths: &[f64], cosines: &[f64], tolerance| {
        let probes = Probes { depths: depths.to_vec(), cosines: cosines.to_vec() };
        field(slab.solve(&light, &probes, tolerance).map(|_| ()))
    };
    assert_eq!(ask(beam(0.0), &[], &[], 1e-6), "illumination.cosine");
    assert_eq!(ask(Illumination::Diffuse { radiance: -1.0 }, &[], &[], 1e-6), "illumination.radiance");
    assert_eq!(ask(DIFFUSE, &[1.1], &[], 1e-6), "probes.depths");
    assert_eq!(ask(DIFFUSE, &[], &[f64::NAN], 1e-6), "probes.cosines");
    assert_eq!(ask(DIFFUSE, &[], &[], 0.0), "tolerance");
    assert_eq!(field(slab.with_ground(Ground { albedo: 2.0, emission: 0.0 }).map(|_| ())), "slab.ground.albedo");
}
