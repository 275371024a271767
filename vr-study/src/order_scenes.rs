//! Scenes on which orders of convergence show early: a smooth field, each feature of which is many voxels wide.

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrSampling};
use vr_core::phantom::{self, Phantom};
use vr_core::rectilinear::Centering;
use vr_core::{
    AmrGrid, Camera, ControlPoint, OpacityRule, Projection, RectilinearGrid, Scene, TransferFunction, View, Volume,
};

/// Phantom of a sum of waves over [−1, 1]³.
pub struct Waves;

impl Phantom for Waves {
    fn name(&self) -> &'static str {
        "waves"
    }

    fn value(&self, p: DVec3) -> f64 {
        0.5 + 0.2 * libm::sin(2.1 * p.x) * libm::cos(1.7 * p.y + 0.3) + 0.25 * libm::sin(1.9 * p.z)
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let (sx, cx) = (libm::sin(2.1 * p.x), libm::cos(2.1 * p.x));
        let (sy, cy) = (libm::sin(1.7 * p.y + 0.3), libm::cos(1.7 * p.y + 0.3));
        DVec3::new(0.42 * cx * cy, -0.34 * sx * sy, 0.475 * libm::cos(1.9 * p.z))
    }

    fn value_range(&self) -> (f64, f64) {
        (0.05, 0.95)
    }

    fn lipschitz(&self) -> f64 {
        (0.42f64 * 0.42 + 0.34 * 0.34 + 0.475 * 0.475).sqrt()
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        // Kinks, but no jumps: pre- and post-classification differ.
        vec![
            ControlPoint::new(0.05, [0.2, 0.9, 0.1], 0.02),
            ControlPoint::new(0.4, [0.3, 0.4, 1.0], 0.15),
            ControlPoint::new(0.62, [1.0, 0.6, 0.2], 0.04),
            ControlPoint::new(0.95, [1.0, 0.1, 0.6], 0.25),
        ]
    }
}

/// World length that the opacities belong to: the ray through the middle has an optical depth of about 2, however fine the grid is.
const UNIT_DISTANCE: f64 = 1.0 / 8.0;

fn scene(points: Vec<ControlPoint>, samples: usize) -> Scene {
    let grid = phantom::sample::<f32>(&Waves, [samples; 3]).expect("at least two samples");
    of_volume(grid.into(), points)
}

fn of_volume(volume: Volume, points: Vec<ControlPoint>) -> Scene {
    let transfer = TransferFunction::new(points, OpacityRule::Extinction, UNIT_DISTANCE).expect("points that ascend");
    Scene::new(volume, transfer)
}

/// Returns a scene that is smooth but for kinks.
pub(crate) fn smooth(samples: usize) -> Scene {
    scene(Waves.transfer_points(), samples)
}

/// Returns a scene with jumps of the transfer function.
pub(crate) fn jumping(samples: usize) -> Scene {
    let c = [1.0, 0.5, 0.2];
    let points = [(0.35, 0.0), (0.35, 0.3), (0.6, 0.3), (0.6, 0.05)];
    scene(points.iter().map(|&(value, opacity)| ControlPoint::new(value, c, opacity)).collect(), samples)
}

/// Returns the smooth scene on an adaptive mesh of three levels: 16 cells along each side, finer in the middle, and finer again in an eighth of that.
pub(crate) fn adaptive() -> Scene {
    let sampling = AmrSampling {
        origin: DVec3::NEG_ONE,
        edge: 0.5,
        blocks: [4; 3],
        block_cells: [4; 3],
        ratios: vec![[2; 3]; 2],
        centring: AmrCentring::Cells,
    };
    let refine = |low: DVec3, high: DVec3, level: usize| {
        let middle = 0.5 * (low + high);
        middle.abs().max_element() < 0.5 && (level == 0 || middle.max_element() < 0.0)
    };
    let mesh = AmrGrid::refining(&sampling, |p| Waves.value(p) as f32, refine).expect("blocks of whole cells");
    of_volume(mesh.into(), Waves.transfer_points())
}

/// Returns the smooth scene on a rectilinear grid: along each axis, steps grow eightfold from the middle to both ends.
pub(crate) fn uneven(samples: usize) -> Scene {
    let place = |k: usize| {
        let t = 2.0 * k as f64 / (samples - 1) as f64 - 1.0;
        // Its slope is 0.25 in the middle and 2 at the ends.
        t * (0.25 + t.abs() * (0.5 + 0.25 * t.abs()))
    };
    let places: Vec<f64> = (0..samples).map(place).collect();
    let mut values = Vec::with_capacity(samples.pow(3));
    for &z in &places {
        for &y in &places {
            values.extend(places.iter().map(|&x| Waves.value(DVec3::new(x, y, z)) as f32));
        }
    }
    let grid = RectilinearGrid::new([places.clone(), places.clone(), places], values, Centering::Points);
    of_volume(grid.expect("places that rise").into(), Waves.transfer_points())
}

/// Returns a view oblique to all axes.
pub(crate) fn view(scene: &Scene, side: u32) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [side, side])
}

/// Returns a view that the middle of the volume fills: without the silhouette, at which light would have a kink of its own.
pub(crate) fn inner_view(scene: &Scene, side: u32) -> View {
    let projection = Projection::Orthographic { height: 0.9 };
    let whole = view(scene, side);
    View { camera: Camera { projection, ..whole.camera }, ..whole }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_waves_know_themselves() {
        let p = DVec3::new(0.3, -0.7, 0.2);
        let h = 1e-6;
        let slope = |axis: DVec3| (Waves.value(p + axis * h) - Waves.value(p - axis * h)) / (2.0 * h);
        let found = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        assert!((found - Waves.gradient(p)).length() < 1e-8);
        assert!(Waves.gradient(DVec3::ZERO).length() <= Waves.lipschitz());
        for scene in [scene(Waves.transfer_points(), 2), adaptive(), uneven(5)] {
            assert!(scene.validate().is_ok());
        }
        let bounds = uneven(5).volume.bounds();
        assert!((bounds.0 - DVec3::NEG_ONE).length() < 1e-12 && (bounds.1 - DVec3::ONE).length() < 1e-12);
        assert_eq!(adaptive().volume.amr().map(|mesh| mesh.levels()), Some(3));
    }
}
