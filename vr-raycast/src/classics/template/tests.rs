//! Templates against rays that go their own way.

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::*;
use vr_physics::check::TestScene;
use vr_physics::check::strategies::{Kind, scene_of};

use super::*;
use crate::caster::{CompositingOrder, ImageSampling, Precision, RayCaster, Rule, Step};
use crate::operator::Needs;
use crate::prepared::PreparedCaster;
use crate::render_tables::TablesByPrecision;
use crate::run::Steps;
use crate::walk::{ListedWalk, cell_steps};

/// Directions of all kinds: any, along axes, in faces and through edges.
fn directions() -> impl Strategy<Value = DVec3> {
    let slope = prop_oneof![-1.0f64..1.0, (-4i32..=4).prop_map(|k| f64::from(k) / 4.0)];
    (slope.clone(), slope, 0usize..3, any::<bool>()).prop_map(|(u, v, axis, back)| {
        let mut d = [u, v, u];
        (d[axis], d[(axis + 1) % 3], d[(axis + 2) % 3]) = (if back { -1.0 } else { 1.0 }, u, v);
        DVec3::from(d)
    })
}

/// View of all of a box in a direction of index space.
fn view_along(direction: DVec3, placement: &Placement, dims: [usize; 3]) -> View {
    let middle = placement.to_world(DVec3::from_array(dims.map(|n| 0.5 * (n - 1) as f64)));
    let forward = (placement.axes() * direction).normalize();
    let up = if forward.x.abs() < 0.8 { DVec3::X } else { DVec3::Y };
    let projection = Projection::Orthographic { height: 300.0 };
    View::new(Camera { eye: middle - 200.0 * forward, target: middle, up, projection }, [8, 8])
}

