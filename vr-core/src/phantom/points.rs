//! Phantoms of scattered points, by name.
//!
//! | name | use |
//! |---|---|
//! | `plummer` | a star cluster: radii and densities over several orders of magnitude |
//! | `turbulence` | gas: points evenly spread, each of the same radius, with values that follow a smooth function |

use super::{plummer, turbulence};
use crate::point_set::PointSet;
use crate::transfer::ControlPoint;

/// The names that [`points_by_name`] knows.
pub const POINT_NAMES: &[&str] = &["plummer", "turbulence"];

/// `count` points of the phantom of a name; the same ones on every machine. `None` for another name, or for no point.
///
/// All lie in the ball of radius 1 around the origin. More points show finer detail; the field that they approach stays the same.
pub fn points_by_name(name: &str, count: usize) -> Option<PointSet> {
    match name {
        "plummer" => plummer::points(count),
        "turbulence" => turbulence::points(count),
        _ => None,
    }
}

/// Control points of a transfer function that shows the features of the phantom of a name, by ascending value, and the
/// `unit_distance` in world units that they are for. Right for any number of points; `None` for another name.
pub fn point_transfer_function(name: &str) -> Option<(Vec<ControlPoint>, f64)> {
    match name {
        "plummer" => Some(plummer::transfer()),
        "turbulence" => Some(turbulence::transfer()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{OpacityRule, TransferFunction};

    #[test]
    fn every_name_gives_as_many_points_as_asked_for_and_a_transfer_function() {
        for name in POINT_NAMES {
            for count in [1, 2, 1000] {
                let points = points_by_name(name, count).unwrap();
                assert_eq!(points.count(), count, "{name}");
                assert!(points.positions().iter().all(|p| p.length() <= 1.0), "{name}");
            }
            assert!(points_by_name(name, 0).is_none(), "{name}");
            let (control, unit_distance) = point_transfer_function(name).unwrap();
            assert!(control.is_sorted_by(|a, b| a.value < b.value), "{name}");
            assert!(TransferFunction::new(control, OpacityRule::Power, unit_distance).is_ok(), "{name}");
        }
        assert!(points_by_name("teapot", 1).is_none() && point_transfer_function("teapot").is_none());
    }
}
