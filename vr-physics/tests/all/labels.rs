//! Labelled grids: closed forms, and every filter against brute force through the field's values alone.

use std::sync::Arc;

use crate::brute::transfer;
use glam::{DMat3, DVec3};
use vr_core::labels::{LabelMap, LabelStyle, LabelledGrid};
use vr_core::{
    AnyGrid, Camera, Clip, Compositing, Control, ControlPoint, Field, Filter, GradientMethod, GridVolume, Model,
    OpacityRule, Placement, Ray, Rays, Scene, Shading, TransferFunction, UniformGrid, View, Volume, optics,
};
use vr_physics::Reference;

const RED: [f64; 3] = [0.8, 0.1, 0.05];
const GREEN: [f64; 3] = [0.1, 0.7, 0.2];

fn labelled_scene(labelled: LabelledGrid, transfer: &TransferFunction) -> Scene {
    let transfer = labelled.transfer(transfer).unwrap();
    Scene::new(Volume::Field(Arc::new(labelled)), transfer)
}

fn map(dims: [usize; 3], label: impl Fn([usize; 3]) -> u8, placement: Placement) -> Arc<LabelMap> {
    let [nx, ny, nz] = dims;
    let voxels: Vec<u8> = (0..nx * ny * nz).map(|i| label([i % nx, i / nx % ny, i / (nx * ny)])).collect();
    let grid = UniformGrid::new(dims, voxels, placement, Default::default()).unwrap();
    Arc::new(LabelMap::new(&AnyGrid::from(grid)).unwrap())
}

/// Two slabs of a label each in a volume of one extinction: depths add up, and each slab hides what is behind it.
#[test]
fn slabs_are_met_exactly() {
    let placement = Placement::from_spacing([1.0, 1.0, 0.5]).unwrap();
    let dims = [4, 4, 21];
    let values = UniformGrid::new(dims, vec![7.0f32; 336], placement, Default::default()).unwrap();
    let volume = Arc::new(GridVolume::new(values.into(), Filter::Trilinear));
    // Slices 4 to 8, then 11 to 12: voxels reach half a step to each side.
    let labels =
        map(dims, |[_, _, z]| [(4..9, 1), (11..13, 2)].iter().find(|s| s.0.contains(&z)).map_or(0, |s| s.1), placement);
    let base = TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], 0.2)], OpacityRule::Power, 1.0).unwrap();
    let style = |hidden: bool| {
        move |label| match label {
            1 => LabelStyle::Solid { color: RED, opacity: 0.4 },
            2 if hidden => LabelStyle::Hidden,
            2 => LabelStyle::Tinted { color: GREEN, opacity: 0.5 },
            _ => LabelStyle::VOLUME,
        }
    };
    let ray = Ray { origin: DVec3::new(1.3, 1.8, -7.0), direction: DVec3::Z };
    let any = View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 0.0, 0.0, None), [1, 1]);
    for hidden in [false, true] {
        let labelled = LabelledGrid::new(volume.clone(), labels.clone(), style(hidden)).unwrap();
        let scene = labelled_scene(labelled, &base);
        let solved = Reference::default().transport(&scene, &any, &ray).unwrap().unwrap();
        // Lengths, opacities of a unit, colours, from front to back.
        let parts = [
            (1.75, 0.2, [1.0; 3]),
            (2.5, 0.4, RED),
            (1.0, 0.2, [1.0; 3]),
            (1.0, if hidden { 0.0 } else { 0.1 }, GREEN),
            (3.75, 0.2, [1.0; 3]),
        ];
        let (mut light, mut clear) = ([0.0; 3], 1.0);
        for (length, opacity, color) in parts {
            let left = (1.0f64 - opacity).powf(length);
            light = std::array::from_fn(|c| light[c] + clear * (1.0 - left) * color[c]);
            clear *= left;
        }
        let off = (0..3).map(|c| (solved.radiance[c] - light[c]).abs()).fold(0.0, f64::max);
        let bound = solved.certainty.value();
        assert!(off <= bound + 1e-14 && bound < 1e-12, "{off} within {bound}");
        assert!((solved.transmittance() - clear).abs() <= bound + 1e-14);
    }
}

