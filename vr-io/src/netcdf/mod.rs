//! NetCDF's classic formats, CDF-1, CDF-2 and CDF-5 (NetCDF User's Guide, "File Format Specifications"). NetCDF-4 is HDF5.
//!
//! Own code: the formats are a header and numbers behind it, and the crates at hand bring arrays of their own.

mod header;

use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::error::{FileError, FileErrorKind};
use crate::read::{Description, ReadOptions};
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::variables::{self, Attribute, Store, Variable};

use header::{Header, Place};

/// True if a file begins as the classic formats do.
pub(crate) fn is_netcdf(head: &[u8]) -> bool {
    [b"CDF\x01", b"CDF\x02", b"CDF\x05"].iter().any(|magic| head.starts_with(*magic))
}

/// Everything that the header says about the chosen variable.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let header = Header::read(path).map_err(|kind| FileError::new(path, kind))?;
    let format = match header.version {
        1 => "NetCDF (CDF-1)",
        2 => "NetCDF (CDF-2)",
        _ => "NetCDF (CDF-5)",
    };
    variables::describe(path, format, Classic { path: path.into(), header }, options)
}

/// A file.
pub(crate) struct Classic {
    path: PathBuf,
    header: Header,
}

impl Classic {
    /// Reads the header.
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        Ok(Self { path: path.into(), header: Header::read(path)? })
    }

    /// The lines of a variable of characters, without the blanks and zeros that fill them up; none where there is no such variable.
    pub fn lines(&self, name: &str) -> Result<Vec<String>, FileErrorKind> {
        let Some((variable, place)) = self.header.texts.iter().find(|(variable, _)| variable.name == name) else {
            return Ok(Vec::new());
        };
        let bytes = self.read_place(variable, place, &vec![0; variable.shape.len()], &variable.shape)?;
        let length = variable.shape.last().copied().unwrap_or(1).max(1);
        let text = |line: &[u8]| {
            let end = line.iter().position(|&c| c == 0).unwrap_or(line.len());
            String::from_utf8_lossy(line[..end].trim_ascii()).into_owned()
        };
        Ok(bytes.chunks(length).map(text).collect())
    }

    /// Reads the bytes of a part of a variable.
    fn read_place(
        &self,
        variable: &Variable,
        place: &Place,
        start: &[usize],
        count: &[usize],
    ) -> Result<Vec<u8>, FileErrorKind> {
        let mut file = regular_file::open(&self.path)?;
        let length = file.length()?;
        let claimed = count.iter().fold(variable.scalar.bytes() as u64, |n, &c| n.saturating_mul(c as u64));
        // Nothing is allocated for more than there is.
        let end = place.end(variable, start, count);
        if end > length || claimed > length {
            let found = claimed.saturating_sub(end.saturating_sub(length));
            return Err(FileErrorKind::Length { claimed, found, hint: " (is the file whole?)" });
        }
        let mut out = Vec::with_capacity(usize::try_from(claimed).unwrap_or(0));
        for (offset, bytes) in place.runs(variable, start, count) {
            file.seek(SeekFrom::Start(offset))?;
            (&mut file).take(bytes).read_to_end(&mut out)?;
        }
        Ok(out)
    }
}

impl Store for Classic {
    fn variables(&self) -> &[Variable] {
        &self.header.variables
    }

    fn attribute(&self, variable: &str, name: &str) -> Option<Attribute> {
        let index = self.header.variables.iter().position(|v| v.name == variable)?;
        let found = self.header.places[index].attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.clone())
    }

    fn read(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Vec<u8>, FileErrorKind> {
        let index = self.header.variables.iter().position(|v| v.name == variable.name);
        self.read_place(variable, &self.header.places[index.unwrap_or_default()], start, count)
    }

    fn endian(&self) -> Endian {
        Endian::Big
    }

    fn default_fill(&self, scalar: ScalarType) -> Option<f64> {
        variables::netcdf_fill(scalar)
    }
}

impl Place {
    /// Byte behind the last one of a part.
    fn end(&self, variable: &Variable, start: &[usize], count: &[usize]) -> u64 {
        let last: Vec<usize> = start.iter().zip(count).map(|(s, n)| s + n.saturating_sub(1)).collect();
        self.offset(variable, &last).saturating_add(variable.scalar.bytes() as u64)
    }

    /// Place of a number.
    fn offset(&self, variable: &Variable, index: &[usize]) -> u64 {
        let strides = self.strides(variable);
        let terms = index.iter().zip(strides).map(|(&i, stride)| (i as u64).saturating_mul(stride));
        terms.fold(self.begin, u64::saturating_add)
    }

    /// Bytes from one index to the next.
    fn strides(&self, variable: &Variable) -> Vec<u64> {
        let mut strides = vec![0; variable.shape.len()];
        let mut stride = variable.scalar.bytes() as u64;
        for a in (0..variable.shape.len()).rev() {
            strides[a] = stride;
            stride = stride.saturating_mul(variable.shape[a] as u64);
        }
        // Records of all variables take turns.
        if let (Some(record), Some(first)) = (self.record, strides.first_mut()) {
            *first = record;
        }
        strides
    }

    /// Offset and length of each run of bytes of a part, in order.
    fn runs(&self, variable: &Variable, start: &[usize], count: &[usize]) -> impl Iterator<Item = (u64, u64)> {
        let strides = self.strides(variable);
        // The axes from `outer` on are one run.
        let n = variable.shape.len();
        let mut outer = n;
        let mut run = variable.scalar.bytes() as u64;
        while outer > 0 && strides[outer - 1] == run {
            outer -= 1;
            run *= count[outer] as u64;
            if count[outer] != variable.shape[outer] {
                break;
            }
        }
        let total: u64 = count[..outer].iter().map(|&c| c as u64).product();
        let (begin, count) = (self.offset(variable, start), count[..outer].to_vec());
        (0..total).map(move |i| {
            let mut rest = i;
            let mut offset = begin;
            for a in (0..outer).rev() {
                offset += rest % count[a] as u64 * strides[a];
                rest /= count[a] as u64;
            }
            (offset, run)
        })
    }
}
