//! Transfer syntaxes: how a data set and its frames are coded (DICOM PS3.5 2024, section 10 and annex A).

use dicom_dictionary_std::uids;

use super::elements::Headers;
use crate::scalar::Endian;

/// Retired in 2006, and still there in files.
const EXPLICIT_BIG_ENDIAN: &str = "1.2.840.10008.1.2.2";

/// Coding of a data set and of the frames in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TransferSyntax {
    pub headers: Headers,
    /// True if everything after the file's meta information is deflated.
    pub deflated: bool,
    pub frames: FrameCoding,
}

/// Coding of frames.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FrameCoding {
    /// Numbers, one after another.
    Native,
    Rle,
    /// JPEG of 8 bits (baseline, extended) or lossless.
    Jpeg,
    /// One that is not read, by its name.
    Unread(String),
}

impl TransferSyntax {
    /// That of files without meta information.
    pub fn native(headers: Headers) -> Self {
        Self { headers, deflated: false, frames: FrameCoding::Native }
    }

    pub fn from_uid(uid: &str) -> Self {
        match uid {
            uids::IMPLICIT_VR_LITTLE_ENDIAN => Self::native(Headers::Implicit),
            uids::EXPLICIT_VR_LITTLE_ENDIAN => Self::native(Headers::Explicit),
            EXPLICIT_BIG_ENDIAN => Self::native(Headers::ExplicitBig),
            uids::DEFLATED_EXPLICIT_VR_LITTLE_ENDIAN => Self { deflated: true, ..Self::native(Headers::Explicit) },
            uids::RLE_LOSSLESS => Self::encapsulated(FrameCoding::Rle),
            uids::JPEG_BASELINE8_BIT | uids::JPEG_EXTENDED12_BIT | uids::JPEG_LOSSLESS | uids::JPEG_LOSSLESS_SV1 => {
                Self::encapsulated(FrameCoding::Jpeg)
            }
            _ => Self::encapsulated(FrameCoding::Unread(name_of(uid))),
        }
    }

    /// Every coded picture sits in a data set in explicit little endian.
    fn encapsulated(frames: FrameCoding) -> Self {
        Self { frames, ..Self::native(Headers::Explicit) }
    }

    /// Byte order of native frames.
    pub fn endian(&self) -> Endian {
        if self.headers == Headers::ExplicitBig { Endian::Big } else { Endian::Little }
    }
}

fn name_of(uid: &str) -> String {
    let name = match uid {
        uids::JPEGLS_LOSSLESS => "JPEG-LS lossless",
        uids::JPEGLS_NEAR_LOSSLESS => "JPEG-LS near-lossless",
        uids::JPEG2000_LOSSLESS => "JPEG 2000 lossless",
        uids::JPEG2000 => "JPEG 2000",
        uids::HTJ2K_LOSSLESS | uids::HTJ2K_LOSSLESS_RPCL | uids::HTJ2K => "High-Throughput JPEG 2000",
        _ if uid.starts_with("1.2.840.10008.1.2.4.11") => "JPEG XL",
        _ if uid.starts_with("1.2.840.10008.1.2.4.10") => "MPEG video",
        _ => return uid.to_owned(),
    };
    format!("{name} ({uid})")
}