/// Returns begin and length of all steps of a walk.
fn walked(mut walk: TemplateWalk<'_>) -> Vec<(f64, f64)> {
    let (mut steps, mut all) = (Steps::new(), Vec::new());
    while walk.next(&mut steps) {
        all.extend((0..steps.len).map(|j| (steps.begin[j], steps.length[j])));
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// The cells of a template are those that each ray's own traversal finds, face by face: in grids, directions and from lattice points of all kinds,
    /// rays through edges and in faces of the box among them.
    #[test]
    fn cells_are_those_of_the_rays_own_traversal(
        dims in prop::array::uniform3(2usize..14),
        spacing in prop::array::uniform3(0.3f64..3.0),
        direction in directions(),
        share in prop::array::uniform2(0.0f64..1.0),
        crop in prop::option::of((prop::array::uniform3(0.0f64..0.4), prop::array::uniform3(0.6f64..1.0))),
    ) {
        let placement = Placement::new(DVec3::new(3.0, -7.0, 0.5), DMat3::from_diagonal(spacing.into())).unwrap();
        let mut view = view_along(direction, &placement, dims);
        let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let world = |p: [f64; 3]| placement.to_world(DVec3::from(p) * last);
        view.clip.crop = crop.map(|(low, high)| (world(low), world(high)));
        let plane = BasePlane::new(&view, &placement, dims).unwrap();
        let template = TemplateSteps::new(Connectivity::Faces, &plane, f64::INFINITY, 0.5);
        // A pixel here and there, and all along one edge of the plane, where rays lie in faces of the box.
        let pixels = (0..plane.size[0]).flat_map(|i| [0, (share[1] * plane.size[1] as f64) as usize].map(|j| [i, j]));
        for pixel in pixels {
            let pixel = [0, 1].map(|a| plane.first[a] + pixel[a] as i64);
            let Some(part) = plane.part(pixel, f64::INFINITY) else { continue };
            let found = walked(TemplateWalk::new(&plane, &template, None, (pixel, &part), Needs::LIGHT));
            let own = cell_steps(&part, dims, f64::INFINITY);
            prop_assert_eq!(found.len(), own.len(), "{:?} {:?}", found, own);
            for (a, b) in found.iter().zip(&own) {
                // Slivers that either leaves to the next cell.
                let rounding = 1e-11 * (1.0 + part.end);
                prop_assert!((a.0 - b.0).abs() <= rounding && (a.1 - b.1).abs() <= rounding, "{:?} {:?}", found, own);
                let cell = |(begin, length): (f64, f64)| part.at(begin + 0.5 * length);
                prop_assert!((cell(*a) - cell(*b)).abs().max_element() <= 1e-9);
            }
        }
    }

    /// Steps of every kind cover the part of a ray that is inside, in order and without gaps, each within its step of the template.
    #[test]
    fn steps_cover_the_part_inside(
        dims in prop::array::uniform3(2usize..14),
        direction in directions(),
        step in prop_oneof![0.05f64..3.0, Just(64.0)],
        connectivity in prop::sample::select(&[Connectivity::Discrete, Connectivity::Continuous, Connectivity::Faces][..]),
        backwards in any::<bool>(),
        far in 150.0f64..250.0,
    ) {
        let placement = Placement::from_spacing([1.0, 0.7, 1.6]).unwrap();
        let view = view_along(direction, &placement, dims);
        let plane = BasePlane::new(&view, &placement, dims).unwrap();
        let template = TemplateSteps::new(connectivity, &plane, step, 0.5);
        for i in 0..plane.size[0] * plane.size[1] {
            let pixel = [plane.first[0] + (i % plane.size[0]) as i64, plane.first[1] + (i / plane.size[0]) as i64];
            let Some(part) = plane.part(pixel, far) else { continue };
            let needs = Needs { backwards, ..Needs::LIGHT };
            let mut walk = TemplateWalk::new(&plane, &template, None, (pixel, &part), needs);
            let (mut steps, mut runs) = (Steps::new(), Vec::new());
            while walk.next(&mut steps) {
                for k in 0..steps.len {
                    let whole = steps.number[k] as usize;
                    let (begin, end) = (template.begin[whole], template.begin[whole] + template.length[whole]);
                    prop_assert!(steps.begin[k] >= begin - 1e-9 && steps.begin[k] + steps.length[k] <= end + 1e-9);
                    prop_assert!(steps.length[k] > 0.0);
                }
                if let Some(places) = walk.places() {
                    for (place, k) in places.iter().zip(0..steps.len) {
                        let middle = part.at(steps.begin[k] + 0.5 * steps.length[k]).to_array();
                        // Half a voxel to the side, and half a slice along the ray for a step that is cut.
                        prop_assert!((0..3).all(|a| (place[a] - middle[a]).abs() <= 1.0 + 1e-9), "{place:?} {middle:?}");
                    }
                }
                runs.push((0..steps.len).map(|k| (steps.begin[k], steps.length[k])).collect::<Vec<_>>());
            }
            if backwards {
                runs.reverse();
            }
            let all = runs.concat();
            prop_assert!((all[0].0 - part.start).abs() <= 1e-10);
            prop_assert!(all.windows(2).all(|w| (w[0].0 + w[0].1 - w[1].0).abs() <= 1e-10));
            let last = all[all.len() - 1];
            prop_assert!((last.0 + last.1 - part.end).abs() <= 1e-10);
        }
    }
}

/// Compares the rays of a template with rays of the plain engine that go their own way from cell to cell, or in steps from where they enter. Returns the
/// largest difference.
fn largest_difference<R: Real>(
    prepared: &PreparedCaster,
    connectivity: Connectivity,
    pipeline: &Pipeline<'_, R>,
) -> Result<f64, TestCaseError> {
    let volume = prepared.source.grid().expect("a grid");
    let plane = BasePlane::new(pipeline.view, volume.placement(), volume.dims()).unwrap();
    let steps = TemplateSteps::new(connectivity, &plane, pipeline.walks.step, pipeline.offset);
    let template = Template { plane, steps, volume, pipeline };
    let picture = template.cast(&Control::default()).unwrap();
    let plane = &template.plane;
    let surfaces = pipeline.layer.map(|layer| SurfaceDepths::new(layer, pipeline.view).unwrap());
    let mut operator = pipeline.operator();
    let mut scratch = pipeline.scratch(operator.as_mut());
    let mut largest: f64 = 0.0;
    for (i, found) in picture.rays.iter().enumerate() {
        let pixel = [plane.first[0] + (i % plane.size[0]) as i64, plane.first[1] + (i / plane.size[0]) as i64];
        let far = surfaces.as_ref().map_or(f64::INFINITY, |s| s.depth(volume.placement().to_world(plane.place(pixel))));
        let Some(part) = plane.part(pixel, far) else {
            prop_assert_eq!(*found, RaySample::NOTHING);
            continue;
        };
        let steps = match connectivity {
            Connectivity::Faces => cell_steps(&part, volume.dims(), pipeline.walks.step),
            // The lattice of such a ray begins where the template does.
            Connectivity::Continuous if part.start == 0.0 => {
                let lattice = crate::walk::Lattice::new(part.start, part.end, pipeline.walks.step);
                (0..lattice.count).map(|k| (lattice.begin(k), lattice.length_of(k))).collect()
            }
            Connectivity::Continuous | Connectivity::Discrete => continue,
        };
        let walk = Walk::Listed(ListedWalk::new(steps, None, 0, scratch.needs().backwards));
        let ray = RayPart { direction: plane.forward, part, walk, shared: None };
        let own = RaySample::from(pipeline.trace_part(&mut scratch, ray, &mut Counts::default()));
        let peak = own.rgba.iter().fold(1.0f32, |p, x| p.max(x.abs()));
        for c in 0..4 {
            largest = largest.max(f64::from((found.rgba[c] - own.rgba[c]).abs() / peak));
        }
    }
    Ok(largest)
}

/// Rays of a template and of the plain engine in a scene, from outside by parallel rays, under settings that go with any of its operators. `None` where the
/// setting is refused.
fn difference_in(test: TestScene, by: &RayCaster) -> Result<Option<f64>, TestCaseError> {
    let TestScene { scene, mut view } = test;
    let height = 1.2 * (scene.volume.bounds().1 - scene.volume.bounds().0).length();
    view.camera.projection = Projection::Orthographic { height };
    let order = if scene.compositing == Compositing::Over { by.order } else { CompositingOrder::default() };
    let prepared = match PreparedCaster::new(RayCaster { order, ..by.clone() }, &scene, &Control::default()) {
        Err(RenderError::Unsupported(_)) => return Ok(None),
        prepared => prepared.map_err(|error| TestCaseError::fail(error.to_string()))?,
    };
    let ImageSampling::Template { connectivity } = by.image_sampling else { panic!("a template was asked for") };
    // The middles of cells along an axis lie between two voxels, and rounding chooses.
    let is_nearest = scene.volume.filter() == Some(Filter::Nearest);
    prop_assume!(!(is_nearest && connectivity == Connectivity::Faces));
    let layer = prepared.scene.layer(&view, &Control::default()).unwrap();
    let seen = (&view, layer.as_ref());
    Ok(Some(match prepared.engine.kernel().expect("the plain engine's") {
        TablesByPrecision::F32(tables) => {
            largest_difference(&prepared, connectivity, &prepared.pipeline(tables, seen).unwrap())?
        }
        TablesByPrecision::F64(tables) => {
            largest_difference(&prepared, connectivity, &prepared.pipeline(tables, seen).unwrap())?
        }
    }))
}

/// Templates that samples of the plain engine can be compared with. Cells that a ray enters within are cut into equal steps of their own: whole ones
/// are taken.
fn casters() -> impl Strategy<Value = RayCaster> {
    let rules = [Rule::Midpoint, Rule::Midpoint, Rule::Left, Rule::Linear, Rule::Quadratic];
    let continuous = (0.3f64..2.0).prop_map(|step| (Connectivity::Continuous, step));
    let template = prop_oneof![continuous, Just((Connectivity::Faces, 64.0))];
    (template, prop::sample::select(rules.to_vec()), any::<bool>()).prop_map(|((connectivity, step), rule, back)| {
        RayCaster {
            image_sampling: ImageSampling::Template { connectivity },
            step: Step::Uniform(step),
            rule,
            order: if back { CompositingOrder::BackToFront } else { CompositingOrder::default() },
            ..RayCaster::default()
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// The rays of a template are those of the plain engine, whatever the scene, the operator and the setting.
    #[test]
    fn rays_are_those_of_the_plain_engine(test in scene_of(&Kind::ALL), by in casters()) {
        let found = difference_in(test, &RayCaster { precision: Precision::F64, ..by })?;
        // A ray that ends early leaves 10⁻⁴, and runs that begin elsewhere end it elsewhere. The rest is rounding to a frame's f32.
        prop_assert!(found.is_none_or(|difference| difference <= 1.1e-4), "{found:?}");
    }

    /// So they are in f32, where no jump makes much of a rounding: positions are rounded by the one and weights by the other.
    #[test]
    fn rays_in_single_precision_are_those_of_the_plain_engine(
        test in scene_of(&[Kind::Plain, Kind::Lights, Kind::Layers, Kind::Accumulate, Kind::Average, Kind::Extrema, Kind::GradientOpacity]),
        by in casters(),
    ) {
        let found = difference_in(test, &by)?;
        prop_assert!(found.is_none_or(|difference| difference <= 1e-3), "{found:?}");
    }
}
