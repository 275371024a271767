//! Roles and coordinates of a variable's axes.

use crate::decode::numbers_as_f64;
use crate::error::FileErrorKind;
use crate::layout::Role;

use super::{Store, Variable, text};

/// An axis of a variable.
#[derive(Clone, Debug)]
pub(super) struct VariableAxis {
    pub role: Role,
    /// Name, where the file has one.
    pub name: Option<String>,
    pub coordinates: Option<Coordinates>,
}

impl VariableAxis {
    /// Indices that a volume takes of an axis of `size`.
    pub fn count(&self, size: usize) -> usize {
        if self.role == Role::Space { size } else { 1 }
    }
}

/// Positions along an axis.
#[derive(Clone, Debug)]
pub(super) struct Coordinates {
    /// One for each index.
    pub values: Vec<f64>,
    pub unit: Option<String>,
    /// Axis of the world, 0 for x, that it runs along, where the file tells.
    pub world: Option<usize>,
    /// True if larger values lie lower.
    pub is_downward: bool,
}

/// Largest last axis that holds components, where nothing names the axes.
const MAX_COMPONENTS: usize = 4;

/// The axes of a variable, the slowest first. Three are of space.
pub(super) fn axes(
    store: &dyn Store,
    variable: &Variable,
    notes: &mut Vec<String>,
) -> Result<Vec<VariableAxis>, FileErrorKind> {
    let n = variable.shape.len();
    let mut axes = Vec::with_capacity(n);
    let mut is_time = vec![false; n];
    for (a, dimension) in variable.dimensions.iter().enumerate() {
        let name = dimension.as_deref().map(last_part).map(str::to_owned);
        let (coordinates, counts_time) = match dimension {
            Some(dimension) => coordinates(store, dimension, variable.shape[a])?,
            None => (None, false),
        };
        let lower = name.as_deref().unwrap_or_default().to_ascii_lowercase();
        is_time[a] = counts_time || matches!(lower.as_str(), "t" | "time");
        let is_component = matches!(lower.as_str(), "c" | "channel" | "channels" | "band" | "component");
        let role = match (is_time[a], is_component) {
            (true, _) => Role::Frame,
            (_, true) => Role::Component,
            _ => Role::Space,
        };
        axes.push(VariableAxis { role, name, coordinates });
    }
    let is_space = |axes: &[VariableAxis], a: usize| axes[a].role == Role::Space;
    let count = |axes: &[VariableAxis]| (0..n).filter(|&a| is_space(axes, a)).count();
    // Short last axes without a name hold the values of a vector or a colour.
    if count(&axes) > 3 && axes.iter().all(|axis| axis.name.is_none()) && variable.shape[n - 1] <= MAX_COMPONENTS {
        axes[n - 1].role = Role::Component;
    }
    // An axis of one element gives its place to time, so that maps over time are a volume.
    for a in 0..n {
        let is_flat = variable.shape[a] < 2 && is_space(&axes, a);
        if is_flat && (count(&axes) > 3 || (0..n).any(|t| is_time[t] && variable.shape[t] > 1)) {
            axes[a].role = Role::Frame;
        }
    }
    if count(&axes) == 2
        && let Some(time) = (0..n).find(|&a| is_time[a] && variable.shape[a] > 1)
    {
        axes[time].role = Role::Space;
        let name = axes[time].name.as_deref().unwrap_or("time");
        notes.push(format!("two axes are of space: {} is shown as the third", crate::error::shown(name)));
    }
    // The first of too many count frames.
    for a in 0..n {
        if count(&axes) > 3 && is_space(&axes, a) {
            axes[a].role = Role::Frame;
        }
    }
    Ok(axes)
}

/// Positions along a dimension, from the variable of its name, and true if they are times.
fn coordinates(store: &dyn Store, dimension: &str, size: usize) -> Result<(Option<Coordinates>, bool), FileErrorKind> {
    let Some(variable) = store.variables().iter().find(|v| v.name == dimension && v.shape == [size]) else {
        return Ok((None, false));
    };
    let unit = text(store, dimension, "units");
    let is_time = unit.as_deref().is_some_and(|unit| unit.contains(" since "));
    let bytes = store.read(variable, &[0], &[size])?;
    let values = numbers_as_f64(&bytes, variable.scalar, store.endian());
    let positive = text(store, dimension, "positive");
    let is_downward = positive.is_some_and(|p| p.eq_ignore_ascii_case("down"));
    let named = text(store, dimension, "axis").unwrap_or_else(|| last_part(dimension).to_owned());
    let world = world_axis(&named);
    let is_time = is_time || named.eq_ignore_ascii_case("t");
    Ok((Some(Coordinates { values, unit, world, is_downward }), is_time))
}

/// The axis of the world that an axis of this name runs along, as the CF conventions and their users name them.
pub(super) fn world_axis(name: &str) -> Option<usize> {
    match name.to_ascii_lowercase().as_str() {
        "x" | "lon" | "longitude" | "west_east" => Some(0),
        "y" | "lat" | "latitude" | "south_north" => Some(1),
        "z" | "lev" | "level" | "plev" | "depth" | "height" | "altitude" | "elevation" | "bottom_top" => Some(2),
        _ => None,
    }
}

fn last_part(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
