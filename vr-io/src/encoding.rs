//! Packing of bytes in a file: as they are, compressed, or as hex digits. Text is read by [`crate::payload`].

use std::io::{self, BufRead, Read};

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};

use crate::polled::Polled;

/// The encodings of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Gzip,
    Bzip2,
    Zlib,
    Hex,
    Text,
}

impl Encoding {
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Gzip => "gzip",
            Self::Bzip2 => "bzip2",
            Self::Zlib => "zlib",
            Self::Hex => "hex",
            Self::Text => "ascii",
        }
    }

    /// The compression that the first bytes of a file show, if any.
    pub fn of_file(head: &[u8]) -> Self {
        match head {
            [0x1f, 0x8b, ..] => Self::Gzip,
            [b'B', b'Z', b'h', b'1'..=b'9', ..] => Self::Bzip2,
            _ => Self::Raw,
        }
    }

    /// The bytes behind the encoding.
    pub fn reader<'a>(self, encoded: impl BufRead + 'a) -> Box<dyn Read + 'a> {
        self.boxed_reader(Box::new(encoded))
    }

    /// Decoders of one kind of stream alone, lest each be compiled for several.
    fn boxed_reader<'a>(self, encoded: Box<dyn BufRead + 'a>) -> Box<dyn Read + 'a> {
        match self {
            Self::Raw | Self::Text => Box::new(encoded),
            // A block of the file may stand for a thousand or, with bzip2, a million times as much: the outcome is polled, too.
            Self::Gzip => Box::new(Polled::new(GzipMembers { member: Some(GzDecoder::new(encoded)) })),
            Self::Bzip2 => Box::new(Polled::new(MultiBzDecoder::new(encoded))),
            Self::Zlib => Box::new(Polled::new(ZlibDecoder::new(encoded))),
            Self::Hex => Box::new(HexDigits { encoded }),
        }
    }
}

/// One gzip member after another, as block compressors write them. What follows the last one and is no member (padding) is
/// left alone, as gzip does, while a damaged member is an error.
struct GzipMembers<R> {
    member: Option<GzDecoder<R>>,
}

impl<R: BufRead> Read for GzipMembers<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(out)?;
            if n > 0 || out.is_empty() {
                return Ok(n);
            }
            let Some(mut rest) = self.member.take().map(GzDecoder::into_inner) else { break };
            if Encoding::of_file(rest.fill_buf()?) == Encoding::Gzip {
                self.member = Some(GzDecoder::new(rest));
            }
        }
        Ok(0)
    }
}

/// Two hex digits a byte; white space anywhere is skipped.
struct HexDigits<R> {
    encoded: R,
}

impl<R: BufRead> Read for HexDigits<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let (mut written, mut high) = (0, None);
        while written < out.len() {
            let available = self.encoded.fill_buf()?;
            if available.is_empty() {
                break;
            }
            let mut used = 0;
            for &c in available {
                if written == out.len() {
                    break;
                }
                used += 1;
                if c.is_ascii_whitespace() {
                    continue;
                }
                let digit =
                    char::from(c).to_digit(16).ok_or_else(|| invalid(format!("{:?} is no hex digit", char::from(c))))?
                        as u8;
                match high.take() {
                    None => high = Some(digit),
                    Some(h) => {
                        out[written] = h << 4 | digit;
                        written += 1;
                    }
                }
            }
            self.encoded.consume(used);
        }
        if high.is_some() { Err(invalid("an odd number of hex digits".into())) } else { Ok(written) }
    }
}

pub(crate) fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut e = GzEncoder::new(Vec::new(), Compression::fast());
        e.write_all(bytes).unwrap();
        e.finish().unwrap()
    }

    fn decode(encoding: Encoding, bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        encoding.reader(bytes).read_to_end(&mut out).map(|_| out)
    }

    #[test]
    fn gzip_members_follow_each_other_and_padding_is_no_member() {
        let mut file = gzip(b"first ");
        file.extend(gzip(b"second"));
        file.extend([0; 16]);
        assert_eq!(decode(Encoding::Gzip, &file).unwrap(), b"first second");
    }

    #[test]
    fn a_flipped_bit_in_gzip_is_noticed() {
        let mut file = gzip(b"some bytes that carry a checksum");
        let n = file.len();
        file[n - 6] ^= 1;
        assert!(decode(Encoding::Gzip, &file).is_err());
    }

    #[test]
    fn decoders_end_where_the_work_is_cancelled() {
        let control = vr_core::Control::default();
        let zeros = [0; 1 << 20];
        let mut bzip2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        bzip2.write_all(&zeros).unwrap();
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), Compression::fast());
        zlib.write_all(&zeros).unwrap();
        let packed = [
            (Encoding::Gzip, gzip(&zeros)),
            (Encoding::Bzip2, bzip2.finish().unwrap()),
            (Encoding::Zlib, zlib.finish().unwrap()),
        ];
        for (encoding, bytes) in &packed {
            assert_eq!(decode(*encoding, bytes).unwrap(), zeros);
        }
        let outcome = control.cancellable(|| {
            packed.map(|(encoding, bytes)| {
                control.cancel_flag().store(false, std::sync::atomic::Ordering::Relaxed);
                let mut reader = encoding.reader(&bytes[..]);
                reader.read_exact(&mut [0; 1000]).unwrap();
                control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
                reader.read_to_end(&mut Vec::new()).unwrap_err().to_string()
            })
        });
        assert_eq!(outcome.unwrap(), ["cancelled"; 3]);
    }

    #[test]
    fn hex_digits_may_be_broken_anywhere() {
        assert_eq!(decode(Encoding::Hex, b"00 fF\n1\n2").unwrap(), [0, 255, 0x12]);
        assert!(decode(Encoding::Hex, b"00f").is_err());
        assert!(decode(Encoding::Hex, b"0g").is_err());
    }
}
