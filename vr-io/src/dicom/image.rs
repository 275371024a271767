//! The images of one file: their size, the type of their numbers, and where each frame lies (DICOM PS3.3 2024, C.7.6).
//!
//! A frame's attributes are looked up in three places: the frame's own functional groups, those shared by all frames (enhanced objects,
//! C.7.6.16), and the data set itself (classic objects).

use std::path::PathBuf;

use glam::DVec3;

use super::elements::{Elements, PixelElement};
use super::file::DicomFile;
use super::tags::{self, Tag};
use super::transfer_syntax::{FrameCoding, TransferSyntax};
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::scalar::{Endian, ScalarType};

/// The images of one file.
#[derive(Debug)]
pub(super) struct Image {
    pub path: PathBuf,
    pub syntax: TransferSyntax,
    /// Offset of the data set in the file.
    pub start: u64,
    pub pixels: PixelElement,
    pub shape: Shape,
    pub frames: Vec<Frame>,
    pub photometric: String,
    /// Number that stands for no value.
    pub padding: Option<i64>,
    /// True if a table leads from stored numbers to values, which is not applied.
    pub has_modality_table: bool,
    /// True if the calibration gives doses.
    pub is_dose: bool,
}

/// Attributes that all images of a volume share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub rows: usize,
    pub columns: usize,
    /// Numbers a pixel: 1, or 3 for colours.
    pub samples: usize,
    /// True if each of these has a plane of its own.
    pub planar: bool,
    pub numbers: Numbers,
}

/// Type of the numbers, and the bits of them that count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Numbers {
    pub scalar: ScalarType,
    /// Unused bits below the number.
    pub shift: u32,
    /// Bits of the number.
    pub bits: u32,
    /// True if unused bits hold something else, or should repeat the sign and might not.
    pub needs_masking: bool,
}

impl Shape {
    /// Bytes of a frame; none of the factors is beyond 16 bits.
    pub fn frame_bytes(&self) -> u64 {
        self.rows as u64 * self.columns as u64 * self.samples as u64 * self.numbers.scalar.bytes() as u64
    }
}

/// One slice.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// Centre of the first pixel, in patient space (LPS).
    pub position: Option<DVec3>,
    /// Directions of growing column and of growing row.
    pub orientation: Option<[DVec3; 2]>,
    /// Distances between rows and between columns.
    pub spacing: Option<[f64; 2]>,
    /// True if that is the spacing at the detector, not in the patient.
    pub spacing_is_detectors: bool,
    pub thickness: Option<f64>,
    pub between_slices: Option<f64>,
    /// Slope and intercept.
    pub rescale: [f64; 2],
    /// Lower and upper end, in calibrated values.
    pub window: Option<[f64; 2]>,
    /// Temporal position, acquisition and instance: the order of slices at one position.
    pub order: [i64; 3],
}

impl Image {
    pub fn new(file: DicomFile) -> Result<Self, FileError> {
        let path = file.path.clone();
        Self::of(file).map_err(|e| FileError::new(&path, e))
    }

    fn of(file: DicomFile) -> Result<Self, FileErrorKind> {
        let DicomFile { path, syntax, start, length, elements, pixels } = file;
        let Some(pixels) = pixels else {
            return Err(FieldError::new(tags::PIXEL_DATA.name(), "nothing", "the object holds no image").into());
        };
        if syntax.frames == FrameCoding::Unread {
            let allowed = "must be uncompressed, deflated, RLE, JPEG (baseline, extended of 8 bits, lossless), JPEG-LS or JPEG 2000";
            return Err(FieldError::new(tags::TRANSFER_SYNTAX_UID.name(), &syntax.name, allowed).into());
        }
        if syntax.frames == FrameCoding::Jpeg2000 && !cfg!(feature = "jpeg2000") {
            return Err(FileErrorKind::Feature { format: "DICOM with frames in JPEG 2000", feature: "jpeg2000" });
        }
        let photometric = elements.text(tags::PHOTOMETRIC_INTERPRETATION).unwrap_or_default().into_owned();
        let shape = shape(&elements, &pixels)?;
        let native = syntax.frames == FrameCoding::Native;
        if native && ["YBR_FULL_422", "YBR_PARTIAL_422", "YBR_PARTIAL_420"].contains(&photometric.as_str()) {
            let allowed = "colours with fewer samples than pixels are read from JPEG alone";
            return Err(FieldError::new(tags::PHOTOMETRIC_INTERPRETATION.name(), photometric, allowed).into());
        }
        if pixels.words && native && syntax.endian() == Endian::Big && shape.numbers.scalar.bytes() == 1 {
            let allowed = "bytes in big-endian words of 16 bits are not read";
            return Err(FieldError::new(tags::BITS_ALLOCATED.name(), 8, allowed).into());
        }
        let count = frame_count(&elements)?;
        let file = Claim { syntax: &syntax, length, pixels: &pixels };
        file.check(count, shape.frame_bytes())?;
        let has_modality_table = !elements.items(tags::MODALITY_LUT_SEQUENCE).is_empty();
        let padding = elements.u16(tags::PIXEL_PADDING_VALUE)?;
        let padding = padding.map(|bits| match shape.numbers.scalar {
            ScalarType::I8 | ScalarType::I16 | ScalarType::I32 => i64::from(bits.cast_signed()),
            _ => i64::from(bits),
        });
        let is_dose = elements.has(tags::DOSE_GRID_SCALING);
        let frames = frames(&elements, count)?;
        Ok(Self { path, syntax, start, pixels, shape, frames, photometric, padding, has_modality_table, is_dose })
    }
}

