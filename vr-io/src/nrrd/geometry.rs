//! Placement of the voxels: space directions and origin, or spacings, with their units.

use std::path::Path;

use glam::{DMat3, DVec3};
use vr_core::Placement;

use crate::error::{FieldError, FileError};
use crate::layout::{Axis, Role};
use crate::notes::{Assumption, Notes};
use crate::world::Space;

use super::header::Header;

pub(super) struct World {
    pub placement: Placement,
    pub placed_by: &'static str,
    pub space: Space,
    pub units: Option<String>,
}

pub(super) fn world(path: &Path, header: &Header, axes: &[Axis], notes: &mut Notes) -> Result<World, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let space = space(header).map_err(in_file)?;
    let has_directions = header.get("space directions").is_some();
    if has_directions {
        if header.get("space").is_some_and(|name| name.to_lowercase().contains("left-handed")) {
            notes.push("the file's space is left-handed and is shown as if right-handed: a mirror image".into());
        }
        oriented(path, header, axes, space, notes)
    } else {
        if let Some(name) = header.get("space") {
            notes.push(format!("space {name} without space directions says nothing: the file's own frame is kept"));
        }
        spaced(path, header, axes, notes)
    }
}

/// The patient space, if the header names one.
fn space(header: &Header) -> Result<Space, FieldError> {
    let Some(name) = header.get("space") else { return Ok(Space::Own) };
    let lower = name.to_lowercase();
    Ok(match lower.trim_end_matches("-time") {
        "right-anterior-superior" => Space::Ras,
        "left-anterior-superior" => Space::Las,
        "left-posterior-superior" => Space::Lps,
        "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => Space::Own,
        _ => match lower.trim_end_matches('t') {
            "ras" => Space::Ras,
            "las" => Space::Las,
            "lps" => Space::Lps,
            _ => {
                let allowed = "must be right-anterior-superior, left-anterior-superior, left-posterior-superior, \
                               scanner-xyz, 3D-right-handed or 3D-left-handed";
                return Err(FieldError::new("space", name, allowed));
            }
        },
    })
}

/// Places voxels by space directions: the world vectors from voxel to voxel.
fn oriented(path: &Path, header: &Header, axes: &[Axis], space: Space, notes: &mut Notes) -> Result<World, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    // One number for each axis of the world; a fourth one is time.
    let in_space = |field: &str, v: &[f64]| match *v {
        [x, y, z] | [x, y, z, _] => Ok(DVec3::new(x, y, z)),
        _ => Err(FieldError::new(field, format_args!("a vector of {} numbers", v.len()), "must have three")),
    };
    // Take the directions and the origin, which need three numbers each.
    let directions = header.vectors("space directions").map_err(in_file)?.unwrap_or_default();
    let columns = axes
        .iter()
        .zip(&directions)
        .filter(|(axis, _)| axis.role == Role::Space)
        .map(|(_, d)| in_space("space directions", d.as_deref().unwrap_or_default()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(in_file)?;
    let [x, y, z] = columns[..] else {
        return Err(in_file(FieldError::new("space directions", columns.len(), "three axes of space need three")));
    };
    let origin = match header.vectors("space origin").map_err(in_file)?.as_deref() {
        Some([Some(v)]) => in_space("space origin", v).map_err(in_file)?,
        Some(other) => {
            let found = format!("{} vectors", other.len());
            return Err(in_file(FieldError::new("space origin", found, "must be one vector like (0,0,0)")));
        }
        None => {
            notes.assume(Assumption::Origin, "no space origin: 0, 0, 0 is assumed");
            DVec3::ZERO
        }
    };
    // Bring both to one unit, and the world to RAS.
    let units = header.quoted("space units");
    let (scale, unit) = common_unit("space units", units.as_deref().unwrap_or_default(), notes);
    let scale = DVec3::from_array(scale);
    let matrix = DMat3::from_diagonal(scale) * DMat3::from_cols(x, y, z);
    let placement = space.place(scale * origin, matrix).map_err(|e| FileError::new(path, e))?;
    Ok(World { placement, placed_by: "space directions", space, units: unit })
}

/// Places voxels by spacings (or axis mins and maxs), along the axes of the file's own frame.
fn spaced(path: &Path, header: &Header, axes: &[Axis], notes: &mut Notes) -> Result<World, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    // Read the numbers of the three axes of space.
    let n = axes.len();
    let of_space = |list: Vec<f64>| -> [f64; 3] {
        let mut numbers = axes.iter().zip(list).filter(|(a, _)| a.role == Role::Space).map(|(_, x)| x);
        std::array::from_fn(|_| numbers.next().unwrap_or(f64::NAN))
    };
    let per_axis = |field| header.per_axis(field, n).map(|o| o.map(of_space)).map_err(in_file);
    let (spacings, mins, maxs) = (per_axis("spacings")?, per_axis("axis mins")?, per_axis("axis maxs")?);
    let centers = match header.words("centers", n).map_err(in_file)? {
        None => header.words("centerings", n).map_err(in_file)?,
        some => some,
    };
    let cell_centred: Vec<bool> = (0..n)
        .filter(|&a| axes[a].role == Role::Space)
        .map(|a| centers.as_ref().is_some_and(|c| c[a] == "cell"))
        .collect();
    let size: Vec<usize> = axes.iter().filter(|a| a.role == Role::Space).map(|a| a.size).collect();

    // Find the spacing and the origin.
    let (mut spacing, placed_by) = match (spacings, mins, maxs) {
        (Some(s), ..) => (s, "spacings"),
        // Cells fill the range from end to end; nodes have one less step than there are of them.
        (None, Some(low), Some(high)) => {
            let steps = |a: usize| (if cell_centred[a] { size[a] } else { size[a] - 1 }) as f64;
            (std::array::from_fn(|a| (high[a] - low[a]) / steps(a)), "axis mins and maxs")
        }
        _ => {
            notes.assume(Assumption::Spacing, "no spacing in the header: 1, 1, 1 is assumed");
            ([1.0; 3], "assumed")
        }
    };
    if let Some(axis) = spacing.iter().position(|s| s.is_nan()) {
        let allowed = format!("the spacing of axis {axis} is unknown; it must be positive and finite");
        return Err(in_file(FieldError::new("spacings", "NaN", allowed)));
    }
    let mut origin: [f64; 3] = std::array::from_fn(|a| match mins {
        Some(low) if low[a].is_finite() => low[a] + if cell_centred[a] { 0.5 * spacing[a] } else { 0.0 },
        _ => 0.0,
    });

    // Bring both to one unit.
    let units = header.quoted("units").unwrap_or_default();
    let units: Vec<&str> = if units.len() == n {
        units.into_iter().zip(axes).filter(|(_, a)| a.role == Role::Space).map(|(u, _)| u).collect()
    } else {
        Vec::new()
    };
    let (scale, unit) = common_unit("units", &units, notes);
    for a in 0..3 {
        spacing[a] *= scale[a];
        origin[a] *= scale[a];
    }
    let placement = Placement::oriented(DVec3::from_array(origin), spacing, DMat3::IDENTITY)
        .map_err(|e| FileError::new(path, e))?;
    Ok(World { placement, placed_by, space: Space::Own, units: unit })
}

