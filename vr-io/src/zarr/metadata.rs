//! Description of an array: `.zarray` of version 2, `zarr.json` of version 3.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::FieldError;
use crate::scalar::{Endian, ScalarType};

use super::codec::Codec;
use super::json::{self, shown};

/// Largest number of bytes of a chunk, decoded: what a 32-bit length can count.
const MAX_CHUNK_BYTES: u64 = 1 << 32;

/// Everything that is needed to find and decode the chunks of an array.
#[derive(Debug)]
pub(super) struct Array {
    pub folder: PathBuf,
    /// The file of JSON.
    pub file: PathBuf,
    pub shape: Vec<usize>,
    /// Shape of what is decoded at once: a chunk, or one of those in a shard.
    pub chunk: Vec<usize>,
    pub shard: Option<Shard>,
    pub scalar: ScalarType,
    pub endian: Endian,
    /// The fill value, as a chunk would hold it.
    pub fill: Vec<u8>,
    pub keys: Keys,
    /// Codings of bytes, in the order of writing.
    pub codecs: Vec<Codec>,
    /// The axis of the array that each axis of a stored chunk is, slowest first.
    pub order: Vec<usize>,
    /// Names of the axes, where version 3 gives them.
    pub names: Option<Vec<String>>,
}

/// Names of the chunks' files.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Keys {
    /// True for `c/0/1/2` rather than `0.1.2`.
    pub with_prefix: bool,
    pub separator: char,
}

/// Several chunks in one file, with a table of where they lie.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shard {
    /// Chunks along each axis.
    pub chunks: Vec<usize>,
    pub table_at_end: bool,
    /// True if a CRC-32C follows the table.
    pub table_has_checksum: bool,
}

impl Array {
    pub fn read(folder: &Path, file: &Path, json: &Value) -> Result<Self, FieldError> {
        let format = json.get("zarr_format");
        let array = match format.and_then(Value::as_u64) {
            Some(2) => Self::version_2(folder, file, json)?,
            Some(3) => Self::version_3(folder, file, json)?,
            _ => return Err(FieldError::new("zarr_format", shown(format), "must be 2 or 3")),
        };
        let n = array.shape.len();
        if array.chunk.len() != n || array.order.len() != n {
            let found = format_args!("{} axes of chunks", array.chunk.len()).to_string();
            return Err(FieldError::new("chunks", found, format!("must be the {n} axes of the shape")));
        }
        let bytes = array.chunk.iter().try_fold(array.scalar.bytes(), |n, &c| n.checked_mul(c));
        if bytes.is_none_or(|bytes| bytes as u64 > MAX_CHUNK_BYTES) {
            let allowed = format!("must be at most {MAX_CHUNK_BYTES} bytes each");
            return Err(FieldError::new("chunks", format_args!("{:?}", array.chunk), allowed));
        }
        Ok(array)
    }

    fn version_2(folder: &Path, file: &Path, json: &Value) -> Result<Self, FieldError> {
        let shape = json::sizes(json, "shape")?;
        let (scalar, endian) = dtype(json.get("dtype"))?;
        let filters = json.get("filters");
        if !filters.is_none_or(|f| f.is_null() || f.as_array().is_some_and(Vec::is_empty)) {
            return Err(FieldError::new("filters", shown(filters), "must be null: no filter is read"));
        }
        let codecs = match json.get("compressor") {
            None | Some(Value::Null) => Vec::new(),
            Some(compressor) => {
                let id = compressor.get("id").and_then(Value::as_str);
                vec![Codec::from_name(id.unwrap_or_default(), "compressor")?]
            }
        };
        let n = shape.len();
        let order = match json.get("order").and_then(Value::as_str) {
            None | Some("C") => (0..n).collect(),
            Some("F") => (0..n).rev().collect(),
            Some(other) => return Err(FieldError::new("order", other, "must be C or F")),
        };
        let separator = separator("dimension_separator", json.get("dimension_separator"), '.')?;
        Ok(Self {
            folder: folder.into(),
            file: file.into(),
            chunk: json::sizes(json, "chunks")?,
            shard: None,
            fill: fill_bytes(json.get("fill_value"), scalar, endian)?,
            shape,
            scalar,
            endian,
            keys: Keys { with_prefix: false, separator },
            codecs,
            order,
            names: None,
        })
    }

