//! DICOM: a folder of slices, one file of a series with its siblings, or a file of many frames (PS3, edition 2024;
//! <https://www.dicomstandard.org/current>).
//!
//! Slices are sorted along their normal by ImagePositionPatient, never by file name, and the distance between them comes from their positions,
//! never from SliceThickness. Patient space is left, posterior, superior, turned to RAS. Nothing that tells who the patient is (name, number,
//! dates, institution) is kept, noted or put into a message.

mod coded_frame;
#[cfg(test)]
mod coded_samples;
mod element_header;
mod elements;
mod encapsulated;
mod file;
mod image;
mod jpeg;
#[cfg(feature = "jpeg2000")]
mod jpeg_2000;
mod jpeg_ls;
mod pixels;
mod rle;
#[cfg(test)]
mod sample;
mod series;
mod stack;
mod tags;
#[cfg(test)]
mod tests;
mod transfer_syntax;

use std::path::Path;

use crate::error::{FieldError, FileError};
use crate::layout::{Axis, Layout, Role};
use crate::memory_folder;
use crate::notes::Notes;
use crate::read::{Description, ReadOptions, Scan};

use file::DicomFile;
use image::{Image, Shape};
use pixels::SliceId;
use stack::Stack;
use transfer_syntax::FrameCoding;

/// Describes the volume of the headers.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let mut notes = Notes::default();
    let files = files(path, options, &mut notes)?;
    let header = files[0].path.clone();
    let modality = series::modality(&files[0].elements);
    let images: Vec<Image> = files.into_iter().map(Image::new).collect::<Result<_, _>>()?;
    one_shape(path, &images)?;
    note_values(&images, &mut notes);

    let ids: Vec<SliceId> = images
        .iter()
        .enumerate()
        .flat_map(|(image, i)| (0..i.frames.len()).map(move |frame| SliceId { image, frame }))
        .collect();
    let frames: Vec<_> = ids.iter().map(|s| &images[s.image].frames[s.frame]).collect();
    let stack = Stack::new(&frames, images.len() > 1, &mut notes).map_err(|e| FileError::new(path, e))?;
    let slices: Vec<SliceId> = stack.order.iter().map(|&i| ids[i]).collect();
    let middle = slices[stack.slices / 2];
    let window = images[middle.image].frames[middle.frame].window;

    let layout = Layout::new(path, &axes(&images[0], &stack), options)?;
    let (source, calibration) = pixels::source(images, &slices, &mut notes);
    Ok(Description {
        format: "DICOM",
        header,
        source,
        layout,
        placement: stack.placement,
        placed_by: stack.placed_by,
        calibration,
        space: stack.space,
        units: stack.has_spacing.then(|| "mm".to_owned()),
        scan: Some(Scan { modality, window }),
        notes,
    })
}

/// The files of the series that a path names.
fn files(path: &Path, options: &ReadOptions, notes: &mut Vec<String>) -> Result<Vec<DicomFile>, FileError> {
    let choice = options.series.as_deref();
    if memory_folder::is_folder(path) {
        let files = series::images_of_folder(path, notes)?;
        let files = series::choose(path, files, choice, notes)?;
        return Ok(series::without_strays(files, notes));
    }
    let named = DicomFile::open(path)?;
    let frames = named.elements.integer(tags::NUMBER_OF_FRAMES).map_err(|e| e.in_file(path))?;
    let uid = series::uid(&named.elements);
    let named = series::choose(path, vec![named], choice, notes)?;
    // A file of many frames is a volume, and a file that belongs to no series has no siblings.
    if frames.is_some_and(|n| n != 1) || uid.is_empty() {
        return Ok(named);
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Other files there are not noted.
    let mut files = series::images_of_folder(folder, &mut Vec::new())?;
    files.retain(|f| series::uid(&f.elements) == uid);
    if files.len() < 2 {
        return Ok(named);
    }
    notes.push(format!("one file of a series is named: all {} of its files in the folder are taken", files.len()));
    Ok(series::without_strays(files, notes))
}

/// Refuses series of which the images differ in size or type.
fn one_shape(path: &Path, images: &[Image]) -> Result<(), FileError> {
    let key = |i: &Image| {
        let Shape { rows, columns, samples, planar, numbers } = i.shape;
        (rows, columns, samples, planar, numbers.scalar, numbers.bits, numbers.shift)
    };
    let first = key(&images[0]);
    let Some(other) = images.iter().find(|i| key(i) != first) else { return Ok(()) };
    let words = |i: &Image| {
        let Shape { rows, columns, samples, numbers, .. } = i.shape;
        let count = images.iter().filter(|j| key(j) == key(i)).count();
        format!("{columns}x{rows} of {samples} {} ({} bits) in {count} files", numbers.scalar, numbers.bits)
    };
    let allowed = format!("must be one size and type in all files of the series; others are {}", words(other));
    Err(FieldError::new("size and type", words(&images[0]), allowed).in_file(path))
}

/// Notes on what stored numbers stand for.
fn note_values(images: &[Image], notes: &mut Vec<String>) {
    let first = &images[0];
    match first.photometric.as_str() {
        "MONOCHROME1" => {
            notes.push("MONOCHROME1: large values are shown dark elsewhere; values are kept as they are".into())
        }
        "PALETTE COLOR" => notes.push("PALETTE COLOR: values are indices of a palette, which is left out".into()),
        "YBR_FULL" if first.syntax.frames != FrameCoding::Jpeg => {
            notes.push("YBR_FULL: components are luma, blue and red difference".into());
        }
        _ => {}
    }
    if let Some(padding) = first.padding {
        let place = tags::PIXEL_PADDING_VALUE.name();
        notes.push(format!(
            "{place} is {padding}: voxels with that stored number hold no value, and are kept as they are"
        ));
    }
    if images.iter().any(|i| i.has_modality_table) {
        notes.push(
            "ModalityLUTSequence, a table from stored numbers to values, is left out: values are the stored numbers"
                .into(),
        );
    }
    if images.iter().any(|i| i.is_dose) {
        notes.push("values are doses: stored numbers times DoseGridScaling".into());
    }
}

fn axes(image: &Image, stack: &Stack) -> Vec<Axis> {
    let axis = |size, role| Axis { size, role };
    let Shape { rows, columns, samples, planar, .. } = image.shape;
    // JPEG of other colours is decoded to RGB, and JPEG 2000 where the code itself transformed them.
    let transformed = ["YBR_RCT", "YBR_ICT"].contains(&image.photometric.as_str());
    let is_rgb = match image.syntax.frames {
        FrameCoding::Jpeg => true,
        FrameCoding::Jpeg2000 if transformed => true,
        _ => image.photometric == "RGB",
    };
    let is_color = samples == 3 && is_rgb;
    let components = axis(samples, if is_color { Role::Color } else { Role::Component });
    let (x, y) = (axis(columns, Role::Space), axis(rows, Role::Space));
    let (z, t) = (axis(stack.slices, Role::Space), axis(stack.times, Role::Frame));
    // Decoders put the numbers of a pixel together.
    if planar && image.syntax.frames == FrameCoding::Native {
        vec![x, y, components, z, t]
    } else {
        vec![components, x, y, z, t]
    }
}
