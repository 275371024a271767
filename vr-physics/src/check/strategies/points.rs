//! Random scattered points, and scenes of them.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{Camera, PointKernel, PointSet, Projection, Scene, TransferFunction, View, Volume};

use super::cameras::{Viewpoint, cuts, generic};
use super::looks::{scheme, stretched, tame_compositing};
use super::transfers::{Recipe, recipe, tame_recipe};
use crate::check::TestScene;

/// Largest number of pixels along a side of a random picture.
const MAX_PIXELS: u32 = 8;

/// 1 to 40 points with any kernel: clustered in place, with radii over two orders of magnitude, some coincident or in each other's
/// supports, some apart; weights of one sign, values of one or both; around the origin, or far from it.
pub fn point_set() -> impl Strategy<Value = PointSet> {
    // Shrinks to one point at the origin.
    let place = [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(|p: [f64; 3]| p.map(|x| x * x * x));
    let radius = (-1.7f32..0.3).prop_map(libm::exp10f);
    let point = (place, any::<bool>(), radius, 0.1f32..2.0, 0.05f32..1.0);
    let kernel = prop::sample::select(PointKernel::ALL.to_vec());
    let far = prop_oneof![4 => Just(0.0), 1 => Just(1000.0)];
    (vec(point, 1..=40), kernel, any::<bool>(), far).prop_map(|(points, kernel, both_signs, far)| {
        let mut positions: Vec<DVec3> = points.iter().map(|p| DVec3::from(p.0) + far).collect();
        for k in (5..positions.len()).step_by(6) {
            positions[k] = positions[k - 1];
        }
        let radii = points.iter().map(|p| p.2).collect();
        // As much of the field from a small support as from a large one.
        let weights = points.iter().map(|p| p.2 * p.2 * p.2 * p.3).collect();
        let values = points.iter().map(|p| if both_signs && p.1 { -p.4 } else { p.4 }).collect();
        PointSet::new(positions, radii, weights, values, kernel).expect("strategies make valid points")
    })
}

/// Any valid scene of points: every transfer function, every compositing, clips, rays exactly through points.
pub fn point_scene() -> impl Strategy<Value = TestScene> {
    let compositing = scheme();
    scenes(recipe(), Sight::any(), cuts(), compositing)
}

/// A scene of points whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold.
pub fn tame_point_scene() -> impl Strategy<Value = TestScene> {
    scenes(tame_recipe(), generic().prop_map(Sight::Generic), cuts(), tame_compositing())
}

fn scenes(
    recipe: impl Strategy<Value = Recipe>,
    sight: impl Strategy<Value = Sight>,
    cuts: impl Strategy<Value = super::cameras::Cuts>,
    compositing: impl Strategy<Value = vr_core::Compositing>,
) -> impl Strategy<Value = TestScene> {
    let size = [1..=MAX_PIXELS, 1..=MAX_PIXELS];
    (point_set(), recipe, sight, size, cuts, compositing).prop_map(
        |(points, recipe, sight, size, cuts, compositing)| {
            let (low, high) = points.value_range();
            let range = (low.min(0.0), high.max(0.0));
            let (aimed_at, radius) = (points.positions()[0], f64::from(points.radii()[0]));
            let transfer: TransferFunction = recipe.of_range(range, points.mean_spacing());
            let volume = Volume::from(points);
            let (camera, size) = match sight {
                Sight::Generic(viewpoint) => (viewpoint.camera(&volume, size[1]), size),
                // An odd number of pixels: the middle one looks at the point itself.
                Sight::Exact { axis, backwards, perspective } => {
                    let along = DVec3::AXES[axis] * if backwards { -4.0 } else { 4.0 };
                    let projection = if perspective {
                        Projection::Perspective { fov: 30.0 }
                    } else {
                        Projection::Orthographic { height: 2.5 * radius }
                    };
                    let up = DVec3::AXES[(axis + 1) % 3];
                    (Camera { eye: aimed_at - along, target: aimed_at, up, projection }, size.map(|n| n | 1))
                }
            };
            let view = View { clip: cuts.of_volume(&volume), ..View::new(camera, size) };
            let scene = Scene { compositing: stretched(compositing, range), ..Scene::new(volume, transfer) };
            TestScene { scene, view }
        },
    )
}

/// The place from which a set is seen.
#[derive(Clone, Debug)]
enum Sight {
    Generic(Viewpoint),
    /// A view along an axis, straight at the first point.
    Exact {
        axis: usize,
        backwards: bool,
        perspective: bool,
    },
}

impl Sight {
    fn any() -> impl Strategy<Value = Self> {
        prop_oneof![
            3 => generic().prop_map(Self::Generic),
            1 => (0usize..3, any::<bool>(), any::<bool>())
                .prop_map(|(axis, backwards, perspective)| Self::Exact { axis, backwards, perspective }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Effort;
    use crate::{Certainty, Reference};
    use proptest::strategy::ValueTree;
    use vr_core::{Control, Model};

    fn draw(scenes: impl Strategy<Value = TestScene>, n: usize) -> Vec<TestScene> {
        let mut runner = Effort::default().runner();
        (0..n).map(|_| scenes.new_tree(&mut runner).unwrap().current()).collect()
    }

    fn solve(t: &TestScene) -> crate::Solution {
        Reference::default().solve(&t.scene, &t.view, &Model::Canonical, &Control::default()).unwrap()
    }

    #[test]
    fn every_scene_is_solved_and_every_feature_is_drawn() {
        let scenes = draw(point_scene(), 300);
        let some = |what: &str, test: &dyn Fn(&PointSet) -> bool| {
            let n = scenes.iter().filter(|t| test(t.scene.volume.points().unwrap())).count();
            assert!(n >= 10, "{what}: {n} of 300");
        };
        for kernel in PointKernel::ALL {
            some(kernel.name(), &|p| p.kernel() == kernel);
        }
        some("negative values", &|p| p.values().iter().any(|&v| v < 0.0));
        some("coincident points", &|p| p.positions().windows(2).any(|w| w[0] == w[1]));
        some("far", &|p| p.bounds().0.x > 900.0);
        let spread = |p: &PointSet| {
            p.radii().iter().fold(0.0f32, |m, &r| m.max(r)) / p.radii().iter().fold(f32::MAX, |m, &r| m.min(r))
        };
        some("very different radii", &|p| spread(p) > 30.0);
        for t in &scenes {
            t.scene.validate().unwrap();
            let solved = solve(t);
            assert!(solved.pixels.iter().all(|p| p.rgba.iter().all(|x| x.is_finite())), "{t:?}");
            assert!(matches!(solved.certainty(), Certainty::Bound(_)), "{t:?}");
        }
    }

    #[test]
    fn tame_scenes_are_certain_and_most_are_visible() {
        let scenes = draw(tame_point_scene(), 200);
        let mut visible = 0;
        for t in &scenes {
            let solved = solve(t);
            let peak = solved.pixels.iter().flat_map(|p| p.rgba).fold(1.0, f64::max);
            assert!(solved.certainty().value() <= 1e-8 * peak, "{:?} {t:?}", solved.certainty());
            visible += usize::from(solved.pixels.iter().any(|p| p.rgba.iter().any(|&x| x > 1e-3)));
        }
        assert!(visible > 100, "{visible} of 200");
    }
}
