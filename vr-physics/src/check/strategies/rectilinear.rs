//! Random rectilinear grids, and scenes of them.

use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::rectilinear::{Centering, RectilinearGrid};

use super::assembly;
use super::cameras::viewpoint;
use super::hashed::Hashed;
use crate::check::TestScene;

/// Any small rectilinear grid: 2 to 6 places an axis, even, uneven, graded, and with steps 10⁴ times as long as others; axes that fall; values of points or of cells;
/// missing values; around the origin, or far from it. The type has one filter, the trilinear one.
pub fn rectilinear_grid() -> impl Strategy<Value = RectilinearGrid> {
    grids(any_steps().boxed(), proptest::option::weighted(0.25, 6u64..40).boxed())
}

/// A rectilinear grid without missing values, whose steps differ by a factor of at most 60.
pub fn tame_rectilinear_grid() -> impl Strategy<Value = RectilinearGrid> {
    grids(tame_steps().boxed(), Just(None).boxed())
}

/// Any scene of a rectilinear grid: every transfer function, every compositing, clips, shading by either gradient, rays in the planes of the grid.
pub fn rectilinear_scene() -> impl Strategy<Value = TestScene> {
    assembly::any_scene(rectilinear_grid(), viewpoint())
}

/// A scene of a rectilinear grid whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold, no shading, no missing values.
pub fn tame_rectilinear_scene() -> impl Strategy<Value = TestScene> {
    assembly::tame_scene(tame_rectilinear_grid())
}

fn tame_steps() -> impl Strategy<Value = Vec<f64>> {
    let uneven = vec(0.2..2.0, 1..=5);
    let graded = (1usize..=5, 1.2f64..2.2).prop_map(|(n, ratio)| (0..n).map(|k| libm::pow(ratio, k as f64)).collect());
    let even = (1usize..=5).prop_map(|n| vec![1.0; n]);
    prop_oneof![1 => even, 3 => uneven, 1 => graded]
}

fn any_steps() -> impl Strategy<Value = Vec<f64>> {
    // The mean is neither very long nor very short: worlds 2^±66 times as large stay within what lengths may be.
    let extreme = (vec(0.5..2.0, 2..=5), any::<prop::sample::Index>(), prop_oneof![Just(0.01), Just(100.0)]).prop_map(
        |(mut steps, at, factor): (Vec<f64>, prop::sample::Index, f64)| {
            let at = at.index(steps.len());
            steps.iter_mut().for_each(|step| *step /= factor);
            steps[at] *= factor * factor;
            steps
        },
    );
    prop_oneof![3 => tame_steps(), 1 => extreme]
}

fn grids(
    steps: BoxedStrategy<Vec<f64>>,
    missing: BoxedStrategy<Option<u64>>,
) -> impl Strategy<Value = RectilinearGrid> {
    let centering = prop_oneof![3 => Just(Centering::Points), 1 => Just(Centering::Cells)];
    let falls = [any::<bool>(), any::<bool>(), any::<bool>()];
    let values = prop_oneof![3 => Just([0.0, 1.0]), 1 => Just([-2.0, 4.0]), 1 => Just([1e4, 50.0])];
    let place = (-1.0f64..1.0, prop_oneof![3 => Just(0.0), 1 => Just(200.0)]);
    ([steps.clone(), steps.clone(), steps], centering, falls, values, place, missing, any::<u64>()).prop_map(
        |(steps, centering, falls, [first, range], (decades, far), missing, seed)| {
            let scale = libm::pow(10.0, decades);
            let axes: [Vec<f64>; 3] = std::array::from_fn(|a| axis(&steps[a], centering, [far, scale], falls[a]));
            let beyond = usize::from(centering == Centering::Cells);
            let count: usize = axes.iter().map(|places| places.len() - beyond).product();
            let value = |i: usize| {
                let hashed = Hashed::of(seed, [i as i64]);
                let is_missing = missing.is_some_and(|n| hashed.is_one_in(n));
                if is_missing { f32::NAN } else { (first + range * hashed.part()) as f32 }
            };
            let values = (0..count).map(value).collect();
            RectilinearGrid::new(axes, values, centering).expect("strategies make valid grids")
        },
    )
}

/// The places at the ends of steps; the faces of cells have one step more.
fn axis(steps: &[f64], centering: Centering, [far, scale]: [f64; 2], falls: bool) -> Vec<f64> {
    let more = if centering == Centering::Cells { &steps[..1] } else { &[] };
    let mut at = far;
    let mut places = vec![at * scale];
    for step in steps.iter().chain(more) {
        at += step;
        places.push(at * scale);
    }
    if falls {
        places.reverse();
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn::{self, draw, scenes_are_solved, tame_scenes_are_certain};
    use vr_core::GradientMethod;
    use vr_core::rectilinear::Axis;

    #[test]
    fn every_scene_is_solved_and_every_feature_is_drawn() {
        let scenes = draw(rectilinear_scene(), 300);
        let some = |what: &str, test: &dyn Fn(&TestScene, &RectilinearGrid) -> bool| {
            drawn::some(&scenes, what, |t| test(t, t.scene.volume.rectilinear().unwrap()));
        };
        let ratio = |axis: &Axis| axis.largest_step() / axis.smallest_step();
        some("very uneven axes", &|_, grid| grid.axes().iter().any(|axis| ratio(axis) > 1e3));
        some("even axes", &|_, grid| grid.axes().iter().all(|axis| ratio(axis) < 10.0));
        some("missing values", &|_, grid| grid.lattice().vacuum_cells().is_some());
        some("analytic gradients", &|t, grid| {
            t.scene.shading.is_some() && grid.gradient_method() == GradientMethod::Analytic
        });
        some("central differences", &|t, grid| {
            t.scene.shading.is_some() && grid.gradient_method() == GradientMethod::CentralDifferences
        });
        some("clips", &|t, _| t.view.clip.crop.is_some() || !t.view.clip.planes.is_empty());
        some("jumps", &|t, _| t.scene.transfer.has_jumps());
        some("an eye inside", &|t, grid| {
            let (low, high) = grid.bounds();
            t.view.camera.eye.cmpgt(low).all() && t.view.camera.eye.cmplt(high).all()
        });
        scenes_are_solved(&scenes);
    }

    #[test]
    fn tame_scenes_are_certain_and_most_are_visible() {
        tame_scenes_are_certain(&draw(tame_rectilinear_scene(), 200), 1e-7);
    }
}
