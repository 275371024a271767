//! Lists of labels: names and colours in text.

use std::path::Path;

use vr_core::transfer::srgb_to_linear;

use super::entry::LabelEntry;
use crate::error::{FieldError, FileError};
use crate::regular_file;

/// Reads a list of labels with names and colours: a label description of ITK-SNAP (`IDX R G B A VIS MSH "NAME"`), a lookup table of FreeSurfer
/// or a colour table of 3D Slicer (`IDX NAME R G B A`), or a table with commas and a line of names (`LabelValue,Name,Color_R,…`).
///
/// Colours are from 0 to 255, in sRGB. The A of FreeSurfer's tables, 0 throughout, says nothing; that of Slicer's is opacity.
///
/// # Errors
/// A [`FileError`] that names the line, what was found and what is allowed.
pub fn read_label_list(path: impl AsRef<Path>) -> Result<Vec<LabelEntry>, FileError> {
    let path = path.as_ref();
    let bytes = regular_file::read(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    parse_label_list(&String::from_utf8_lossy(&bytes), path)
}

/// Reads the text of a list of labels; `path` is what errors call it.
///
/// # Errors
/// A [`FileError`] that names the line, what was found and what is allowed.
pub fn parse_label_list(text: &str, path: &Path) -> Result<Vec<LabelEntry>, FileError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let lines: Vec<(usize, &str)> = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).collect();
    let at =
        |line: usize| move |e: FieldError| FieldError { field: format!("line {line}: {}", e.field), ..e }.in_file(path);
    let mut entries = Vec::with_capacity(lines.len());
    let header = lines.first().filter(|(_, line)| line.contains(',') && line.to_lowercase().contains("color"));
    let table = header.map(|&(number, line)| Columns::of(line).map_err(at(number))).transpose()?;
    for &(number, line) in &lines[usize::from(table.is_some())..] {
        let entry = match &table {
            Some(columns) => columns.entry(line),
            None => entry(line),
        };
        let entry = entry.map_err(at(number))?;
        if entries.iter().any(|e: &LabelEntry| e.label == entry.label) {
            return Err(at(number)(FieldError::new("label", entry.label, "is there already: each has one line")));
        }
        entries.push(entry);
    }
    if entries.is_empty() {
        return Err(FieldError::new("list", "no label", "a line has a label, its colour and its name").in_file(path));
    }
    // Opacities that are 0 throughout are none: FreeSurfer's.
    if table.is_none() && entries.iter().all(|e| e.visible.is_none() && e.opacity.is_none_or(|o| o == 0.0)) {
        entries.iter_mut().for_each(|e| e.opacity = None);
    }
    Ok(entries)
}

/// Words of a line; what stands in quotes is one.
fn words(line: &str) -> Vec<&str> {
    let mut words = Vec::new();
    for (i, part) in line.split('"').enumerate() {
        if i % 2 == 1 {
            words.push(part);
        } else {
            words.extend(part.split_whitespace());
        }
    }
    words
}

const FORMS: &str = "must be IDX R G B A VIS MSH \"NAME\" (ITK-SNAP) or IDX NAME R G B A (FreeSurfer, Slicer)";

fn entry(line: &str) -> Result<LabelEntry, FieldError> {
    let words = words(line);
    let is_number = |word: &&str| word.parse::<f64>().is_ok();
    match words[..] {
        [label, r, g, b, a, visible, mesh, name] if [r, g, b, a, visible, mesh].iter().all(is_number) => {
            Ok(LabelEntry {
                label: parsed_label(label)?,
                name: Some(name.to_owned()),
                color: Some(color([r, g, b])?),
                opacity: Some(number("A", a, 1.0)?),
                visible: Some(visible != "0"),
            })
        }
        // A name in several words has no quotes in old files.
        [label, .., r, g, b, a] if words.len() >= 6 && [r, g, b, a].iter().all(is_number) => Ok(LabelEntry {
            label: parsed_label(label)?,
            name: Some(words[1..words.len() - 4].join(" ")),
            color: Some(color([r, g, b])?),
            opacity: Some(number("A", a, 255.0)? / 255.0),
            visible: None,
        }),
        _ => Err(FieldError::new("list", line, FORMS)),
    }
}

fn parsed_label(word: &str) -> Result<i32, FieldError> {
    word.parse().map_err(|_| FieldError::new("label", word, "must be a whole number"))
}