    fn version_3(folder: &Path, file: &Path, json: &Value) -> Result<Self, FieldError> {
        let shape = json::sizes(json, "shape")?;
        let data_type = json.get("data_type");
        let scalar = data_type
            .and_then(Value::as_str)
            .and_then(|name| if name == "bool" { Some(ScalarType::U8) } else { ScalarType::from_name(name) })
            .ok_or_else(|| FieldError::new("data_type", shown(data_type), TYPES))?;
        let (grid, settings) = named(json.get("chunk_grid"), "chunk_grid")?;
        if grid != "regular" {
            return Err(FieldError::new("chunk_grid", grid, "must be regular"));
        }
        let mut chunk = json::sizes(settings, "chunk_shape")?;
        let (encoding, settings) = named(json.get("chunk_key_encoding"), "chunk_key_encoding")?;
        let separator = |fallback| separator("chunk_key_encoding", settings.get("separator"), fallback);
        let keys = match encoding {
            "default" => Keys { with_prefix: true, separator: separator('/')? },
            "v2" => Keys { with_prefix: false, separator: separator('.')? },
            other => return Err(FieldError::new("chunk_key_encoding", other, "must be default or v2")),
        };
        if json.get("storage_transformers").and_then(Value::as_array).is_some_and(|t| !t.is_empty()) {
            let found = shown(json.get("storage_transformers"));
            return Err(FieldError::new("storage_transformers", found, "must be none"));
        }
        let mut chain = Chain::read(json.get("codecs"), shape.len())?;
        let mut shard = None;
        if let Some(settings) = chain.sharding.take() {
            if !chain.codecs.is_empty() || !chain.order.is_sorted() {
                let allowed = "must be alone: no coding before or after it is read";
                return Err(FieldError::new("codecs", "sharding_indexed among others", allowed));
            }
            let inner = json::sizes(settings, "chunk_shape")?;
            shard = Some(Shard::read(settings, &chunk, &inner)?);
            chunk = inner;
            chain = Chain::read(settings.get("codecs"), shape.len())?;
            if chain.sharding.is_some() {
                return Err(FieldError::new("codecs", "shards in shards", "are not read"));
            }
        }
        Ok(Self {
            folder: folder.into(),
            file: file.into(),
            chunk,
            shard,
            fill: fill_bytes(json.get("fill_value"), scalar, chain.endian)?,
            names: json.get("dimension_names").and_then(json::strings),
            shape,
            scalar,
            endian: chain.endian,
            keys,
            codecs: chain.codecs,
            order: chain.order,
        })
    }

    /// Numbers of a chunk.
    pub fn chunk_count(&self) -> usize {
        self.chunk.iter().product()
    }

    /// Name of the coding: of the outermost compression.
    pub fn encoding(&self) -> &'static str {
        self.codecs.iter().rev().find(|c| **c != Codec::Crc32c).map_or("raw", |c| c.name())
    }

    /// The file that holds the chunk, or the shard, of these indices.
    pub fn chunk_file(&self, indices: &[usize]) -> PathBuf {
        let mut key = String::from(if self.keys.with_prefix { "c" } else { "" });
        for index in indices {
            if !key.is_empty() {
                key.push(self.keys.separator);
            }
            key.push_str(&index.to_string());
        }
        self.folder.join(key)
    }
}

/// The codings of version 3, sorted by what they work on.
struct Chain<'a> {
    codecs: Vec<Codec>,
    order: Vec<usize>,
    endian: Endian,
    /// The settings of shards, which stand where `bytes` would.
    sharding: Option<&'a Value>,
}

