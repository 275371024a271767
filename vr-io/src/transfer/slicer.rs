//! 3D Slicer's volume properties as text (`.vp`): nine lines of numbers.

use crate::error::FieldError;

use super::TransferFile;
use super::volume_property::VolumeProperty;

pub(super) const FORMAT: &str = "3D Slicer's volume property";

/// The lines, as messages name them.
const LINES: [&str; 9] = [
    "line 1 (interpolation)",
    "line 2 (shade)",
    "line 3 (diffuse)",
    "line 4 (ambient)",
    "line 5 (specular)",
    "line 6 (specular power)",
    "line 7 (scalar opacity)",
    "line 8 (gradient opacity)",
    "line 9 (colour)",
];

/// True if a text has the lines of a volume property: six of one number, then one of many.
pub(super) fn is_property(text: &str) -> bool {
    let count = |line: &str| {
        let numbers = line.split_whitespace().map(str::parse::<f64>);
        numbers.collect::<Result<Vec<_>, _>>().map_or(0, |numbers| numbers.len())
    };
    let mut lines = text.lines().map(count);
    lines.by_ref().take(6).filter(|&n| n == 1).count() == 6 && lines.next().is_some_and(|n| n >= 3)
}

/// Reads a volume property.
pub(super) fn parse(text: &str) -> Result<TransferFile, FieldError> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let line = |k: usize| {
        let allowed = "a volume property has nine lines: interpolation, shade, diffuse, ambient, specular, power, scalar opacity, gradient \
                       opacity, colour";
        lines.get(k).copied().ok_or_else(|| FieldError::new(LINES[k], "the end of the file", allowed))
    };
    let number = |k: usize| {
        let found = line(k)?;
        found.parse::<f64>().map_err(|_| FieldError::new(LINES[k], found, "must be one number"))
    };
    let coefficients = [number(3)?, number(2)?, number(4)?, number(5)?];
    VolumeProperty {
        is_nearest: number(0)? == 0.0,
        shading: (number(1)? != 0.0).then_some(coefficients),
        opacity: rows::<2>(LINES[6], line(6)?)?.into_iter().map(|[x, a]| [x, a, 0.5, 0.0]).collect(),
        gradient: rows::<2>(LINES[7], line(7)?)?,
        color: rows::<4>(LINES[8], line(8)?)?,
        unit_distance: None,
    }
    .into_file(FORMAT, [LINES[6], LINES[7], LINES[8]])
}

/// Rows of N numbers, after the number of all of them.
pub(super) fn rows<const N: usize>(field: &str, text: &str) -> Result<Vec<[f64; N]>, FieldError> {
    let mut numbers = Vec::new();
    for word in text.split_whitespace() {
        numbers.push(word.parse::<f64>().map_err(|_| FieldError::new(field, word, "must be a number"))?);
    }
    let Some((&count, numbers)) = numbers.split_first() else { return Ok(Vec::new()) };
    if count != numbers.len() as f64 {
        let allowed = format!("the first number, {count}, must be how many follow");
        return Err(FieldError::new(field, format!("{} numbers", numbers.len()), allowed));
    }
    let (rows, rest) = numbers.as_chunks::<N>();
    if !rest.is_empty() {
        return Err(FieldError::new(field, format!("{} numbers", numbers.len()), format!("must be groups of {N}")));
    }
    Ok(rows.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::linear_to_srgb;
    use vr_core::{Filter, OpacityRule, TransferFunction};

    const BONE: &str =
        "1\n1\n0.9\n0.1\n0.2\n10\n6 -3024 0 200 0 1000 0.6\n4 0 1 255 1\n8 -3024 0 0 0 1000 1 0.5 0.25\n";

    #[test]
    fn values_are_absolute_and_diffuse_comes_first() {
        let file = parse(BONE).unwrap();
        assert!(file.absolute && file.gradient_per_voxel.is_empty() && file.filter.is_none());
        let shading = file.shading.unwrap();
        assert_eq!([shading.diffuse, shading.ambient, shading.specular, shading.power], [0.9, 0.1, 0.2, 10.0]);
        let transfer = TransferFunction::new(file.points, OpacityRule::Power, 1.0).unwrap();
        assert_eq!((transfer.at(200.0).opacity, transfer.at(1000.0).opacity), (0.0, 0.6));
        assert!((transfer.at(600.0).opacity - 0.3).abs() < 1e-12);
        // Colours are interpolated as they stand on the screen.
        let t = (600.0 + 3024.0) / 4024.0;
        assert!((linear_to_srgb(transfer.at(600.0).color[1]) - 0.5 * t).abs() < 1.0 / 255.0);
    }

    #[test]
    fn gradient_opacity_is_taken_where_it_does_something() {
        let text = BONE.replace("4 0 1 255 1", "6 0 0 10 0 80 1").replacen('1', "0", 2);
        let file = parse(&text).unwrap();
        assert_eq!(file.filter, Some(Filter::Nearest));
        assert_eq!(file.gradient_per_voxel, [(0.0, 0.0), (10.0, 0.0), (80.0, 1.0)]);
        assert!(file.shading.is_none() && file.notes[0].contains("gradient opacity"));
        let shading = file.shading_at(2.0).unwrap();
        assert_eq!((shading.ambient, shading.diffuse), (1.0, 0.0));
        assert_eq!(shading.gradient_opacity[2], (40.0, 1.0));
    }

    #[test]
    fn names_the_line() {
        for (from, to, word) in [
            ("0.9", "shiny", "line 3 (diffuse): found shiny; must be one number"),
            ("0.9", "-1", "shading.diffuse"),
            (
                "6 -3024",
                "8 -3024",
                "line 7 (scalar opacity): found 6 numbers; the first number, 8, must be how many follow",
            ),
            ("6 -3024 0 200", "5 -3024 0", "must be groups of 2"),
            ("200 0", "-5000 0", "line 7 (scalar opacity), point 2: found -5000"),
            ("1000 0.6", "1000 1.6", "point 3: found 1.6; opacities must be in [0, 1]"),
            ("1 0.5 0.25", "1 5 0.25", "line 9 (colour), point 2: found 5; colours"),
            ("4 0 1 255 1", "4 0 1 255 2", "line 8 (gradient opacity), point 2: found 2"),
            (
                "\n8 -3024 0 0 0 1000 1 0.5 0.25\n",
                "",
                "line 9 (colour): found the end of the file; a volume property has nine",
            ),
        ] {
            let message = parse(&BONE.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
