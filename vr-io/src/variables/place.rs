//! Placement of a variable's voxels, from coordinates along its axes or from attributes of its own.

use glam::{DMat3, DVec3};
use vr_core::Placement;

use crate::error::{FileErrorKind, shown};
use crate::layout::Role;
use crate::length_unit;
use crate::notes::{Assumption, Notes};

use super::axes::{Coordinates, VariableAxis, world_axis};
use super::{Store, Variable, numbers};

/// Placement of the voxels.
pub(super) struct Placed {
    pub placement: Placement,
    pub by: &'static str,
    pub unit: Option<String>,
}

/// Largest deviation of a step from the mean step that counts as even: what coordinates in 32 bits make of it.
const EVEN: f64 = 1e-2;

/// Places the voxels. The fastest axis is the world's x unless all three tell what they are.
pub(super) fn place(
    store: &dyn Store,
    variable: &Variable,
    axes: &[VariableAxis],
    notes: &mut Notes,
) -> Result<Placed, FileErrorKind> {
    // The fastest first, as a volume has them.
    let space: Vec<usize> = (0..axes.len()).rev().filter(|&a| axes[a].role == Role::Space).collect();
    let [x, y, z] = space[..] else {
        let found = format_args!("{} axes of space", space.len());
        return Err(FileErrorKind::field("shape", found, "a volume has three"));
    };
    let space = [x, y, z];
    // Fiji's and ilastik's files give the size of a voxel in the order of the axes.
    let sizes = numbers(store, &variable.name, "element_size_um");
    if sizes.len() >= 3 && sizes.iter().rev().take(3).all(|&s| s > 0.0 && s.is_finite()) {
        let spacing = [1, 2, 3].map(|back| sizes[sizes.len() - back]);
        let placement = Placement::from_spacing(spacing)?;
        return Ok(Placed { placement, by: "element_size_um", unit: Some("µm".to_owned()) });
    }
    let coordinates = space.map(|a| axes[a].coordinates.as_ref());
    let names = space.map(|a| axes[a].name.as_deref());
    let world = worlds(coordinates, names);
    let lines = coordinates.map(|c| c.and_then(line));
    // Lengths of one unit are places; anything else tells the directions at most.
    let units = coordinates.map(|c| c.and_then(|c| c.unit.as_deref()).filter(|u| *u != "1" && !u.is_empty()));
    let common = length_unit::common(units);
    let is_length =
        units == [None; 3] || units.iter().flatten().all(|u| length_unit::LengthUnit::from_name(u).is_some());
    if let [Some(a), Some(b), Some(c)] = &lines
        && is_length
        && (common.is_some() || units == [None; 3])
    {
        let (unit, factors) = common.map_or((None, [1.0; 3]), |(unit, factors)| (Some(unit), factors));
        let (mut steps, mut origin) = ([DVec3::ZERO; 3], DVec3::ZERO);
        for (i, line) in [a, b, c].into_iter().enumerate() {
            let sign = if coordinates[i].is_some_and(|c| c.is_downward) { -1.0 } else { 1.0 };
            steps[i][world[i]] = sign * line.step * factors[i];
            origin[world[i]] = sign * line.first * factors[i];
            if let Some((low, high)) = line.uneven {
                let name = shown(names[i].unwrap_or_default());
                notes.push(format!(
                    "steps along {name} are uneven, {low} to {high}: their mean, {}, is taken",
                    line.step
                ));
            }
        }
        let placement = Placement::new(origin, DMat3::from_cols(steps[0], steps[1], steps[2]))?;
        return Ok(Placed { placement, by: "coordinates", unit });
    }
    // Directions alone: north is up, and so is less pressure.
    let mut steps = [DVec3::ZERO; 3];
    for i in 0..3 {
        let is_backward = lines[i].as_ref().is_some_and(|line| line.step < 0.0);
        let is_downward = coordinates[i].is_some_and(|c| c.is_downward);
        steps[i][world[i]] = if is_backward != is_downward { -1.0 } else { 1.0 };
    }
    let why = if lines.iter().all(Option::is_none) {
        "no coordinates: spacing 1, 1, 1 is assumed".to_owned()
    } else {
        let word = |i: usize| format!("{} in {}", names[i].unwrap_or("an axis"), units[i].unwrap_or("no unit"));
        let [a, b, c] = [0, 1, 2].map(|i| shown(&word(i)));
        format!("coordinates ({a}, {b}, {c}) are no lengths of one unit: spacing 1, 1, 1 is assumed")
    };
    notes.assume(Assumption::Spacing, why);
    let placement = Placement::new(DVec3::ZERO, DMat3::from_cols(steps[0], steps[1], steps[2]))?;
    Ok(Placed { placement, by: "assumed", unit: None })
}

/// The axis of the world that each of the volume's runs along: what all three tell, or their order.
fn worlds(coordinates: [Option<&Coordinates>; 3], names: [Option<&str>; 3]) -> [usize; 3] {
    let told = [0, 1, 2].map(|i| coordinates[i].and_then(|c| c.world).or_else(|| world_axis(names[i]?)));
    let is_all = (0..3).all(|world| told.contains(&Some(world)));
    if is_all { told.map(Option::unwrap_or_default) } else { [0, 1, 2] }
}

/// Even coordinates.
struct Line {
    first: f64,
    step: f64,
    /// Smallest and largest step, where they differ.
    uneven: Option<(f64, f64)>,
}

/// First coordinate and mean step; `None` where they make no axis.
fn line(coordinates: &Coordinates) -> Option<Line> {
    let values = &coordinates.values;
    let (first, last) = (*values.first()?, *values.last()?);
    let step = (last - first) / (values.len() as f64 - 1.0);
    if !(step.is_finite() && step != 0.0) {
        return None;
    }
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let (low, high) = steps.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
    let is_even = (low - step).abs().max((high - step).abs()) <= EVEN * step.abs();
    // Coordinates that turn back are none.
    (low.signum() == high.signum()).then_some(Line { first, step, uneven: (!is_even).then_some((low, high)) })
}
