//! The text of a header: its fields, and what their words mean.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{FieldError, FileError};
use crate::header_text::HeaderText;

/// A header's fields, by their names without spaces (`data file` and `datafile` are the same field).
#[derive(Debug, Default)]
pub(super) struct Header {
    fields: BTreeMap<String, String>,
    key_values: BTreeMap<String, String>,
    /// The lines after `data file: LIST`.
    listed_files: Vec<String>,
    /// Bytes of the file up to and with the empty line.
    pub length: u64,
}

const KNOWN: [&str; 28] = [
    "dimension",
    "type",
    "blocksize",
    "encoding",
    "endian",
    "content",
    "min",
    "max",
    "oldmin",
    "oldmax",
    "datafile",
    "lineskip",
    "byteskip",
    "number",
    "sampleunits",
    "sizes",
    "spacings",
    "thicknesses",
    "axismins",
    "axismaxs",
    "centers",
    "centerings",
    "labels",
    "units",
    "kinds",
    "space",
    "spacedimension",
    "spaceunits",
];
const KNOWN_ORIENTATION: [&str; 3] = ["spaceorigin", "spacedirections", "measurementframe"];

impl Header {
    /// Reads a file up to the empty line that ends its header.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let mut text = HeaderText::open(path)?;
        let mut first = true;
        loop {
            match text.next_line()? {
                b"" | b"\n" | b"\r\n" => break,
                // Not even the first line is one of a header: do not look for the end of it.
                line if first && !line.starts_with(b"NRRD") => break,
                _ => first = false,
            }
        }
        Self::parse(&text.into_bytes()).map_err(|e| e.in_file(path))
    }

    pub fn parse(text: &[u8]) -> Result<Self, FieldError> {
        let mut header = Self { length: text.len() as u64, ..Self::default() };
        let text = String::from_utf8_lossy(text);
        let mut lines = text.lines();
        let magic = lines.next().unwrap_or_default().trim_end();
        if !matches!(magic.strip_prefix("NRRD000"), Some("1" | "2" | "3" | "4" | "5")) {
            return Err(FieldError::new("magic", magic, "must be NRRD0001 to NRRD0005"));
        }
        let mut listing = false;
        for line in lines.map(str::trim_end) {
            if line.is_empty() {
                break;
            } else if listing {
                header.listed_files.push(line.to_owned());
            } else if line.starts_with('#') {
                continue;
            } else if let Some((name, value)) = line.split_once(':') {
                if let Some(value) = value.strip_prefix('=') {
                    header.key_values.insert(name.to_owned(), value.trim().to_owned());
                    continue;
                }
                let value = value.trim();
                let key = name.to_lowercase().replace(' ', "");
                listing = key == "datafile" && value.starts_with("LIST");
                if header.fields.insert(key, value.to_owned()).is_some() {
                    return Err(FieldError::new(name, "the field twice", "must be there once"));
                }
            } else {
                return Err(FieldError::new(
                    "header line",
                    line,
                    "must be 'field: value', 'key:=value' or '# comment'",
                ));
            }
        }
        Ok(header)
    }

    /// A field by its name (with or without spaces).
    pub fn get(&self, field: &str) -> Option<&str> {
        self.fields.get(&field.replace(' ', "")).map(String::as_str)
    }

    pub fn required(&self, field: &str) -> Result<&str, FieldError> {
        self.get(field).ok_or_else(|| FieldError::new(field, "nothing", "the field is required"))
    }

    pub fn key_value(&self, key: &str) -> Option<&str> {
        self.key_values.get(key).map(String::as_str)
    }

    /// The keys that begin with a word, and their values.
    pub fn key_values_of(self, word: &str) -> BTreeMap<String, String> {
        self.key_values.into_iter().filter(|(key, _)| key.starts_with(word)).collect()
    }

    pub fn listed_files(&self) -> &[String] {
        &self.listed_files
    }

    pub fn unknown_fields(&self) -> Vec<&str> {
        let known = |f: &&str| KNOWN.contains(f) || KNOWN_ORIENTATION.contains(f);
        self.fields.keys().map(String::as_str).filter(|f| !known(f)).collect()
    }

    /// Numbers along each axis, fastest first.
    pub fn sizes(&self) -> Result<Vec<usize>, FieldError> {
        // The largest that the format allows.
        const MAX_AXES: usize = 16;
        let dimension = self.required("dimension")?;
        let axes: usize = dimension
            .parse()
            .ok()
            .filter(|n| (1..=MAX_AXES).contains(n))
            .ok_or_else(|| FieldError::new("dimension", dimension, "must be 1 to 16; a volume needs 3"))?;
        let text = self.required("sizes")?;
        let sizes: Option<Vec<usize>> = text.split_whitespace().map(|w| w.parse().ok().filter(|&n| n > 0)).collect();
        sizes
            .filter(|s| s.len() == axes)
            .ok_or_else(|| FieldError::new("sizes", text, format!("must be {axes} positive integers")))
    }

    /// One number for each axis, NaN where it is unknown.
    pub fn per_axis(&self, field: &str, axes: usize) -> Result<Option<Vec<f64>>, FieldError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
        numbers
            .filter(|n| n.len() == axes)
            .map(Some)
            .ok_or_else(|| FieldError::new(field, text, format!("must be {axes} numbers, one for each axis")))
    }

    /// One word for each axis.
    pub fn words(&self, field: &str, axes: usize) -> Result<Option<Vec<&str>>, FieldError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        let words: Vec<&str> = text.split_whitespace().collect();
        if words.len() == axes {
            Ok(Some(words))
        } else {
            Err(FieldError::new(field, text, format!("must be {axes} words, one for each axis")))
        }
    }

    /// Strings in double quotes.
    pub fn quoted(&self, field: &str) -> Option<Vec<&str>> {
        Some(self.get(field)?.split('"').skip(1).step_by(2).collect())
    }

    /// Vectors in brackets; `None` in place of one that is `none`.
    pub fn vectors(&self, field: &str) -> Result<Option<Vec<Option<Vec<f64>>>>, FieldError> {
        let Some(text) = self.get(field) else { return Ok(None) };
        let wrong = || FieldError::new(field, text, "must be vectors like (1,0,0), or none");
        let (mut vectors, mut rest) = (Vec::new(), text.trim_start());
        while !rest.is_empty() {
            if let Some(inner) = rest.strip_prefix('(') {
                let (inner, after) = inner.split_once(')').ok_or_else(wrong)?;
                let numbers: Option<Vec<f64>> = inner.split(',').map(|n| n.trim().parse().ok()).collect();
                vectors.push(Some(numbers.ok_or_else(wrong)?));
                rest = after.trim_start();
            } else {
                rest = rest.strip_prefix("none").ok_or_else(wrong)?.trim_start();
                vectors.push(None);
            }
        }
        Ok(Some(vectors))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_keys_and_comments() {
        let h = Header::parse(
            b"NRRD0005\r\n# data file: none\r\nSizes: 3 4\r\ndimension: 2\r\nbyte skip:= -1\r\ndatafile: a b.raw\r\n\r\n",
        )
        .unwrap();
        assert_eq!(h.sizes().unwrap(), [3, 4]);
        assert_eq!(h.get("data file"), Some("a b.raw"));
        // With `:=` it is a key of the writer's own, not the field.
        assert_eq!(h.get("byte skip"), None);
        assert_eq!(h.key_value("byte skip"), Some("-1"));
    }

    #[test]
    fn vectors_may_hold_spaces() {
        let h = Header::parse(b"NRRD0004\nspace directions: none (1, 0,0)(0,-1.5e1,0)\n").unwrap();
        let v = h.vectors("space directions").unwrap().unwrap();
        assert_eq!(v, [None, Some(vec![1.0, 0.0, 0.0]), Some(vec![0.0, -15.0, 0.0])]);
        for bad in ["(1,0", "1,0,0", "(a,b,c)", "()"] {
            let h = Header::parse(format!("NRRD0004\nspace directions: {bad}\n").as_bytes()).unwrap();
            assert!(h.vectors("space directions").is_err(), "{bad}");
        }
    }

    #[test]
    fn refuses_other_magic_words_and_stray_lines() {
        assert!(Header::parse(b"").is_err());
        assert!(Header::parse(b"NRRD0006\n").is_err());
        assert!(Header::parse(b"NRRD0004\nstray\n").is_err());
        assert!(Header::parse(b"NRRD0004\ntype: u8\ntype: u8\n").is_err());
    }
}