impl<'a> Chain<'a> {
    fn read(value: Option<&'a Value>, axes: usize) -> Result<Self, FieldError> {
        let list = value.and_then(Value::as_array);
        let list = list.ok_or_else(|| FieldError::new("codecs", shown(value), "must be a list"))?;
        let mut chain = Self { codecs: Vec::new(), order: (0..axes).collect(), endian: Endian::Little, sharding: None };
        let mut is_bytes = false;
        for entry in list {
            let (name, settings) = named(Some(entry), "codecs")?;
            let misplaced = |must| Err(FieldError::new("codecs", name, must));
            match name {
                "transpose" if is_bytes => return misplaced("must come before bytes"),
                "transpose" => {
                    let turned = permutation(settings.get("order"), axes)?;
                    chain.order = turned.iter().map(|&a| chain.order[a]).collect();
                }
                "bytes" | "endian" | "sharding_indexed" if is_bytes => return misplaced("must be there once"),
                "bytes" | "endian" => {
                    is_bytes = true;
                    chain.endian = match settings.get("endian").and_then(Value::as_str) {
                        None | Some("little") => Endian::Little,
                        Some("big") => Endian::Big,
                        Some(other) => return Err(FieldError::new("endian", other, "must be little or big")),
                    };
                }
                "sharding_indexed" => {
                    is_bytes = true;
                    chain.sharding = Some(settings);
                }
                _ if !is_bytes => return misplaced("must come after bytes; before it, transpose alone is read"),
                _ => chain.codecs.push(Codec::from_name(name.trim_start_matches("numcodecs."), "codecs")?),
            }
        }
        if is_bytes { Ok(chain) } else { Err(FieldError::new("codecs", shown(value), "must have bytes among them")) }
    }
}

impl Shard {
    fn read(settings: &Value, shard: &[usize], inner: &[usize]) -> Result<Self, FieldError> {
        let fits = shard.len() == inner.len() && shard.iter().zip(inner).all(|(s, i)| s.is_multiple_of(*i));
        if !fits {
            let allowed = format!("must divide the shards, {shard:?}");
            return Err(FieldError::new("chunk_shape", format_args!("{inner:?}"), allowed));
        }
        let table = Chain::read(settings.get("index_codecs"), 1)?;
        let allowed = "must be bytes, little-endian, and crc32c";
        let wrong = || FieldError::new("index_codecs", shown(settings.get("index_codecs")), allowed);
        let table_has_checksum = match table.codecs.as_slice() {
            [] => false,
            [Codec::Crc32c] => true,
            _ => return Err(wrong()),
        };
        if table.endian != Endian::Little || table.sharding.is_some() {
            return Err(wrong());
        }
        let table_at_end = match settings.get("index_location").and_then(Value::as_str) {
            None | Some("end") => true,
            Some("start") => false,
            Some(other) => return Err(FieldError::new("index_location", other, "must be start or end")),
        };
        let chunks = shard.iter().zip(inner).map(|(s, i)| s / i).collect();
        Ok(Self { chunks, table_at_end, table_has_checksum })
    }
}

const TYPES: &str = "must be bool, or integers of 8 to 64 bits, or floats of 32 or 64";

/// NumPy's name of a type: byte order, kind, bytes.
fn dtype(value: Option<&Value>) -> Result<(ScalarType, Endian), FieldError> {
    let wrong = || FieldError::new("dtype", shown(value), TYPES);
    let text = value.and_then(Value::as_str).ok_or_else(wrong)?;
    let mut letters = text.chars();
    let endian = match letters.next() {
        Some('<' | '|') => Endian::Little,
        Some('>') => Endian::Big,
        _ => return Err(wrong()),
    };
    let scalar = match letters.as_str() {
        "b1" | "u1" => ScalarType::U8,
        "i1" => ScalarType::I8,
        "u2" => ScalarType::U16,
        "i2" => ScalarType::I16,
        "u4" => ScalarType::U32,
        "i4" => ScalarType::I32,
        "u8" => ScalarType::U64,
        "i8" => ScalarType::I64,
        "f4" => ScalarType::F32,
        "f8" => ScalarType::F64,
        _ => return Err(wrong()),
    };
    Ok((scalar, endian))
}

