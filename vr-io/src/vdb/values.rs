//! Values of a node as they are stored: those of active voxels alone, packed.

use std::io::Read;

use crate::encoding::Encoding;
use crate::error::FileErrorKind;
use crate::float16;
use crate::zarr;

use super::bytes::{Bits, Bytes};

/// Packing of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compression {
    zip: bool,
    /// True if inactive values are left out.
    active_alone: bool,
    blosc: bool,
}

impl Compression {
    pub fn from_flags(flags: u32) -> Result<Self, FileErrorKind> {
        if flags > 7 {
            return Err(FileErrorKind::field(
                "compression",
                flags,
                "must be a sum of 1 (zip), 2 (active) and 4 (Blosc)",
            ));
        }
        Ok(Self { zip: flags & 1 != 0, active_alone: flags & 2 != 0, blosc: flags & 4 != 0 })
    }

    pub fn name(self) -> &'static str {
        match (self.blosc, self.zip) {
            (true, _) => "blosc",
            (_, true) => "zlib",
            _ => "raw",
        }
    }
}

/// Everything that leads from bytes to values.
#[derive(Clone, Copy, Debug)]
pub(super) struct ValueReader {
    pub compression: Compression,
    pub is_half: bool,
    pub background: f32,
}

impl ValueReader {
    /// Reads the values of a node, of which `active` tells those that are active.
    pub fn read(&self, bytes: &mut Bytes<'_>, active: &Bits, count: usize) -> Result<Vec<f32>, FileErrorKind> {
        // One byte tells which values inactive voxels have.
        let [kind] = bytes.array()?;
        if kind > 6 {
            return Err(FileErrorKind::field("kind of inactive values", kind, "must be 0 to 6"));
        }
        let mut inactive = [if kind == 0 { self.background } else { -self.background }, self.background];
        if matches!(kind, 2 | 4 | 5) {
            inactive[0] = bytes.f32()?;
        }
        if kind == 5 {
            inactive[1] = bytes.f32()?;
        }
        let second = matches!(kind, 3..=5).then(|| bytes.bits(count)).transpose()?;
        let are_all = !self.compression.active_alone || kind == 6;
        let stored = self.numbers(bytes, if are_all { count } else { active.count() })?;
        if are_all {
            return Ok(stored);
        }
        let mut stored = stored.into_iter();
        let value = |i: usize| {
            if active.is_on(i) {
                stored.next().unwrap_or(self.background)
            } else {
                inactive[usize::from(second.as_ref().is_some_and(|second| second.is_on(i)))]
            }
        };
        Ok((0..count).map(value).collect())
    }

    fn numbers(&self, bytes: &mut Bytes<'_>, count: usize) -> Result<Vec<f32>, FileErrorKind> {
        let length = count * if self.is_half { 2 } else { 4 };
        let Compression { zip, blosc, .. } = self.compression;
        if !zip && !blosc {
            return Ok(self.decoded(bytes.take(length)?));
        }
        let packed = bytes.i64()?;
        let wrong = || FileErrorKind::field("length of packed values", packed, "must be that of bytes in the file");
        let size = usize::try_from(packed.unsigned_abs()).map_err(|_| wrong())?;
        let packed_bytes = bytes.take(size)?;
        // What packing would make longer is there as it is.
        let unpacked = if packed <= 0 {
            packed_bytes.to_vec()
        } else {
            let encoding = self.compression.name();
            let damaged = |source| FileErrorKind::Damaged { encoding, source };
            if blosc {
                zarr::decode_blosc(packed_bytes, length).map_err(damaged)?
            } else {
                let mut out = Vec::new();
                let mut zlib = Encoding::Zlib.reader(packed_bytes).take(length as u64 + 1);
                zlib.read_to_end(&mut out).map_err(damaged)?;
                out
            }
        };
        if unpacked.len() != length {
            let allowed = format!("must be {length} for {count} values");
            return Err(FileErrorKind::field("bytes of a node", unpacked.len(), allowed));
        }
        Ok(self.decoded(&unpacked))
    }

    fn decoded(&self, bytes: &[u8]) -> Vec<f32> {
        if self.is_half {
            bytes.as_chunks().0.iter().map(|b| float16::widen(u16::from_le_bytes(*b))).collect()
        } else {
            bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
        }
    }
}