fn required(elements: &Elements, tag: Tag) -> Result<u16, FieldError> {
    let allowed = "must be 1 to 65535";
    match elements.u16(tag)? {
        None => Err(FieldError::new(tag.name(), "nothing", allowed)),
        Some(0) => Err(FieldError::new(tag.name(), 0, allowed)),
        Some(n) => Ok(n),
    }
}

fn shape(elements: &Elements, pixels: &PixelElement) -> Result<Shape, FieldError> {
    let (rows, columns) = (required(elements, tags::ROWS)?, required(elements, tags::COLUMNS)?);
    let samples = elements.u16(tags::SAMPLES_PER_PIXEL)?.unwrap_or(1);
    if !(1..=4).contains(&samples) {
        return Err(FieldError::new(tags::SAMPLES_PER_PIXEL.name(), samples, "must be 1 to 4"));
    }
    let planar = elements.u16(tags::PLANAR_CONFIGURATION)?.unwrap_or(0) == 1;
    let numbers = numbers(elements, pixels.tag)?;
    Ok(Shape { rows: rows.into(), columns: columns.into(), samples: samples.into(), planar, numbers })
}

fn numbers(elements: &Elements, tag: Tag) -> Result<Numbers, FieldError> {
    let allocated = required(elements, tags::BITS_ALLOCATED)?;
    let signed = elements.u16(tags::PIXEL_REPRESENTATION)?.unwrap_or(0) == 1;
    let float = |scalar: ScalarType| Numbers { scalar, shift: 0, bits: u32::from(allocated), needs_masking: false };
    let scalar = match (tag, allocated, signed) {
        (tags::FLOAT_PIXEL_DATA, 32, _) => return Ok(float(ScalarType::F32)),
        (tags::DOUBLE_FLOAT_PIXEL_DATA, 64, _) => return Ok(float(ScalarType::F64)),
        (tags::PIXEL_DATA, 8, false) => ScalarType::U8,
        (tags::PIXEL_DATA, 8, true) => ScalarType::I8,
        (tags::PIXEL_DATA, 16, false) => ScalarType::U16,
        (tags::PIXEL_DATA, 16, true) => ScalarType::I16,
        (tags::PIXEL_DATA, 32, false) => ScalarType::U32,
        (tags::PIXEL_DATA, 32, true) => ScalarType::I32,
        (tags::PIXEL_DATA, 1, _) => {
            let allowed = "must be 8, 16 or 32: images of single bits (segmentations) are not read";
            return Err(FieldError::new(tags::BITS_ALLOCATED.name(), 1, allowed));
        }
        _ => {
            let allowed = "must be 8, 16 or 32; 32 for float pixel data, 64 for double float pixel data";
            return Err(FieldError::new(tags::BITS_ALLOCATED.name(), allocated, allowed));
        }
    };
    let bits = elements.u16(tags::BITS_STORED)?.unwrap_or(allocated);
    if !(1..=allocated).contains(&bits) {
        return Err(FieldError::new(
            tags::BITS_STORED.name(),
            bits,
            format!("must be 1 to {allocated} (BitsAllocated)"),
        ));
    }
    let high = elements.u16(tags::HIGH_BIT)?.unwrap_or(bits - 1);
    if !(bits - 1..allocated).contains(&high) {
        let allowed = format!("must be {} to {} (BitsStored, BitsAllocated)", bits - 1, allocated - 1);
        return Err(FieldError::new(tags::HIGH_BIT.name(), high, allowed));
    }
    let shift = high + 1 - bits;
    let spare = bits < allocated;
    let needs_masking = spare && (shift > 0 || signed || elements.has_overlay_in_voxels());
    Ok(Numbers { scalar, shift: shift.into(), bits: bits.into(), needs_masking })
}

