//! Files of transfer functions: ParaView's, 3D Slicer's, VTK's, ImageJ's, tables, and the `[transfer]` of a scene file.

mod color_space;
mod curves;
mod delimited;
mod lut;
mod opacity;
mod own;
mod paraview;
mod polyline;
mod slicer;
mod slicer_json;
mod volume_property;
mod write;
mod xml;

use std::path::Path;

use vr_core::{ControlPoint, Filter, OpacityRule, Shading};

use crate::error::{FieldError, FileError, on_one_line, shown_path};
use crate::regular_file;
use crate::scene::{TransferPoints, TransferRowSection, stretching};

pub use paraview::{ColorMap, parse_color_maps, read_color_maps};
pub use write::{TRANSFER_EXTENSIONS, TransferSource, write_transfer};

/// A transfer function from a file, and what the file says besides.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFile {
    /// Format in words.
    pub format: &'static str,
    /// Name that the file gives it; empty where it gives none.
    pub name: String,
    /// Control points at the file's own values, in linear light; none where there are rows.
    pub points: Vec<ControlPoint>,
    /// Rows of a two-dimensional transfer function; none of one by the value alone.
    pub rows: Vec<TransferRowSection>,
    /// True if the values are those of a volume; false if the points are to be spread over one's range.
    pub absolute: bool,
    /// Shading, where the file has it.
    pub shading: Option<Shading>,
    /// Factor on the extinction at differences of the value from one voxel to the next, as VTK's programs measure gradients; empty for none.
    pub gradient_per_voxel: Vec<(f64, f64)>,
    /// The filter, where the file names one.
    pub filter: Option<Filter>,
    /// World length that the opacities belong to, where the file has it.
    pub unit_distance: Option<f64>,
    /// Meaning of the opacities, where the file has it.
    pub opacity_rule: Option<OpacityRule>,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
}

impl TransferFile {
    /// A transfer function of points alone.
    fn of_points(format: &'static str, points: Vec<ControlPoint>, absolute: bool) -> Self {
        Self {
            format,
            name: String::new(),
            points,
            rows: Vec::new(),
            absolute,
            shading: None,
            gradient_per_voxel: Vec::new(),
            filter: None,
            unit_distance: None,
            opacity_rule: None,
            notes: Vec::new(),
        }
    }

    /// Points or rows, moved to another range of values where one is given. A range of one value is widened, so that the value lies in the middle.
    pub fn transfer_points(&self, range: Option<(f64, f64)>) -> TransferPoints {
        let points = match &self.rows[..] {
            [] => TransferPoints::ByValue(self.points.clone()),
            rows => TransferPoints::ByGradient(rows.to_vec()),
        };
        match range {
            Some(range) => points.stretched(range),
            None => points,
        }
    }

    /// The control points moved to another range of values. A range of one value is widened, so that the value lies in the middle.
    pub fn over(&self, range: (f64, f64)) -> Vec<ControlPoint> {
        stretched(&self.points, range)
    }

    /// Shading with the factors on the extinction at gradients, for a volume of a mean spacing of voxels. `None` where the file has neither.
    pub fn shading_at(&self, spacing: f64) -> Option<Shading> {
        if self.gradient_per_voxel.is_empty() {
            return self.shading.clone();
        }
        // Unshaded, and yet clearer where nothing changes.
        let flat = || Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Shading::default() };
        let shading = self.shading.clone().unwrap_or_else(flat);
        let per_length = |&(magnitude, factor): &(f64, f64)| (magnitude / spacing, factor);
        Some(Shading { gradient_opacity: self.gradient_per_voxel.iter().map(per_length).collect(), ..shading })
    }
}

/// Control points moved to another range of values.
fn stretched(points: &[ControlPoint], range: (f64, f64)) -> Vec<ControlPoint> {
    match points {
        [first, .., last] => points.iter().map(stretching((first.value, last.value), range)).collect(),
        _ => points.to_vec(),
    }
}

/// Most points of a transfer function.
const MAX_POINTS: usize = 1 << 16;

/// The formats, as messages list them.
const FORMATS: &str = "ParaView's JSON or XML, 3D Slicer's .vp, .vp.json or presets, VTK's XML, ImageJ's .lut, a table (.csv, .tsv) of value, \
                       red, green, blue, opacity, or TOML with [transfer]";

