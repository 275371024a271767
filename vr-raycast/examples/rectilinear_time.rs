//! Time of a sample in rectilinear grids beside that in a uniform grid, in the plain engine and in packets:
//! `cargo run --release -p vr-raycast --example rectilinear_time`.

mod sample_time;

use std::sync::Arc;

use glam::DVec3;
use vr_core::Volume;
use vr_core::rectilinear::{Centering, RectilinearGrid};

use sample_time::{side, value};

/// A grid over the unit cube, cells of which have these widths along each axis, but for a factor.
fn grid(width: impl Fn(usize) -> f64) -> Volume {
    let side = side();
    let mut places = vec![0.0];
    (0..side - 1).for_each(|k| places.push(places[k] + width(k)));
    let places: Vec<f64> = places.iter().map(|p| p / places[side - 1]).collect();
    let mut values = Vec::with_capacity(side.pow(3));
    for &z in &places {
        for &y in &places {
            values.extend(places.iter().map(|&x| value(DVec3::new(x, y, z))));
        }
    }
    let axes = [places.clone(), places.clone(), places];
    Volume::Rectilinear(Arc::new(RectilinearGrid::new(axes, values, Centering::Points).expect("places rise")))
}

fn main() {
    let side = side();
    // Graded from both ends to the middle.
    let graded = |ratio: f64| move |k: usize| ratio.powi(k.min(side - 2 - k) as i32);
    let random = |k: usize| 1.0 + (k * 7919 % 101) as f64 / 101.0;
    sample_time::print(vec![
        ("even axes", grid(|_| 1.0)),
        ("two widths", grid(|k| if k / 32 % 2 == 1 { 0.6 } else { 1.0 })),
        ("graded by 1.02", grid(graded(1.02))),
        ("graded by 1.05", grid(graded(1.05))),
        ("graded by 1.2", grid(graded(1.2))),
        ("random, 1 to 2", grid(random)),
        ("random, 1 to 16", grid(|k| random(k) * [1.0, 4.0, 2.0, 8.0][k % 4])),
    ]);
}
