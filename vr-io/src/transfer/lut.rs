//! ImageJ's colour tables in bytes: reds, greens and blues, after a header of NIH Image or none.

use crate::error::FieldError;

use super::TransferFile;
use super::color_space::ColorSpace;
use super::curves::{colors, growing, merge};

/// First bytes of NIH Image's header.
const MAGIC: &[u8] = b"ICOL";
/// Length of NIH Image's header: magic, version, number of colours, first and last, and what is not used.
const HEADER: usize = 32;
/// Length of a table without a header.
const RAW: usize = 3 * 256;

/// True if bytes are a table: by their header, or by their length and a name that says so or bytes that are no text.
pub(super) fn is_binary(bytes: &[u8], is_named: bool) -> bool {
    let text = std::str::from_utf8(bytes).is_ok_and(|text| !text.contains('\0'));
    bytes.starts_with(MAGIC) || (bytes.len() == RAW && (is_named || !text) && !is_table_of_text(bytes))
}

/// True if all bytes are those of numbers in a text.
fn is_table_of_text(bytes: &[u8]) -> bool {
    bytes.iter().all(|b| b.is_ascii_digit() || b.is_ascii_whitespace() || b".,;+-eE".contains(b))
}

/// Reads a table; it is to be spread over a range of values.
pub(super) fn parse(bytes: &[u8]) -> Result<TransferFile, FieldError> {
    let (count, table) = if bytes.starts_with(MAGIC) {
        let Some((header, table)) = bytes.split_at_checked(HEADER) else {
            return Err(FieldError::new("header", format!("{} bytes", bytes.len()), "must be 32 bytes"));
        };
        (usize::from(u16::from_be_bytes([header[6], header[7]])), table)
    } else {
        (256, bytes)
    };
    if !(2..=256).contains(&count) {
        return Err(FieldError::new("number of colours", count, "must be 2 to 256"));
    }
    if table.len() < 3 * count {
        let allowed = format!("{count} colours need {}", 3 * count);
        return Err(FieldError::new("colours", format!("{} bytes", table.len()), allowed));
    }
    let row = |k: usize| {
        let component = |c: usize| f64::from(table[c * count + k]) / 255.0;
        [k as f64, component(0), component(1), component(2)]
    };
    let rows: Vec<[f64; 4]> = (0..count).map(row).collect();
    let line = colors(&rows, ColorSpace::Rgb, |row, _| format!("colour {row}"))?;
    let mut notes = Vec::new();
    let opacity = growing(&line, &mut notes);
    Ok(TransferFile { notes, ..TransferFile::of_points("ImageJ's colour table", merge(&line, &opacity), false) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red grows, green falls, blue is constant.
    fn table(count: usize) -> Vec<u8> {
        let at = |k: usize| (255 * k / (count - 1)) as u8;
        let reds = (0..count).map(at);
        reds.clone().chain(reds.rev()).chain((0..count).map(|_| 128)).collect()
    }

    #[test]
    fn raw_tables_and_those_of_nih_image() {
        let raw = table(256);
        assert!(is_binary(&raw, true) && is_binary(&raw, false));
        let file = parse(&raw).unwrap();
        assert!(!file.absolute && file.notes[0].contains("no opacities"));
        let (first, last) = (file.points[0], file.points[file.points.len() - 1]);
        assert_eq!((first.value, first.color[0], first.opacity), (0.0, 0.0, 0.0));
        assert_eq!((last.value, last.color[1], last.opacity), (255.0, 0.0, 1.0));
        assert!((last.color[0] - 1.0).abs() < 1e-12);

        let mut nih = b"ICOL\0\x04\0\x20".to_vec();
        nih.resize(HEADER, 0);
        nih.extend(table(32));
        assert!(is_binary(&nih, false));
        assert_eq!(parse(&nih).unwrap().points.last().unwrap().value, 31.0);
    }

    #[test]
    fn damage_is_named() {
        let mut nih = b"ICOL\0\x04\x01\0".to_vec();
        assert!(parse(&nih).unwrap_err().to_string().contains("header: found 8 bytes"));
        nih.resize(HEADER + 5, 0);
        assert!(parse(&nih).unwrap_err().to_string().contains("colours: found 5 bytes; 256 colours need 768"));
        nih[6] = 9;
        assert!(parse(&nih).unwrap_err().to_string().contains("number of colours: found 2304"));
        assert!(!is_binary(&[b'1'; RAW], true), "a text of that length");
    }
}
