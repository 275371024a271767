//! Positions of the planes of a rectilinear grid, along each axis, from the pieces that share them.

use crate::error::{FieldError, FileErrorKind};
use crate::scalar::ScalarType;
use crate::vtk::Extent;
use crate::vtk::lattice_file::LatticePiece;

/// Puts the positions of all pieces at their places along the axes of the whole.
///
/// # Errors
/// Damaged arrays, pieces that leave planes out, and pieces that place one plane differently.
pub(super) fn joined(whole: &Extent, pieces: &[LatticePiece]) -> Result<[Vec<f64>; 3], FileErrorKind> {
    let mut axes = [Vec::new(), Vec::new(), Vec::new()];
    for (axis, all) in axes.iter_mut().enumerate() {
        let wrong = |found: String, allowed: &str| FieldError::new(format!("Coordinates, axis {axis}"), found, allowed);
        // Nothing is allocated beyond what the pieces can fill.
        let planes = whole.dims(false)[axis];
        let there = pieces.iter().fold(0usize, |sum, piece| sum.saturating_add(piece.extent.dims(false)[axis]));
        if planes > there {
            let found = format!("{there} planes in all pieces");
            return Err(wrong(found, "pieces must fill a box of points").into());
        }
        let mut precision = 0.0f64;
        let mut joined: Vec<Option<f64>> = Vec::new();
        for piece in pieces {
            let array = piece.coordinates.get(axis).ok_or_else(|| wrong("none".into(), "there must be one array"))?;
            let positions = array.numbers(piece.extent.dims(false)[axis], &piece.store)?;
            precision = precision.max(precision_of(array.scalar));
            // After the first array has been found as long as its piece says.
            joined.resize(planes, None);
            let first = usize::try_from(piece.extent.first()[axis] - whole.first()[axis]).unwrap_or(usize::MAX);
            for (i, position) in positions.into_iter().enumerate() {
                let plane = first.saturating_add(i);
                let place = joined.get_mut(plane).ok_or_else(|| wrong(plane.to_string(), "is beyond the others"))?;
                if let Some(before) = place.filter(|&before| before != position) {
                    let found = format!("plane {plane} at {before} and at {position}");
                    return Err(wrong(found, "pieces must share the planes where they meet").into());
                }
                *place = Some(position);
            }
        }
        let gap = || wrong("planes in no piece".into(), "pieces must fill a box of points");
        let positions: Vec<f64> = joined.into_iter().collect::<Option<_>>().ok_or_else(gap)?;
        *all = evened(positions, precision);
    }
    Ok(axes)
}

/// Relative rounding of the positions of a type.
pub(super) fn precision_of(scalar: ScalarType) -> f64 {
    if scalar == ScalarType::F32 { f32::EPSILON.into() } else { f64::EPSILON }
}

/// The same positions, made even where only the rounding of the file's type tells them from even ones.
pub(super) fn evened(positions: Vec<f64>, precision: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (positions.first().copied(), positions.last().copied()) else { return positions };
    let step = (last - first) / (positions.len() - 1).max(1) as f64;
    let tolerance = precision * first.abs().max(last.abs());
    let even = |i: usize| first + i as f64 * step;
    // Where rounding hides the steps, they are what the file says.
    let is_even = step.is_finite()
        && tolerance < 0.01 * step.abs()
        && positions.iter().enumerate().all(|(i, x)| (x - even(i)).abs() <= tolerance);
    if is_even { (0..positions.len()).map(even).collect() } else { positions }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_steps_are_even_and_others_stay() {
        let floats: Vec<f64> = (0..60).map(|i| f64::from(0.1f32 * i as f32 + 7.0)).collect();
        let even = evened(floats.clone(), f32::EPSILON.into());
        let steps: Vec<f64> = even.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1e-12), "{steps:?}");
        assert!(even.iter().zip(&floats).all(|(a, b)| (a - b).abs() < 2e-6));
        assert_eq!(evened(floats.clone(), f64::EPSILON), floats);
        for other in [vec![], vec![1.0], vec![0.0, 0.4, 1.0], vec![0.0, f64::NAN, 1.0], vec![3.0, 2.0]] {
            assert_eq!(format!("{:?}", evened(other.clone(), 1e-7)), format!("{other:?}"));
        }
    }
}
