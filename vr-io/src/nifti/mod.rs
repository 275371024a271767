//! NIfTI-1 and NIfTI-2, single files and pairs, gzipped or not: <https://nifti.nimh.nih.gov>.

mod header;
mod transform;

use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use vr_core::Calibration;

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::layout::{Axis, Layout, Role};
use crate::memory_folder;
use crate::notes::Notes;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::regular_file;
use crate::scalar::ScalarType;
use crate::world::Space;

pub use transform::Transform;

use header::Header;

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let path = &header_of_image(path);
    let in_file = |e: FieldError| e.in_file(path);
    let (head, encoding) = read_head(path)?;
    let header = Header::parse(&head).map_err(in_file)?;
    let mut notes = Notes::default();

    let (scalar, channels) = data_type(header.datatype).map_err(in_file)?;
    let mut axes = vec![Axis { size: channels, role: if channels > 1 { Role::Color } else { Role::Component } }];
    let sizes = header.sizes().map_err(in_file)?;
    axes.extend(sizes.iter().enumerate().map(|(i, &size)| Axis {
        size,
        // x y z, time, then the values of a vector; beyond that writers differ, and there is hardly ever more than one.
        role: match i {
            0..3 => Role::Space,
            3 => Role::Frame,
            _ => Role::Component,
        },
    }));
    let layout = Layout::new(path, &axes, options)?;
    let placed = transform::place(&header, options.transform, &mut notes).map_err(in_file)?;
    let placement = Space::Ras.place(placed.origin, placed.axes).map_err(|e| FileError::new(path, e))?;

    let segment = if header.is_pair {
        let image = image_of_header(path)?;
        let skip = Skip::Bytes(header.vox_offset(0).map_err(in_file)?);
        Segment { path: image, start: 0, lines: 0, skip }
    } else {
        let skip = Skip::Bytes(header.vox_offset(header.length).map_err(in_file)?);
        Segment { path: path.clone(), start: 0, lines: 0, skip }
    };
    let encoding = if header.is_pair { encoding_of(&segment.path)? } else { encoding };
    let payload = Payload {
        segments: vec![segment],
        encoding,
        scalar,
        endian: header.endian,
        // Writers pad.
        excess_is_error: false,
        hint: " (are dim, datatype and vox_offset right?)",
    };
    // Not for colours; 0 and NaN mean none.
    let scaled = channels == 1 && header.scl_slope != 0.0 && header.scl_slope.is_finite();
    let calibration = if scaled {
        let intercept = if header.scl_inter.is_finite() { header.scl_inter } else { 0.0 };
        Calibration { slope: header.scl_slope, intercept }
    } else {
        Calibration::default()
    };
    Ok(Description {
        format: header.version,
        header: path.clone(),
        source: payload.into(),
        layout,
        placement,
        placed_by: placed.by,
        calibration,
        space: Space::Ras,
        units: header.units().map(str::to_owned),
        scan: None,
        notes,
    })
}

/// The stored type and the number of values a voxel.
fn data_type(code: i16) -> Result<(ScalarType, usize), FieldError> {
    let plain = |scalar| Ok((scalar, 1));
    let refuse = |name: &str| {
        let allowed = "must be 8- to 64-bit integers or floats, RGB24 or RGBA32";
        Err(FieldError::new("datatype", format_args!("{code} ({name})"), allowed))
    };
    match code {
        2 => plain(ScalarType::U8),
        4 => plain(ScalarType::I16),
        8 => plain(ScalarType::I32),
        16 => plain(ScalarType::F32),
        64 => plain(ScalarType::F64),
        256 => plain(ScalarType::I8),
        512 => plain(ScalarType::U16),
        768 => plain(ScalarType::U32),
        1024 => plain(ScalarType::I64),
        1280 => plain(ScalarType::U64),
        128 => Ok((ScalarType::U8, 3)),
        2304 => Ok((ScalarType::U8, 4)),
        32 => refuse("complex numbers, COMPLEX64"),
        1792 => refuse("complex numbers, COMPLEX128"),
        2048 => refuse("complex numbers, COMPLEX256"),
        1536 => refuse("FLOAT128"),
        1 => refuse("single bits"),
        _ => refuse("unknown"),
    }
}

/// The first bytes of a file, decompressed, and the compression.
fn read_head(path: &Path) -> Result<(Vec<u8>, Encoding), FileError> {
    // The longer of the two headers.
    const LONGEST: u64 = 540;
    let encoding = encoding_of(path)?;
    let file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    let mut head = Vec::new();
    // What came out before the damage is judged as a short header.
    let _ = encoding.reader(BufReader::new(file)).take(LONGEST).read_to_end(&mut head);
    Ok((head, encoding))
}

fn encoding_of(path: &Path) -> Result<Encoding, FileError> {
    let mut magic = Vec::new();
    regular_file::open(path).and_then(|f| f.take(4).read_to_end(&mut magic)).map_err(|e| FileError::new(path, e))?;
    Ok(Encoding::of_file(&magic))
}

/// Returns the header file of a pair's image file (`x.img`, `x.img.gz`); any other path as it is.
fn header_of_image(path: &Path) -> PathBuf {
    sibling(path, "img", "hdr").unwrap_or_else(|| path.into())
}

/// The image file of a pair.
fn image_of_header(path: &Path) -> Result<PathBuf, FileError> {
    sibling(path, "hdr", "img").ok_or_else(|| {
        let data = PathBuf::from(path.to_string_lossy().replace(".hdr", ".img"));
        FileError::new(path, FileErrorKind::DataFile { data, source: std::io::ErrorKind::NotFound.into() })
    })
}

/// The other file of a pair, whether it is compressed or not, if there is one.
fn sibling(path: &Path, this: &str, other: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let plain = name.strip_suffix(".gz").unwrap_or(name);
    let stem = plain.strip_suffix(this)?;
    [format!("{stem}{other}"), format!("{stem}{other}.gz")]
        .into_iter()
        .map(|n| path.with_file_name(n))
        .find(|p| memory_folder::exists(p))
}
