//! Transfer syntaxes: how a data set and its frames are coded (DICOM PS3.5 2024, section 10 and annex A; UIDs in PS3.6, annex A).

use super::element_header::Headers;
use crate::scalar::Endian;

/// Coding of a data set and of the frames in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TransferSyntax {
    /// Name and UID, or the UID alone where that is not known.
    pub name: String,
    pub headers: Headers,
    /// True if everything after the file's meta information is deflated.
    pub deflated: bool,
    pub frames: FrameCoding,
}

/// Coding of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameCoding {
    /// Numbers, one after another.
    Native,
    Rle,
    /// JPEG of 8 bits (baseline, extended) or lossless.
    Jpeg,
    JpegLs,
    /// JPEG 2000, read by builds with the feature `jpeg2000` alone.
    Jpeg2000,
    /// One that is not read.
    Unread,
}

const DEFLATED: &str = "1.2.840.10008.1.2.1.99";

/// UIDs (a star stands for any end), names and codings. Whatever is not here has frames that are not read, in a data set of explicit little
/// endian, as every coded picture.
const KNOWN: [(&str, &str, Headers, FrameCoding); 18] = {
    use FrameCoding::{Jpeg, Jpeg2000, JpegLs, Native, Rle, Unread};
    use Headers::{Explicit, ExplicitBig, Implicit};
    [
        ("1.2.840.10008.1.2", "implicit little endian", Implicit, Native),
        ("1.2.840.10008.1.2.1", "explicit little endian", Explicit, Native),
        (DEFLATED, "deflated explicit little endian", Explicit, Native),
        // Retired in 2006, and still there in files.
        ("1.2.840.10008.1.2.2", "explicit big endian", ExplicitBig, Native),
        ("1.2.840.10008.1.2.5", "RLE lossless", Explicit, Rle),
        ("1.2.840.10008.1.2.4.50", "JPEG baseline", Explicit, Jpeg),
        ("1.2.840.10008.1.2.4.51", "JPEG extended", Explicit, Jpeg),
        ("1.2.840.10008.1.2.4.57", "JPEG lossless", Explicit, Jpeg),
        ("1.2.840.10008.1.2.4.70", "JPEG lossless, first-order prediction", Explicit, Jpeg),
        ("1.2.840.10008.1.2.4.80", "JPEG-LS lossless", Explicit, JpegLs),
        ("1.2.840.10008.1.2.4.81", "JPEG-LS near-lossless", Explicit, JpegLs),
        ("1.2.840.10008.1.2.4.90", "JPEG 2000 lossless", Explicit, Jpeg2000),
        ("1.2.840.10008.1.2.4.91", "JPEG 2000", Explicit, Jpeg2000),
        ("1.2.840.10008.1.2.4.201", "High-Throughput JPEG 2000", Explicit, Unread),
        ("1.2.840.10008.1.2.4.202", "High-Throughput JPEG 2000", Explicit, Unread),
        ("1.2.840.10008.1.2.4.203", "High-Throughput JPEG 2000", Explicit, Unread),
        ("1.2.840.10008.1.2.4.11*", "JPEG XL", Explicit, Unread),
        ("1.2.840.10008.1.2.4.10*", "MPEG video", Explicit, Unread),
    ]
};

impl TransferSyntax {
    /// Transfer syntax of files without meta information.
    pub fn native(headers: Headers) -> Self {
        Self { name: "without meta information".into(), headers, deflated: false, frames: FrameCoding::Native }
    }

    pub fn from_uid(uid: &str) -> Self {
        let fits = |known: &str| match known.strip_suffix('*') {
            Some(beginning) => uid.starts_with(beginning),
            None => uid == known,
        };
        let (name, headers, frames) = match KNOWN.iter().find(|(known, ..)| fits(known)) {
            Some(&(_, name, headers, frames)) => (format!("{name} ({uid})"), headers, frames),
            None => (uid.to_owned(), Headers::Explicit, FrameCoding::Unread),
        };
        Self { name, headers, deflated: uid == DEFLATED, frames }
    }

    /// Byte order of native frames.
    pub fn endian(&self) -> Endian {
        self.headers.endian()
    }
}
