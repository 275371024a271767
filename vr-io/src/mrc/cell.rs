//! The cell of a crystal as a basis of the world, and the grid in it.

use glam::{DMat3, DVec3};

use crate::error::FieldError;
use crate::notes::{Assumption, Notes};

use super::header::Header;

/// Placement of the voxels, in Å.
pub(super) struct Placed {
    pub origin: DVec3,
    /// Steps from one column, row and section to the next.
    pub axes: DMat3,
    pub by: &'static str,
}

pub(super) fn place(header: &Header, notes: &mut Notes) -> Result<Placed, FieldError> {
    let known = header.lengths != [0.0; 3];
    let steps = if known {
        let edges = edges(header.lengths, angles(header, notes))?;
        // MX counts intervals along X, the axis of the cell, whichever way the voxels are stored.
        let mut steps = edges;
        for (axis, intervals) in header.intervals.into_iter().enumerate() {
            if intervals <= 0 {
                return Err(FieldError::new(["MX", "MY", "MZ"][axis], intervals, "must be 1 or more"));
            }
            *steps.col_mut(axis) /= f64::from(intervals);
        }
        steps
    } else {
        notes.assume(Assumption::Spacing, "no lengths of the cell in the header: 1, 1, 1 is assumed between voxels");
        DMat3::IDENTITY
    };
    let [columns, rows, sections] = header.axes.map(|axis| steps.col(axis));
    let axes = DMat3::from_cols(columns, rows, sections);

    let start = DVec3::from_array(header.start.map(f64::from));
    let origin = DVec3::from_array(header.origin);
    let origin = if origin != DVec3::ZERO {
        if start != DVec3::ZERO && (axes * start - origin).length() > 1e-3 * axes.x_axis.length() {
            notes.push("ORIGIN places the volume; NXSTART, NYSTART and NZSTART, which say otherwise, do not".into());
        }
        origin
    } else {
        axes * start
    };
    Ok(Placed { origin, axes, by: if known { "cell" } else { "assumed" } })
}

fn angles(header: &Header, notes: &mut Vec<String>) -> [f64; 3] {
    if header.angles == [0.0; 3] {
        notes.push("no angles of the cell in the header: 90° are assumed".into());
        return [90.0; 3];
    }
    header.angles
}

/// The edges a, b and c of a cell: a along x, b in the plane of x and y (the convention of the Protein Data Bank's format).
///
/// With angles α between b and c, β between c and a, γ between a and b, c is
/// |c| (cos β, (cos α − cos β cos γ) / sin γ, √(1 − cos²β − c_y²)).
fn edges([a, b, c]: [f64; 3], angles: [f64; 3]) -> Result<DMat3, FieldError> {
    for (axis, length) in [a, b, c].into_iter().enumerate() {
        if !(length > 0.0 && length.is_finite()) {
            return Err(FieldError::new("CELLA", length, format!("length {} must be positive and finite", axis + 1)));
        }
    }
    let allowed = "must be angles between 0 and 180 degrees that close a cell";
    let wrong = || FieldError::new("CELLB", format_args!("{angles:?}"), allowed);
    if angles.iter().any(|&angle| !(angle > 0.0 && angle < 180.0)) {
        return Err(wrong());
    }
    // 90°, by far the most frequent, shall give axes without crumbs.
    let cos = |degrees: f64| if degrees == 90.0 { 0.0 } else { libm::cos(degrees.to_radians()) };
    let [cos_alpha, cos_beta, cos_gamma] = angles.map(cos);
    let sin_gamma = (1.0 - cos_gamma * cos_gamma).sqrt();
    let y = (cos_alpha - cos_beta * cos_gamma) / sin_gamma;
    let z_squared = 1.0 - cos_beta * cos_beta - y * y;
    if !(z_squared > 1e-12 && sin_gamma > 1e-6) {
        return Err(wrong());
    }
    Ok(DMat3::from_cols(
        DVec3::new(a, 0.0, 0.0),
        DVec3::new(b * cos_gamma, b * sin_gamma, 0.0),
        DVec3::new(c * cos_beta, c * y, c * z_squared.sqrt()),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_have_their_lengths_and_angles() {
        let lengths = [2.0, 3.0, 5.0];
        let angles = [70.0, 100.0, 110.0];
        let m = edges(lengths, angles).unwrap();
        let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
        for (edge, length) in [a, b, c].into_iter().zip(lengths) {
            assert!((edge.length() - length).abs() < 1e-12);
        }
        for ((p, q), angle) in [(b, c), (c, a), (a, b)].into_iter().zip(angles) {
            assert!((p.angle_between(q).to_degrees() - angle).abs() < 1e-9, "{angle}");
        }
        assert!(m.determinant() > 0.0);
        assert_eq!(edges(lengths, [90.0; 3]).unwrap(), DMat3::from_diagonal(DVec3::from_array(lengths)));
    }

    #[test]
    fn refuses_cells_that_do_not_close() {
        for angles in [[10.0, 20.0, 40.0], [0.0, 90.0, 90.0], [90.0, 180.0, 90.0], [f64::NAN, 90.0, 90.0], [120.0; 3]] {
            assert!(edges([1.0; 3], angles).is_err(), "{angles:?}");
        }
        for lengths in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, f64::INFINITY]] {
            assert!(edges(lengths, [90.0; 3]).is_err(), "{lengths:?}");
        }
    }
}
