//! Grids with colours: closed forms, and every operator against brute force through the public samplers.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::filter::{Lattice, Reconstruction};
use vr_core::{
    Camera, ColorGrid, Compositing, Control, ControlPoint, Filter, GradientMethod, GridVolume, IndexRay,
    LatticeVisitor, Light, Model, OpacityRule, Placement, Projection, Rays, Sampler, SamplerVisitor, Scene, Shading,
    TransferFunction, UniformGrid, View, Volume, Voxel, gradient_between_samples, optics,
};
use vr_physics::{Certainty, Pixel, Reference};

/// Seeded numbers from 0 to 1 (SplitMix64, Steele et al. 2014).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// A slightly sheared 5×6×4 grid of random colours; its values are smooth, so that operators that pick one pick it well.
fn colors(seed: u64) -> ColorGrid {
    let dims = [5, 6, 4];
    let axes = DMat3::from_cols(DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.0, 0.8, 0.0), DVec3::new(0.2, 0.0, 1.3));
    let placement = Placement::new(DVec3::new(-1.0, 2.0, 0.5), axes).unwrap();
    let values: Vec<f32> = (0..120)
        .map(|i| {
            let (x, y, z) = ((i % 5) as f32, (i / 5 % 6) as f32, (i / 30) as f32);
            0.5 + 0.3 * (0.9 * x + 0.4 * y).sin() + 0.25 * (1.1 * z - 0.7 * y).cos()
        })
        .collect();
    let mut next = random(seed);
    let channels = [(); 3].map(|()| (0..120).map(|_| (next() * 65535.0) as u16).collect());
    let grid = UniformGrid::new(dims, values, placement, Default::default()).unwrap();
    ColorGrid::new(GridVolume::new(grid.into(), Filter::Trilinear), channels).unwrap()
}

fn scene(colors: ColorGrid, emission: bool) -> Scene {
    let p = |value, color, opacity| {
        let point = ControlPoint::new(value, color, opacity);
        ControlPoint { emission: emission.then_some(color), ..point }
    };
    let points = vec![
        p(0.1, [0.1, 0.2, 0.9], 0.0),
        p(0.45, [0.9, 0.3, 0.1], 0.25),
        p(0.6, [0.2, 0.8, 0.3], 0.05),
        p(1.0, [1.0, 1.0, 0.9], 0.6),
    ];
    let light = Light { direction: Some(DVec3::new(0.3, 1.0, 0.5)), color: [1.0, 0.8, 0.6] };
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene { lights: vec![Light::default(), light], ..Scene::new(colors.into(), transfer) }
}

const SIDE: u32 = 5;

fn view(scene: &Scene) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 35.0, 25.0, Some(40.0)), [SIDE; 2])
}

fn solve(scene: &Scene, view: &View) -> Vec<Pixel> {
    Reference::default().solve(scene, view, &Model::Canonical, &Control::default()).unwrap().pixels
}

/// Midpoint samples along a ray: index position, value, gradient per index step.
struct March {
    ray: IndexRay,
    n: usize,
}

type Samples = Vec<([f64; 3], f64, [f64; 3])>;

impl SamplerVisitor for &March {
    type Output = Samples;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Samples {
        let h = self.ray.length() / self.n as f64;
        let at = |k: usize| self.ray.at(self.ray.start + (k as f64 + 0.5) * h).to_array();
        let sample = |k| {
            let (value, gradient) = sampler.value_and_gradient(at(k));
            (at(k), value, gradient)
        };
        (0..self.n).map(sample).collect()
    }
}

struct Central<'a>(&'a mut Samples);

impl LatticeVisitor for Central<'_> {
    type Output = ();
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) {
        for (at, _, g) in self.0 {
            *g = gradient_between_samples(&lattice, *at);
        }
    }
}

