//! Lattices of levels, from the positions and distances that files tell in a few digits.

use glam::DVec3;

use crate::error::FieldError;

/// Largest relative error of a distance that a file tells.
const DIGITS: f64 = 1e-3;
/// Largest error of a position, in cells.
const SHIFT: f64 = 0.05;
/// Indices beyond this cannot be told from their neighbours in 64-bit floats of a few digits.
const MAX_INDEX: f64 = 4e15;

/// Cells of a finer level along the edges of a coarser one's cell.
///
/// # Errors
/// Distances that do not divide by whole numbers.
pub(super) fn ratios_of(coarse: DVec3, fine: DVec3, field: &str) -> Result<[u32; 3], FieldError> {
    let mut ratios = [0; 3];
    for (a, ratio) in ratios.iter_mut().enumerate() {
        let exact = coarse[a] / fine[a];
        let whole = exact.round();
        if !((1.0..=f64::from(u32::MAX)).contains(&whole) && (exact - whole).abs() <= DIGITS * whole) {
            let found = format!("{} on the level below {}, along axis {a}", fine[a], coarse[a]);
            return Err(FieldError::new(field, found, "must divide that of the level before by a whole number"));
        }
        *ratio = whole as u32;
    }
    Ok(ratios)
}

/// Index of the cell that begins at a position.
///
/// # Errors
/// A position that is not the corner of a cell.
pub(super) fn index_of(position: DVec3, origin: DVec3, spacing: DVec3, field: &str) -> Result<[i64; 3], FieldError> {
    let exact = (position - origin) / spacing;
    let whole = exact.round();
    if whole.abs().cmplt(DVec3::splat(MAX_INDEX)).all() && (exact - whole).abs().cmple(DVec3::splat(SHIFT)).all() {
        return Ok(whole.to_array().map(|x| x as i64));
    }
    let DVec3 { x, y, z } = position;
    let allowed = format!(
        "must be a corner of a cell of its level: {} {} {} and steps of {} {} {}",
        origin.x, origin.y, origin.z, spacing.x, spacing.y, spacing.z
    );
    Err(FieldError::new(field, format!("{x} {y} {z}"), allowed))
}

/// Cells of a level along the edges of a cell of another one, from the ratios of the levels between.
pub(super) fn spacing_of(spacing: DVec3, ratios: &[[u32; 3]], level: usize) -> DVec3 {
    ratios.iter().take(level).fold(spacing, |spacing, ratio| spacing / DVec3::from_array(ratio.map(f64::from)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_digits_are_enough() {
        let coarse = DVec3::new(0.833333, 0.833333, 0.666667);
        assert_eq!(ratios_of(coarse, DVec3::new(0.416667, 0.208333, 0.666667), "spacing"), Ok([2, 4, 1]));
        for wrong in [DVec3::splat(0.5), DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::splat(-0.4), DVec3::splat(2.0)] {
            let error = ratios_of(coarse, wrong, "spacing").unwrap_err().to_string();
            assert!(error.contains("whole number"), "{error}");
        }
        assert_eq!(spacing_of(DVec3::splat(12.0), &[[2, 3, 1], [2, 2, 2]], 2), DVec3::new(3.0, 2.0, 6.0));
    }

    #[test]
    fn positions_are_corners_of_cells() {
        let spacing = DVec3::new(0.208333, 0.208333, 0.166667);
        let origin = DVec3::new(-1.75, -1.25, 0.0);
        let at = DVec3::new(-0.5000000298, -2.98e-8, 1.0);
        assert_eq!(index_of(at, origin, spacing, "Origin"), Ok([6, 6, 6]));
        for wrong in [DVec3::splat(0.1), DVec3::splat(f64::NAN), DVec3::splat(1e300)] {
            assert!(index_of(wrong, origin, spacing, "Origin").is_err());
        }
    }
}
