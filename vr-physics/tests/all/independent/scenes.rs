//! Small scenes of the kinds that have been drawn wrongly, each made from a seed.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::{
    Calibration, Camera, Clip, Compositing, ControlPoint, Filter, GradientMethod, Light, OpacityRule, Placement, Plane,
    Projection, Scene, Shading, TransferFunction, UniformGrid, View, Volume,
};

/// A generator of random numbers: SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    pub fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    fn color(&mut self) -> [f64; 3] {
        let peak = self.of(&[1.0, 1.0, 1.0, 3.0]);
        std::array::from_fn(|_| if self.chance(0.1) { 0.0 } else { self.within(0.0, peak) })
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| self.within(-1.0, 1.0)));
            if v.length() > 0.2 {
                return v;
            }
        }
    }
}

/// Stored numbers: f32, or small integers.
fn samples(r: &mut Random, dims: [usize; 3]) -> Vec<f32> {
    let n: usize = dims.iter().product();
    let place = |i: usize| [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
    let (a, b) = (r.within(-1.0, 0.5), r.within(0.5, 2.0));
    let at = r.below(dims[0]);
    match r.below(8) {
        // Noise, waves, a constant, a constant block, labels, spikes, two halves, a ramp.
        0 => (0..n).map(|_| r.within(a, b) as f32).collect(),
        1 => {
            let k: [f64; 3] = std::array::from_fn(|_| r.within(0.2, 1.4));
            (0..n)
                .map(|i| {
                    let p = place(i);
                    ((0..3).map(|c| k[c] * p[c] as f64).sum::<f64>().sin()) as f32
                })
                .collect()
        }
        2 => vec![r.of(&[0.0, 1.0, a as f32, 7.0]); n],
        3 => (0..n)
            .map(|i| {
                let p = place(i);
                if p[0] + p[1] > dims[0] { r.within(a, b) as f32 } else { a as f32 }
            })
            .collect(),
        4 => (0..n).map(|_| r.below(4) as f32).collect(),
        5 => (0..n).map(|_| if r.chance(0.08) { b as f32 } else { a as f32 }).collect(),
        6 => (0..n).map(|i| if place(i)[0] < at { a as f32 } else { b as f32 }).collect(),
        _ => (0..n)
            .map(|i| {
                let p = place(i);
                (p[0] + 2 * p[1]) as f32 * 0.25
            })
            .collect(),
    }
}

fn volume(r: &mut Random, filter: Filter) -> (Volume, Vec<f64>) {
    let dims: [usize; 3] = std::array::from_fn(|_| 3 + r.below(4));
    let mut numbers = samples(r, dims);
    // Offsets, the ends of f32, and the usual.
    let (gain, offset) = r.of(&[
        (1.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.0),
        (1.0, 1e3),
        (1.0, 1e5),
        (0.5, 1e6),
        (4.0, 1e7),
        (1e-40, 0.0),
        (4e37, 0.0),
        (1e-7, 0.0),
    ]);
    for s in &mut numbers {
        *s = (f64::from(*s) * gain + offset) as f32;
    }
    let spacing = r.of(&[[1.0; 3], [1.0; 3], [0.7, 1.1, 1.6], [1.0, 30.0, 0.2], [1e-3, 1e-3, 2e-3]]);
    let direction = match r.below(5) {
        0 | 1 => DMat3::IDENTITY,
        2 => DMat3::from_cols(DVec3::X, DVec3::new(0.7, 0.7, 0.0), DVec3::new(0.1, -0.3, 0.9)),
        3 => DMat3::from_cols(r.direction(), DVec3::Y, DVec3::new(0.0, 0.3, 1.0)),
        _ => DMat3::from_cols(DVec3::X, DVec3::new(1.0, 0.01, 0.0), DVec3::Z),
    };
    let origin = r.of(&[DVec3::ZERO, DVec3::ZERO, DVec3::new(10.0, -3.0, 2.5), DVec3::new(1e5, -2e5, 1e4)]);
    let placement = Placement::oriented(origin, spacing, direction)
        .unwrap_or_else(|_| Placement::from_spacing(spacing).expect("a placement"));
    let tame = gain.log10().abs() < 10.0;
    let calibration = if tame {
        r.of(&[(1.0, 0.0), (1.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (-2.0, 5.0), (0.1, -3.0), (1e-3, 1024.0)])
    } else {
        r.of(&[(1.0, 0.0), (-1.0, 0.0)])
    };
    let calibration = Calibration { slope: calibration.0, intercept: calibration.1 };
    let values: Vec<f64> = numbers.iter().map(|&s| calibration.value(f64::from(s))).collect();
    let small = numbers.iter().all(|s| s.fract() == 0.0 && (0.0..255.0).contains(s));
    if small && r.chance(0.7) {
        let bytes: Vec<u8> = numbers.iter().map(|&s| s as u8).collect();
        return (UniformGrid::new(dims, bytes, placement, calibration).expect("a grid").into(), values);
    }
    match r.below(6) {
        // A mask, and noise.
        0 => {
            let half = dims[1] / 2;
            for (i, s) in numbers.iter_mut().enumerate() {
                if i / dims[0] % dims[1] < half {
                    *s = f32::NAN;
                }
            }
        }
        1 => numbers.iter_mut().for_each(|s| {
            if r.chance(0.06) {
                *s = f32::NAN
            }
        }),
        _ => {}
    }
    let _ = filter;
    (UniformGrid::new(dims, numbers, placement, calibration).expect("a grid").into(), values)
}

fn transfer(r: &mut Random, values: &[f64], spacing: f64) -> TransferFunction {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let span = if high > low { high - low } else { high.abs().max(1e-30) };
    let emits = r.chance(0.25);
    let point = |r: &mut Random, value: f64, opacity: f64| {
        let emission = emits.then(|| if r.chance(0.3) { [0.0; 3] } else { r.color() });
        ControlPoint { emission, ..ControlPoint::new(value, r.color(), opacity) }
    };
    let opacity = |r: &mut Random| match r.below(9) {
        0 | 1 => 0.0,
        2 => 1.0,
        3 => 0.999,
        4 => r.of(&[1e-12, 1e-7, 0.999_999_999]),
        _ => r.within(0.0, 1.0),
    };
    let some = |r: &mut Random| match r.below(4) {
        0 => values[r.below(values.len())],
        _ => low + span * r.within(-0.1, 1.1),
    };
    let mut points = Vec::new();
    match r.below(6) {
        // A ramp.
        0 => {
            let (a, b) = (opacity(r), opacity(r));
            points.push(point(r, low, a));
            points.push(point(r, low + span, b));
        }
        // A jump of colour and opacity, to 1 and to 0.999 as well.
        1 => {
            let v = some(r);
            let (a, b) = (opacity(r), r.of(&[1.0, 0.999, 0.5, 0.0]));
            points.push(point(r, v, a));
            points.push(point(r, v, b));
        }
        // A spike.
        2 => {
            let (v, width) = (some(r), span * r.of(&[1e-6, 1e-3, 0.03]));
            let top = opacity(r);
            points.extend([(v - width, 0.0), (v, top), (v + width, 0.0)].map(|(v, a)| point(r, v, a)));
        }
        // A constant.
        3 => {
            let (v, a) = (some(r), opacity(r));
            points.push(point(r, v, a));
        }
        // Anything.
        _ => {
            let n = 2 + r.below(5);
            let mut at: Vec<f64> = (0..n).map(|_| some(r)).collect();
            if r.chance(0.3) {
                at[1] = at[0];
            }
            at.sort_by(f64::total_cmp);
            for v in at {
                let a = opacity(r);
                points.push(point(r, v, a));
            }
        }
    }
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    let unit = spacing * r.of(&[0.02, 0.3, 1.0, 1.0, 3.0, 30.0]);
    let rule = r.of(&[OpacityRule::Power, OpacityRule::Power, OpacityRule::Extinction]);
    TransferFunction::new(points, rule, unit).expect("a transfer function")
}

fn shading(r: &mut Random, values: &[f64], spacing: f64) -> (Shading, Vec<Light>) {
    let span =
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - values.iter().copied().fold(f64::INFINITY, f64::min);
    let steep = span / spacing;
    let mut lights = vec![Light { direction: None, color: r.color() }];
    if r.chance(0.5) {
        lights[0].direction = Some(r.direction());
    }
    if r.chance(0.2) {
        lights.push(Light { direction: Some(r.direction()), color: r.color() });
    }
    let gradient_opacity = match r.below(5) {
        0 => vec![(0.0, 0.5)],
        1 if steep > 0.0 => vec![(0.0, 0.0), (steep * r.within(0.1, 1.0), 1.0)],
        2 if steep > 0.0 => vec![(0.1 * steep, 0.0), (0.3 * steep, 1.0), (0.4 * steep, 0.5)],
        _ => Vec::new(),
    };
    let shading = Shading {
        ambient: r.within(0.0, 1.0),
        diffuse: r.within(0.0, 1.0),
        specular: r.of(&[0.0, 0.5]),
        power: r.of(&[1.0, 2.0, 20.0, 7.5]),
        gradient: r.of(&[GradientMethod::CentralDifferences, GradientMethod::Analytic]),
        gradient_opacity,
    };
    (shading, lights)
}

fn view(r: &mut Random, volume: &Volume) -> View {
    let grid = volume.grid().expect("a grid");
    let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
    let place = |p: DVec3| grid.placement().to_world(p * last);
    let diagonal = (place(DVec3::ONE) - place(DVec3::ZERO)).length();
    let target = place(DVec3::from_array(std::array::from_fn(|_| r.within(0.2, 0.8))));
    let axes = [DVec3::X, DVec3::Y, -DVec3::Z];
    let toward = if r.chance(0.25) { r.of(&axes) } else { r.direction().normalize() };
    let distance = r.of(&[2.0, 2.0, 2.0, 3.0, 0.2, 0.05, 1e3, 1e6]);
    let eye = target - toward * (diagonal * distance);
    let up = axes.into_iter().find(|a| a.cross(toward).length() > 0.3).expect("an up");
    let projection = if r.chance(0.6) || distance > 100.0 {
        Projection::Orthographic { height: diagonal * r.of(&[0.3, 0.7]) }
    } else {
        Projection::Perspective { fov: r.of(&[15.0, 45.0, 100.0]) }
    };
    let mut clip = Clip::default();
    if r.chance(0.1) {
        let (a, b) = volume.bounds();
        clip.crop = Some((a + (b - a) * 0.15, b - (b - a) * 0.2));
    }
    if r.chance(0.1) {
        let normal = r.direction();
        clip.planes.push(Plane { normal, offset: normal.dot(target) - 0.1 * diagonal * normal.length() });
    }
    let size = [1 + r.below(4) as u32, 1 + r.below(4) as u32];
    View { clip, ..View::new(Camera { eye, target, up, projection }, size) }
}

/// The scene of a seed with a transfer function of value and gradient in place of its own.
pub fn scene_with_rows(seed: u64) -> (Scene, View, [u32; 2]) {
    let (mut scene, view, pixel) = scene(seed);
    let mut r = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5eed);
    let r = &mut r;
    let spacing = scene.volume.mean_spacing();
    let (low, high) = scene.volume.value_range().unwrap_or((0.0, 1.0));
    let steep = if high > low { (high - low) / spacing } else { 1.0 };
    let emits = r.chance(0.25);
    // One function after the other, until so many are of the same rule and kind.
    let rule = scene.transfer.rule();
    let unit = scene.transfer.unit_distance();
    let mut rows = Vec::new();
    let mut gradient = if r.chance(0.5) { 0.0 } else { steep * r.within(0.0, 0.3) };
    for _ in 0..1 + r.below(4) {
        let points = transfer(r, &[low, high, 0.5 * (low + high)], spacing).points().to_vec();
        let change = |p: ControlPoint| ControlPoint {
            opacity: if rule == OpacityRule::Power { p.opacity.min(0.999) } else { p.opacity },
            emission: emits.then(|| p.emission.unwrap_or(p.color)),
            ..p
        };
        rows.push((gradient, points.into_iter().map(change).collect()));
        gradient += steep * r.of(&[1e-3, 0.05, 0.2, 0.5]) * r.within(0.5, 1.0);
    }
    scene.transfer = Arc::new(TransferFunction::of_rows(rows, rule, unit).expect("rows"));
    if !scene.compositing.integrates_light() {
        scene.compositing = Compositing::Over;
    }
    if let Some(shading) = &mut scene.shading {
        Arc::make_mut(shading).gradient_opacity.clear();
    }
    (scene, view, pixel)
}

/// The scene of a seed, and a pixel of it.
pub fn scene(seed: u64) -> (Scene, View, [u32; 2]) {
    let mut r = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let r = &mut r;
    use Filter::*;
    let filter = r.of(&[
        Trilinear, Trilinear, Trilinear, Trilinear, Trilinear, Nearest, Nearest, Nearest, BSpline, CatmullRom, Gaussian,
    ]);
    let (volume, values) = volume(r, filter);
    let spacing = volume.mean_spacing();
    let transfer = transfer(r, &values, spacing);
    let shading = r.chance(0.3).then(|| shading(r, &values, spacing));
    let threshold = values[r.below(values.len())] * 0.5 + values[r.below(values.len())] * 0.5;
    let compositing = match r.below(10) {
        0 => Compositing::Maximum,
        1 => Compositing::Minimum,
        2 => Compositing::Average,
        3 => Compositing::First { threshold },
        4 => Compositing::Accumulate { level: r.of(&[0.5, 0.9, 0.2, 0.999_999]) },
        _ => Compositing::Over,
    };
    let view = view(r, &volume);
    let pixel = [r.below(view.size[0] as usize) as u32, r.below(view.size[1] as usize) as u32];
    let mut scene = Scene { compositing, ..Scene::new(volume.with_filter(filter), transfer) };
    if let Some((shading, lights)) = shading {
        (scene.shading, scene.lights) = (Some(Arc::new(shading)), lights);
    }
    (scene, view, pixel)
}
