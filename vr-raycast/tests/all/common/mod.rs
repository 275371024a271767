//! Small scenes, and pictures of them.
use glam::DVec3;
use vr_core::phantom;
use vr_core::*;
use vr_physics::Reference;
use vr_physics::check::pictures::error;
use vr_physics::metrics::Metrics;
use vr_raycast::RayCaster;

/// A grid of f32 samples of a function of the index.
pub fn grid(dims: [usize; 3], placement: Placement, f: impl Fn(f64, f64, f64) -> f64) -> UniformGrid<f32> {
    let mut samples = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                samples.push(f(x as f64, y as f64, z as f64) as f32);
            }
        }
    }
    UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap()
}

/// The same with unit spacing, as a volume.
pub fn volume(dims: [usize; 3], f: impl Fn(f64, f64, f64) -> f64) -> Volume {
    grid(dims, Placement::from_spacing([1.0; 3]).unwrap(), f).into()
}

/// A transfer function under the power rule from (value, colour, opacity).
pub fn transfer(points: &[(f64, [f64; 3], f64)], unit_distance: f64) -> TransferFunction {
    let points = points.iter().map(|&(v, c, a)| ControlPoint::new(v, c, a)).collect();
    TransferFunction::new(points, OpacityRule::Power, unit_distance).unwrap()
}

/// Everything of opacity `alpha` a unit, white.
pub fn homogeneous(alpha: f64) -> TransferFunction {
    transfer(&[(0.0, [1.0; 3], alpha)], 1.0)
}

/// One pixel, its ray parallel to −z through a world point.
pub fn down(x: f64, y: f64) -> View {
    let eye = DVec3::new(x, y, 1000.0);
    let projection = Projection::Orthographic { height: 1.0 };
    View::new(Camera { eye, target: eye - DVec3::Z, up: DVec3::Y, projection }, [1, 1])
}

/// An oblique orthographic view of all of a scene.
pub fn oblique(scene: &Scene, size: u32) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [size, size])
}

/// Returns the error of an oblique picture of 24² pixels against the correct pixels.
pub fn oblique_error(scene: &Scene, caster: &RayCaster) -> Metrics {
    error(caster, scene, &oblique(scene, 24))
}

/// Returns the error of a picture of 16² pixels, parallel or with a field of view, against the correct pixels.
pub fn framed_error(scene: &Scene, caster: &RayCaster, fov: Option<f64>) -> Metrics {
    error(caster, scene, &View::new(Camera::framing(scene.bounds(), 35.0, 25.0, fov), [16, 16]))
}

/// A picture by default control.
pub fn render(caster: &RayCaster, scene: &Scene, view: &View) -> Rendered {
    let control = Control::default();
    caster.prepare(scene, &control).unwrap().render(view, &control).unwrap()
}

/// Colour and depth of a view's first pixel.
pub fn pixel(caster: &RayCaster, scene: &Scene, view: &View) -> ([f32; 4], f32) {
    let frame = render(caster, scene, view).frame;
    (frame.pixels()[0], frame.depth().unwrap()[0])
}

/// The true picture of a scene, to 10⁻⁷: a frame holds f32.
pub fn truth(scene: &Scene, view: &View) -> Frame {
    let solution = Reference::new(1e-7).solve(scene, view, &Model::Canonical, &Control::default()).unwrap();
    let rgba = solution.pixels.iter().map(|p| p.rgba.map(|x| x as f32)).collect();
    let depth = solution.pixels.iter().map(|p| p.depth as f32).collect();
    Frame::new(view.size, rgba, Some(depth))
}

/// The largest difference of any component, divided by max(1, the largest component of the second picture).
pub fn max_error(got: &Frame, want: &Frame) -> f64 {
    let all = |f: &Frame| f.pixels().iter().flatten().map(|&x| f64::from(x)).collect::<Vec<_>>();
    let (got, want) = (all(got), all(want));
    let peak = want.iter().fold(1.0, |p: f64, x| p.max(x.abs()));
    got.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
}

/// Asserts all components within a bound.
pub fn assert_close(got: [f32; 4], want: [f64; 4], bound: f64, what: &str) {
    for c in 0..4 {
        assert!((f64::from(got[c]) - want[c]).abs() <= bound, "{what}: {got:?}, expected {want:?}");
    }
}

/// Root mean square of the difference over all components: averaged over rays, it falls evenly.
pub fn rms(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sum: f64 = pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    (sum / (4.0 * a.pixels().len() as f64)).sqrt()
}

/// The phantoms without jumps, each with its own transfer function.
pub fn phantom_scenes(n: usize) -> Vec<(&'static str, Scene)> {
    ["marschner-lobb", "blobs", "fog", "hydrogen"]
        .map(|name| {
            let phantom = phantom::by_name(name).unwrap();
            let grid = phantom::sample::<f32>(&*phantom, [n; 3]).unwrap();
            let unit = phantom::TRANSFER_UNIT_DISTANCE;
            let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, unit).unwrap();
            (name, Scene::new(grid.into(), transfer))
        })
        .to_vec()
}

/// Numbers from 0 to 1, one after the other, by a seed (Marsaglia's xorshift, 2003).
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}
