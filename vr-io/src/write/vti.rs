//! Volumes as ImageData of VTK (.vti), with appended raw numbers.

use std::io;

use glam::DMat3;

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::scalar::ScalarType;

use super::shape::{directions, shear, vector, words};
use super::{Job, refused};

pub(super) fn write(job: &mut Job<'_>) -> Result<ScalarType, WriteError> {
    let placement = job.grid.placement();
    if let Some(cosine) = shear(placement) {
        let message = format!(
            "the index axes are not perpendicular (cosine {cosine:.2e}): VTK's Direction is a rotation; .nrrd, .nii and .mha hold sheared volumes"
        );
        return Err(refused(job.path, message));
    }
    let numbers = job.values("ImageData");
    if job.options.patient {
        job.notes.push("VTK knows no patients: positions are written as they are, in RAS".into());
    }
    let type_name = match numbers.scalar() {
        ScalarType::U8 => "UInt8",
        ScalarType::I8 => "Int8",
        ScalarType::U16 => "UInt16",
        ScalarType::I16 => "Int16",
        ScalarType::F32 => "Float32",
        _ => "Float64",
    };
    let extent = job.grid.dims().map(|n| format!("0 {}", n - 1)).join(" ");
    let directions = directions(placement);
    // Row by row; older versions of VTK know no other than the identity.
    let rows = words(directions.transpose().to_cols_array());
    let direction = if directions == DMat3::IDENTITY { String::new() } else { format!(" Direction=\"{rows}\"") };
    let mut header = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\"{direction}>\n\
         <Piece Extent=\"{extent}\">\n<PointData Scalars=\"values\">\n\
         <DataArray type=\"{type_name}\" Name=\"values\" format=\"appended\" offset=\"0\"/>\n\
         </PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n",
        vector(placement.origin()),
        vector(placement.spacing()),
    );
    // Numbers at a multiple of eight bytes can be mapped into memory.
    while (header.len() + 1) % 8 != 0 {
        header.push(' ');
    }
    header.push('_');
    let failed = |source: io::Error| WriteError::Io { path: job.path.into(), source };
    write_whole(job.path, |mut out| {
        out.write_all(header.as_bytes())
            .and_then(|()| out.write_all(&numbers.bytes().to_le_bytes()))
            .and_then(|()| numbers.write(&mut out))
            .and_then(|()| out.write_all(b"\n</AppendedData>\n</VTKFile>\n"))
            .map_err(failed)
    })?;
    Ok(numbers.scalar())
}
