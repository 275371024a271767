//! Arrangement of the pages: what the text of the first one says about channels, slices and times.

use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};
use vr_core::{Calibration, number_text};

use crate::error::{FieldError, FileError};
use crate::layout::Role;
use crate::length_unit::{LengthUnit, MICROMETRE, common};
use crate::notes::{Assumption, Notes};

use super::Page;

/// Distances between voxels, as far as a file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Spacing {
    pub plane: Option<[f64; 2]>,
    pub slices: Option<f64>,
    pub unit: Option<String>,
    pub by: &'static str,
    /// True if the resolution is one that programs write for a screen or a printer, whatever the picture shows.
    pub is_screen: bool,
}

impl Spacing {
    /// This, or what `other` says where this says nothing about the plane.
    pub fn or(self, other: Self) -> Self {
        if self.plane.is_some() { self } else { Self { slices: self.slices, ..other } }
    }
}

/// Spacing, unit and source of a stack; what is assumed goes to the notes.
pub(crate) fn spacing_notes(
    spacing: Spacing,
    format: &str,
    notes: &mut Notes,
) -> ([f64; 3], Option<String>, &'static str) {
    let Spacing { plane, slices, unit, by, is_screen } = spacing;
    // Without a unit a resolution says no more than the shape of a pixel.
    let says_nothing = unit.is_none() && slices.is_none() && plane.is_some_and(|[x, y]| x == y);
    match (plane.filter(|_| !is_screen && !says_nothing), slices) {
        (Some([x, y]), Some(z)) => ([x, y, z], unit, by),
        (Some([x, y]), None) => {
            let columns = number_text(x);
            let why = "say nothing about the distance of slices: that of columns";
            notes.assume(Assumption::Spacing, format!("the {by} {why}, {columns}, is assumed"));
            ([x, y, x], unit, by)
        }
        (None, Some(z)) => {
            let slices = number_text(z);
            let said = format!("only the distance of slices, {slices}, is stated: 1, 1 is assumed within them");
            notes.assume(Assumption::Spacing, said);
            ([1.0, 1.0, z], unit, "spacing of slices")
        }
        (None, None) => {
            let why = if is_screen { ", beside a resolution in dpi that is a screen's or printer's" } else { "" };
            notes.assume(Assumption::Spacing, format!("{format} states no spacing{why}: 1, 1, 1 is assumed"));
            ([1.0; 3], None, "assumed")
        }
    }
}

/// Meaning of the pages of a file: slices, frames, channels.
#[derive(Debug, Default)]
pub(super) struct Arrangement {
    /// Axes over the pages, fastest first.
    pub axes: Vec<(usize, Role)>,
    pub spacing: Spacing,
    pub calibration: Option<Calibration>,
    pub is_imagej: bool,
    pub is_ome: bool,
    /// Name of the metadata that this comes from.
    pub by: &'static str,
}

impl Arrangement {
    /// Reads the text of a file's first page.
    pub fn read(path: &Path, text: Option<&str>, page: &Page, notes: &mut Vec<String>) -> Result<Self, FileError> {
        match text {
            Some(text) if text.starts_with("ImageJ=") => Ok(imagej(text, page)),
            Some(text) if text.trim_start().starts_with('<') && text.contains("<OME") => {
                ome(text, page, notes).map_err(|e| e.in_file(path))
            }
            _ => Ok(Self::default()),
        }
    }

    /// Number of pages that the text speaks of; `None` where there is no text, or its numbers are beyond all bounds.
    pub fn pages(&self) -> Option<usize> {
        if self.axes.is_empty() { None } else { self.axes.iter().try_fold(1usize, |n, a| n.checked_mul(a.0)) }
    }

    /// Takes times as slices where there is one slice only: stacks are often labelled so.
    pub fn mend(&mut self, notes: &mut Vec<String>) {
        let at = |axes: &[(usize, Role)], role| axes.iter().position(|a| a.1 == role);
        let (Some(z), Some(t)) = (at(&self.axes, Role::Space), at(&self.axes, Role::Frame)) else { return };
        let times = self.axes[t].0;
        if self.axes[z].0 == 1 && times > 1 {
            notes.push(format!("{} names {times} times of one slice: they are taken as slices", self.by));
            (self.axes[z].1, self.axes[t].1) = (Role::Frame, Role::Space);
        }
    }
}

