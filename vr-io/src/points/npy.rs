//! NumPy's `.npy` with N×3 positions (NEP 1, "A simple file format for NumPy arrays"); [`crate::npy`] reads volumes.

use glam::DVec3;

use super::roles::Roles;
use super::{Found, Numbering, Table, numbers};
use crate::error::FileErrorKind;
use crate::npy::{Element, Header};

pub(super) fn read(bytes: &[u8]) -> Result<Found, FileErrorKind> {
    let header = Header::parse(bytes)?;
    let data = bytes.get(header.length..).unwrap_or_default();
    let (endian, by_column) = (header.endian, header.by_column);

    // Hold type and shape against the length of the data.
    let Element::Number(scalar) = header.element else {
        return Err(FileErrorKind::field("descr", "16-bit floats", "positions must be i1 … u8, f4 or f8"));
    };
    let count = match *header.shape.as_slice() {
        [count, 3] => count,
        _ => {
            let allowed = "must be (N, 3): a position in each row; or three axes and more: a volume";
            return Err(FileErrorKind::field("shape", header.shape_text(), allowed));
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    const MAGIC: &[u8] = b"\x93NUMPY";

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
