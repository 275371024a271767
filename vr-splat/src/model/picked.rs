//! Values that are picked of sheets and of samples, by the model; and pictures of them.

use vr_core::{
    Calibration, Camera, Classification, Compositing, ControlPoint, OpacityRule, Placement, Scene, TransferFunction,
    UniformGrid, View,
};
use vr_physics::check::pictures::draw;

use super::{Line, Part, SplatModel};
use crate::capabilities::check;
use crate::kernel::{Shape, SplatKernel};
use crate::splatter::{Buffers, Splatter};

impl SplatModel {
    /// The value that an operator picks along the ray through a point of the image; `None` where there is none.
    fn picked(&self, x: f64, y: f64) -> Option<f64> {
        let ray = self.rays.at(x, y);
        let line = Line::new(&self.seen, &self.input, &ray, [x, y]);
        let parts = self.parts(&line, self.ends(&ray, &line)?);
        let values = || {
            parts.iter().filter_map(|part| match part {
                Part::Value { value, length, .. } => Some((*value, *length)),
                _ => None,
            })
        };
        match self.scene.compositing {
            Compositing::Maximum => values().map(|v| v.0).reduce(f64::max),
            Compositing::Minimum => values().map(|v| v.0).reduce(f64::min),
            Compositing::Average => {
                let (sum, length) = values().fold((0.0, 0.0), |(s, l), (v, w)| (s + v * w, l + w));
                (length > 0.0).then(|| sum / length)
            }
            Compositing::First { threshold } => {
                // What comes first, or first behind vacuum, is seen as it is; elsewhere the threshold was passed.
                let mut fresh = true;
                for part in &parts {
                    match part {
                        Part::Value { value, .. } if *value >= threshold => {
                            return Some(if fresh { *value } else { threshold });
                        }
                        Part::Value { .. } => fresh = false,
                        _ => fresh = true,
                    }
                }
                None
            }
            other => unreachable!("{} picks nothing", other.name()),
        }
    }
}

/// Values from 0 to 1 of a smooth field with or without a hole, their grey and opacity the same.
fn scene(compositing: Compositing, holed: bool, slope: f64) -> Scene {
    let dims = [11, 9, 10];
    let value = |i: usize| {
        let [x, y, z] = [i % 11, i / 11 % 9, i / 99].map(|x| x as f64);
        let hole = holed && (x - 5.0).abs() < 2.0 && (y - 4.0).abs() < 2.0 && (z - 5.0).abs() < 2.0;
        let f = 0.5 + 0.4 * libm::sin(0.9 * x + 0.3) * libm::cos(0.7 * y) * libm::sin(0.5 * z + 1.0);
        if hole { f32::NAN } else { ((f - 0.2) / slope) as f32 }
    };
    let samples: Vec<f32> = (0..dims.iter().product()).map(value).collect();
    let calibration = Calibration { slope, intercept: 0.2 };
    let placement = Placement::from_spacing([0.7, 1.0, 1.3]).unwrap();
    let grid: UniformGrid<f32> = UniformGrid::new(dims, samples, placement, calibration).unwrap();
    let points = [0.0, 1.0].map(|v| ControlPoint::new(v, [v; 3], v)).to_vec();
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene { compositing, ..Scene::new(grid.into(), transfer) }
}

#[test]
fn pictures_are_what_the_model_picks() {
    let operators =
        [Compositing::Maximum, Compositing::Minimum, Compositing::Average, Compositing::First { threshold: 0.55 }];
    for buffers in [Buffers::Axis, Buffers::Samples] {
        for shape in [Shape::Bilinear, Shape::BSpline, Shape::Cone] {
            for (compositing, holed, slope) in operators.into_iter().flat_map(|o| [(o, false, 2.0), (o, true, -0.5)]) {
                let scene = scene(compositing, holed, slope);
                let renderer = Splatter { buffers, kernel: SplatKernel::new(shape), ..Splatter::default() };
                for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
                    let view = View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, fov), [11; 2]);
                    let model = SplatModel::new(&renderer, &scene, &check(&renderer, &scene).unwrap(), &view).unwrap();
                    let frame = draw(&renderer, &scene, &view).frame;
                    let (mut worst, mut apart, mut there) = (0.0f64, 0, 0);
                    for (i, pixel) in frame.pixels().iter().enumerate() {
                        let found = model.picked((i % 11) as f64 + 0.5, (i / 11) as f64 + 0.5);
                        let alone = found.is_some() != (pixel[3] > 0.0);
                        there += usize::from(found.is_some());
                        // Grey is the value, and of a first hit whole: all of them are opaque.
                        let grey = match compositing {
                            Compositing::First { .. } => f64::from(pixel[0]),
                            _ => f64::from(pixel[3]),
                        };
                        let off = found.map_or(0.0, |v| (v - grey).abs());
                        if alone || off > 1e-4 { apart += 1 } else { worst = worst.max(off) }
                    }
                    let how = format!("{buffers:?} {shape:?} {} {holed} {azimuth}", compositing.name());
                    println!("{how}: {worst:.1e}, {apart} of {there} apart");
                    // Tables and rounding. A ray may just meet a sheet, a sample or a hole, or just not: in few pixels.
                    assert!(there > 25 && apart <= 2, "{how}: {apart} of {there}");
                }
            }
        }
    }
    let voxels = Splatter { classification: Classification::Pre, ..Splatter::default() };
    assert!(check(&voxels, &scene(Compositing::Maximum, false, 1.0)).is_err());
}
