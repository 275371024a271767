//! The bytes of a file, of which no more are taken than there are.

use crate::error::FileErrorKind;

/// A place in a file that was read.
#[derive(Clone, Debug)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub fn new(all: &'a [u8], at: usize) -> Self {
        Self { all, at }
    }

    pub fn at(&self) -> usize {
        self.at
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8], FileErrorKind> {
        let taken = self.at.checked_add(count).and_then(|end| self.all.get(self.at..end));
        let taken = taken.ok_or_else(|| {
            let found = format_args!("{count} bytes from byte {} on", self.at);
            FileErrorKind::field("OpenVDB", found, format!("the file ends at byte {}: is it whole?", self.all.len()))
        })?;
        self.at += count;
        Ok(taken)
    }

    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], FileErrorKind> {
        Ok(self.take(N)?.first_chunk().copied().unwrap_or([0; N]))
    }

    pub fn u32(&mut self) -> Result<u32, FileErrorKind> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn i64(&mut self) -> Result<i64, FileErrorKind> {
        self.array().map(i64::from_le_bytes)
    }

    pub fn f32(&mut self) -> Result<f32, FileErrorKind> {
        self.array().map(f32::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64, FileErrorKind> {
        self.array().map(f64::from_le_bytes)
    }

    pub fn index(&mut self) -> Result<[i32; 3], FileErrorKind> {
        let mut next = || self.array().map(i32::from_le_bytes);
        Ok([next()?, next()?, next()?])
    }

    /// A text with its length before it.
    pub fn text(&mut self) -> Result<String, FileErrorKind> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// A set of bits, eight a byte, the lowest first.
    pub fn bits(&mut self, count: usize) -> Result<Bits, FileErrorKind> {
        self.take(count / 8).map(|bytes| Bits(bytes.to_vec()))
    }
}

/// A set of bits.
#[derive(Clone, Debug)]
pub(super) struct Bits(Vec<u8>);

impl Bits {
    pub fn is_on(&self, i: usize) -> bool {
        self.0[i / 8] >> (i % 8) & 1 == 1
    }

    pub fn count(&self) -> usize {
        self.0.iter().map(|b| b.count_ones() as usize).sum()
    }

    /// Indices of the bits that are on.
    pub fn on(&self) -> impl Iterator<Item = usize> {
        (0..8 * self.0.len()).filter(|&i| self.is_on(i))
    }
}
