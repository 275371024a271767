//! The program's name in the pictures that it writes, by which it knows them again.
//!
//! A picture may be replaced by a new one; another program's file is not to be lost for having the same name.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use exr::meta::MetaData;

use crate::regular_file;

/// Name and version of the program, as the files name their maker.
pub(crate) const MAKER: &str = concat!("vr ", env!("CARGO_PKG_VERSION"));

/// Key of the maker in a PNG, as its specification has it.
pub(crate) const PNG_KEY: &str = "Software";

/// Beginning and end of a packet of XMP that names the maker, as WebP holds it.
pub(crate) const XMP: [&str; 2] = [
    "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description \
     xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" xmp:CreatorTool=\"",
    "\"/></rdf:RDF></x:xmpmeta>",
];

/// Bytes at either end of a file in which its maker's name stands.
const END: u64 = 4096;

/// True if a file is a picture or an animation that this program has written, in this version or another, as a PNG, EXR, GIF or WebP.
///
/// # Examples
/// ```
/// use vr_core::Frame;
/// use vr_io::{PngOptions, is_own_picture, write};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("x.png");
/// write(&path, &Frame::new([1, 1], vec![[0.5; 4]], None), &PngOptions::default())?;
/// assert!(is_own_picture(&path));
/// std::fs::write(&path, "a shopping list")?;
/// assert!(!is_own_picture(&path));
/// # Ok(())
/// # }
/// ```
pub fn is_own_picture(path: impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    let Ok((head, tail)) = ends(path) else { return false };
    if head.starts_with(b"\x89PNG") {
        // The chunk says that the text is not packed, has no language, and is not translated.
        return contains(&head, &[PNG_KEY.as_bytes(), b"\0\0\0\0\0vr "].concat());
    }
    if head.starts_with(b"GIF8") {
        // A comment: the extension, its label, the length of the text, which another version may have longer, and the text.
        return head.windows(6).any(|w| w.starts_with(&[0x21, 0xfe]) && w.ends_with(b"vr "));
    }
    if head.starts_with(b"RIFF") {
        return contains(&tail, &[XMP[0].as_bytes(), b"vr "].concat());
    }
    head.starts_with(&exr::meta::magic_number::BYTES) && is_own_exr(path)
}

fn is_own_exr(path: &Path) -> bool {
    // The record among the attributes may be long.
    let Ok(meta) = MetaData::read_from_file(path, false) else { return false };
    meta.headers
        .iter()
        .filter_map(|h| h.own_attributes.software_name.as_ref())
        .any(|name| name.as_slice().starts_with(b"vr "))
}

/// Returns the first and the last bytes of a file.
fn ends(path: &Path) -> std::io::Result<(Vec<u8>, Vec<u8>)> {
    let mut file = regular_file::open(path)?;
    let (mut head, mut tail) = (Vec::new(), Vec::new());
    (&mut file).take(END).read_to_end(&mut head)?;
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(END)))?;
    file.take(END).read_to_end(&mut tail)?;
    Ok((head, tail))
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

#[cfg(test)]
mod tests {
    use vr_core::{Control, Frame};

    use super::*;
    use crate::{AnimationOptions, PngDepth, PngOptions, write, write_animation, write_bytes};

    #[test]
    fn every_picture_is_known_again() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let frame = Frame::new([3, 2], vec![[0.5; 4]; 6], None);
        for (name, depth) in [("a.png", PngDepth::Eight), ("b.png", PngDepth::Sixteen), ("c.exr", PngDepth::Eight)] {
            write(at(name), &frame, &PngOptions { depth, ..PngOptions::default() }).unwrap();
            assert!(is_own_picture(at(name)), "{name}");
        }
        for name in ["d.gif", "e.webp", "f.apng"] {
            let options = AnimationOptions { fps: 10.0, repeats: true };
            write_animation(at(name), &[at("a.png"), at("a.png")], &options, &Control::default()).unwrap();
            assert!(is_own_picture(at(name)), "{name}");
        }
    }

    #[test]
    fn other_versions_are_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.gif");
        write_bytes(&path, b"GIF89a\x01\0\x01\0\0\0\0\x21\xfe\x0avr 10.20.3\0;").unwrap();
        assert!(is_own_picture(&path));
    }

    #[test]
    fn nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        image::RgbImage::new(2, 2).save(at("another.png")).unwrap();
        write_bytes(at("note.txt"), b"vr 0.1.0, Software, and so on").unwrap();
        write_bytes(at("empty.png"), b"").unwrap();
        for name in ["another.png", "note.txt", "empty.png", "missing.png", "."] {
            assert!(!is_own_picture(at(name)), "{name}");
        }
    }
}
