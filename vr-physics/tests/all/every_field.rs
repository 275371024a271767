//! Every filter, shading and compositing scheme against brute force: many samples through the public sampler, no polynomials.

use std::sync::Arc;

use crate::brute::transfer;
use glam::{DMat3, DVec3};
use vr_core::field::{FunctionField, FunctionLine};
use vr_core::filter::{Lattice, Reconstruction};
use vr_core::phantom::{self, Phantom};
use vr_core::{
    Camera, Clip, Compositing, ContinuousModel, Control, DiscreteModel, Filter, GradientMethod, IndexRay,
    LatticeVisitor, Light, Medium, MediumBounds, Model, OpacityRule, Placement, Projection, Ray, Rays, Sampler,
    SamplerVisitor, Scene, SegmentTerm, Shading, TransferFunction, UniformGrid, View, Voxel, gradient_between_samples,
    optics,
};
use vr_physics::{Certainty, Optics, Reference, transport};

/// Waves on a slightly sheared 6×7×8 grid.
fn scene(filter: Filter) -> Scene {
    let dims = [6, 7, 8];
    let samples: Vec<f32> = (0..336)
        .map(|i| {
            let (x, y, z) = ((i % 6) as f32, (i / 6 % 7) as f32, (i / 42) as f32);
            0.5 + 0.3 * (0.9 * x + 0.4 * y).sin() + 0.25 * (1.1 * z - 0.7 * y).cos()
        })
        .collect();
    let axes = DMat3::from_cols(DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.0, 0.8, 0.0), DVec3::new(0.2, 0.0, 1.3));
    let placement = Placement::new(DVec3::new(-1.0, 2.0, 0.5), axes).unwrap();
    let volume = UniformGrid::new(dims, samples, placement, Default::default()).unwrap();
    let light = Light { direction: Some(DVec3::new(0.3, 1.0, 0.5)), color: [1.0, 0.8, 0.6] };
    Scene { lights: vec![Light::default(), light], ..Scene::new(volume.into(), transfer(1.0)).with_filter(filter) }
}

fn view(scene: &Scene) -> View {
    let camera = Camera::framing(scene.volume.bounds(), 35.0, 25.0, Some(40.0));
    View::new(camera, [6, 6])
}

fn shading(gradient: GradientMethod) -> Shading {
    Shading { gradient, ..Shading::default() }
}

/// Midpoint samples along a ray: position in the world's distance, value, world gradient.
struct March {
    ray: IndexRay,
    n: usize,
}

type Samples = Vec<(f64, f64, [f64; 3])>;

impl SamplerVisitor for &March {
    type Output = Samples;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Samples {
        let h = self.ray.length() / self.n as f64;
        (0..self.n)
            .map(|k| {
                let s = self.ray.start + (k as f64 + 0.5) * h;
                let (value, gradient) = sampler.value_and_gradient(self.ray.at(s).to_array());
                (s, value, gradient)
            })
            .collect()
    }
}

struct Central<'a>(&'a March, &'a mut Samples);

impl LatticeVisitor for Central<'_> {
    type Output = ();
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) {
        for (s, _, g) in self.1 {
            *g = gradient_between_samples(&lattice, self.0.ray.at(*s).to_array());
        }
    }
}

