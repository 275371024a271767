//! Encapsulated frames: items of coded bytes, after a table of offsets that may be empty (DICOM PS3.5 2024, annex A.4).

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::element_header::{Headers, ItemHeader};
use super::tags;
use crate::error::{FieldError, FileErrorKind};
use crate::regular_file;

/// A run of coded bytes in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fragment {
    pub offset: u64,
    pub length: u64,
}

/// The fragments of each frame.
pub(super) fn frames(path: &Path, offset: u64, count: usize) -> Result<Vec<Vec<Fragment>>, FileErrorKind> {
    let file = regular_file::open(path)?;
    let end = file.length()?;
    let mut source = BufReader::new(file);
    source.seek(SeekFrom::Start(offset))?;
    let cut_off = |at: u64| {
        let allowed = "must be an item or the end of the sequence: the file is cut off or damaged";
        FieldError::new(tags::PIXEL_DATA.name(), format_args!("no item at byte {at}"), allowed)
    };
    let (mut at, mut items) = (offset, Vec::new());
    loop {
        let length = match Headers::Explicit.item(&mut source).map_err(|_| cut_off(at))? {
            ItemHeader::SequenceEnd => break,
            ItemHeader::Item(Some(length)) => u64::from(length),
            ItemHeader::Item(None) | ItemHeader::ItemEnd | ItemHeader::NoItem => return Err(cut_off(at).into()),
        };
        let fragment = Fragment { offset: at + 8, length };
        at = fragment.offset + length;
        if at > end {
            return Err(cut_off(fragment.offset).into());
        }
        items.push(fragment);
        source.seek_relative(i64::try_from(length).unwrap_or(i64::MAX))?;
    }
    let Some((table, fragments)) = items.split_first() else { return Err(cut_off(offset).into()) };
    if fragments.len() == count {
        return Ok(fragments.iter().map(|&f| vec![f]).collect());
    }
    if count == 1 && !fragments.is_empty() {
        return Ok(vec![fragments.to_vec()]);
    }
    let mut offsets = Vec::new();
    source.seek(SeekFrom::Start(table.offset))?;
    source.take(table.length).read_to_end(&mut offsets)?;
    let offsets: Vec<u64> = offsets.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).into()).collect();
    by_table(fragments, &offsets, count).map_err(Into::into)
}

/// Fragments by the offsets of the first one of each frame, which count from the first item after the table.
fn by_table(fragments: &[Fragment], offsets: &[u64], count: usize) -> Result<Vec<Vec<Fragment>>, FieldError> {
    let wrong = |found: String| {
        let allowed =
            format!("must be one for each of {count} frames, or a table of offsets must tell which belong together");
        FieldError::new("fragments", found, allowed)
    };
    if offsets.len() != count || fragments.is_empty() {
        return Err(wrong(format!("{} fragments and {} offsets", fragments.len(), offsets.len())));
    }
    let first = fragments[0].offset;
    let mut frames = vec![Vec::new(); count];
    for fragment in fragments {
        let from_first = fragment.offset - first;
        let frame = offsets.partition_point(|&o| o <= from_first).checked_sub(1);
        frames[frame.ok_or_else(|| wrong("a fragment before the first frame".into()))?].push(*fragment);
    }
    match frames.iter().position(Vec::is_empty) {
        Some(empty) => Err(wrong(format!("none for frame {empty}"))),
        None => Ok(frames),
    }
}

/// The coded bytes of a frame.
pub(super) fn read(path: &Path, fragments: &[Fragment]) -> Result<Vec<u8>, FileErrorKind> {
    let mut file = regular_file::open(path)?;
    let mut bytes = Vec::new();
    for fragment in fragments {
        file.seek(SeekFrom::Start(fragment.offset))?;
        (&mut file).take(fragment.length).read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_group_fragments() {
        let fragments = [10, 30, 60].map(|offset| Fragment { offset, length: 4 });
        let frames = by_table(&fragments, &[0, 50], 2).unwrap();
        assert_eq!(frames.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        assert!(by_table(&fragments, &[], 2).is_err());
        assert!(by_table(&fragments, &[0, 90], 2).is_err());
        assert!(by_table(&fragments, &[5, 50], 2).is_err());
    }
}
