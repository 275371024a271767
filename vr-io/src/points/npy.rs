//! NumPy's `.npy` with N×3 positions (NEP 1, "A simple file format for NumPy arrays").
//!
//! Own code: the header is one line, and the crates at hand bring a parser of Python for it.

use glam::DVec3;

use crate::scalar::{Endian, ScalarType};

use super::roles::Roles;
use super::{Found, Numbering, Table, numbers};
use crate::error::FileErrorKind;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

pub(super) fn read(bytes: &[u8]) -> Result<Found, FileErrorKind> {
    // Split the header from the data.
    let cut = || FileErrorKind::field("header", format!("{} bytes", bytes.len()), "the header must be whole");
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
        FileErrorKind::field(
            "magic",
            String::from_utf8_lossy(&bytes[..bytes.len().min(MAGIC.len())]),
            "must be \\x93NUMPY",
        )
    })?;
    let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk().map(|(n, rest)| (usize::from(u16::from_le_bytes(*n)), rest)),
        2 | 3 => rest.split_first_chunk().map(|(n, rest)| (u32::from_le_bytes(*n) as usize, rest)),
        other => return Err(FileErrorKind::field("version", other, "must be 1, 2 or 3")),
    }
    .ok_or_else(cut)?;
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = String::from_utf8_lossy(header);

    // Read type and shape, and hold them against the length of the data.
    let (scalar, endian) = element(entry(&header, "descr")?)?;
    let by_column = match entry(&header, "fortran_order")? {
        "True" => true,
        "False" => false,
        other => return Err(FileErrorKind::field("fortran_order", other, "must be True or False")),
    };
    let shape = entry(&header, "shape")?;
    let sizes: Option<Vec<u64>> =
        shape.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect();
    let count = match sizes.as_deref() {
        Some(&[count, 3]) => count,
        _ => return Err(FileErrorKind::field("shape", shape, "must be (N, 3): a position in each row")),
    };
    let claimed = u128::from(count) * 3 * scalar.bytes() as u128;
    if claimed != data.len() as u128 {
        let allowed = format!("the shape and type claim {claimed}");
        return Err(FileErrorKind::field("data", format!("{} bytes", data.len()), allowed));
    }
    let all = numbers::numbers(data, scalar, endian);
    let positions = if by_column {
        let n = all.len() / 3;
        (0..n).map(|k| DVec3::new(all[k], all[n + k], all[2 * n + k])).collect()
    } else {
        numbers::positions(&all)
    };
    Ok(Found {
        table: Table { positions, columns: Roles::default(), numbering: Numbering::FromZero },
        format: "NumPy",
        encoding: "raw",
        scalar,
        endian,
        names: Vec::new(),
        notes: Vec::new(),
    })
}

/// Value of a key of the header's dictionary: a word, or the text in quotes or brackets.
fn entry<'h>(header: &'h str, key: &str) -> Result<&'h str, FileErrorKind> {
    let missing =
        || FileErrorKind::field(key, header.trim(), "the header must hold 'descr', 'fortran_order' and 'shape'");
    let (_, after) = header.split_once(&format!("'{key}'")).ok_or_else(missing)?;
    let value = after.trim_start().strip_prefix(':').ok_or_else(missing)?.trim_start();
    let end = |value: &'h str, stop: &[char]| value.find(stop).map(|end| &value[..end]);
    match value.chars().next() {
        Some('\'') => end(&value[1..], &['\'']),
        Some('(') => end(&value[1..], &[')']),
        _ => end(value, &[',', '}']).map(str::trim_end),
    }
    .ok_or_else(missing)
}

/// `<f4`.
fn element(descr: &str) -> Result<(ScalarType, Endian), FileErrorKind> {
    let endian = match descr.chars().next() {
        Some('>') => Endian::Big,
        Some('<' | '|') => Endian::Little,
        _ => Endian::NATIVE,
    };
    let scalar = match descr.trim_start_matches(['<', '>', '|', '=']) {
        "f4" => ScalarType::F32,
        "f8" => ScalarType::F64,
        "i1" => ScalarType::I8,
        "u1" => ScalarType::U8,
        "i2" => ScalarType::I16,
        "u2" => ScalarType::U16,
        "i4" => ScalarType::I32,
        "u4" => ScalarType::U32,
        "i8" => ScalarType::I64,
        "u8" => ScalarType::U64,
        _ => return Err(FileErrorKind::field("descr", descr, "must be a real number type: f4, f8, i1 … u8")),
    };
    Ok((scalar, endian))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, by_column: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{descr}', 'fortran_order': {by_column}, 'shape': {shape}, }}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), data].concat()
    }

    fn found(bytes: &[u8]) -> Result<Vec<DVec3>, String> {
        read(bytes).map(|f| f.table.positions).map_err(|e| e.to_string())
    }

    #[test]
    fn rows_and_columns() {
        let expected = vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];
        let rows: Vec<u8> = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(found(&file("<f4", "False", "(2, 3)", &rows)).unwrap(), expected);
        let columns: Vec<u8> = [1.0f64, 4.0, 2.0, 5.0, 3.0, 6.0].iter().flat_map(|x| x.to_be_bytes()).collect();
        assert_eq!(found(&file(">f8", "True", "(2, 3)", &columns)).unwrap(), expected);
        assert_eq!(found(&file("|i1", "False", "(2,3)", &[1, 2, 3, 4, 5, 6])).unwrap(), expected);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (bytes, word) in [
            (file("<f4", "False", "(2, 3)", &[0; 23]), "23 bytes; the shape and type claim 24"),
            (file("<f4", "False", "(99999999999999999999, 3)", &[]), "shape"),
            (file("<f8", "False", "(18446744073709551615, 3)", &[]), "claim 4427218577690292387"),
            (file("<f4", "False", "(4, 4)", &[0; 64]), "shape: found 4, 4; must be (N, 3)"),
            (file("<c8", "False", "(1, 3)", &[0; 24]), "descr: found <c8"),
            (file("<f4", "Maybe", "(1, 3)", &[0; 12]), "fortran_order"),
            (MAGIC.to_vec(), "header must be whole"),
            (file("<f4", "False", "(2, 3)", &[0; 24])[..40].to_vec(), "header must be whole"),
        ] {
            let error = found(&bytes).unwrap_err();
            assert!(error.contains(word), "no {word:?} in {error}");
        }
    }
}