/// Factors that bring three axes to the unit of the first one, and that unit. Where a unit is no length that we know, the
/// numbers stay as they are, and that is said.
fn common_unit(field: &str, units: &[&str], notes: &mut Vec<String>) -> ([f64; 3], Option<String>) {
    let &[first, second, third, ..] = units else { return ([1.0; 3], None) };
    if first.is_empty() && second.is_empty() && third.is_empty() {
        return ([1.0; 3], None);
    }
    if first == second && first == third {
        return ([1.0; 3], Some(first.to_owned()));
    }
    let metres = |unit: &str| {
        Some(match unit {
            "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
            "cm" | "centimeter" => 1e-2,
            "mm" | "millimeter" | "millimeters" => 1e-3,
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" => 1e-6,
            "nm" | "nanometer" => 1e-9,
            _ => return None,
        })
    };
    match (metres(first), metres(second), metres(third)) {
        (Some(a), Some(b), Some(c)) => {
            notes.push(format!("{field} differ ({first}, {second}, {third}): all lengths are turned to {first}"));
            ([1.0, b / a, c / a], Some(first.to_owned()))
        }
        _ => {
            notes.push(format!(
                "{field} differ ({first}, {second}, {third}) and are not all known: lengths stay as they are"
            ));
            ([1.0; 3], None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(fields: &str) -> Result<World, FileError> {
        let h = Header::parse(format!("NRRD0005\ndimension: 3\nsizes: 5 6 7\n{fields}").as_bytes()).unwrap();
        let axes = [5, 6, 7].map(|size| Axis { size, role: Role::Space });
        world(Path::new("x.nrrd"), &h, &axes, &mut Notes::default())
    }

    #[test]
    fn turns_left_spaces_to_ras() {
        let fields = "space directions: (0,2,0) (1,0,0) (0,0,3)\nspace origin: (10,20,30)\n";
        let lps = place(&format!("space: left-posterior-superior\n{fields}")).unwrap();
        assert_eq!(lps.placement.origin(), DVec3::new(-10.0, -20.0, 30.0));
        assert_eq!(lps.placement.axes().x_axis, DVec3::new(0.0, -2.0, 0.0));
        let las = place(&format!("space: LAS\n{fields}")).unwrap();
        assert_eq!(las.placement.origin(), DVec3::new(-10.0, 20.0, 30.0));
        let own = place(&format!("space: 3D-right-handed\n{fields}")).unwrap();
        assert_eq!(own.placement.origin(), DVec3::new(10.0, 20.0, 30.0));
        assert_eq!(own.space, Space::Own);
    }

    #[test]
    fn brings_units_together() {
        let w = place("spacings: 0.5 0.5 2000\nunits: \"mm\" \"mm\" \"um\"\n").unwrap();
        assert!((w.placement.spacing() - DVec3::new(0.5, 0.5, 2.0)).length() < 1e-12);
        assert_eq!(w.units.as_deref(), Some("mm"));
    }

    #[test]
    fn axis_mins_count_cells_and_nodes() {
        let w = place("axis mins: 0 0 0\naxis maxs: 4 6 7\ncenters: node cell cell\n").unwrap();
        assert_eq!(w.placement.spacing(), DVec3::ONE);
        assert_eq!(w.placement.origin(), DVec3::new(0.0, 0.5, 0.5));
    }

    #[test]
    fn never_a_geometry_of_nan() {
        for bad in [
            "spacings: nan nan nan\n",
            "spacings: 1 0 1\n",
            "spacings: 1 -1 1\n",
            "space directions: (nan,0,0) (0,1,0) (0,0,1)\n",
            "space directions: (1,0,0) (0,1,0) (1,1,0)\n",
            "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (nan,0,0)\n",
            "space directions: (1,0) (0,1) (0,0)\n",
            "axis mins: 0 0 0\naxis maxs: 0 1 1\n",
        ] {
            assert!(place(bad).is_err(), "{bad}");
        }
    }
}
