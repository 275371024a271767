//! Scenes, views and settings through which two ways of drawing are compared, and the comparison.

use std::sync::Arc;

use proptest::prelude::*;
use vr_core::*;
use vr_physics::check::pictures::*;
use vr_physics::check::strategies::{Kind, scene_of};
use vr_physics::check::{FixedLayer, TestScene};
use vr_texslice::{Blend, Format, Proxy, TextureSlicer};

pub const FORMATS: [Format; 6] =
    [Format::Scalar, Format::PreIntegrated, Format::Compressed, Format::Rgba, Format::LuminanceAlpha, Format::Paletted];
pub const PROXIES: [Proxy; 3] = [Proxy::Planes, Proxy::Shells, Proxy::Stacks];
pub const OPERATORS: [Compositing; 6] = [
    Compositing::Over,
    Compositing::Accumulate { level: 0.3 },
    Compositing::Average,
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::First { threshold: 0.45 },
];

/// Ways in which a scene looks at gradients: shading by either kind of them, opacity by factors and by rows, with shading and without.
pub fn looks(scene: &Scene) -> Vec<Scene> {
    let steepest = 12.0;
    let shaded = |shading: Shading| Scene { shading: Some(Arc::new(shading)), ..scene.clone() };
    let factors = vec![(0.02 * steepest, 0.0), (0.2 * steepest, 1.0), (steepest, 1.7)];
    let analytic = || Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    vec![
        scene.clone(),
        shaded(Shading::default()),
        shaded(analytic()),
        shaded(Shading { gradient_opacity: factors.clone(), ..Shading::default() }),
        shaded(Shading { gradient_opacity: factors, ..analytic() }),
        with_rows(scene, steepest),
        with_rows(&shaded(analytic()), steepest),
    ]
}

/// The first two of them, and of the others that whose turn it is in a view: pictures of all of them in all views would take minutes.
pub fn looks_of_view(scene: &Scene, view: usize) -> Vec<Scene> {
    let mut looks = looks(scene);
    let other = looks.swap_remove(2 + view % (looks.len() - 2));
    looks.truncate(2);
    looks.push(other);
    looks
}

/// The scene with a transfer function by gradient: half as dense in flat regions as its own, and denser in steep ones, all but half as steep as `steepest`.
pub fn with_rows(scene: &Scene, steepest: f64) -> Scene {
    let transfer = &scene.transfer;
    let row = |share: f64| -> Vec<ControlPoint> {
        let of = |p: &ControlPoint| ControlPoint { opacity: (share * p.opacity).min(0.99), ..*p };
        transfer.points().iter().map(of).collect()
    };
    let rows = vec![(0.0, row(0.5)), (0.1 * steepest, row(0.0)), (0.5 * steepest, row(1.5))];
    let rows = TransferFunction::of_rows(rows, transfer.rule(), transfer.unit_distance()).unwrap();
    Scene { transfer: Arc::new(rows), ..scene.clone() }
}

/// A random scene, of four one with rows by gradient where these mean anything.
pub fn random_scene(kinds: &[Kind]) -> impl Strategy<Value = TestScene> + use<> {
    (scene_of(kinds), 0..4).prop_map(|(test, choice)| if choice == 0 { by_slope(test) } else { test })
}

/// The scene with rows by gradient, up to half of the steepest slope; as it is where no light is gathered, or slopes cannot be told apart.
pub fn by_slope(test: TestScene) -> TestScene {
    let grid = test.scene.volume.grid().filter(|_| test.scene.compositing.integrates_light());
    let range = grid.and_then(|grid| grid.value_range()).map(|(low, high)| high - low);
    let steepest = range.map_or(0.0, |range| range / test.scene.volume.mean_spacing());
    if !(steepest > 1e-300 && steepest < 1e50) {
        return test;
    }
    let flat = |shading: &Arc<Shading>| Arc::new(Shading { gradient_opacity: Vec::new(), ..Shading::clone(shading) });
    let scene = Scene { shading: test.scene.shading.as_ref().map(flat), ..test.scene };
    TestScene { scene: with_rows(&scene, steepest), view: test.view }
}

