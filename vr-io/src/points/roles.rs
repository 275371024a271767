//! Roles of a file's columns.

use crate::error::FieldError;
use crate::names::{missing, named, plain};

use super::PointOptions;

/// Roles that a column may have, with at most one column each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Roles<T> {
    pub radius: Option<T>,
    pub smoothing: Option<T>,
    pub mass: Option<T>,
    pub density: Option<T>,
    pub weight: Option<T>,
    pub value: Option<T>,
    pub color: Option<T>,
}

/// Names as [`plain`] makes them, of which the first one found has the role. Single letters that also name parts of a velocity or a
/// colour are left to the user.
const RADIUS: &[&str] = &["radius", "radii", "supportradius", "r"];
const SMOOTHING: &[&str] = &["smoothinglength", "smoothinglengths", "hsml", "smoothing", "h"];
const MASS: &[&str] = &["mass", "masses", "particlemass", "m"];
const DENSITY: &[&str] = &["density", "densities", "rho"];
const WEIGHT: &[&str] = &["weight", "weights"];
const VALUE: &[&str] =
    &["value", "values", "scalar", "scalars", "temperature", "internalenergy", "pressure", "intensity"];

/// The value of this name is 1 at every point.
pub(super) const ONE: &str = "1";

impl Roles<usize> {
    /// Finds the columns among their names: those that options name, then those with a name that is commonly used.
    ///
    /// # Errors
    /// A name that options give and that no column has.
    pub fn choose(names: &[String], options: &PointOptions) -> Result<Self, FieldError> {
        let columns = &options.columns;
        // Red, green and blue, not a radius.
        let colours = usual(names, &["g"]).is_some() && usual(names, &["b"]).is_some();
        let radius = if colours { &RADIUS[..RADIUS.len() - 1] } else { RADIUS };
        let value = match options.value.as_deref() {
            Some(ONE) => None,
            chosen => role("value", chosen, names, VALUE)?,
        };
        Ok(Self {
            radius: role("radius", columns.radius.as_deref(), names, radius)?,
            smoothing: role("smoothing_length", columns.smoothing_length.as_deref(), names, SMOOTHING)?,
            mass: role("mass", columns.mass.as_deref(), names, MASS)?,
            density: role("density", columns.density.as_deref(), names, DENSITY)?,
            weight: role("weight", columns.weight.as_deref(), names, WEIGHT)?,
            value,
            color: options
                .color_value
                .as_deref()
                .map_or(Ok(None), |name| role("color_value", Some(name), names, &[]))?,
        })
    }

    /// The columns that have a role, in the order in which [`Self::try_map`] takes them.
    pub fn list(&self) -> Vec<usize> {
        let roles = [self.radius, self.smoothing, self.mass, self.density, self.weight, self.value, self.color];
        roles.into_iter().flatten().collect()
    }
}

impl<T> Roles<T> {
    /// Loads what there is.
    pub fn try_map<U, E>(self, mut load: impl FnMut(T) -> Result<U, E>) -> Result<Roles<U>, E> {
        let mut one = |column: Option<T>| column.map(&mut load).transpose();
        Ok(Roles {
            radius: one(self.radius)?,
            smoothing: one(self.smoothing)?,
            mass: one(self.mass)?,
            density: one(self.density)?,
            weight: one(self.weight)?,
            value: one(self.value)?,
            color: one(self.color)?,
        })
    }
}

/// The columns of the three coordinates.
///
/// # Errors
/// A name that options give and that no column has; none that looks like one.
pub(super) fn positions(names: &[String], options: &PointOptions) -> Result<[usize; 3], FieldError> {
    let mut found = [0; 3];
    for (axis, place) in found.iter_mut().enumerate() {
        let chosen = options.columns.position.as_ref().map(|p| p[axis].as_str());
        let field = ["x", "y", "z"][axis];
        *place = match chosen {
            Some(name) => named(names, name).ok_or_else(|| missing(&format!("position ({field})"), name, names))?,
            None => names.iter().position(|n| is_coordinate(&plain(n), axis)).ok_or_else(|| {
                let allowed = "positions need columns x, y and z, or px, py, pz, …, or three that options name";
                FieldError::new(format!("column {field}"), names.join(", "), allowed)
            })?,
        };
    }
    Ok(found)
}

