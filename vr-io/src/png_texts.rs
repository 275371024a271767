//! Texts in a PNG, as chunks right behind its header.

use png::text_metadata::{EncodableTextChunk, ITXtChunk};

/// Bytes of a PNG up to the end of its header: the signature, and a chunk of 13 bytes with length, name and checksum.
const HEADER: usize = 8 + 4 + 4 + 13 + 4;

/// Puts texts into a PNG.
///
/// # Errors
/// The reason why these bytes are no PNG, or a chunk cannot hold a text.
pub(crate) fn with_texts(bytes: &[u8], texts: &[ITXtChunk]) -> Result<Vec<u8>, String> {
    let (header, rest) = bytes.split_at_checked(HEADER).ok_or("a PNG without a header")?;
    let mut out = header.to_vec();
    texts.iter().try_for_each(|text| text.encode(&mut out)).map_err(|e| e.to_string())?;
    out.extend_from_slice(rest);
    Ok(out)
}
