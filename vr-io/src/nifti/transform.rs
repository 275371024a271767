//! Transform from voxel to world, by one of the three methods that a header can hold.

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::error::FieldError;

use super::header::Header;

/// Transform of a NIfTI file that places the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Transform {
    /// The sform if its code is above 0, else the qform if its is, else spacing alone.
    #[default]
    Auto,
    /// The affine map in srow_x, srow_y, srow_z.
    Sform,
    /// Rotation by a quaternion, and offsets.
    Qform,
    /// Spacing alone, from the world's origin.
    Spacing,
}

/// Origin and steps in RAS.
pub(super) struct Placed {
    pub origin: DVec3,
    pub axes: DMat3,
    pub by: &'static str,
}

pub(super) fn place(header: &Header, wanted: Transform, notes: &mut Vec<String>) -> Result<Placed, FieldError> {
    let code = |name: &str, code: i32| match code {
        1.. => Ok(()),
        _ => Err(FieldError::new(format!("{name}_code"), code, format!("must be above 0 to use the {name}"))),
    };
    let chosen = match wanted {
        Transform::Auto if header.sform_code > 0 => Transform::Sform,
        Transform::Auto if header.qform_code > 0 => Transform::Qform,
        Transform::Auto => Transform::Spacing,
        given => given,
    };
    let placed = match chosen {
        Transform::Sform => {
            code("sform", header.sform_code)?;
            sform(header)
        }
        Transform::Qform => {
            code("qform", header.qform_code)?;
            qform(header)?
        }
        Transform::Auto | Transform::Spacing => {
            let axes = DMat3::from_diagonal(DVec3::from_array(spacing(header)?));
            Placed { origin: DVec3::ZERO, axes, by: "spacing" }
        }
    };
    // Other programs choose otherwise: where that would show, say it.
    if chosen == Transform::Sform && header.qform_code > 0 {
        let differ = qform(header).map_or(true, |q| {
            let scale = placed.axes.abs().to_cols_array().into_iter().fold(0.0, f64::max);
            !q.axes.abs_diff_eq(placed.axes, 1e-3 * scale) || !q.origin.abs_diff_eq(placed.origin, scale)
        });
        if differ {
            notes.push("placed by the sform; the qform says otherwise (the transform `qform` takes that)".into());
            return Ok(placed);
        }
    }
    notes.push(match chosen {
        Transform::Sform | Transform::Qform => format!("placed by the {}", placed.by),
        _ => "neither sform nor qform: placed by spacing alone".into(),
    });
    Ok(placed)
}

fn sform(header: &Header) -> Placed {
    let [x, y, z] = header.srow;
    let column = |c: usize| DVec3::new(x[c], y[c], z[c]);
    Placed { origin: column(3), axes: DMat3::from_cols(column(0), column(1), column(2)), by: "sform" }
}

fn qform(header: &Header) -> Result<Placed, FieldError> {
    let [b, c, d] = header.quatern;
    // The quaternion has unit length; rounding may leave nothing for its real part.
    let a = (1.0 - b * b - c * c - d * d).max(0.0).sqrt();
    let length = (a * a + b * b + c * c + d * d).sqrt();
    if !(0.9..1.1).contains(&length) {
        let found = format_args!("{b} {c} {d}");
        return Err(FieldError::new("quatern_b, c, d", found, "must have b² + c² + d² of at most 1"));
    }
    let rotation = DMat3::from_quat(DQuat::from_xyzw(b, c, d, a).normalize());
    let mut spacing = spacing(header)?;
    // qfac: −1 turns the third axis; 0 counts as 1.
    if header.pixdim[0] < 0.0 {
        spacing[2] = -spacing[2];
    }
    let axes = rotation * DMat3::from_diagonal(DVec3::from_array(spacing));
    Ok(Placed { origin: DVec3::from_array(header.qoffset), axes, by: "qform" })
}

fn spacing(header: &Header) -> Result<[f64; 3], FieldError> {
    let [_, x, y, z, ..] = header.pixdim;
    for (axis, s) in [x, y, z].into_iter().enumerate() {
        if !(s > 0.0 && s.is_finite()) {
            return Err(FieldError::new(format!("pixdim[{}]", axis + 1), s, "must be positive and finite"));
        }
    }
    Ok([x, y, z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Endian;

    fn header() -> Header {
        let mut head = vec![0u8; 348];
        head[0..4].copy_from_slice(&348i32.to_le_bytes());
        head[344..348].copy_from_slice(b"n+1\0");
        let mut h = Header::parse(&head).unwrap();
        assert_eq!(h.endian, Endian::Little);
        h.pixdim = [-1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        h.qform_code = 1;
        // A quarter turn about z: x goes to y.
        h.quatern = [0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
        h.qoffset = [7.0, 8.0, 9.0];
        h
    }

    fn near(a: DVec3, b: [f64; 3]) -> bool {
        (a - DVec3::from_array(b)).length() < 1e-12
    }

    #[test]
    fn quaternion_and_qfac() {
        let p = place(&header(), Transform::Auto, &mut Vec::new()).unwrap();
        assert_eq!(p.by, "qform");
        assert!(near(p.axes.x_axis, [0.0, 2.0, 0.0]));
        assert!(near(p.axes.y_axis, [-3.0, 0.0, 0.0]));
        assert!(near(p.axes.z_axis, [0.0, 0.0, -4.0]));
        assert!(near(p.origin, [7.0, 8.0, 9.0]));
    }

    #[test]
    fn sform_comes_first_unless_another_is_asked_for() {
        let mut h = header();
        h.sform_code = 2;
        h.srow = [[1.0, 0.0, 0.5, 10.0], [0.0, 1.0, 0.0, 20.0], [0.0, 0.0, 1.0, 30.0]];
        let mut notes = Vec::new();
        let p = place(&h, Transform::Auto, &mut notes).unwrap();
        assert_eq!((p.by, p.axes.z_axis), ("sform", DVec3::new(0.5, 0.0, 1.0)));
        assert!(notes[0].contains("qform says otherwise"));
        assert_eq!(place(&h, Transform::Qform, &mut notes).unwrap().by, "qform");
        assert_eq!(place(&h, Transform::Spacing, &mut notes).unwrap().origin, DVec3::ZERO);
        h.sform_code = 0;
        assert!(place(&h, Transform::Sform, &mut notes).is_err());
    }

    #[test]
    fn refuses_quaternions_that_are_none() {
        let mut h = header();
        h.quatern = [1.0, 1.0, 1.0];
        assert!(qform(&h).is_err());
        h.quatern = [f64::NAN, 0.0, 0.0];
        assert!(qform(&h).is_err());
    }
}
