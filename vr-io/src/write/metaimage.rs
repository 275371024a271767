//! Volumes as MetaImage files, with the fields that ITK writes: <https://itk.org/Wiki/ITK/MetaIO/Documentation>.

use std::io;
use std::path::{Path, PathBuf};

use glam::DVec3;
use vr_core::Placement;

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::scalar::ScalarType;
use crate::world::{Space, orientation};

use super::shape::{directions, is_upright, vector, words};
use super::{Job, refused};

/// The file of the voxels beside a header.
pub(super) fn data_file(header: &Path) -> Result<PathBuf, WriteError> {
    let data = header.with_extension("raw");
    let name = data.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // A reader takes a percent sign for a pattern.
    if name.contains('%') {
        return Err(refused(header, "a header names no file with a percent sign; name it otherwise, or .mha"));
    }
    Ok(data)
}

pub(super) fn write(job: &mut Job<'_>, data: Option<&Path>) -> Result<ScalarType, WriteError> {
    let numbers = job.values("MetaImage");
    let name = data.map_or("LOCAL".into(), |data| data.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let header = header(job, numbers.scalar(), &name);
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        move |source: io::Error| WriteError::Io { path, source }
    };
    write_whole(job.path, |mut out| {
        out.write_all(header.as_bytes()).map_err(failed(job.path))?;
        // The header takes its place last: without the voxels there is none.
        match data {
            Some(data) => write_whole(data, |mut out| numbers.write(&mut out).map_err(failed(data))),
            None => numbers.write(&mut out).map_err(failed(job.path)),
        }
    })?;
    Ok(numbers.scalar())
}

fn header(job: &mut Job<'_>, scalar: ScalarType, data: &str) -> String {
    let element_type = match scalar {
        ScalarType::U8 => "MET_UCHAR",
        ScalarType::I8 => "MET_CHAR",
        ScalarType::U16 => "MET_USHORT",
        ScalarType::I16 => "MET_SHORT",
        ScalarType::F32 => "MET_FLOAT",
        _ => "MET_DOUBLE",
    };
    let placement = job.grid.placement();
    let [nx, ny, nz] = job.grid.dims();
    let mut text = String::from(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n",
    );
    // A frame of its own that spacing describes needs no transform, and is no patient's without one.
    let spacing_alone = is_upright(placement) && placement.origin() == DVec3::ZERO;
    if job.options.patient || !spacing_alone {
        text += &transform(placement);
        if job.options.patient {
            text += &format!("AnatomicalOrientation = {}\n", origins(placement));
        } else {
            let note =
                "MetaImage places patients alone: the file's own frame is written as RAS, turned to the format's LPS";
            job.notes.push(note.into());
        }
    }
    let spacing = vector(placement.spacing());
    text + &format!(
        "ElementSpacing = {spacing}\nDimSize = {nx} {ny} {nz}\nElementType = {element_type}\nElementDataFile = {data}\n"
    )
}

/// The transform, in LPS: a row for each index axis.
fn transform(placement: &Placement) -> String {
    let turn = Space::Lps.to_ras();
    let d = directions(placement);
    let matrix = [d.x_axis, d.y_axis, d.z_axis].map(|axis| (turn * axis).to_array());
    let offset = vector(turn * placement.origin());
    format!("TransformMatrix = {}\nOffset = {offset}\nCenterOfRotation = 0 0 0\n", words(matrix.into_iter().flatten()))
}

/// Letters of where each axis comes from.
fn origins(placement: &Placement) -> String {
    let opposite = |towards| match towards {
        'R' => 'L',
        'L' => 'R',
        'A' => 'P',
        'P' => 'A',
        'S' => 'I',
        _ => 'S',
    };
    orientation(placement).chars().map(opposite).collect()
}
