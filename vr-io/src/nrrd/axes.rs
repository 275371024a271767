//! Roles of the array's axes: space, components of a voxel, or frames.

use crate::error::FieldError;
use crate::layout::{Axis, Role};
use crate::scalar::ScalarType;

use super::header::Header;

/// The axes, fastest first. Space directions tell most, kinds come next; where a file has neither, the first three axes are
/// space and the others frames.
pub(super) fn axes(header: &Header, sizes: &[usize], scalar: ScalarType) -> Result<Vec<Axis>, FieldError> {
    let n = sizes.len();
    let kinds = header.words("kinds", n)?;
    let spacings = header.per_axis("spacings", n)?;
    let directions = header.vectors("space directions")?;
    if let Some(d) = &directions
        && d.len() != n
    {
        let allowed = format!("must be {n} vectors (or none), one for each axis");
        return Err(FieldError::new("space directions", format_args!("{} vectors", d.len()), allowed));
    }
    let looks_like_colours = (3..=4).contains(&sizes[0]) && scalar == ScalarType::U8;
    if n == 3 && looks_like_colours && kinds.is_none() && spacings.is_none() && directions.is_none() {
        return Err(FieldError::new(
            "sizes",
            format_args!("{} {} {} of 8 bits, no kinds", sizes[0], sizes[1], sizes[2]),
            "that is a picture with colours, not a volume; if it is one, say 'kinds: domain domain domain'",
        ));
    }

    let mut space_axes = 0;
    let mut role_of = |axis: usize| {
        let kind = kinds.as_ref().map_or("", |k| k[axis]);
        let is_space = match &directions {
            // In a space with time, the vector of the time axis has no length in space.
            Some(d) => d[axis].as_ref().is_some_and(|v| v.len() < 4 || v[..3] != [0.0; 3]),
            None => match kind {
                "domain" | "space" => true,
                // NaN stands for a spacing that makes no sense, as that of components.
                "" | "???" | "none" => spacings.as_ref().is_none_or(|s| n <= 3 || !s[axis].is_nan()),
                _ => false,
            },
        };
        // A fourth axis of space has to be something else.
        if is_space && space_axes < 3 {
            space_axes += 1;
            return Role::Space;
        }
        match kind {
            "time" | "domain" | "space" => Role::Frame,
            "" | "???" | "none" | "list" if axis > 0 => Role::Frame,
            "RGB-color" | "3-color" if sizes[axis] == 3 => Role::Color,
            "RGBA-color" | "4-color" if sizes[axis] == 4 => Role::Color,
            // Kinds that say no more than that there are several.
            "" | "???" | "none" | "list" | "vector" if axis == 0 => Role::of_components(sizes[axis], scalar),
            _ => Role::Component,
        }
    };
    Ok((0..n).map(|axis| Axis { size: sizes[axis], role: role_of(axis) }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use Role::{Color, Component, Frame, Space};

    fn roles(fields: &str) -> Vec<Role> {
        let h = Header::parse(format!("NRRD0005\n{fields}").as_bytes()).unwrap();
        axes(&h, &h.sizes().unwrap(), ScalarType::U8).unwrap().iter().map(|a| a.role).collect()
    }

    #[test]
    fn directions_then_kinds_then_order() {
        let d = "space directions: none (1,0,0) (0,1,0) (0,0,1)\n";
        let four = "dimension: 4\nsizes: 3 8 9 10\n";
        assert_eq!(roles(&format!("{four}{d}")), [Color, Space, Space, Space]);
        assert_eq!(roles(&format!("{four}{d}kinds: 3-vector domain domain domain\n"))[0], Component);
        assert_eq!(roles(&format!("{four}{d}kinds: RGBA-color domain domain domain\n"))[0], Component, "not of three");
        assert_eq!(roles(&format!("{four}{d}kinds: time domain domain domain\n"))[0], Frame);
        assert_eq!(roles(&format!("{four}kinds: RGB-color domain domain domain\n")), [Color, Space, Space, Space]);
        assert_eq!(roles(&format!("{four}spacings: nan 1 1 1\n")), [Color, Space, Space, Space]);
        assert_eq!(roles(four), [Space, Space, Space, Frame]);
        assert_eq!(roles(&format!("{four}kinds: domain domain domain domain\n")), [Space, Space, Space, Frame]);
    }
}