fn frame_count(elements: &Elements) -> Result<usize, FieldError> {
    match elements.integer(tags::NUMBER_OF_FRAMES)? {
        None => Ok(1),
        Some(n) => usize::try_from(n)
            .ok()
            .filter(|&n| n > 0)
            .ok_or_else(|| FieldError::new(tags::NUMBER_OF_FRAMES.name(), n, "must be 1 or more")),
    }
}

/// Claim of a header on the pixel data, checked against the bytes that are there before anything is allocated.
struct Claim<'a> {
    syntax: &'a TransferSyntax,
    length: u64,
    pixels: &'a PixelElement,
}

impl Claim<'_> {
    fn check(&self, frames: usize, frame_bytes: u64) -> Result<(), FileErrorKind> {
        const HINT: &str = " (are Rows, Columns, BitsAllocated and NumberOfFrames right?)";
        if self.syntax.frames == FrameCoding::Native {
            let claimed = frame_bytes.saturating_mul(frames as u64);
            let Some(value) = self.pixels.length else {
                let allowed = "must be known, since the transfer syntax is uncompressed";
                return Err(FileErrorKind::field(format!("length of {}", self.pixels.tag.name()), "unknown", allowed));
            };
            let there = if self.syntax.deflated { u64::MAX } else { self.length.saturating_sub(self.pixels.offset) };
            let found = there.min(value.into());
            if found < claimed {
                return Err(FileErrorKind::Length { claimed, found, hint: HINT });
            }
            return Ok(());
        }
        if self.pixels.length.is_some() {
            let allowed = "must be unknown, since the transfer syntax encapsulates frames";
            return Err(FileErrorKind::field(format!("length of {}", self.pixels.tag.name()), "known", allowed));
        }
        // A fragment has at least the eight bytes that say how long it is.
        let most = self.length.saturating_sub(self.pixels.offset) / 8;
        if frames as u64 > most {
            let allowed = format!("the file has room for {most} at most");
            return Err(FileErrorKind::field(tags::NUMBER_OF_FRAMES.name(), frames, allowed));
        }
        Ok(())
    }
}

/// The functional groups that apply to a frame, and the data set behind them.
struct Groups<'a> {
    all: &'a Elements,
    shared: Option<&'a Elements>,
    own: Option<&'a Elements>,
}

impl<'a> Groups<'a> {
    /// Elements that hold the attributes of a functional group.
    fn of(&self, sequence: Tag) -> &'a Elements {
        [self.own, self.shared].into_iter().flatten().find_map(|g| g.items(sequence).first()).unwrap_or(self.all)
    }
}

fn frames(all: &Elements, count: usize) -> Result<Vec<Frame>, FieldError> {
    let shared = all.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let per_frame = all.items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE);
    if !per_frame.is_empty() && per_frame.len() != count {
        let allowed = format!("must be one for each of {count} frames");
        let found = format_args!("{} items", per_frame.len());
        return Err(FieldError::new(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE.name(), found, allowed));
    }
    let mut frames = Vec::new();
    for i in 0..count {
        frames.push(frame(&Groups { all, shared, own: per_frame.get(i) })?);
    }
    if count > 1 && per_frame.iter().all(|g| g.items(tags::PLANE_POSITION_SEQUENCE).is_empty()) {
        spread(all, &mut frames)?;
    }
    Ok(frames)
}