fn brute(scene: &Scene, view: &View, pixel: usize) -> Option<[f64; 4]> {
    const N: usize = 20_000;
    let ray = Rays::new(view).unwrap().at((pixel as u32 % SIDE) as f64 + 0.5, (pixel as u32 / SIDE) as f64 + 0.5);
    let colors = scene.volume.colors().unwrap();
    let u = colors.values();
    let march = March { ray: IndexRay::new(&ray, u.placement(), u.dims(), &view.clip, f64::INFINITY)?, n: N };
    let mut samples = u.with_sampler(&march);
    if scene.shading.as_ref().is_some_and(|s| s.gradient == GradientMethod::CentralDifferences) {
        u.with_lattice(Central(&mut samples));
    }
    let h = march.ray.length() / N as f64;
    let picked = |value: f64, tint: [f64; 3]| {
        let o = scene.transfer.at(value);
        [0, 1, 2].map(|c| o.color[c] * o.opacity * tint[c]).into_iter().chain([o.opacity]).collect::<Vec<_>>()
    };
    let pixel = |v: Vec<f64>| Some([v[0], v[1], v[2], v[3]]);
    let by_value = |a: &&([f64; 3], f64, [f64; 3]), b: &&([f64; 3], f64, [f64; 3])| a.1.total_cmp(&b.1);
    match scene.compositing {
        Compositing::Maximum => {
            let s = samples.iter().rev().max_by(by_value)?;
            return pixel(picked(s.1, colors.color(s.0)));
        }
        Compositing::Minimum => {
            let s = samples.iter().min_by(by_value)?;
            return pixel(picked(s.1, colors.color(s.0)));
        }
        Compositing::Average => {
            let mean = samples.iter().map(|s| s.1).sum::<f64>() / N as f64;
            let tint = [0, 1, 2].map(|c| samples.iter().map(|s| colors.color(s.0)[c]).sum::<f64>() / N as f64);
            return pixel(picked(mean, tint));
        }
        _ => {}
    }
    let along = scene.shading.as_ref().map(|s| (s, s.along::<f64>(&scene.lights, ray.direction)));
    let lit = |s: &([f64; 3], f64, [f64; 3])| -> ([f64; 3], f64) {
        let (own, tint) = (scene.transfer.at(s.1).color, colors.color(s.0));
        let color = [0, 1, 2].map(|c| own[c] * tint[c]);
        let g = u.placement().gradient_to_world(DVec3::from(s.2));
        match &along {
            None => (color, 1.0),
            Some((s, r)) => {
                let (factor, added) = r.reflect(g.to_array());
                ([0, 1, 2].map(|c| color[c] * factor[c] + added[c]), s.modulation(g.length()))
            }
        }
    };
    if let Compositing::First { threshold } = scene.compositing {
        let hit = samples.iter().find(|s| s.1 >= threshold);
        return Some(hit.map_or([0.0; 4], |s| {
            let ([r, g, b], _) = lit(s);
            [r, g, b, 1.0]
        }));
    }
    let level = if let Compositing::Accumulate { level } = scene.compositing { level } else { 1.0 };
    let (mut rgb, mut alpha) = ([0.0; 3], 0.0);
    for s in &samples {
        let (color, factor) = lit(s);
        let tau = scene.transfer.extinction_at(s.1) * factor * h;
        let step = optics::opacity_of_depth(tau).min((level - alpha) / (1.0 - alpha));
        let tint = colors.color::<f64>(s.0);
        for c in 0..3 {
            let light = if scene.transfer.has_emission() {
                scene.transfer.at(s.1).emission[c] * tint[c] * h * optics::source_weight(tau)
            } else {
                step * color[c]
            };
            rgb[c] += (1.0 - alpha) * light;
        }
        alpha += (1.0 - alpha) * step;
    }
    Some([rgb[0], rgb[1], rgb[2], alpha])
}

/// Compares all pixels; `slack` is what brute force may miss beyond the bound. Returns the largest bound, of those below `limit`.
fn compare(name: &str, scene: &Scene, slack: f64) -> f64 {
    let view = view(scene);
    let (mut seen, mut largest) = (0.0f64, 0.0f64);
    for (i, pixel) in solve(scene, &view).iter().enumerate() {
        let Certainty::Bound(bound) = pixel.certainty else { panic!("{name}: {:?} is no bound", pixel.certainty) };
        let expected = brute(scene, &view, i).unwrap_or_default();
        for c in 0..4 {
            let error = (pixel.rgba[c] - expected[c]).abs();
            assert!(error <= slack + bound, "{name}, pixel {i}: {:?} for {expected:?}, bound {bound:e}", pixel.rgba);
            seen = seen.max(pixel.rgba[c]);
        }
        largest = largest.max(bound);
    }
    assert!(seen > 0.1, "{name}: nothing to see");
    largest
}

#[test]
fn a_slab_from_one_colour_to_another_is_a_closed_form() {
    // A constant value, red at the front face and blue at the back one: X(s) = (1 − s/L, 0, s/L).
    let dims = [2, 2, 3];
    let placement = Placement::from_spacing([1.0, 1.0, 1.5]).unwrap();
    let grid = UniformGrid::new(dims, vec![7u8; 12], placement, Default::default()).unwrap();
    let ramp: Vec<u16> = [0u16, 32768, 65535].into_iter().flat_map(|v| [v; 4]).collect();
    let other = ramp.iter().map(|v| 65535 - v).collect();
    let colors = ColorGrid::new(GridVolume::new(grid.into(), Filter::Trilinear), [other, vec![0; 12], ramp]).unwrap();
    let (length, unit, opacity) = (3.0, 1.0, 0.4);
    let camera = Camera {
        eye: DVec3::new(0.4, 0.6, -5.0),
        target: DVec3::new(0.4, 0.6, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 0.1 },
    };
    let view = View::new(camera, [1, 1]);
    let kappa: f64 = -f64::ln_1p(-opacity) / unit;
    let (tau, clear) = (kappa * length, (-kappa * length).exp());
    // The middle voxel is half of a stored number off the line: 4·10⁻⁶ of a hat of half the length.
    let off = 8e-6;
    for emission in [None, Some([2.0; 3])] {
        let point = ControlPoint { emission, ..ControlPoint::new(0.0, [1.0; 3], opacity) };
        let transfer = TransferFunction::new(vec![point], OpacityRule::Power, unit).unwrap();
        let pixel = solve(&Scene::new(colors.clone().into(), transfer), &view)[0];
        // ∫ q (1 − s/L) e^(−κs) ds, q = κ or the emission.
        let source = if emission.is_some() { 2.0 / kappa } else { 1.0 };
        let red = source * (1.0 - (1.0 - clear) / tau);
        let blue = source * (1.0 - clear) - red;
        let expected = [red, 0.0, blue, 1.0 - clear];
        for c in 0..4 {
            assert!((pixel.rgba[c] - expected[c]).abs() < off * source.max(1.0), "{:?} for {expected:?}", pixel.rgba);
        }
        assert!(pixel.certainty.value() < 1e-10);
    }
}

