//! NRRD (“nearly raw raster data”), versions 1 to 5: <https://teem.sourceforge.net/nrrd/format.html>.

mod axes;
mod data;
mod geometry;
mod header;

use std::collections::BTreeMap;
use std::path::Path;

use vr_core::Calibration;

use crate::error::{FieldError, FileError, shown};
use crate::layout::Layout;
use crate::notes::Notes;
use crate::read::{Description, ReadOptions, file_head};
use crate::scalar::ScalarType;

use header::Header;

/// Keys of ours for what NRRD has no field for; other readers show them and go on.
pub(crate) const SLOPE_KEY: &str = "vr slope";
pub(crate) const INTERCEPT_KEY: &str = "vr intercept";

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let header = Header::read(path)?;
    let in_file = |e: FieldError| e.in_file(path);
    let mut notes = Notes::default();
    let unknown = header.unknown_fields();
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.iter().map(|name| shown(name)).collect();
        notes.push(format!("unknown fields are left aside: {}", names.join(", ")));
    }
    let sizes = header.sizes().map_err(in_file)?;
    let scalar = scalar_type(header.required("type").map_err(in_file)?).map_err(in_file)?;
    let axes = axes::axes(&header, &sizes, scalar).map_err(in_file)?;
    let layout = Layout::new(path, &axes, options)?;
    let world = geometry::world(path, &header, &axes, &mut notes)?;
    let payload = data::payload(path, &header, &layout, scalar)?;
    let calibration = calibration(&header).map_err(in_file)?;
    Ok(Description {
        format: "NRRD",
        header: path.into(),
        source: payload.into(),
        layout,
        placement: world.placement,
        placed_by: world.placed_by,
        calibration,
        space: world.space,
        units: world.units,
        scan: None,
        notes,
    })
}

/// Keys about segments in the header of a file; `None` for a file that is no NRRD.
pub(crate) fn segment_keys(path: &Path) -> Result<Option<BTreeMap<String, String>>, FileError> {
    let head = if crate::memory_folder::is_file(path) {
        file_head(path).map_err(|e| FileError::new(path, e))?
    } else {
        Vec::new()
    };
    Ok(if head.starts_with(b"NRRD") { Some(Header::read(path)?.key_values_of("Segment")) } else { None })
}

fn scalar_type(name: &str) -> Result<ScalarType, FieldError> {
    // Every spelling that the format lists.
    Ok(match name {
        "signed char" | "int8" | "int8_t" => ScalarType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => ScalarType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => ScalarType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => ScalarType::U16,
        "int" | "signed int" | "int32" | "int32_t" => ScalarType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => ScalarType::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => ScalarType::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => ScalarType::U64,
        "float" => ScalarType::F32,
        "double" => ScalarType::F64,
        _ => {
            let allowed = "must be int8, uint8, int16, uint16, int32, uint32, int64, uint64, float or double";
            return Err(FieldError::new("type", name, allowed));
        }
    })
}

fn calibration(header: &Header) -> Result<Calibration, FieldError> {
    let number = |key: &str, default: f64| match header.key_value(key) {
        None => Ok(default),
        Some(text) => text.parse().map_err(|_| FieldError::new(key, text, "must be a number")),
    };
    Ok(Calibration { slope: number(SLOPE_KEY, 1.0)?, intercept: number(INTERCEPT_KEY, 0.0)? })
}