fn number(field: &str, word: &str, max: f64) -> Result<f64, FieldError> {
    let number = word.parse().ok().filter(|n| (0.0..=max).contains(n));
    number.ok_or_else(|| FieldError::new(field, word, format!("must be a number from 0 to {max}")))
}

fn color(words: [&str; 3]) -> Result<[f64; 3], FieldError> {
    let mut color = [0.0; 3];
    for (c, word) in color.iter_mut().zip(words) {
        *c = srgb_to_linear(number("colour", word, 255.0)? / 255.0);
    }
    Ok(color)
}

/// Columns of a table with commas.
struct Columns {
    label: usize,
    name: usize,
    color: [usize; 3],
    opacity: Option<usize>,
}

impl Columns {
    fn of(line: &str) -> Result<Self, FieldError> {
        let names: Vec<String> = line.split(',').map(|name| name.trim().to_lowercase().replace('_', "")).collect();
        let place = |known: &str| names.iter().position(|name| name == known);
        let needed = |known: &str| {
            place(known).ok_or_else(|| {
                FieldError::new("columns", line, "must have LabelValue, Name, Color_R, Color_G and Color_B")
            })
        };
        Ok(Self {
            label: needed("labelvalue")?,
            name: needed("name")?,
            color: [needed("colorr")?, needed("colorg")?, needed("colorb")?],
            opacity: place("colora"),
        })
    }

    fn entry(&self, line: &str) -> Result<LabelEntry, FieldError> {
        let cells = cells(line);
        let cell = |i: usize| {
            cells
                .get(i)
                .map(|c| c.trim())
                .ok_or_else(|| FieldError::new("columns", line, format!("must have {} cells at least", i + 1)))
        };
        let opacity = self.opacity.map(|i| number("Color_A", cell(i)?, 255.0)).transpose()?;
        Ok(LabelEntry {
            label: parsed_label(cell(self.label)?)?,
            name: Some(cell(self.name)?.to_owned()),
            color: Some(color([cell(self.color[0])?, cell(self.color[1])?, cell(self.color[2])?])?),
            opacity: opacity.map(|a| a / 255.0),
            visible: None,
        })
    }
}

/// Cells of a line with commas; those in quotes may hold some.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("there is one from the beginning").push(c),
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Vec<LabelEntry> {
        parse_label_list(text, Path::new("list.txt")).unwrap()
    }

    fn refused(text: &str) -> String {
        parse_label_list(text, Path::new("list.txt")).unwrap_err().to_string()
    }

    #[test]
    fn every_form_is_read() {
        let snap =
            parsed("# comment\n\n   1   255   0    0    0.25  1  0    \"Label \u{e9}, one\"\n2 0 0 255 1 0 0 \"b\"\n");
        assert_eq!(snap[0].name.as_deref(), Some("Label \u{e9}, one"));
        assert_eq!((snap[0].opacity, snap[0].visible, snap[1].visible), (Some(0.25), Some(true), Some(false)));
        let free =
            parsed("#No. Label Name: R G B A\n0   Unknown 0 0 0 0\n2   Left-Cerebral-White-Matter  245 245 245 0\n");
        assert_eq!((free[1].label, free[1].opacity), (2, None), "FreeSurfer's A says nothing");
        let slicer = parsed("# Color table file\n0 Background 0 0 0 0\n1 soft tissue 128 174 128 255\n");
        assert_eq!((slicer[1].name.as_deref(), slicer[1].opacity), (Some("soft tissue"), Some(1.0)));
        assert_eq!(slicer[0].opacity, Some(0.0));
        let table = parsed("LabelValue,Name,Color_R,Color_G,Color_B,Color_A\n7,\"vein, left\",0,0,255,128\n");
        assert_eq!((table[0].label, table[0].name.as_deref()), (7, Some("vein, left")));
        assert!((table[0].opacity.unwrap() - 128.0 / 255.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        assert_eq!(
            refused("1 a 0 0 0 0\n2 b 0 0 256 0\n"),
            "list.txt: line 2: colour: found 256; must be a number from 0 to 255"
        );
        assert!(refused("1 a 0 0\n").contains("line 1: list: found 1 a 0 0; must be IDX R G B A VIS MSH"));
        assert!(refused("1 a 0 0 0 0\n1 b 0 0 0 0\n").contains("line 2: label: found 1; is there already"));
        assert!(refused("x a 0 0 0 0\n").contains("must be a whole number"));
        assert!(refused("LabelValue,Color_R\n").contains("LabelValue, Name"));
        assert!(refused("# nothing\n").contains("no label"));
    }
}
