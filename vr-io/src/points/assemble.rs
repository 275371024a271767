//! Assembly of points from columns: radii, weights and values that a file holds, and assumptions for those that it lacks.

use glam::DVec3;
use vr_core::{PointSet, memory, number_text};

use super::neighbours;
use super::roles::Roles;
use super::{BYTES_PER_POINT, Column, PointOptions, Table};
use crate::error::FileErrorKind;

/// η: a smoothing length is so many mean distances of particles in smoothed particle hydrodynamics, h = η (m/ρ)^(1/3) (Price 2012,
/// "Smoothed particle hydrodynamics and magnetohydrodynamics", section 2.3).
const ETA: f64 = 1.2;
/// Radii in smoothing lengths: that is where the cubic spline ends.
const REACH: f64 = 2.0;
/// Points in a support of 2η mean distances: 4π/3 · 2.4³ = 57.9.
const NEIGHBOURS: usize = 58;

/// Makes points of a table. Tells in the notes what was assumed.
///
/// # Errors
/// A number that makes no sense, with its point and column; too few points, or all at one place, where radii are to be guessed.
pub(super) fn assemble(
    table: Table,
    options: &PointOptions,
    notes: &mut Vec<String>,
) -> Result<PointSet, FileErrorKind> {
    let Table { positions, columns, numbering } = table;
    // Refuse positions and numbers out of range.
    let place = |k: usize, what: &str| format!("{}, {what}", numbering.name(k));
    if let Some(k) = positions.iter().position(|p| !p.abs().cmplt(DVec3::splat(1e30)).all()) {
        let found = positions[k].to_array();
        return Err(FileErrorKind::field(
            place(k, "position"),
            format!("{found:?}"),
            "must be finite, and smaller than 1e30",
        ));
    }
    if positions.is_empty() {
        return Err(vr_core::PointError::Empty.into());
    }
    memory::check("the points", positions.len() as u64 * BYTES_PER_POINT)?;
    let all = |column: &Column, what: &str, allowed: &str, right: fn(f64) -> bool| match column
        .numbers
        .iter()
        .position(|&x| !right(x))
    {
        None => Ok(()),
        Some(k) => {
            Err(FileErrorKind::field(place(k, &format!("{what} '{}'", column.name)), show(column.numbers[k]), allowed))
        }
    };
    let length = (|x: f64| x > 1e-30 && x < 1e30, "must be positive, between 1e-30 and 1e30");
    let finite = (|x: f64| (x as f32).is_finite(), "must be finite, and below 3.4e38");
    let Roles { radius, smoothing, mass, density, weight, value, color } = &columns;
    for (column, what) in [(radius, "radius"), (smoothing, "smoothing length"), (density, "density")] {
        if let Some(column) = column {
            all(column, what, length.1, length.0)?;
        }
    }
    for (column, what) in [(mass, "mass"), (weight, "weight"), (value, "value"), (color, "color_value")] {
        if let Some(column) = column {
            all(column, what, finite.1, finite.0)?;
        }
    }

    // Choose the radii.
    let volumes: Option<Vec<f64>> = mass
        .as_ref()
        .zip(density.as_ref())
        .map(|(m, rho)| m.numbers.iter().zip(&rho.numbers).map(|(m, rho)| m / rho).collect());
    let radii = radii(&positions, (radius.as_ref(), smoothing.as_ref()), volumes.as_deref(), options, notes)?;
    let scale = options.radius_scale.unwrap_or(1.0);
    let scaled: Vec<f64> = radii.iter().map(|r| r * scale).collect();
    if let Some(k) = scaled.iter().position(|&r| !length.0(r)) {
        return Err(FileErrorKind::field(place(k, "radius"), show(scaled[k]), length.1));
    }

    // Choose weights and values so that the field follows the values, or else a density.
    let own_volumes = || radii.iter().map(|r| (r / (REACH * ETA)).powi(3)).collect();
    let ones = || vec![1.0; positions.len()];
    let numbers = |column: &Column| column.numbers.clone();
    let (weights, values) = match (weight, value, volumes) {
        (Some(w), v, _) => (numbers(w), v.as_ref().map_or_else(ones, numbers)),
        (None, Some(v), Some(volumes)) => (volumes, numbers(v)),
        (None, Some(v), None) => {
            notes.push(format!("weights: the volume (radius / {})^3 of each point", REACH * ETA));
            (own_volumes(), numbers(v))
        }
        (None, None, _) => {
            let (weights, field) = match (mass, density) {
                (Some(m), _) => (numbers(m), "the density of mass"),
                (None, Some(rho)) => {
                    let weights: Vec<f64> = own_volumes();
                    let masses = weights.iter().zip(&rho.numbers).map(|(volume, rho)| volume * rho).collect();
                    (masses, "the density")
                }
                (None, None) => (ones(), "the number of points per unit volume"),
            };
            notes.push(format!("no value is chosen: the field is {field}"));
            (weights, ones())
        }
    };
    // Round to single precision.
    let single = |numbers: Vec<f64>, what: &str| -> Result<Vec<f32>, FileErrorKind> {
        match numbers.iter().position(|&x| !(x as f32).is_finite()) {
            None => Ok(numbers.into_iter().map(|x| x as f32).collect()),
            Some(k) => Err(FileErrorKind::field(place(k, what), show(numbers[k]), finite.1)),
        }
    };
    let (weights, values) = (single(weights, "weight")?, single(values, "value")?);
    let radii = single(scaled, "radius")?;
    let points = PointSet::new(positions, radii, weights, values, options.kernel.unwrap_or_default())?;
    // Mix values, and make colours.
    let points = points.with_mixing(options.mixing.unwrap_or_default())?;
    match (color, &options.color_value) {
        (Some(color), _) => Ok(points.with_colors(colors(color, options, notes))?),
        (None, Some(name)) => {
            let allowed = "this file has no column besides the positions, of which colours could be made";
            Err(FileErrorKind::field("color_value", name, allowed))
        }
        (None, None) => Ok(points),
    }
}