/// ImageJ's lines of `key=value` (ij.io.TiffDecoder and FileInfo, ImageJ 1.x).
fn imagej(text: &str, page: &Page) -> Arrangement {
    let get = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
    let count = |key| get(key).and_then(|v| v.parse::<usize>().ok()).filter(|&n| n > 0);
    let number = |key| get(key).and_then(|v| v.parse::<f64>().ok()).filter(|x| x.is_finite());
    let (channels, slices, frames) = (count("channels"), count("slices"), count("frames"));
    let axes = match (channels, slices, frames) {
        (None, None, None) => vec![(count("images").unwrap_or(1), Role::Space)],
        // Channels of one page are not pages.
        _ => {
            let channels = channels.unwrap_or(1);
            let channels = if page.samples > 1 && channels == page.samples { 1 } else { channels };
            let (slices, frames) = (slices.unwrap_or(1), frames.unwrap_or(1));
            vec![(channels, Role::Component), (slices, Role::Space), (frames, Role::Frame)]
        }
    };
    let unit = get("unit").map(|u| u.replace("\\u00B5", "µ").replace("\\u00b5", "µ")).filter(|u| u != "pixel");
    let unit = unit.map(|u| LengthUnit::from_name(&u).map_or(u, |l| l.symbol.to_owned()));
    // The tags count pixels per that unit; "inch" and "cm" are in millimetres already.
    let mut spacing = Spacing { slices: number("spacing").map(f64::abs).filter(|&s| s > 0.0), ..Default::default() };
    let tags = &page.resolution;
    if let Some(plane) = tags.plane.filter(|_| unit.is_some()) {
        let known = unit.as_deref().and_then(LengthUnit::from_name);
        let scale = match (&tags.unit, known) {
            (Some(mm), Some(unit)) => LengthUnit::from_name(mm).map_or(1.0, |mm| mm.metres / unit.metres),
            _ => 1.0,
        };
        spacing.plane = Some(plane.map(|x| x * scale));
        spacing.by = "ImageJ's description";
    }
    spacing.unit = unit;
    // A function of degree one from stored to true values; 20 is ImageJ's straight line.
    let line = |c0: f64, c1: f64| Calibration { slope: c1, intercept: c0 };
    let calibration = match (get("cf"), number("c0"), number("c1")) {
        (Some("0"), Some(c0), Some(c1)) if c1 != 0.0 => Some(line(c0, c1)),
        _ => None,
    };
    Arrangement { axes, spacing, calibration, is_imagej: true, is_ome: false, by: "ImageJ's description" }
}

/// The first `Pixels` of OME-XML (schema 2016-06; older ones name the same attributes).
fn ome(text: &str, page: &Page, notes: &mut Vec<String>) -> Result<Arrangement, FieldError> {
    let options = ParsingOptions { allow_dtd: false, ..Default::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|e| FieldError::new("OME-XML", e, "must be whole XML without a DTD"))?;
    let named = |name: &'static str| move |n: &Node<'_, '_>| n.is_element() && n.tag_name().name() == name;
    let mut images = document.descendants().filter(named("Pixels"));
    let pixels = images.next().ok_or_else(|| FieldError::new("OME-XML", "no Pixels", "must describe an image"))?;
    let others = images.count();
    if others > 0 {
        notes.push(format!("OME-XML describes {} images: the first is taken", others + 1));
    }
    // One file of a set holds a part of the pages.
    let mut names: Vec<&str> =
        pixels.descendants().filter(named("UUID")).filter_map(|n| n.attribute("FileName")).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() > 1 {
        let allowed = "sets of files are not read: join them to one file";
        return Err(FieldError::new("OME-XML TiffData", format_args!("{} files", names.len()), allowed));
    }
    let size = |name: &'static str| -> Result<usize, FieldError> {
        let Some(text) = pixels.attribute(name) else { return Ok(1) };
        let number = text.trim().parse().ok().filter(|&n: &usize| n > 0);
        number.ok_or_else(|| FieldError::new(format!("OME-XML {name}"), text, "must be 1 or more"))
    };
    let channels = size("SizeC")?;
    // Channels of one page are not pages.
    let channels = if page.samples > 1 && channels % page.samples == 0 { channels / page.samples } else { channels };
    let order = pixels.attribute("DimensionOrder").unwrap_or("XYZCT");
    let allowed = "must be XY and then Z, C and T in any order";
    let wrong = || FieldError::new("OME-XML DimensionOrder", order, allowed);
    let stack = order.strip_prefix("XY").filter(|s| s.len() == 3).ok_or_else(wrong)?;
    let mut axes = Vec::new();
    for c in stack.chars() {
        let axis = match c {
            'Z' => (size("SizeZ")?, Role::Space),
            'C' => (channels, Role::Component),
            'T' => (size("SizeT")?, Role::Frame),
            _ => return Err(wrong()),
        };
        if axes.iter().any(|a: &(usize, Role)| a.1 == axis.1) {
            return Err(wrong());
        }
        axes.push(axis);
    }
    let spacing = physical_size(&pixels)?;
    Ok(Arrangement { axes, spacing, calibration: None, is_imagej: false, is_ome: true, by: "OME-XML" })
}

/// `PhysicalSizeX` and its like, in one unit.
fn physical_size(pixels: &Node<'_, '_>) -> Result<Spacing, FieldError> {
    let size = |name: &'static str| -> Result<Option<f64>, FieldError> {
        let Some(text) = pixels.attribute(name) else { return Ok(None) };
        let number = text.trim().parse().ok().filter(|&x: &f64| x > 0.0 && x.is_finite());
        number.map(Some).ok_or_else(|| FieldError::new(format!("OME-XML {name}"), text, "must be positive and finite"))
    };
    let unit = |name| pixels.attribute(name).unwrap_or(MICROMETRE.symbol);
    let [x, y, z] = [size("PhysicalSizeX")?, size("PhysicalSizeY")?, size("PhysicalSizeZ")?];
    let units = [unit("PhysicalSizeXUnit"), unit("PhysicalSizeYUnit"), unit("PhysicalSizeZUnit")];
    // A unit of what is not stated counts for nothing.
    let z_unit = if z.is_some() { units[2] } else { units[0] };
    let (unit, factors) = match common([Some(units[0]), Some(units[1]), Some(z_unit)]) {
        Some((unit, factors)) => (Some(unit), factors),
        None => (None, [1.0; 3]),
    };
    Ok(Spacing {
        plane: x.zip(y).map(|(x, y)| [x * factors[0], y * factors[1]]),
        slices: z.map(|z| z * factors[2]),
        unit,
        by: "OME-XML",
        is_screen: false,
    })
}