/// A solid of opacity 1 ends light where it begins; a clip plane through it shows it unlit.
#[test]
fn opaque_solids_are_walls() {
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let values = UniformGrid::new([9; 3], vec![0u8; 729], placement, Default::default()).unwrap();
    let volume = Arc::new(GridVolume::new(values.into(), Filter::Trilinear));
    let labels = map([9; 3], |p| u8::from(p.iter().all(|i| (2..7).contains(i))), placement);
    let clear = TransferFunction::new(vec![ControlPoint::new(0.0, [0.0; 3], 0.0)], OpacityRule::Power, 1.0).unwrap();
    let solid = |label| if label == 1 { LabelStyle::Solid { color: RED, opacity: 1.0 } } else { LabelStyle::VOLUME };
    let labelled = LabelledGrid::new(volume, labels, solid).unwrap();
    let shading = Shading { specular: 0.0, ..Shading::default() };
    let lit = shading.ambient + shading.diffuse;
    let scene = Scene { shading: Some(Arc::new(shading)), ..labelled_scene(labelled, &clear) };
    let ray = Ray { origin: DVec3::new(4.2, 4.1, -3.0), direction: DVec3::Z };
    let camera = Camera::framing((DVec3::ZERO, DVec3::ONE), 0.0, 0.0, None);
    for (clip, factor) in [(None, lit), (Some(4.3), 1.0)] {
        let planes = clip.map(|offset| vr_core::Plane { normal: DVec3::Z, offset }).into_iter().collect();
        let view = View { clip: Clip { crop: None, planes }, ..View::new(camera, [1, 1]) };
        let solved = Reference::default().transport(&scene, &view, &ray).unwrap().unwrap();
        assert_eq!(solved.depth, f64::INFINITY);
        let off = (0..3).map(|c| (solved.radiance[c] - factor * RED[c]).abs()).fold(0.0, f64::max);
        assert!(
            off <= solved.certainty.value() + 1e-14 && solved.certainty.value() < 1e-11,
            "{off}: {:?}",
            solved.certainty
        );
    }
}

/// Noise of a seed, in 0 to 1.
fn noise(seed: u64, i: u64) -> f64 {
    let mut x = (seed << 32 ^ i).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ x >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

/// A labelled grid of noise, and labels in lumps, on a lattice of their own if `apart`.
fn random(seed: u64, filter: Filter, apart: bool) -> LabelledGrid {
    let dims = [6, 7, 5];
    let samples: Vec<f32> = (0..210).map(|i| noise(seed, i) as f32).collect();
    let axes = DMat3::from_cols(DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.0, 0.8, 0.0), DVec3::new(0.2, 0.0, 1.3));
    let placement = Placement::new(DVec3::new(-1.0, 2.0, 0.5), axes).unwrap();
    let grid = UniformGrid::new(dims, samples, placement, Default::default()).unwrap();
    let volume = Arc::new(GridVolume::new(grid.into(), filter));
    let (dims, placement) = if apart {
        let axes =
            DMat3::from_rotation_y(0.4) * DMat3::from_rotation_z(0.7) * DMat3::from_diagonal(DVec3::new(0.9, 0.7, 1.1));
        ([5, 6, 4], Placement::new(DVec3::new(0.2, 3.0, 1.9), axes).unwrap())
    } else {
        (dims, placement)
    };
    let labels =
        map(dims, |[x, y, z]| (6.0 * noise(seed + 1, (x / 2 + 10 * (y / 3) + 100 * (z / 2)) as u64)) as u8, placement);
    let style = |label| match label {
        1 => LabelStyle::Solid { color: RED, opacity: 0.7 },
        2 => LabelStyle::Hidden,
        3 => LabelStyle::Tinted { color: GREEN, opacity: 0.8 },
        4 => LabelStyle::Solid { color: GREEN, opacity: 0.3 },
        5 => LabelStyle::Volume { opacity: 0.4 },
        _ => LabelStyle::VOLUME,
    };
    LabelledGrid::new(volume, labels, style).unwrap()
}