/// Colours of a column's numbers.
fn colors(column: &Column, options: &PointOptions, notes: &mut Vec<String>) -> Vec<[f32; 3]> {
    let ends = || column.numbers.iter().fold([f64::MAX, f64::MIN], |[l, h], &x| [l.min(x), h.max(x)]);
    let [low, high] = options.color_range.unwrap_or_else(ends);
    let map = options.color_map.unwrap_or_default();
    let ends = [low, high].map(number_text);
    notes.push(format!("colours: '{}' from {} to {}, by {}", column.name, ends[0], ends[1], map.name()));
    let fraction = |x: f64| if high > low { (x - low) / (high - low) } else { 0.5 };
    column.numbers.iter().map(|&x| map.at(fraction(x)).map(|c| c.clamp(0.0, 1.0) as f32)).collect()
}

/// Formats a number, with an exponent where there would be many zeros.
fn show(number: f64) -> String {
    format!("{number:?}")
}

/// A radius each, not scaled yet: the user's, the file's, that of the smoothing length, of mass and density, or of the neighbours.
fn radii(
    positions: &[DVec3],
    (radius, smoothing): (Option<&Column>, Option<&Column>),
    volumes: Option<&[f64]>,
    options: &PointOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<f64>, FileErrorKind> {
    if let Some(radius) = options.radius {
        return Ok(vec![radius; positions.len()]);
    }
    if let Some(column) = radius {
        return Ok(column.numbers.clone());
    }
    if let Some(column) = smoothing {
        notes.push(format!("radii: {REACH} smoothing lengths, '{}'", column.name));
        return Ok(column.numbers.iter().map(|h| REACH * h).collect());
    }
    if let Some(volumes) = volumes {
        notes.push(format!("radii: {} (mass / density)^(1/3)", REACH * ETA));
        return Ok(volumes.iter().map(|&volume| REACH * ETA * libm::cbrt(volume)).collect());
    }
    let count = positions.len();
    let k = NEIGHBOURS.min(count - 1);
    let advice =
        "the file tells no radii, and they cannot be guessed from the neighbours: give one, or a column of them";
    if k == 0 {
        return Err(FileErrorKind::field("radius", "one point alone", advice));
    }
    let plain: Vec<[f64; 3]> = positions.iter().map(|p| p.to_array()).collect();
    let mut radii = neighbours::distances(&plain, k);
    if let Some(point) = radii.iter().position(|&r| r <= 0.0) {
        return Err(FileErrorKind::field("radius", format!("point {point} with {k} others at its place"), advice));
    }
    // Fewer points than a support would hold: as if it went on like that.
    let widened = libm::cbrt(NEIGHBOURS as f64 / k as f64);
    radii.iter_mut().for_each(|r| *r *= widened);
    notes.push(match k {
        NEIGHBOURS => format!("the file tells no radii: each reaches to the {NEIGHBOURS}th neighbour"),
        k => format!("the file tells no radii: each reaches {widened:.3} times as far as the {k} others"),
    });
    Ok(radii)
}

#[cfg(test)]
mod tests {
    use super::super::Numbering;
    use super::*;

    fn column(name: &str, numbers: &[f64]) -> Option<Column> {
        Some(Column { name: name.to_owned(), numbers: numbers.to_vec() })
    }

    fn three(columns: Roles<Column>, options: &PointOptions) -> Result<(PointSet, Vec<String>), String> {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(3.0, 0.0, 0.0)];
        let mut notes = Vec::new();
        let table = Table { positions, columns, numbering: Numbering::FromZero };
        match assemble(table, options, &mut notes) {
            Ok(points) => Ok((points, notes)),
            Err(e) => Err(e.to_string()),
        }
    }

    #[test]
    fn mass_and_density_are_a_volume() {
        let (mass, density) = (column("m", &[8.0; 3]), column("rho", &[1.0; 3]));
        let value = column("T", &[1.0, 2.0, 3.0]);
        let columns = Roles { mass, density, value, ..Roles::default() };
        let (points, notes) = three(columns.clone(), &PointOptions::default()).unwrap();
        assert_eq!((points.weights(), points.values()), (&[8.0; 3][..], &[1.0, 2.0, 3.0][..]));
        assert_eq!((points.radii(), notes.len()), (&[4.8; 3][..], 1));
        // Without a value, the density: Σ m W is Σ (m/ρ) ρ W.
        let (points, notes) = three(Roles { value: None, ..columns }, &PointOptions::default()).unwrap();
        assert_eq!((points.weights(), points.values()), (&[8.0; 3][..], &[1.0; 3][..]));
        assert!(notes[1].contains("density of mass"), "{notes:?}");
    }

    #[test]
    fn smoothing_lengths_are_half_a_radius_and_options_come_first() {
        let columns = Roles { smoothing: column("h", &[0.5, 1.0, 2.0]), ..Roles::default() };
        let (points, _) = three(columns.clone(), &PointOptions::default()).unwrap();
        assert_eq!(points.radii(), [1.0, 2.0, 4.0]);
        assert_eq!((points.weights(), points.values()), (&[1.0; 3][..], &[1.0; 3][..]));
        let options = PointOptions { radius: Some(3.0), radius_scale: Some(0.5), ..PointOptions::default() };
        assert_eq!(three(columns, &options).unwrap().0.radii(), [1.5; 3]);
    }

    #[test]
    fn neighbours_give_radii_where_nothing_else_does() {
        let (points, notes) = three(Roles::default(), &PointOptions::default()).unwrap();
        // The second of two others, and 29 times the volume.
        let widened = 29f64.cbrt();
        let expected = [3.0, 2.0, 3.0].map(|d| (d * widened) as f32);
        assert!(points.radii().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{:?}", points.radii());
        assert!(notes[0].contains("2 others") && notes[1].contains("number of points"), "{notes:?}");
    }

    #[test]
    fn nonsense_is_named() {
        let of = |columns| three(columns, &PointOptions::default()).unwrap_err();
        let error = of(Roles { smoothing: column("h", &[1.0, 0.0, 1.0]), ..Roles::default() });
        assert_eq!(error, "point 1, smoothing length 'h': found 0.0; must be positive, between 1e-30 and 1e30");
        for bad in [-1.0, f64::NAN, f64::INFINITY, 1e30] {
            let error = of(Roles { radius: column("R", &[1.0, 1.0, bad]), ..Roles::default() });
            assert!(error.contains("point 2, radius 'R'"), "{error}");
        }
        let error = of(Roles { value: column("T", &[1.0, 1.0, f64::NAN]), ..Roles::default() });
        assert!(error.contains("point 2, value 'T': found NaN"), "{error}");
        let rare = Roles { mass: column("m", &[1e20; 3]), density: column("rho", &[1e-25; 3]), ..Roles::default() };
        let error = of(Roles { value: column("T", &[1.0; 3]), ..rare });
        assert!(error.contains("point 0, weight: found 1e45"), "{error}");
    }
}
