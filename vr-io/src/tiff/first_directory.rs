//! Check of a file's first directory, which the decoder reads before it can be told how much memory it may take.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::{FileError, FileErrorKind};

/// Returns what is wrong with a table in the first directory that the file is too short to hold. What is no TIFF is left to the decoder. The
/// file is at its begin afterwards.
///
/// # Errors
/// Errors of reading.
pub(crate) fn fault(file: &mut (impl Read + Seek)) -> io::Result<Option<String>> {
    let longest = longest_table(file)?;
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let excess = longest.filter(|&bytes| bytes > u128::from(length));
    Ok(excess.map(|bytes| format!("its directory names a table of {bytes} bytes, more than the file has")))
}

/// Refuses a volume's file whose first directory has such a fault.
///
/// # Errors
/// A damaged file, or errors of reading.
pub(crate) fn check(path: &Path, file: &mut (impl Read + Seek)) -> Result<(), FileError> {
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    match fault(file).map_err(|e| in_file(e.into()))? {
        Some(fault) => Err(in_file(FileErrorKind::Damaged { encoding: "TIFF", source: io::Error::other(fault) })),
        None => Ok(()),
    }
}

/// Returns the bytes of the longest table that the first directory names; `None` where there is no directory.
fn longest_table(file: &mut (impl Read + Seek)) -> io::Result<Option<u128>> {
    file.rewind()?;
    let mut head = Vec::new();
    (&mut *file).take(16).read_to_end(&mut head)?;
    let is_big = match head.get(..2) {
        Some(b"II") => false,
        Some(b"MM") => true,
        _ => return Ok(None),
    };
    // Classic files have offsets of 4 bytes, and BigTIFF of 8.
    let is_wide = head.get(2..4).is_some_and(|version| number(version, is_big) == 43);
    let (first, wide) = if is_wide { (head.get(8..16), 8) } else { (head.get(4..8), 4) };
    let Some(first) = first.map(|bytes| number(bytes, is_big)) else { return Ok(None) };
    file.seek(SeekFrom::Start(first))?;
    let mut bytes = vec![0; if is_wide { 8 } else { 2 }];
    if file.read_exact(&mut bytes).is_err() {
        return Ok(None);
    }
    // Go through the entries: tag, type, count, and the value or its place.
    let entries = number(&bytes, is_big);
    let mut entry = vec![0; 4 + 2 * wide];
    let mut longest = 0;
    for _ in 0..entries {
        if file.read_exact(&mut entry).is_err() {
            break;
        }
        let size: u128 = match number(&entry[2..4], is_big) {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16..=18 => 8,
            _ => 0,
        };
        longest = longest.max(size * u128::from(number(&entry[4..4 + wide], is_big)));
    }
    Ok(Some(longest))
}

/// Returns the number of some bytes.
fn number(bytes: &[u8], is_big: bool) -> u64 {
    let add = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
    if is_big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A classic file in either byte order whose directory has one entry: a table of `count` shorts.
    fn file(is_big: bool, count: u32) -> Vec<u8> {
        let short = |n: u16| if is_big { n.to_be_bytes() } else { n.to_le_bytes() };
        let long = |n: u32| if is_big { n.to_be_bytes() } else { n.to_le_bytes() };
        let order: &[u8] = if is_big { b"MM" } else { b"II" };
        [order, &short(42), &long(8), &short(1), &short(258), &short(3), &long(count), &long(0), &long(0)].concat()
    }

    #[test]
    fn tables_longer_than_the_file_are_refused() {
        for is_big in [false, true] {
            let fault = |count| fault(&mut Cursor::new(file(is_big, count))).unwrap();
            assert_eq!(fault(3), None);
            let refused = fault(4_718_595).unwrap();
            assert!(refused.contains("9437190 bytes"), "{refused}");
        }
    }

    #[test]
    fn what_is_no_directory_is_left_to_the_decoder() {
        for bytes in [&b""[..], b"II", b"PNG", b"II*\0\xff\xff\xff\xff", b"MM\0+\0\x08\0\0\0\0\0\0\0\0\0\x10"] {
            assert_eq!(fault(&mut Cursor::new(bytes)).unwrap(), None, "{bytes:?}");
        }
    }
}
