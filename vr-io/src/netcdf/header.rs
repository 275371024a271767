//! The header of a classic file: dimensions, attributes and variables.

use std::io::{BufReader, Read};
use std::path::Path;

use crate::decode::numbers_as_f64;
use crate::error::{FileErrorKind, shown};
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::variables::{Attribute, Variable};

/// Most bytes of a header: attributes are read into memory.
const MAX_BYTES: u64 = 1 << 26;
/// Most dimensions of a variable, as the library has it.
const MAX_AXES: u64 = 1024;

/// Everything before the numbers.
#[derive(Debug)]
pub(super) struct Header {
    /// 1, 2 or 5.
    pub version: u8,
    /// Variables of numbers.
    pub variables: Vec<Variable>,
    /// Place of each of them, in the same order.
    pub places: Vec<Place>,
    /// Variables of characters, which have the type of their bytes here, and their places.
    pub texts: Vec<(Variable, Place)>,
}

/// Place of a variable's numbers, and its attributes.
#[derive(Debug)]
pub(super) struct Place {
    /// First byte.
    pub begin: u64,
    /// Bytes from one record to the next, where the first axis counts records.
    pub record: Option<u64>,
    pub attributes: Vec<(String, Attribute)>,
}

struct Dimension {
    name: String,
    /// 0 for the one that counts records.
    length: u64,
}

impl Header {
    pub fn read(path: &Path) -> Result<Self, FileErrorKind> {
        let file = regular_file::open(path)?;
        let length = file.length()?;
        Self::parse(BufReader::new(file), length)
    }

    fn parse(file: impl Read, length: u64) -> Result<Self, FileErrorKind> {
        let mut words = Words { file, version: 1, left: length.min(MAX_BYTES) };
        let magic = words.bytes(4)?;
        words.version = match magic[..] {
            [b'C', b'D', b'F', version @ (1 | 2 | 5)] => version,
            _ => return Err(FileErrorKind::field("magic", format!("{magic:?}"), "must be CDF and 1, 2 or 5")),
        };
        let counted = words.size()?;
        let dimensions =
            words.list(10, "dimensions", |words| Ok(Dimension { name: words.name()?, length: words.size()? }))?;
        words.attributes()?;
        let raw = words.list(11, "variables", Words::variable)?;
        let version = words.version;

        // Records hold a part of each variable that has the dimension without a length.
        let counts_records = |v: &RawVariable| v.dimensions.first().is_some_and(|&d| is_record(&dimensions, d));
        let record_bytes = |v: &RawVariable| {
            let numbers = v.dimensions.iter().skip(1).map(|&d| dimension(&dimensions, d).map_or(0, |d| d.length));
            numbers.fold(v.kind.bytes(), u64::saturating_mul)
        };
        let padded = |bytes: u64| bytes.saturating_add(3) / 4 * 4;
        let of_records: Vec<u64> = raw.iter().filter(|v| counts_records(v)).map(record_bytes).collect();
        let record = match of_records[..] {
            // One alone is not padded.
            [only] => only,
            _ => of_records.iter().map(|&bytes| padded(bytes)).fold(0, u64::saturating_add),
        };
        // A file that is being written does not count its records.
        let streaming = if version == 5 { u64::MAX } else { u64::from(u32::MAX) };
        let first_record = raw.iter().filter(|v| counts_records(v)).map(|v| v.begin).min().unwrap_or(length);
        let records = if counted == streaming {
            length.saturating_sub(first_record).checked_div(record).unwrap_or(0)
        } else {
            counted
        };

        let (mut variables, mut places, mut texts) = (Vec::new(), Vec::new(), Vec::new());
        for v in raw {
            let scalar = match v.kind {
                Kind::Number(scalar) => scalar,
                Kind::Text => ScalarType::U8,
            };
            let (mut shape, mut names) = (Vec::new(), Vec::new());
            for (a, &d) in v.dimensions.iter().enumerate() {
                let found = dimension(&dimensions, d).ok_or_else(|| {
                    let allowed = format!("the file has {} dimensions", dimensions.len());
                    FileErrorKind::field(format!("dimensions of {}", shown(&v.name)), d, allowed)
                })?;
                let size = if found.length > 0 { found.length } else { records };
                if found.length == 0 && a > 0 {
                    let name = format!("dimensions of {}", shown(&v.name));
                    return Err(FileErrorKind::field(name, shown(&found.name), "the one of records must be the first"));
                }
                shape.push(
                    usize::try_from(size).map_err(|_| FileErrorKind::field("dimension", size, "must fit memory"))?,
                );
                names.push(Some(found.name.clone()));
            }
            let record = counts_records(&v).then_some(record);
            let place = Place { begin: v.begin, record, attributes: v.attributes };
            let variable = Variable { name: v.name, shape, dimensions: names, scalar };
            if v.kind == Kind::Text {
                texts.push((variable, place));
            } else {
                variables.push(variable);
                places.push(place);
            }
        }
        Ok(Self { version, variables, places, texts })
    }
}

fn dimension(dimensions: &[Dimension], index: u64) -> Option<&Dimension> {
    dimensions.get(usize::try_from(index).ok()?)
}

