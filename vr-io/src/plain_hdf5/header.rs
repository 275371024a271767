//! The header of an object: messages about it.

use crate::error::FileErrorKind;

use super::damaged;
use super::window::{Window, word};

/// The message that leads to more messages.
const CONTINUATION: u16 = 0x10;
/// Parts that a header may be in, and bytes of each.
const MAX_PARTS: usize = 64;
const MAX_LENGTH: u64 = 1 << 16;

/// A message.
pub(super) struct Message {
    pub kind: u16,
    pub data: Vec<u8>,
    /// Place of its data in the file.
    pub at: u64,
}

/// All messages of the header at a place; none for a header of another version.
pub(super) fn messages(window: &mut Window, at: u64) -> Result<Vec<Message>, FileErrorKind> {
    let head = window.bytes(at, 16)?;
    if head[0] != 1 {
        return Ok(Vec::new());
    }
    let length = head[8..].first_chunk().map_or(0, |b| u32::from_le_bytes(*b));
    // Behind the head of 12 bytes, messages begin at a multiple of 8.
    let mut parts = vec![(at.saturating_add(16), u64::from(length))];
    let mut found = Vec::new();
    let mut next = 0;
    while let Some(&(begin, length)) = parts.get(next) {
        next += 1;
        if length > MAX_LENGTH {
            return Err(damaged(begin, "a header that is too long"));
        }
        let bytes = window.bytes(begin, length)?;
        let mut from = 0;
        // Type and size of each, of two bytes, flags of one, and three that are reserved.
        while let Some(head) = bytes.get(from..).and_then(|rest| rest.first_chunk::<8>()) {
            let kind = u16::from_le_bytes([head[0], head[1]]);
            let size = usize::from(u16::from_le_bytes([head[2], head[3]]));
            let place = begin + from as u64 + 8;
            let data =
                bytes.get(from + 8..from + 8 + size).ok_or_else(|| damaged(place, "a message that is cut off"))?;
            from += 8 + size;
            if kind == CONTINUATION {
                let part = word(data, 0).zip(word(data, 8));
                parts.push(part.ok_or_else(|| damaged(place, "a message that is too short"))?);
                if parts.len() > MAX_PARTS {
                    return Err(damaged(place, "too many parts of one header"));
                }
            } else {
                found.push(Message { kind, data: data.to_vec(), at: place });
            }
        }
    }
    Ok(found)
}