fn brute(scene: &Scene, view: &View, ray: &Ray, n: usize) -> Option<[f64; 4]> {
    let u = scene.volume.grid().unwrap();
    let march = March { ray: IndexRay::new(ray, u.placement(), u.dims(), &view.clip, f64::INFINITY)?, n };
    let mut samples = u.with_sampler(&march);
    if let Some(s) = &scene.shading
        && s.gradient == GradientMethod::CentralDifferences
    {
        u.with_lattice(Central(&march, &mut samples));
    }
    let h = march.ray.length() / n as f64;
    let value_pixel = |v: f64| {
        let o = scene.transfer.at(v);
        [o.color[0] * o.opacity, o.color[1] * o.opacity, o.color[2] * o.opacity, o.opacity]
    };
    let values = samples.iter().map(|s| s.1);
    match scene.compositing {
        Compositing::Maximum => return Some(value_pixel(values.fold(f64::NEG_INFINITY, f64::max))),
        Compositing::Minimum => return Some(value_pixel(values.fold(f64::INFINITY, f64::min))),
        Compositing::Average => return Some(value_pixel(values.sum::<f64>() / n as f64)),
        _ => {}
    }
    let along = scene.shading.as_ref().map(|s| (s, s.along::<f64>(&scene.lights, ray.direction)));
    let colored = |value: f64, g: [f64; 3]| {
        let color = scene.transfer.at(value).color;
        let g = u.placement().gradient_to_world(DVec3::from(g));
        match &along {
            None => (color, 1.0),
            Some((s, r)) => {
                let (factor, added) = r.reflect(g.to_array());
                (std::array::from_fn(|c| color[c] * factor[c] + added[c]), s.modulation(g.length()))
            }
        }
    };
    if let Compositing::First { threshold } = scene.compositing {
        let hit = samples.iter().find(|s| s.1 >= threshold);
        return Some(hit.map_or([0.0; 4], |s| {
            let (c, _): ([f64; 3], f64) = colored(s.1, s.2);
            [c[0], c[1], c[2], 1.0]
        }));
    }
    let level = if let Compositing::Accumulate { level } = scene.compositing { level } else { 1.0 };
    let (mut rgb, mut alpha) = ([0.0; 3], 0.0);
    for (_, value, g) in samples {
        let (color, factor) = colored(value, g);
        let step = optics::opacity_of_depth(scene.transfer.extinction_at(value) * factor * h);
        let step = step.min((level - alpha) / (1.0 - alpha));
        for c in 0..3 {
            rgb[c] += (1.0 - alpha) * step * color[c];
        }
        alpha += (1.0 - alpha) * step;
    }
    Some([rgb[0], rgb[1], rgb[2], alpha])
}

/// Compares all pixels; `slack` is what brute force may miss beyond the bound. Returns the largest bound.
fn compare(name: &str, scene: &Scene, slack: f64) -> Certainty {
    let view = view(scene);
    let solution = Reference::default().solve(scene, &view, &Model::Canonical, &Control::default()).unwrap();
    let rays = Rays::new(&view).unwrap();
    let mut seen = 0.0f64;
    for (i, pixel) in solution.pixels.iter().enumerate() {
        let ray = rays.at((i % 6) as f64 + 0.5, (i / 6) as f64 + 0.5);
        let Some(expected) = brute(scene, &view, &ray, 20_000) else {
            assert_eq!(pixel.rgba, [0.0; 4]);
            continue;
        };
        for c in 0..4 {
            let error = (pixel.rgba[c] - expected[c]).abs();
            assert!(error <= slack + pixel.certainty.value(), "{name}, pixel {i}: {:?} for {expected:?}", pixel.rgba);
            seen = seen.max(pixel.rgba[c]);
        }
    }
    assert!(seen > 0.1, "{name}: nothing to see");
    solution.certainty()
}

fn bound(name: &str, certainty: Certainty, most: f64) {
    let Certainty::Bound(b) = certainty else { panic!("{name}: {certainty:?} is no bound") };
    assert!(b <= most, "{name}: bound {b:e}");
}

#[test]
fn every_filter() {
    for filter in Filter::ALL {
        // Midpoint at 1/2000 of a voxel: 10⁻⁷ where the field is continuous, a step's opacity where it jumps.
        let slack = if filter.is_continuous() { 1e-6 } else { 1e-3 };
        // The Gaussian is interpolated: its remainder adds to the tolerance.
        let most = if filter == Filter::Gaussian { 1e-9 } else { 1e-10 };
        bound(filter.name(), compare(filter.name(), &scene(filter), slack), most);
    }
}

#[test]
fn every_filter_shaded() {
    for filter in Filter::ALL {
        for gradient in [GradientMethod::CentralDifferences, GradientMethod::Analytic] {
            let shaded = Scene { shading: Some(Arc::new(shading(gradient))), ..scene(filter) };
            let name = format!("{filter}, {gradient:?}");
            let slack = if filter.is_continuous() { 1e-4 } else { 1e-3 };
            let certainty = compare(&name, &shaded, slack);
            if filter != Filter::Gaussian || gradient == GradientMethod::CentralDifferences {
                bound(&name, certainty, 1e-9);
            }
        }
    }
}