/// True if a header's words name the three coordinates.
pub(super) fn name_positions(names: &[String]) -> bool {
    (0..3).all(|axis| names.iter().any(|n| is_coordinate(&plain(n), axis)))
}

/// x, pos_x, Coordinates:0, xpos, …
fn is_coordinate(plain: &str, axis: usize) -> bool {
    let (letter, digit) = [("x", "0"), ("y", "1"), ("z", "2")][axis];
    let is_word = |word: &str| {
        matches!(
            word,
            "p" | "pos"
                | "position"
                | "positions"
                | "coord"
                | "coords"
                | "coordinate"
                | "coordinates"
                | "point"
                | "points"
        )
    };
    plain == letter
        || plain.strip_suffix(letter).is_some_and(is_word)
        || plain.strip_suffix(digit).is_some_and(is_word)
        || plain.strip_prefix(letter).is_some_and(is_word)
}

fn role(field: &str, chosen: Option<&str>, names: &[String], usually: &[&str]) -> Result<Option<usize>, FieldError> {
    match chosen {
        Some(name) => named(names, name).map(Some).ok_or_else(|| missing(field, name, names)),
        None => Ok(usual(names, usually)),
    }
}

/// The column with the first of the names.
fn usual(names: &[String], usually: &[&str]) -> Option<usize> {
    usually.iter().find_map(|u| names.iter().position(|n| plain(n) == *u))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        text.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn coordinates_have_many_names() {
        for text in [
            "x y z",
            "PX PY PZ",
            "Points:0 Points:1 Points:2",
            "pos_x pos_y pos_z",
            "x[mm] y[mm] z[mm]",
            "XPos YPos ZPos",
        ] {
            assert!(name_positions(&names(text)), "{text}");
            assert_eq!(positions(&names(text), &PointOptions::default()).unwrap(), [0, 1, 2]);
        }
        assert!(!name_positions(&names("x y w")) && !name_positions(&names("0 1 2")));
        let mut options = PointOptions::default();
        options.columns.position = Some(["c", "a", "b"].map(str::to_owned));
        assert_eq!(positions(&names("a b c"), &options).unwrap(), [2, 0, 1]);
        assert!(positions(&names("a b d"), &options).unwrap_err().allowed.contains("a, b, d"));
    }

    #[test]
    fn roles_are_found_by_name() {
        let found = Roles::choose(&names("Hsml x Masses rho Temperature"), &PointOptions::default()).unwrap();
        let expected =
            Roles { smoothing: Some(0), mass: Some(2), density: Some(3), value: Some(4), ..Roles::default() };
        assert_eq!(found, expected);
        // Colours are no radius.
        assert_eq!(Roles::choose(&names("x y z r g b"), &PointOptions::default()).unwrap().radius, None);
        assert_eq!(Roles::choose(&names("x y z r"), &PointOptions::default()).unwrap().radius, Some(3));
    }

    #[test]
    fn options_choose() {
        let mut options = PointOptions { value: Some("Bz".to_owned()), ..PointOptions::default() };
        options.columns.mass = Some("w".to_owned());
        let found = Roles::choose(&names("value bz w"), &options).unwrap();
        assert_eq!((found.value, found.mass), (Some(1), Some(2)));
        options.value = Some(ONE.to_owned());
        assert_eq!(Roles::choose(&names("value w"), &options).unwrap().value, None);
        options.color_value = Some("w".to_owned());
        assert_eq!(
            Roles::choose(&names("value w"), &options).unwrap().color,
            Some(1),
            "also where it has another role"
        );
        options.value = Some("vorticity".to_owned());
        let error = Roles::choose(&names("value w"), &options).unwrap_err();
        assert_eq!((error.field.as_str(), error.found.as_str()), ("value", "vorticity"));
    }
}
