//! Scenes made from scenes, whose pictures follow from those of the originals.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Clip, Control, ControlPoint, Layer, Light, Plane, Projection, Scene, Shading, Surfaces, TransferFunction,
};

use super::fixed_layer::FixedLayer;
use super::test_scene::TestScene;
use super::transformed_volume::{quarter_turned as quarter_turned_volume, scaled as scaled_volume};

/// The scene with another transfer function of the same kind.
fn with_points(scene: &Scene, change: impl Fn(usize, &ControlPoint) -> ControlPoint, unit_distance: f64) -> Scene {
    let t = &scene.transfer;
    let points = t.points().iter().enumerate().map(|(i, p)| change(i, p)).collect();
    let transfer = TransferFunction::new(points, t.rule(), unit_distance).expect("still a valid transfer function");
    Scene { transfer: Arc::new(transfer), ..scene.clone() }
}

/// The scene with every colour and every emission times a factor of its control point's number. Opacity stays. Without a
/// highlight the picture is linear in these.
///
/// # Panics
/// Panics if a factor is negative or not finite.
pub fn with_emission_times(test: &TestScene, factor: impl Fn(usize) -> f64) -> TestScene {
    let change = |i: usize, p: &ControlPoint| ControlPoint {
        color: p.color.map(|c| c * factor(i)),
        emission: p.emission.map(|e| e.map(|x| x * factor(i))),
        ..*p
    };
    let scene = with_points(&test.scene, change, test.scene.transfer.unit_distance());
    TestScene { scene, view: test.view.clone() }
}

/// The scene without the highlights of its shading, which add light that is not the volume's.
pub fn without_highlights(test: &TestScene) -> TestScene {
    let shading = test.scene.shading.as_ref().map(|s| Arc::new(Shading { specular: 0.0, ..(**s).clone() }));
    TestScene { scene: Scene { shading, ..test.scene.clone() }, view: test.view.clone() }
}

/// The world `s` times as large, with κ and q divided by `s`: the same picture, to the last bit where `s` is a power of two.
/// Depths are `s` times as large, those of a layer, too.
///
/// # Panics
/// Panics if `s` is not positive, or takes a number beyond what f64 holds.
pub fn scaled_world(test: &TestScene, s: f64) -> TestScene {
    let unit_distance = test.scene.transfer.unit_distance() * s;
    let change = |_: usize, p: &ControlPoint| ControlPoint { emission: p.emission.map(|e| e.map(|x| x / s)), ..*p };
    let mut scene = with_points(&test.scene, change, unit_distance);
    scene.volume = scaled_volume(&test.scene.volume, s);
    scene.shading = test.scene.shading.as_ref().map(|shading| {
        let gradient_opacity = shading.gradient_opacity.iter().map(|&(magnitude, f)| (magnitude / s, f)).collect();
        Arc::new(Shading { gradient_opacity, ..(**shading).clone() })
    });
    let mut view = test.view.clone();
    let layer = test.scene.layer(&test.view, &Control::default()).expect("a test's view is valid");
    scene.surfaces = layer.map(|layer| {
        let pixels = layer.pixels.iter().map(|&(color, depth)| (color, (f64::from(depth) * s) as f32));
        Arc::new(FixedLayer(Layer { pixels: pixels.collect() })) as Arc<dyn Surfaces>
    });
    view.camera.eye *= s;
    view.camera.target *= s;
    if let Projection::Orthographic { height } = &mut view.camera.projection {
        *height *= s;
    }
    view.clip = Clip {
        crop: view.clip.crop.map(|(low, high)| (low * s, high * s)),
        planes: view.clip.planes.iter().map(|p| Plane { offset: p.offset * s, ..*p }).collect(),
    };
    TestScene { scene, view }
}

/// Everything turned by 90° about a world axis (0 x, 1 y, 2 z), counter-clockwise seen from its tip: camera, clip and lights; and
/// the values are laid out anew, so that two axes of a grid swap and one of them runs the other way. The same picture, up to
/// rounding (the nearest filter excepted, which takes the voxel of higher index at the middle between two).
///
/// A grid whose axes are those of the world keeps this.
///
/// # Panics
/// Panics if `axis` is above 2.
pub fn quarter_turned(test: &TestScene, axis: usize) -> TestScene {
    // The turn takes axis a to axis b and axis b to minus a.
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    let turn = |v: DVec3| {
        let mut turned = v;
        turned[b] = v[a];
        // Not −v, which would fill scene files with −0.
        turned[a] = 0.0 - v[b];
        turned
    };
    let mut view = test.view.clone();
    let camera = &mut view.camera;
    (camera.eye, camera.target, camera.up) = (turn(camera.eye), turn(camera.target), turn(camera.up));
    view.clip = Clip {
        crop: view.clip.crop.map(|(low, high)| {
            let (p, q) = (turn(low), turn(high));
            (p.min(q), p.max(q))
        }),
        planes: view.clip.planes.iter().map(|p| Plane { normal: turn(p.normal), ..*p }).collect(),
    };
    let mut scene = test.scene.clone();
    scene.volume = quarter_turned_volume(&test.scene.volume, (a, b), turn);
    scene.lights = scene.lights.iter().map(|l| Light { direction: l.direction.map(turn), ..*l }).collect();
    TestScene { scene, view }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use glam::DMat3;
    use vr_core::GridVolume;

    fn field(volume: &GridVolume, world: DVec3) -> f64 {
        volume.stored_at(volume.placement().to_index(world).to_array())
    }

    #[test]
    fn a_quarter_turn_takes_the_field_along() {
        let case = cases::by_name("full-u16").unwrap();
        let test = TestScene { scene: case.scene, view: case.view };
        let before = test.scene.volume.grid().unwrap();
        let turns: [fn(DVec3) -> DVec3; 3] =
            [|v| DVec3::new(v.x, -v.z, v.y), |v| DVec3::new(v.z, v.y, -v.x), |v| DVec3::new(-v.y, v.x, v.z)];
        for (axis, turn) in turns.into_iter().enumerate() {
            let turned = quarter_turned(&test, axis);
            let after = turned.scene.volume.grid().unwrap();
            assert!(after.placement().axes().abs_diff_eq(DMat3::IDENTITY, 0.0), "still along the world's axes");
            for p in [DVec3::new(1.25, 7.5, 3.125), DVec3::new(15.0, 0.5, 8.75)] {
                assert_eq!(field(before, p), field(after, turn(p)), "axis {axis}");
            }
            assert_eq!(turned.view.camera.eye, turn(test.view.camera.eye));
        }
    }

    #[test]
    fn four_quarter_turns_are_none() {
        let case = cases::by_name("anisotropy").unwrap();
        let test = TestScene { scene: case.scene, view: case.view };
        for axis in 0..3 {
            let back = (0..4).fold(test.clone(), |t, _| quarter_turned(&t, axis));
            assert_eq!(back.scene_file().unwrap(), test.scene_file().unwrap());
        }
    }

    #[test]
    fn scaling_there_and_back_is_nothing() {
        let case = cases::by_name("bright").unwrap();
        let test = TestScene { scene: case.scene, view: case.view };
        let back = scaled_world(&scaled_world(&test, 8.0), 0.125);
        assert_eq!(back.scene_file().unwrap(), test.scene_file().unwrap());
        assert_ne!(scaled_world(&test, 8.0).scene_file().unwrap(), test.scene_file().unwrap());
    }
}