#[test]
fn every_filter_and_source_of_light() {
    for (seed, filter) in Filter::ALL.into_iter().enumerate() {
        // Midpoint at 1/2000 of a voxel: 10⁻⁷ where field and colour are continuous, a step's light where they jump.
        let slack = if filter.is_continuous() { 1e-6 } else { 1e-3 };
        let most = if filter == Filter::Gaussian { 1e-9 } else { 1e-10 };
        for emission in [false, true] {
            let scene = scene(colors(seed as u64).with_filter(filter), emission);
            let bound = compare(&format!("{filter}, emission {emission}"), &scene, slack);
            assert!(bound <= most, "{filter}: {bound:e}");
        }
    }
}

#[test]
fn shaded_and_modulated() {
    for gradient in [GradientMethod::CentralDifferences, GradientMethod::Analytic] {
        for modulated in [false, true] {
            let gradient_opacity = if modulated { vec![(0.05, 0.0), (0.3, 1.0), (0.4, 0.5)] } else { Vec::new() };
            let shading = Shading { gradient, gradient_opacity, ..Shading::default() };
            let shaded = Scene { shading: Some(Arc::new(shading)), ..scene(colors(9), false) };
            let bound = compare(&format!("{gradient:?}, {modulated}"), &shaded, 1e-4);
            assert!(bound <= 1e-9, "{gradient:?}: {bound:e}");
        }
    }
}

#[test]
fn every_operator() {
    for filter in [Filter::Trilinear, Filter::CatmullRom] {
        for compositing in [
            Compositing::Maximum,
            Compositing::Minimum,
            Compositing::Average,
            Compositing::First { threshold: 0.7 },
            Compositing::Accumulate { level: 0.4 },
        ] {
            let scene = Scene { compositing, ..scene(colors(5).with_filter(filter), false) };
            let name = format!("{filter}, {}", compositing.name());
            // Places are known to 1/20000 of a ray, on which colours change by less than a tenth per percent.
            let bound = compare(&name, &scene, 5e-4);
            // A smooth extreme's place is known to the root of its value's error.
            let most = if matches!(compositing, Compositing::Maximum | Compositing::Minimum) { 1e-4 } else { 1e-9 };
            assert!(bound <= most, "{name}: {bound:e}");
        }
    }
}

#[test]
fn of_equal_values_the_nearest_has_its_colour() {
    // A plateau of the largest value, red in front and green behind.
    let dims = [2, 2, 9];
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let at = |i: usize| i / 4;
    let values: Vec<u8> = (0..36).map(|i| if (2..7).contains(&at(i)) { 255 } else { 40 }).collect();
    let red: Vec<u16> = (0..36).map(|i| if at(i) < 4 { 65535 } else { 0 }).collect();
    let green: Vec<u16> = red.iter().map(|r| 65535 - r).collect();
    let grid = UniformGrid::new(dims, values, placement, Default::default()).unwrap();
    let colors = ColorGrid::new(GridVolume::new(grid.into(), Filter::Trilinear), [red, green, vec![0; 36]]).unwrap();
    let transfer = TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], 1.0)], OpacityRule::Power, 1.0).unwrap();
    let scene = Scene { compositing: Compositing::Maximum, ..Scene::new(Volume::from(colors), transfer) };
    let eye = DVec3::new(0.4, 0.6, -5.0);
    let projection = Projection::Orthographic { height: 0.1 };
    let camera = Camera { eye, target: eye + DVec3::Z, up: DVec3::Y, projection };
    let pixel = solve(&scene, &View::new(camera, [1, 1]))[0];
    assert!((pixel.rgba[0] - 1.0).abs() < 1e-9 && pixel.rgba[1] < 1e-9, "{:?}", pixel.rgba);
    assert!((pixel.depth - 7.0).abs() < 1e-9, "{}", pixel.depth);
    assert!(pixel.certainty.value() < 1e-4, "{:?}", pixel.certainty);
}