/// An extension of version 3: its name, and its settings, null where it has none.
fn named<'a>(value: Option<&'a Value>, field: &str) -> Result<(&'a str, &'a Value), FieldError> {
    const NONE: &Value = &Value::Null;
    let wrong = || FieldError::new(field, shown(value), "must have a name");
    let value = value.ok_or_else(wrong)?;
    if let Some(name) = value.as_str() {
        return Ok((name, NONE));
    }
    let name = value.get("name").and_then(Value::as_str).ok_or_else(wrong)?;
    Ok((name, value.get("configuration").unwrap_or(NONE)))
}

fn separator(field: &str, value: Option<&Value>, fallback: char) -> Result<char, FieldError> {
    match value.and_then(Value::as_str) {
        None => Ok(fallback),
        Some(".") => Ok('.'),
        Some("/") => Ok('/'),
        Some(other) => Err(FieldError::new(field, other, "must be . or /")),
    }
}

fn permutation(value: Option<&Value>, axes: usize) -> Result<Vec<usize>, FieldError> {
    let wrong = || FieldError::new("transpose", shown(value), format!("must be a permutation of 0 to {}", axes - 1));
    if value.and_then(Value::as_str) == Some("F") {
        return Ok((0..axes).rev().collect());
    }
    let list = value.and_then(Value::as_array).ok_or_else(wrong)?;
    let list: Vec<usize> =
        list.iter().map(|v| v.as_u64().map(|n| n as usize)).collect::<Option<_>>().ok_or_else(wrong)?;
    let mut sorted = list.clone();
    sorted.sort_unstable();
    if sorted.iter().copied().eq(0..axes) { Ok(list) } else { Err(wrong()) }
}

/// The bytes of the fill value; of none, those of 0.
fn fill_bytes(value: Option<&Value>, scalar: ScalarType, endian: Endian) -> Result<Vec<u8>, FieldError> {
    let wrong = || FieldError::new("fill_value", shown(value), format!("must be a number of type {scalar}"));
    let value = match value {
        None | Some(Value::Null) => &Value::from(0),
        Some(value) => value,
    };
    let value = match value {
        Value::Bool(b) => &Value::from(u8::from(*b)),
        value => value,
    };
    // Bits of a float that no number of JSON can be.
    let bits = value.as_str().and_then(|s| u64::from_str_radix(s.strip_prefix("0x")?, 16).ok());
    let float = || match value.as_str() {
        Some("NaN") => Some(f64::NAN),
        Some("Infinity") => Some(f64::INFINITY),
        Some("-Infinity") => Some(f64::NEG_INFINITY),
        _ => value.as_f64(),
    };
    // Version 2 writes integers as floats now and then.
    let integer = || {
        let whole = |f: f64| (f.fract() == 0.0 && f.abs() < 2f64.powi(53)).then_some(f as i128);
        value.as_i64().map(i128::from).or(value.as_u64().map(i128::from)).or(value.as_f64().and_then(whole))
    };
    macro_rules! bytes {
        ($t:ty) => {
            <$t>::try_from(integer().ok_or_else(wrong)?).map_err(|_| wrong())?.to_le_bytes().to_vec()
        };
    }
    let mut bytes = match scalar {
        ScalarType::U8 => bytes!(u8),
        ScalarType::I8 => bytes!(i8),
        ScalarType::U16 => bytes!(u16),
        ScalarType::I16 => bytes!(i16),
        ScalarType::U32 => bytes!(u32),
        ScalarType::I32 => bytes!(i32),
        ScalarType::U64 => bytes!(u64),
        ScalarType::I64 => bytes!(i64),
        ScalarType::F32 => match bits {
            Some(bits) => u32::try_from(bits).map_err(|_| wrong())?.to_le_bytes().to_vec(),
            None => (float().ok_or_else(wrong)? as f32).to_le_bytes().to_vec(),
        },
        ScalarType::F64 => match bits {
            Some(bits) => bits.to_le_bytes().to_vec(),
            None => float().ok_or_else(wrong)?.to_le_bytes().to_vec(),
        },
    };
    if endian == Endian::Big {
        bytes.reverse();
    }
    Ok(bytes)
}