/// Reads a transfer function; the format is told by the content, then by the name.
///
/// The colours of all formats but TOML are sRGB, as these programs put them on the screen, and are interpolated as they do it; the points
/// follow that in linear light as closely as 8 bits show.
///
/// # Errors
/// A [`FileError`] naming the file and the field.
pub fn read_transfer(path: impl AsRef<Path>) -> Result<TransferFile, FileError> {
    let path = path.as_ref();
    let bytes = regular_file::read(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    parse_transfer(&bytes, path)
}

/// Reads a transfer function from the content of a file; `path` is what errors call it, and tells what the content does not. See
/// [`read_transfer`].
///
/// # Errors
/// A [`FileError`] naming the file and the field.
pub fn parse_transfer(bytes: &[u8], path: &Path) -> Result<TransferFile, FileError> {
    let lower = path.to_string_lossy().to_lowercase();
    let named = |extension: &str| lower.ends_with(extension);
    let unknown = |found: &str| FieldError::new("transfer function", found, format!("must be {FORMATS}")).in_file(path);
    if lut::is_binary(bytes, named(".lut")) {
        return lut::parse(bytes).map_err(|e| e.in_file(path));
    }
    let text = std::str::from_utf8(bytes).ok().filter(|text| !text.contains('\0'));
    let Some(text) = text.map(|text| text.trim_start_matches('\u{feff}')) else {
        return Err(unknown("bytes that are no text"));
    };
    let mut letters = text.chars().filter(|c| !c.is_whitespace());
    let mut file = match (letters.next(), letters.next()) {
        (None, _) => return Err(unknown("an empty file")),
        (Some('<'), _) => xml::parse(text).map_err(|e| e.in_file(path))?,
        (Some('['), Some(c)) if c.is_alphabetic() => own::parse(text, path)?,
        (Some('{' | '['), _) if !named(".toml") => json(text, path)?,
        _ if named(".toml") => own::parse(text, path)?,
        _ if named(".vp") || slicer::is_property(text) => slicer::parse(text).map_err(|e| e.in_file(path))?,
        _ => delimited::parse(text, named(".lut")).map_err(|e| e.in_file(path))?,
    };
    let count = file.transfer_points(None).points().count();
    if count > MAX_POINTS {
        let allowed = format!("a transfer function has at most {MAX_POINTS}");
        return Err(FieldError::new("points", count, allowed).in_file(path));
    }
    // Everything else is told to a reader of notes, who has more than one file.
    let place = shown_path(path);
    file.notes.iter_mut().for_each(|note| *note = format!("{place}: {}", on_one_line(note)));
    Ok(file)
}

/// Reads JSON: 3D Slicer's volume properties, or ParaView's colour maps.
fn json(text: &str, path: &Path) -> Result<TransferFile, FileError> {
    if let Some(property) = slicer_json::parse(text) {
        return property.map_err(|e| e.in_file(path));
    }
    let maps = parse_color_maps(text, path)?;
    let count = maps.len();
    let mut maps = maps.into_iter();
    let Some(ColorMap { name, points, mut notes }) = maps.next() else { unreachable!("there is one at least") };
    if count > 1 {
        notes.insert(0, format!("there are {count} colour maps: the first one, {name}, is used"));
    }
    Ok(TransferFile { name, notes, ..TransferFile::of_points("ParaView's colour map", points, false) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format(text: &str, name: &str) -> &'static str {
        parse_transfer(text.as_bytes(), Path::new(name)).map_or_else(|e| panic!("{e}"), |file| file.format)
    }

    #[test]
    fn formats_are_told_by_content() {
        let vp = "1\n1\n0.9\n0.1\n0.2\n10\n4 0 0 100 1\n4 0 1 255 1\n8 0 0 0 0 100 1 1 1\n";
        assert_eq!(format(vp, "a.txt"), "3D Slicer's volume property");
        assert_eq!(format(r#"{"RGBPoints": [0,0,0,0, 1,1,1,1]}"#, "a.txt"), "ParaView's colour map");
        assert_eq!(format(r#"[ {"RGBPoints": [0,0,0,0, 1,1,1,1]}]"#, "a.txt"), "ParaView's colour map");
        assert_eq!(format(r#"<ColorMap><Point x="0" o="0" r="1" g="0" b="0"/></ColorMap>"#, "a"), "ParaView's XML");
        assert_eq!(format("0,1,0,0,0\n1,1,1,1,1\n", "a.csv"), "table");
        let own = "[transfer]\npoints = [{ value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.5 }]\n";
        assert_eq!(format(own, "a.txt"), "scene file");
    }

    #[test]
    fn what_is_none_is_refused() {
        for (bytes, word) in [
            (&b""[..], "an empty file"),
            (b"  \n", "an empty file"),
            (b"NRRD\0\0\x01", "no text"),
            (b"\xff\xfe\xfd", "no text"),
            (b"<html/>", "must be"),
            (b"hello world", "line 1"),
            (b"{}", "RGBPoints"),
        ] {
            let message = parse_transfer(bytes, Path::new("x.y")).unwrap_err().to_string();
            assert!(message.starts_with("x.y: ") && message.contains(word) && !message.contains('\n'), "{message}");
        }
    }
}