#[test]
fn opacity_modulated_by_the_gradient() {
    let modulated = Shading {
        gradient_opacity: vec![(0.05, 0.0), (0.3, 1.0), (0.4, 0.5)],
        ..shading(GradientMethod::CentralDifferences)
    };
    let s = Scene { shading: Some(Arc::new(modulated)), ..scene(Filter::Trilinear) };
    bound("modulated", compare("modulated", &s, 1e-4), 1e-9);
}

#[test]
fn every_compositing_scheme() {
    for filter in [Filter::Trilinear, Filter::CatmullRom, Filter::Gaussian] {
        for compositing in [
            Compositing::Maximum,
            Compositing::Minimum,
            Compositing::Average,
            Compositing::First { threshold: 0.7 },
            Compositing::Accumulate { level: 0.4 },
        ] {
            let s = Scene { compositing, ..scene(filter) };
            let name = format!("{filter}, {}", compositing.name());
            // A picked value is only as good as the field: the Gaussian's is known to its remainder on 1/32 of a cell.
            let most = if filter == Filter::Gaussian { 1e-2 } else { 1e-9 };
            bound(&name, compare(&name, &s, 2e-4), most);
        }
    }
}

#[test]
fn clipped_is_what_the_interval_leaves() {
    let s = scene(Filter::Trilinear);
    let (low, high) = s.volume.bounds();
    let middle = 0.5 * (low + high);
    let clip = Clip {
        crop: Some((low, DVec3::new(middle.x, high.y, high.z))),
        planes: vec![vr_core::Plane { normal: DVec3::Y, offset: middle.y }],
    };
    let v = View { clip, ..view(&s) };
    let solution = Reference::default().solve(&s, &v, &Model::Canonical, &Control::default()).unwrap();
    let rays = Rays::new(&v).unwrap();
    let mut lit = 0;
    for (i, p) in solution.pixels.iter().enumerate() {
        let ray = rays.at((i % 6) as f64 + 0.5, (i / 6) as f64 + 0.5);
        let expected = brute(&s, &v, &ray, 20_000).unwrap_or_default();
        lit += usize::from(p.rgba[3] > 0.0);
        assert!((0..4).all(|c| (p.rgba[c] - expected[c]).abs() < 1e-6), "pixel {i}");
    }
    assert!(lit > 2 && lit < 36);
}

#[test]
fn analytic_fields_go_through_the_same_integrator() {
    for name in phantom::NAMES {
        let phantom: Arc<dyn Phantom> = phantom::by_name(name).unwrap().into();
        let field = FunctionField::of_phantom(Arc::clone(&phantom));
        let field = field.with_lipschitz(phantom.lipschitz_between_breakpoints());
        let points = phantom.transfer_points();
        let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
        let ray = Ray { origin: DVec3::new(-3.0, 0.21, 0.13), direction: DVec3::new(1.0, -0.04, 0.02).normalize() };
        let line = FunctionLine::new(&field, ray, 2.0, 4.0);
        let t = transport(&line, &Optics::new(&transfer, None), 1e-3, 1.0);
        let n = 200_000;
        let h = 2.0 / f64::from(n);
        let (mut tau, mut light) = (0.0, 0.0);
        for k in 0..n {
            let value = phantom.value(ray.origin + ray.direction * (2.0 + (f64::from(k) + 0.5) * h));
            let step = transfer.extinction_at(value) * h;
            light += libm::exp(-tau) * optics::opacity_of_depth(step) * transfer.at(value).color[0];
            tau += step;
        }
        let error = (t.radiance[0] - light).abs().max((t.opacity() - optics::opacity_of_depth(tau)).abs());
        let Certainty::Bound(b) = t.certainty else { panic!("{name}: {:?}", t.certainty) };
        // A step of 10⁻⁵ misplaces a jump by as much: τ is off by κ times that.
        assert!(error <= b + 2e-4, "{name}: error {error:e}, bound {b:e}");
        assert!(b < 0.2, "{name}: bound {b:e}");
    }
}

/// The scene's own field, told as a medium of slabs.
struct Slabs {
    scene: Scene,
    view: View,
    n: usize,
}

