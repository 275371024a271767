//! Random scattered points, and scenes of them.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{Compositing, PointKernel, PointMixing, PointSet, Shading, Volume};

use super::assembly::{self, Look, assemble, plain_picture};
use super::cameras::{Viewpoint, generic};
use super::kinds::with_slopes;
use super::looks::{lit, modulation, scheme, tame_compositing};
use super::transfers::{recipe, tame_recipe, value_range};
use crate::check::TestScene;

/// Largest number of points of a set.
const MAX_POINTS: usize = 40;

/// 1 to 40 points with any kernel: clustered in place, with radii over two orders of magnitude, some coincident or in each other's
/// supports, some apart; weights of one sign, values of one or both; around the origin, or far from it.
pub fn point_set() -> impl Strategy<Value = PointSet> {
    // Shrinks to one point at the origin.
    let place = [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(|p: [f64; 3]| p.map(|x| x * x * x));
    let radius = (-1.7f32..0.3).prop_map(libm::exp10f);
    let point = (place, any::<bool>(), radius, 0.1f32..2.0, 0.05f32..1.0);
    let kernel = prop::sample::select(PointKernel::ALL.to_vec());
    let far = prop_oneof![4 => Just(0.0), 1 => Just(1000.0)];
    (vec(point, 1..=MAX_POINTS), kernel, any::<bool>(), far).prop_map(|(points, kernel, both_signs, far)| {
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

/// Points whose values are weighted means, or that have colours, or both.
pub fn mixed_point_set() -> impl Strategy<Value = PointSet> {
    let mixtures = vec![(PointMixing::Mean, false), (PointMixing::Sum, true), (PointMixing::Mean, true)];
    let colors = vec([0.0f32..=1.0, 0.0..=1.0, 0.0..=1.0], MAX_POINTS);
    (point_set(), prop::sample::select(mixtures), colors).prop_map(|(points, (mixing, colored), mut colors)| {
        colors.truncate(points.count());
        let points = points.with_mixing(mixing).expect("weights are positive");
        if colored { points.with_colors(colors).expect("a colour for each point") } else { points }
    })
}

/// Any valid scene of points: sums, means and colours, every transfer function, every compositing, clips, shading, opacity by the gradient, rays exactly through points.
pub fn point_scene() -> impl Strategy<Value = TestScene> {
    let modulations = prop_oneof![2 => Just(Vec::new()).boxed(), 1 => modulation().boxed()];
    let shading = proptest::option::weighted(0.35, (lit(), modulations));
    let points = prop_oneof![2 => point_set().boxed(), 1 => mixed_point_set().boxed()];
    (points, recipe(), plain_picture(viewpoint()), scheme(), shading).prop_map(
        |(points, recipe, picture, compositing, shading)| {
            let volume = Volume::from(points);
            let (low, high) = value_range(&volume);
            let steepest = (high - low) / volume.mean_spacing();
            let lit = shading.map(|((shading, lights), gradient_opacity)| {
                (with_slopes(Shading { gradient_opacity, ..shading }, steepest), lights)
            });
            assemble(volume, &recipe, &picture, Look::plain(compositing, lit))
        },
    )
}

/// A scene of points that are shaded, and whose picture depends continuously on every number but where a gradient vanishes.
pub fn shaded_point_scene() -> impl Strategy<Value = TestScene> {
    let look = lit().prop_map(|lit| Look::plain(Compositing::Over, Some(lit)));
    assembly::scenes(point_set(), tame_recipe(), plain_picture(generic()), look)
}

/// A scene of points whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold.
pub fn tame_point_scene() -> impl Strategy<Value = TestScene> {
    let look = tame_compositing().prop_map(|compositing| Look::plain(compositing, None));
    assembly::scenes(point_set(), tame_recipe(), plain_picture(generic()), look)
}

/// The same of [points that are mixed](mixed_point_set). Where a ray goes along the rims of two supports, the reference's bound may be wide.
pub fn tame_mixed_point_scene() -> impl Strategy<Value = TestScene> {
    let look = tame_compositing().prop_map(|compositing| Look::plain(compositing, None));
    assembly::scenes(mixed_point_set(), tame_recipe(), plain_picture(generic()), look)
}

/// Any viewpoint, or a view along an axis, straight at the first point.
fn viewpoint() -> impl Strategy<Value = Viewpoint> {
    prop_oneof![
        3 => generic(),
        1 => (0usize..3, any::<bool>(), any::<bool>())
            .prop_map(|(axis, backwards, perspective)| Viewpoint::AtPoint { axis, backwards, perspective }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn::{self, draw, scenes_are_solved, tame_scenes_are_certain};

    #[test]
    fn every_scene_is_solved_and_every_feature_is_drawn() {
        let scenes = draw(point_scene(), 300);
        let some = |what: &str, test: &dyn Fn(&PointSet) -> bool| {
            drawn::some(&scenes, what, |t| test(t.scene.volume.points().unwrap()));
        };
        for kernel in PointKernel::ALL {
            some(kernel.name(), &|p| p.kernel() == kernel);
        }
        some("negative values", &|p| p.values().iter().any(|&v| v < 0.0));
        some("coincident points", &|p| p.positions().windows(2).any(|w| w[0] == w[1]));
        some("means", &|p| p.mixing() == PointMixing::Mean);
        some("colours of sums", &|p| p.mixing() == PointMixing::Sum && p.colors().is_some());
        some("colours of means", &|p| p.mixing() == PointMixing::Mean && p.colors().is_some());
        some("far", &|p| p.bounds().0.x > 900.0);
        let spread = |p: &PointSet| {
            p.radii().iter().fold(0.0f32, |m, &r| m.max(r)) / p.radii().iter().fold(f32::MAX, |m, &r| m.min(r))
        };
        some("very different radii", &|p| spread(p) > 30.0);
        drawn::some(&scenes, "shading", |t| t.scene.shading.is_some());
        drawn::some(&scenes, "opacity by the gradient", |t| t.scene.has_gradient_opacity());
        scenes_are_solved(&scenes);
    }

    #[test]
    fn tame_scenes_are_certain_and_most_are_visible() {
        tame_scenes_are_certain(&draw(tame_point_scene(), 200), 1e-8);
    }

    #[test]
    fn tame_scenes_of_means_and_colours_are_solved() {
        // With a proven bound, which is wide where a ray goes along the rims of two supports: a mean changes from one value to the other there.
        scenes_are_solved(&draw(tame_mixed_point_scene(), 200));
    }

    #[test]
    fn shaded_scenes_are_certain_and_most_are_visible() {
        // Beside the edge of a support that another covers in part, and where gradients of two points cancel, directions lose digits.
        tame_scenes_are_certain(&draw(shaded_point_scene(), 150), 1e-7);
    }
}
