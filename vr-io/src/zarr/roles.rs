//! Roles of an array's axes, by their names.

use crate::error::FieldError;
use crate::layout::Role;

/// An axis of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NamedAxis {
    pub name: String,
    pub role: Role,
    pub unit: Option<String>,
}

impl NamedAxis {
    pub fn new(name: &str, role: Role) -> Self {
        Self { name: name.to_owned(), role, unit: None }
    }
}

/// The role of an axis with this name; `None` for names that are not known.
pub(super) fn by_name(name: &str) -> Option<Role> {
    match name.to_ascii_lowercase().as_str() {
        "x" | "y" | "z" => Some(Role::Space),
        "t" | "time" => Some(Role::Frame),
        "c" | "channel" | "channels" | "band" => Some(Role::Component),
        _ => None,
    }
}

/// The axis of the world, 0 for x, that an axis of this name runs along.
pub(super) fn world_axis(name: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|n| n.eq_ignore_ascii_case(name))
}

/// The axes of an array that nothing but its own names describes.
pub(super) fn of_array(
    count: usize,
    names: Option<&[String]>,
    notes: &mut Vec<String>,
) -> Result<Vec<NamedAxis>, FieldError> {
    if let Some(names) = names.filter(|n| n.len() == count) {
        let roles: Option<Vec<Role>> = names.iter().map(|n| by_name(n)).collect();
        if let Some(roles) = roles {
            return Ok(names.iter().zip(roles).map(|(name, role)| NamedAxis::new(name, role)).collect());
        }
    }
    let names: &[&str] = match count {
        3 => &["z", "y", "x"],
        4 => &["t", "z", "y", "x"],
        5 => &["t", "c", "z", "y", "x"],
        _ => return Err(FieldError::new("shape", format_args!("{count} axes"), "must be 3 to 5")),
    };
    notes.push(format!("the axes have no known names: {} are assumed", names.join(", ")));
    Ok(names.iter().map(|name| NamedAxis::new(name, by_name(name).unwrap_or(Role::Space))).collect())
}