fn is_record(dimensions: &[Dimension], index: u64) -> bool {
    dimension(dimensions, index).is_some_and(|d| d.length == 0)
}

struct RawVariable {
    name: String,
    dimensions: Vec<u64>,
    attributes: Vec<(String, Attribute)>,
    kind: Kind,
    begin: u64,
}

/// Type of a variable or an attribute.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Text,
    Number(ScalarType),
}

impl Kind {
    fn bytes(self) -> u64 {
        match self {
            Self::Text => 1,
            Self::Number(scalar) => scalar.bytes() as u64,
        }
    }
}

/// The words of a header, of which no more are read than the file has.
struct Words<R> {
    file: R,
    version: u8,
    left: u64,
}

impl<R: Read> Words<R> {
    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, FileErrorKind> {
        let cut_off = || FileErrorKind::field("header", "its end", "must be whole, and of 64 MiB at most");
        self.left = self.left.checked_sub(count).ok_or_else(cut_off)?;
        let mut bytes = Vec::new();
        (&mut self.file).take(count).read_to_end(&mut bytes)?;
        if bytes.len() as u64 == count { Ok(bytes) } else { Err(cut_off()) }
    }

    fn word(&mut self) -> Result<u32, FileErrorKind> {
        let bytes = self.bytes(4)?;
        Ok(bytes.first_chunk().map_or(0, |b| u32::from_be_bytes(*b)))
    }

    fn long(&mut self) -> Result<u64, FileErrorKind> {
        let bytes = self.bytes(8)?;
        Ok(bytes.first_chunk().map_or(0, |b| u64::from_be_bytes(*b)))
    }

    /// A size or a count.
    fn size(&mut self) -> Result<u64, FileErrorKind> {
        if self.version == 5 { self.long() } else { self.word().map(u64::from) }
    }

    /// Bytes and their padding to whole words.
    fn padded(&mut self, count: u64) -> Result<Vec<u8>, FileErrorKind> {
        let mut bytes = self.bytes(count)?;
        self.bytes(count.wrapping_neg() % 4)?;
        bytes.shrink_to_fit();
        Ok(bytes)
    }

    fn name(&mut self) -> Result<String, FileErrorKind> {
        let length = self.size()?;
        let bytes = self.padded(length)?;
        String::from_utf8(bytes).map_err(|_| FileErrorKind::field("header", "a name that is no text", "must be UTF-8"))
    }

    /// A list that begins with its tag, or with 0 where it is empty.
    fn list<T>(
        &mut self,
        tag: u32,
        what: &str,
        mut entry: impl FnMut(&mut Self) -> Result<T, FileErrorKind>,
    ) -> Result<Vec<T>, FileErrorKind> {
        let (found, count) = (self.word()?, self.size()?);
        if found != tag && (found, count) != (0, 0) {
            return Err(FileErrorKind::field(format!("list of {what}"), found, format!("must begin with {tag}")));
        }
        // Grows with what is there: each entry is some bytes of the file.
        let mut entries = Vec::new();
        for _ in 0..count {
            entries.push(entry(self)?);
        }
        Ok(entries)
    }

    fn attributes(&mut self) -> Result<Vec<(String, Attribute)>, FileErrorKind> {
        self.list(12, "attributes", |words| {
            let (name, kind, count) = (words.name()?, words.kind()?, words.size()?);
            let bytes = words.padded(count.saturating_mul(kind.bytes()))?;
            let value = match kind {
                Kind::Text => Attribute::Text(String::from_utf8_lossy(&bytes).into_owned()),
                Kind::Number(scalar) => Attribute::Numbers(numbers_as_f64(&bytes, scalar, Endian::Big)),
            };
            Ok((name, value))
        })
    }

    fn kind(&mut self) -> Result<Kind, FileErrorKind> {
        Ok(Kind::Number(match self.word()? {
            1 => ScalarType::I8,
            2 => return Ok(Kind::Text),
            3 => ScalarType::I16,
            4 => ScalarType::I32,
            5 => ScalarType::F32,
            6 => ScalarType::F64,
            7 => ScalarType::U8,
            8 => ScalarType::U16,
            9 => ScalarType::U32,
            10 => ScalarType::I64,
            11 => ScalarType::U64,
            other => return Err(FileErrorKind::field("nc_type", other, "must be 1 to 11")),
        }))
    }

    fn variable(&mut self) -> Result<RawVariable, FileErrorKind> {
        let (name, count) = (self.name()?, self.size()?);
        if count > MAX_AXES {
            let field = format!("dimensions of {}", shown(&name));
            return Err(FileErrorKind::field(field, count, format!("must be at most {MAX_AXES}")));
        }
        let dimensions = (0..count).map(|_| self.size()).collect::<Result<_, _>>()?;
        let (attributes, kind) = (self.attributes()?, self.kind()?);
        // Its size in bytes, which the dimensions tell as well, and better where it is beyond 32 bits.
        self.size()?;
        let begin = if self.version == 1 { u64::from(self.word()?) } else { self.long()? };
        Ok(RawVariable { name, dimensions, attributes, kind, begin })
    }
}