impl Slabs {
    fn slabs(&self, ray: &Ray) -> Vec<(f64, Medium)> {
        let u = self.scene.volume.grid().unwrap();
        let Some(ray) = IndexRay::new(ray, u.placement(), u.dims(), &self.view.clip, f64::INFINITY) else {
            return Vec::new();
        };
        let march = March { ray, n: self.n };
        let medium = |value: f64| {
            let kappa = self.scene.transfer.extinction_at(value);
            Medium { extinction: kappa, emission: self.scene.transfer.at(value).color.map(|c| c * kappa) }
        };
        let samples = u.with_sampler(&march);
        samples.into_iter().map(|(s, v, _)| (s + ray.offset, medium(v))).collect()
    }
}

impl DiscreteModel for Slabs {
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm> {
        let slabs = self.slabs(&Rays::new(&self.view).unwrap().at(x, y));
        let h = if slabs.len() > 1 { slabs[1].0 - slabs[0].0 } else { 0.0 };
        let term = |m: &Medium| {
            let tau = m.extinction * h;
            let weight = h * optics::source_weight(tau);
            SegmentTerm { transparency: libm::exp(-tau), light: m.emission.map(|q| q * weight) }
        };
        slabs.iter().map(|(_, m)| term(m)).collect()
    }
}

impl ContinuousModel for Slabs {
    fn breakpoints(&self, ray: &Ray) -> Vec<f64> {
        let slabs = self.slabs(ray);
        if slabs.len() < 2 {
            return Vec::new();
        }
        let h = slabs[1].0 - slabs[0].0;
        (0..=slabs.len()).map(|k| slabs[0].0 + (k as f64 - 0.5) * h).collect()
    }

    fn medium(&self, ray: &Ray, s: f64) -> Medium {
        let slabs = self.slabs(ray);
        let nearest = slabs.iter().min_by(|a, b| (a.0 - s).abs().total_cmp(&(b.0 - s).abs()));
        nearest.map_or_else(Medium::default, |n| n.1)
    }

    fn bounds(&self, _: &Ray, _: f64, _: f64) -> Option<MediumBounds> {
        Some(MediumBounds { extinction_slope: 0.0, emission_slope: 0.0 })
    }
}

#[test]
fn a_discrete_model_is_the_over_operator() {
    let s = scene(Filter::Trilinear);
    let v = view(&s);
    let model = Model::Discrete(Arc::new(Slabs { scene: s.clone(), view: v.clone(), n: 300 }));
    let solution = Reference::default().solve(&s, &v, &model, &Control::default()).unwrap();
    bound("discrete", solution.certainty(), 1e-12);
    let rays = Rays::new(&v).unwrap();
    for (i, p) in solution.pixels.iter().enumerate() {
        let ray = rays.at((i % 6) as f64 + 0.5, (i / 6) as f64 + 0.5);
        // The same 300 steps by the over operator; the step is a difference of distances from the eye, good to 10⁻¹³.
        let expected = brute(&s, &v, &ray, 300).unwrap_or_default();
        assert!((0..4).all(|c| (p.rgba[c] - expected[c]).abs() < 1e-11), "pixel {i}: {:?} for {expected:?}", p.rgba);
    }
}

#[test]
fn a_continuous_model_of_slabs_is_its_discrete_sum() {
    let s = scene(Filter::Trilinear);
    let camera = Camera { projection: Projection::Orthographic { height: 4.0 }, ..view(&s).camera };
    let v = View::new(camera, [2, 2]);
    let slabs = Arc::new(Slabs { scene: s.clone(), view: v.clone(), n: 12 });
    let reference = Reference::default();
    let solve = |model: Model| reference.solve(&s, &v, &model, &Control::default()).unwrap();
    let continuous = solve(Model::Continuous(Arc::clone(&slabs) as Arc<dyn ContinuousModel>));
    let discrete = solve(Model::Discrete(slabs));
    // The nodes at the ends of a slab see either neighbour: its nearest sample is a tie there, so they only agree roughly.
    for (a, b) in continuous.pixels.iter().zip(&discrete.pixels) {
        assert!((0..4).all(|c| (a.rgba[c] - b.rgba[c]).abs() < 2e-3), "{:?} {:?}", a.rgba, b.rgba);
        assert!(a.rgba[3] > 0.2);
    }
}