/// The midpoint rule between jumps of the field, by its values and gradients at points alone.
fn brute(scene: &Scene, field: &dyn Field, ray: &Ray, samples: usize) -> [f64; 4] {
    let (low, high) = field.bounds();
    let clip = Clip { crop: Some((low, high)), planes: vec![] };
    let Some([from, to]) = ray.inside(&clip) else { return [0.0; 4] };
    let mut ends = vec![from];
    field.jumps(ray, [from, to], &mut ends);
    ends.push(to);
    let reflect = scene.shading.as_ref().map(|s| s.along::<f64>(&scene.lights, ray.direction));
    let mut rgba = [0.0; 4];
    for part in ends.windows(2) {
        assert!(part[0] <= part[1], "jumps are in order");
        let h = (part[1] - part[0]) / samples as f64;
        let mut last = None::<f64>;
        for k in 0..samples {
            let at = ray.origin + ray.direction * (part[0] + (k as f64 + 0.5) * h);
            let value = field.value(at);
            // Values of a cell differ by less than 1, and codes by more.
            if let (Some(last), Some(value)) = (last, value) {
                assert!((last - value).abs() < 0.99 || part[0] == from || part[1] == to, "a jump was missed");
            }
            last = value.or(last);
            let Some(value) = value else { continue };
            let o = scene.transfer.at(value);
            let mut color = o.color;
            if let Some(along) = &reflect {
                let (factor, added) = along.reflect(field.gradient(at).unwrap().to_array());
                color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
            }
            let alpha = optics::opacity_of_depth(scene.transfer.extinction(o.opacity) * h);
            let clear = 1.0 - rgba[3];
            rgba = std::array::from_fn(|c| rgba[c] + clear * alpha * if c < 3 { color[c] } else { 1.0 });
        }
    }
    rgba
}

#[test]
fn every_filter_and_lattice_against_brute_force() {
    let mut seed = 0;
    for filter in Filter::ALL {
        for apart in [false, true] {
            for shaded in [None, Some(GradientMethod::CentralDifferences), Some(GradientMethod::Analytic)] {
                seed += 2;
                let labelled = random(seed, filter, apart);
                let labelled = if let Some(method) = shaded { labelled.with_gradient(method) } else { labelled };
                let field = Arc::new(labelled);
                let mut scene = Scene::new(Volume::Field(field.clone()), field.transfer(&transfer(1.0)).unwrap());
                scene.shading = shaded.map(|gradient| Arc::new(Shading { gradient, ..Shading::default() }));
                let view = View::new(Camera::framing(scene.bounds(), 35.0, 25.0, Some(40.0)), [5, 5]);
                let rays = Rays::new(&view).unwrap();
                let solved = Reference::new(1e-8).solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap();
                for (i, pixel) in solved.pixels.iter().enumerate() {
                    let ray = rays.at((i % 5) as f64 + 0.5, (i / 5) as f64 + 0.5);
                    let wanted = brute(&scene, &*field, &ray, 400);
                    let off = (0..4).map(|c| (pixel.rgba[c] - wanted[c]).abs()).fold(0.0, f64::max);
                    // The midpoint rule over kinks and steep highlights, in steps of a 400th of a stretch.
                    let slack = if shaded.is_some() { 1e-3 } else { 1e-4 };
                    assert!(
                        off < slack,
                        "{filter} apart {apart} {shaded:?}, pixel {i}: {:?}, not {wanted:?}",
                        pixel.rgba
                    );
                    assert!(
                        shaded.is_some() || filter == Filter::Gaussian || pixel.certainty.value() < 1e-7,
                        "{filter}: {:?}",
                        pixel.certainty
                    );
                }
            }
        }
    }
}

#[test]
fn codes_are_not_compared() {
    let scene = labelled_scene(random(5, Filter::Trilinear, false), &transfer(1.0));
    let refused = Scene { compositing: Compositing::Maximum, ..scene.clone() }.validate().unwrap_err();
    assert_eq!(refused.field, "render.compositing");
    // A mask shows the values themselves.
    let Volume::Field(_) = &scene.volume else { unreachable!() };
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let ramp: Vec<u8> = (0..27).collect();
    let grid = UniformGrid::new([3; 3], ramp, placement, Default::default()).unwrap();
    let volume = Arc::new(GridVolume::new(grid.into(), Filter::Trilinear));
    let labels = map([3; 3], |[_, _, z]| u8::from(z < 2), placement);
    let keep = |label| if label == 1 { LabelStyle::VOLUME } else { LabelStyle::Hidden };
    let scene = labelled_scene(LabelledGrid::new(volume, labels, keep).unwrap(), &transfer(1.0));
    let scene = Scene { compositing: Compositing::Maximum, ..scene };
    scene.validate().unwrap();
}
