//! Scenes made from scenes, whose pictures follow from those of the originals.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::{
    AnyGrid, CellMesh, Clip, Control, ControlPoint, Layer, Light, Placement, Plane, Projection, Scene, Shading,
    Surfaces, TransferFunction, UniformGrid, Volume, Voxel, with_grid,
};

use super::fixed_layer::FixedLayer;
use super::test_scene::TestScene;

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
    scene.volume = match &test.scene.volume {
        Volume::Cells(mesh) => with_vertices(mesh, |v| v * s),
        _ => {
            let old = placement(&test.scene);
            let axes = DMat3::from_cols(old.axes().x_axis * s, old.axes().y_axis * s, old.axes().z_axis * s);
            with_placement(&test.scene, Placement::new(old.origin() * s, axes).expect("still a placement"))
        }
    };
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
/// the voxels are laid out anew, so that two axes of the grid swap and one of them runs the other way. The same picture, up to
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
    scene.volume = match &test.scene.volume {
        Volume::Cells(mesh) => with_vertices(mesh, turn),
        _ => on_grid(&test.scene, quarter_turned_grid(&test.scene, (a, b), turn)),
    };
    scene.lights = scene.lights.iter().map(|l| Light { direction: l.direction.map(turn), ..*l }).collect();
    TestScene { scene, view }
}

/// Voxel i of the old grid becomes voxel j of the new one: j_b = i_a, j_a = n_b − 1 − i_b.
fn quarter_turned_grid(scene: &Scene, (a, b): (usize, usize), turn: impl Fn(DVec3) -> DVec3) -> AnyGrid {
    fn build<T: Voxel>(grid: &UniformGrid<T>, (a, b): (usize, usize), placement: Placement) -> UniformGrid<T> {
        let old = grid.dims();
        let mut dims = old;
        dims.swap(a, b);
        let mut samples = Vec::with_capacity(grid.samples().len());
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let j = [x, y, z];
                    let mut i = j;
                    i[a] = j[b];
                    i[b] = old[b] - 1 - j[a];
                    samples.push(grid.samples()[(i[2] * old[1] + i[1]) * old[0] + i[0]]);
                }
            }
        }
        UniformGrid::new(dims, samples, placement, grid.calibration()).expect("still a grid")
    }
    let old = placement(scene);
    let columns = [old.axes().x_axis, old.axes().y_axis, old.axes().z_axis];
    let mut axes = columns.map(&turn);
    axes[b] = turn(columns[a]);
    axes[a] = DVec3::ZERO - turn(columns[b]);
    let steps = with_grid!(grid(scene), g => g.dims()[b] - 1) as f64;
    let origin = turn(old.origin() + columns[b] * steps);
    let placement = Placement::new(origin, DMat3::from_cols(axes[0], axes[1], axes[2])).expect("still a placement");
    with_grid!(grid(scene), g => build(g, (a, b), placement).into())
}

/// A mesh with its vertices in other places.
fn with_vertices(mesh: &CellMesh, moved: impl Fn(DVec3) -> DVec3) -> Volume {
    let vertices = mesh.vertices().iter().map(|&v| moved(v)).collect();
    CellMesh::new(vertices, mesh.cells().to_vec(), mesh.values().clone()).expect("still a mesh").into()
}

fn grid(scene: &Scene) -> &AnyGrid {
    scene.volume.grid().expect("only grids and meshes can be transformed").values()
}

fn placement(scene: &Scene) -> Placement {
    with_grid!(grid(scene), g => *g.placement())
}

fn with_placement(scene: &Scene, placement: Placement) -> Volume {
    fn build<T: Voxel>(grid: &UniformGrid<T>, placement: Placement) -> UniformGrid<T> {
        UniformGrid::new(grid.dims(), grid.samples().to_vec(), placement, grid.calibration()).expect("still a grid")
    }
    on_grid(scene, with_grid!(grid(scene), g => build(g, placement).into()))
}

/// A grid under the filter of a scene's.
fn on_grid(scene: &Scene, grid: AnyGrid) -> Volume {
    Volume::from(grid).with_filter(scene.volume.filter().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use vr_core::{GridVolume, Sampler, SamplerVisitor, filter::Reconstruction};

    struct At([f64; 3]);
    impl SamplerVisitor for At {
        type Output = f64;
        fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> f64 {
            sampler.value(self.0)
        }
    }

    fn field(volume: &GridVolume, world: DVec3) -> f64 {
        volume.with_sampler(At(volume.placement().to_index(world).to_array()))
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