/// Returns the pictures of two renderers; `None` if both refuse, for the same reason.
pub fn both(renderers: [TextureSlicer; 2], scene: &Scene, view: &View) -> Option<[Rendered; 2]> {
    let control = Control::default();
    let [first, second] = renderers.each_ref().map(|renderer| {
        let drawn = renderer.prepare(scene, &control);
        drawn.and_then(|mut prepared| prepared.render(view, &control))
    });
    match (first, second) {
        (Ok(first), Ok(second)) => Some([first, second]),
        (Err(first), Err(second)) => {
            assert_eq!(first.to_string(), second.to_string());
            None
        }
        (first, second) => panic!("{renderers:?}: {:?} and {:?}", first.err(), second.err()),
    }
}

/// Grey fog of so many samples along an edge.
pub fn grey<T: phantom::Quantize>(samples: usize) -> Scene
where
    AnyGrid: From<UniformGrid<T>>,
{
    let mut scene = phantom_scene::<T>("fog", samples, 1.0);
    let mut points = scene.transfer.points().to_vec();
    points.iter_mut().for_each(|p| p.color = [p.color[1]; 3]);
    let transfer = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance());
    scene.transfer = Arc::new(transfer.unwrap());
    scene
}

/// Views in parallel and in perspective, along an axis, clipped, and from inside, with rays in all directions. `second`: azimuth and elevation of
/// the second one, in degrees.
pub fn views(scene: &Scene, size: [u32; 2], second: [f64; 2]) -> Vec<View> {
    let from = |azimuth, elevation, fov| View { size, ..view(scene, azimuth, elevation, fov, size[1]) };
    let cut = Plane { normal: glam::DVec3::new(2.0, 0.6, -0.4), offset: 0.2 };
    let crop = Some((glam::DVec3::splat(-0.7), glam::DVec3::new(0.8, 0.5, 0.9)));
    let clipped = View { clip: Clip { crop, planes: vec![cut] }, ..from(33.0, 21.0, Some(40.0)) };
    let mut inside = from(20.0, 10.0, Some(110.0));
    let (low, high) = scene.volume.bounds();
    let eye = low + (high - low) * glam::DVec3::new(0.6, 0.45, 0.3);
    inside.camera.target = eye + (inside.camera.target - inside.camera.eye);
    inside.camera.eye = eye;
    vec![from(0.0, 0.0, None), from(second[0], second[1], None), from(140.0, -30.0, Some(80.0)), clipped, inside]
}

/// The scene with an opaque plane through its middle, as seen in a view.
pub fn layered(scene: &Scene, view: &View) -> Scene {
    let rays = Rays::new(view).unwrap();
    let width = view.size[0];
    let pixel = |i: u32| {
        let ray = rays.at(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        let middle = scene.volume.bounds().0 * 0.5 + scene.volume.bounds().1 * 0.5;
        ([0.3, 0.6, 0.1], (ray.direction.dot(middle - ray.origin)).max(0.2) as f32)
    };
    FixedLayer::new(view, pixel).among(scene)
}

/// Draws a scene in some views in two ways, in every format and kind of slices, under every operator and blend, and looking at gradients in all
/// ways in turn. Pictures must be the same, bit for bit, and so must counts.
///
/// `spacing` is the distance of slices in each view; `both` draws a picture in both ways, `None` if both refuse. Returns the number of pictures and
/// that of their fragments.
pub fn alike_in_every_setting(
    scene: &Scene,
    views: &[View],
    spacing: impl Fn(usize) -> f64,
    both: impl Fn(&TextureSlicer, &Scene, &View) -> Option<[Rendered; 2]>,
) -> (usize, u64) {
    let (mut drawn, mut fragments) = (0, 0);
    for (k, view) in views.iter().enumerate() {
        for (format, proxy) in FORMATS.iter().flat_map(|&f| PROXIES.map(|p| (f, p))) {
            for (compositing, blend) in
                OPERATORS.iter().flat_map(|&c| [Blend::FrontToBack, Blend::BackToFront].map(|b| (c, b)))
            {
                for scene in looks_of_view(scene, k) {
                    let scene = Scene { compositing, ..scene };
                    let slice_spacing = spacing(k);
                    let renderer =
                        TextureSlicer { format, proxy, blend, slice_spacing, ..TextureSlicer::brute_force() };
                    let Some([one, other]) = both(&renderer, &scene, view) else { continue };
                    let how = format!("{renderer:?} {compositing:?} {:?} {:?}", scene.shading, view.camera);
                    assert!(one.frame == other.frame, "{how}");
                    // Nothing is left out, so both ways have found every fragment, and none twice.
                    assert_eq!(one.stats.counts, other.stats.counts, "{how}");
                    drawn += 1;
                    fragments += other.stats.counts.samples;
                }
            }
        }
    }
    (drawn, fragments)
}