fn frame(groups: &Groups<'_>) -> Result<Frame, FieldError> {
    let all = groups.all;
    // Nuclear medicine keeps the place of its frames with the detector.
    let detector = all.items(tags::DETECTOR_INFORMATION_SEQUENCE).first().unwrap_or(all);
    let place = |sequence: Tag, tag: Tag, count: usize| match groups.of(sequence).numbers(tag, Some(count))? {
        None => detector.numbers(tag, Some(count)),
        some => Ok(some),
    };
    let position =
        place(tags::PLANE_POSITION_SEQUENCE, tags::IMAGE_POSITION_PATIENT, 3)?.map(|p| DVec3::from_slice(&p));
    let orientation = place(tags::PLANE_ORIENTATION_SEQUENCE, tags::IMAGE_ORIENTATION_PATIENT, 6)?;
    let orientation = orientation.map(|o| directions(&o)).transpose()?;

    let measures = groups.of(tags::PIXEL_MEASURES_SEQUENCE);
    let mut spacing = measures.numbers(tags::PIXEL_SPACING, Some(2))?;
    let spacing_is_detectors = spacing.is_none();
    if spacing_is_detectors {
        spacing = all.numbers(tags::IMAGER_PIXEL_SPACING, Some(2))?;
    }
    let spacing = spacing.map(|s| [s[0], s[1]]);
    if let Some(found) = spacing.and_then(|s| s.into_iter().find(|&x| x <= 0.0)) {
        return Err(FieldError::new(tags::PIXEL_SPACING.name(), found, "must be above 0"));
    }
    let thickness = measures.number(tags::SLICE_THICKNESS)?.filter(|&t| t > 0.0);
    let between_slices = match measures.number(tags::SPACING_BETWEEN_SLICES)? {
        None => all.number(tags::SPACING_BETWEEN_SLICES)?,
        some => some,
    };

    let values = groups.of(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE);
    let slope = match values.number(tags::RESCALE_SLOPE)? {
        None => all.number(tags::DOSE_GRID_SCALING)?,
        some => some,
    };
    if slope == Some(0.0) {
        return Err(FieldError::new(tags::RESCALE_SLOPE.name(), 0, "must not be 0"));
    }
    let rescale = [slope.unwrap_or(1.0), values.number(tags::RESCALE_INTERCEPT)?.unwrap_or(0.0)];
    let shown = groups.of(tags::FRAME_VOILUT_SEQUENCE);
    // A window is for display alone: a wrong one is left out.
    let window = match (shown.number(tags::WINDOW_CENTER), shown.number(tags::WINDOW_WIDTH)) {
        (Ok(Some(center)), Ok(Some(width))) if width > 0.0 => Some([center - width / 2.0, center + width / 2.0]),
        _ => None,
    };

    let content = groups.of(tags::FRAME_CONTENT_SEQUENCE);
    let time = match content.u32(tags::TEMPORAL_POSITION_INDEX) {
        Some(index) => i64::from(index),
        None => all.integer(tags::TEMPORAL_POSITION_IDENTIFIER)?.unwrap_or(0),
    };
    let number = |tag| Ok::<_, FieldError>(all.integer(tag)?.unwrap_or(0));
    let order = [time, number(tags::ACQUISITION_NUMBER)?, number(tags::INSTANCE_NUMBER)?];
    Ok(Frame {
        position,
        orientation,
        spacing,
        spacing_is_detectors,
        thickness,
        between_slices,
        rescale,
        window,
        order,
    })
}

/// Unit vectors of growing column and of growing row, which must be at right angles.
fn directions(o: &[f64]) -> Result<[DVec3; 2], FieldError> {
    // Files round them to four digits.
    const ROUNDED: f64 = 1e-2;
    let (row, column) = (DVec3::from_slice(&o[..3]), DVec3::from_slice(&o[3..]));
    let is_unit = |v: DVec3| (v.length() - 1.0).abs() < ROUNDED;
    if !is_unit(row) || !is_unit(column) || row.dot(column).abs() > ROUNDED {
        let found = o.iter().map(f64::to_string).collect::<Vec<_>>().join("\\");
        let allowed = "must be two unit vectors at right angles";
        return Err(FieldError::new(tags::IMAGE_ORIENTATION_PATIENT.name(), found, allowed));
    }
    Ok([row.normalize(), column.normalize()])
}

/// Puts the frames of a classic file, which has one position for all of them, one behind the other.
fn spread(all: &Elements, frames: &mut [Frame]) -> Result<(), FieldError> {
    let count = frames.len();
    let offsets = match all.numbers(tags::GRID_FRAME_OFFSET_VECTOR, None)? {
        Some(offsets) if offsets.len() == count => {
            // Relative to the position, or its third coordinate and on from there.
            let first = offsets[0];
            Some(offsets.iter().map(|z| z - first).collect())
        }
        Some(offsets) => {
            let found = format_args!("{} numbers", offsets.len());
            let allowed = format!("must be one for each of {count} frames");
            return Err(FieldError::new(tags::GRID_FRAME_OFFSET_VECTOR.name(), found, allowed));
        }
        None => frames[0].between_slices.or(frames[0].thickness).map(|s| (0..count).map(|i| i as f64 * s).collect()),
    };
    let offsets: Option<Vec<f64>> = offsets;
    for (i, frame) in frames.iter_mut().enumerate() {
        let normal = frame.orientation.map(|[row, column]| row.cross(column));
        frame.position = match (frame.position, normal, &offsets) {
            (Some(first), Some(normal), Some(offsets)) => Some(first + normal * offsets[i]),
            // A position that all frames share says nothing.
            _ => None,
        };
    }
    Ok(())
}
