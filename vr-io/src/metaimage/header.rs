//! The text of a header: `Key = value` lines, the last of which says where the voxels are.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{FieldError, FileError, shown_path};
use crate::header_text::HeaderText;

#[derive(Debug, Default)]
pub(super) struct Header {
    fields: BTreeMap<String, String>,
    /// Bytes of the file up to the end of the line with `ElementDataFile`.
    pub length: u64,
    /// Lines after it, where it says LIST.
    listed_files: Vec<String>,
}

const LAST_KEY: &str = "ElementDataFile";

impl Header {
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let mut text = HeaderText::open(path)?;
        loop {
            let line = text.next_line()?;
            if line.is_empty() {
                break;
            }
            let line = String::from_utf8_lossy(line);
            if let Some((key, value)) = line.split_once('=')
                && key.trim() == LAST_KEY
            {
                if value.trim_start().starts_with("LIST") {
                    text.read_rest()?;
                }
                break;
            }
        }
        Self::parse(&text.into_bytes()).map_err(|e| e.in_file(path))
    }

    pub fn parse(text: &[u8]) -> Result<Self, FieldError> {
        let mut header = Self::default();
        let mut lines = text.split_inclusive(|&c| c == b'\n');
        for line in lines.by_ref() {
            header.length += line.len() as u64;
            let line = String::from_utf8_lossy(line);
            if line.trim().is_empty() {
                continue;
            }
            let (key, value) = line
                .split_once('=')
                .ok_or_else(|| FieldError::new("header line", line.trim(), "must be 'Key = value'"))?;
            let key = key.trim().to_owned();
            let last = key == LAST_KEY;
            header.fields.insert(key, value.trim().to_owned());
            if last {
                break;
            }
        }
        header.listed_files =
            lines.map(|line| String::from_utf8_lossy(line).trim().to_owned()).filter(|line| !line.is_empty()).collect();
        Ok(header)
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.fields.get(key).map(String::as_str)
    }

    pub fn required(&self, key: &str) -> Result<&str, FieldError> {
        self.get(key).ok_or_else(|| FieldError::new(key, "nothing", "the field is required"))
    }

    /// `NDims`: three, or four with frames.
    pub fn dimension(&self) -> Result<usize, FieldError> {
        let text = self.required("NDims")?;
        text.parse()
            .ok()
            .filter(|n| (3..=4).contains(n))
            .ok_or_else(|| FieldError::new("NDims", text, "must be 3, or 4 with frames"))
    }

    /// Exactly `count` numbers of the first of these keys that is there.
    pub fn numbers(&self, keys: &[&str], count: usize) -> Result<Option<Vec<f64>>, FieldError> {
        let Some((key, text)) = keys.iter().find_map(|k| Some((*k, self.get(k)?))) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
        numbers
            .filter(|n| n.len() == count)
            .map(Some)
            .ok_or_else(|| FieldError::new(key, text, format!("must be {count} numbers")))
    }

    pub fn number(&self, key: &str) -> Result<Option<f64>, FieldError> {
        Ok(self.numbers(&[key], 1)?.map(|n| n[0]))
    }

    /// True or False, of the first of these keys that is there.
    pub fn flag(&self, keys: &[&str]) -> Result<Option<bool>, FieldError> {
        let Some((key, text)) = keys.iter().find_map(|k| Some((*k, self.get(k)?))) else { return Ok(None) };
        match text.to_lowercase().as_str() {
            "true" | "t" | "1" => Ok(Some(true)),
            "false" | "f" | "0" => Ok(Some(false)),
            _ => Err(FieldError::new(key, text, "must be True or False")),
        }
    }

    /// The data files after `ElementDataFile = LIST`, or the one that a line of the header's own file names.
    pub fn listed_files(&self, path: &Path) -> Result<&[String], FieldError> {
        if self.listed_files.is_empty() {
            let found = format!("LIST and no names in {}", shown_path(path));
            return Err(FieldError::new(LAST_KEY, found, "must be followed by one file name a line"));
        }
        Ok(&self.listed_files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_with_the_data_file() {
        let h = Header::parse(b"NDims = 3\r\nDimSize=1 2 3\nElementDataFile = LOCAL\n\x00\x01=\xff\n").unwrap();
        assert_eq!(h.length, 49);
        assert_eq!(h.get("DimSize"), Some("1 2 3"));
        assert_eq!(h.dimension(), Ok(3));
        assert!(Header::parse(b"no key\n").is_err());
    }

    #[test]
    fn lists_files() {
        let h = Header::parse(b"ElementDataFile = LIST 2\na.raw\n\nb c.raw\n").unwrap();
        assert_eq!(h.listed_files(Path::new("x")).unwrap(), ["a.raw", "b c.raw"]);
    }
}
