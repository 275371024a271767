//! Volumes as OME-Zarr 0.5: Zarr 3 (ZEP 1), a pyramid of resolutions, chunks of 64³ packed with gzip.
//!
//! Each level is made of the one before by blocks of 2×2×2 voxels, and is all of a level that is held in memory beside the volume.
//!
//! The format knows a scale and a translation along each axis, and no rotation: axes that run along those of the world, in whatever
//! order and direction, keep their places, others do not.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use flate2::{Compression, write::GzEncoder};
use glam::DVec3;
use serde_json::{Value, json};
use vr_core::{GridVolume, Placement, parallel};

use crate::edit::{Reduction, flip_grid, halve_grid};
use crate::error::WriteError;
use crate::length_unit::{LengthUnit, MILLIMETRE};
use crate::scalar::ScalarType;

use super::levels::Level;
use super::numbers::Numbers;
use super::{Job, folder, refused, shape};

/// Voxels along each axis of a chunk.
const CHUNK: usize = 64;
const NAMES: [&str; 3] = ["x", "y", "z"];

pub(super) fn write(job: &mut Job<'_>) -> Result<ScalarType, WriteError> {
    folder::check_vacant(job.path, "a Zarr is a folder of its own: remove it, or choose another name")?;
    let levels = job.options.levels.of(job.grid.dims(), job.path)?;
    let numbers = job.values("OME-Zarr");
    let (scalar, placement) = (numbers.scalar(), *job.grid.placement());
    let along = world_axes(&placement);
    if along.is_none() {
        job.notes.push(
            "OME-Zarr holds no rotation: spacing and the first voxel's place are kept, the directions of the axes are lost"
                .to_owned(),
        );
    } else if job.options.patient {
        job.notes.push("OME-Zarr knows no patients: positions are written as they are, in RAS".to_owned());
    }
    // Scales are positive: axes that run backwards are reversed, voxels and all.
    let mut grid = None;
    for (axis, _) in along.iter().flatten().enumerate().filter(|(_, (_, is_backward))| *is_backward) {
        let reversed = flip_grid(grid.as_ref().unwrap_or(job.grid), axis);
        grid = Some(reversed.map_err(|e| refused(job.path, e.to_string()))?);
    }
    let grid = grid.as_ref().unwrap_or(job.grid);
    let names = along.map_or([0, 1, 2], |along| along.map(|(world, _)| world)).map(|world| NAMES[world]);

    let failed = |source: io::Error| WriteError::Io { path: job.path.into(), source };
    let (temporary, _under_way) = folder::beside(job.path).map_err(failed)?;
    let reduction = job.options.levels.reduction;
    let group = group(grid.placement(), &levels, reduction, names, unit(job));
    write_json(&temporary.path().join("zarr.json"), &group).map_err(failed)?;
    let mut coarse = None;
    for number in 0..levels.len() {
        if number > 0 {
            let finer = coarse.as_ref().unwrap_or(grid);
            coarse = Some(halve_grid(finer, reduction).map_err(|e| refused(job.path, e.to_string()))?);
        }
        let array = temporary.path().join(number.to_string());
        write_array(&array, coarse.as_ref().unwrap_or(grid), scalar, names).map_err(failed)?;
    }
    folder::rename(temporary, job.path).map_err(failed)?;
    if let [_, .., Level { dims: [x, y, z], .. }] = levels[..] {
        let (count, how) = (levels.len(), reduction.name());
        job.notes.push(format!("{count} resolutions are written, down to {x}×{y}×{z} by the {how} of blocks of 2×2×2"));
    }
    Ok(scalar)
}

/// The axis of the world that each index axis runs along, and true if it runs backwards; `None` where one runs along none.
fn world_axes(placement: &Placement) -> Option<[(usize, bool); 3]> {
    /// Error of a direction of 32 bits that a few programs have passed on.
    const MAX_SINE: f64 = 1e-5;
    let directions = shape::directions(placement);
    let mut along = [(0, false); 3];
    for (axis, along) in along.iter_mut().enumerate() {
        let direction = directions.col(axis);
        let world = direction.abs().max_position();
        let mut aside = direction;
        aside[world] = 0.0;
        if aside.length() > MAX_SINE {
            return None;
        }
        *along = (world, direction[world] < 0.0);
    }
    Some(along)
}

/// Name of the unit of lengths, as UDUNITS-2 has it.
fn unit(job: &Job<'_>) -> Option<&'static str> {
    let named = job.options.units.as_deref().and_then(LengthUnit::from_name);
    let unit = named.or(job.options.patient.then_some(MILLIMETRE))?;
    Some(match unit.symbol {
        "pm" => "picometer",
        "Å" => "angstrom",
        "nm" => "nanometer",
        "µm" => "micrometer",
        "mm" => "millimeter",
        "cm" => "centimeter",
        "m" => "meter",
        "km" => "kilometer",
        _ => "inch",
    })
}

/// Writes one resolution.
fn write_array(array: &Path, grid: &GridVolume, scalar: ScalarType, names: [&str; 3]) -> io::Result<()> {
    let numbers = Numbers::values(grid).with_scalar(scalar);
    fs::create_dir(array)?;
    write_json(&array.join("zarr.json"), &described(grid.dims(), scalar, names))?;
    let counts = grid.dims().map(|n| n.div_ceil(CHUNK));
    parallel::try_collect(counts.iter().product(), |i| {
        let at = [i % counts[0], i / counts[0] % counts[1], i / counts[0] / counts[1]];
        let bytes = chunk(grid.dims(), &numbers, at)?;
        // What is not there counts as the fill value.
        if bytes.iter().all(|&b| b == 0) {
            return Ok(());
        }
        let place = array.join("c").join(at[2].to_string()).join(at[1].to_string());
        fs::create_dir_all(&place)?;
        let mut packed = GzEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&bytes)?;
        fs::write(place.join(at[0].to_string()), packed.finish()?)
    })?;
    Ok(())
}

fn write_json(path: &Path, value: &Value) -> io::Result<()> {
    fs::write(path, serde_json::to_string_pretty(value)? + "\n")
}

/// The group: one image and its resolutions. Lists run from the slowest axis to the fastest.
fn group(placement: &Placement, levels: &[Level], reduction: Reduction, names: [&str; 3], unit: Option<&str>) -> Value {
    let axis = |name: &str| match unit {
        Some(unit) => json!({"name": name, "type": "space", "unit": unit}),
        None => json!({"name": name, "type": "space"}),
    };
    let world = |name: &str| NAMES.iter().position(|n| *n == name).unwrap_or_default();
    let origin = names.map(|name| placement.origin()[world(name)]);
    let slowest_first = |v: [f64; 3]| json!([v[2] + 0.0, v[1] + 0.0, v[0] + 0.0]);
    let spacing: DVec3 = placement.spacing();
    let dataset = |(number, level): (usize, &Level)| {
        let placed = [0, 1, 2].map(|axis| level.placed(axis, spacing[axis], origin[axis]));
        json!({
            "path": number.to_string(),
            "coordinateTransformations": [
                {"type": "scale", "scale": slowest_first(placed.map(|(scale, _)| scale))},
                {"type": "translation", "translation": slowest_first(placed.map(|(_, first)| first))},
            ],
        })
    };
    let mut image = json!({
        "axes": names.iter().rev().map(|name| axis(name)).collect::<Vec<_>>(),
        "datasets": levels.iter().enumerate().map(dataset).collect::<Vec<_>>(),
    });
    if levels.len() > 1 {
        image["type"] = json!(reduction.name());
    }
    json!({
        "zarr_format": 3,
        "node_type": "group",
        "attributes": {"ome": {"version": "0.5", "multiscales": [image]}},
    })
}

/// The array.
fn described(dims: [usize; 3], scalar: ScalarType, names: [&str; 3]) -> Value {
    let slowest_first = |v: [usize; 3]| json!([v[2], v[1], v[0]]);
    let name = match scalar {
        ScalarType::U8 => "uint8",
        ScalarType::I8 => "int8",
        ScalarType::U16 => "uint16",
        ScalarType::I16 => "int16",
        ScalarType::F32 => "float32",
        _ => "float64",
    };
    let fill = if matches!(scalar, ScalarType::F32 | ScalarType::F64) { json!(0.0) } else { json!(0) };
    json!({
        "zarr_format": 3,
        "node_type": "array",
        "shape": slowest_first(dims),
        "data_type": name,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [CHUNK, CHUNK, CHUNK]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
        "fill_value": fill,
        "codecs": [
            {"name": "bytes", "configuration": {"endian": "little"}},
            {"name": "gzip", "configuration": {"level": 6}},
        ],
        "dimension_names": names.iter().rev().collect::<Vec<_>>(),
    })
}

/// Bytes of a chunk, with zeros beyond the edges of the volume.
fn chunk(dims: [usize; 3], numbers: &Numbers<'_>, at: [usize; 3]) -> io::Result<Vec<u8>> {
    let size = numbers.scalar().bytes();
    let first = at.map(|n| n * CHUNK);
    let count = [0, 1, 2].map(|a| CHUNK.min(dims[a] - first[a]));
    let mut out = Vec::with_capacity(CHUNK * CHUNK * CHUNK * size);
    for z in 0..count[2] {
        for y in 0..count[1] {
            let row = ((first[2] + z) * dims[1] + first[1] + y) * dims[0] + first[0];
            out.resize((z * CHUNK + y) * CHUNK * size, 0);
            numbers.write_part(row..row + count[0], &mut out)?;
        }
    }
    out.resize(CHUNK * CHUNK * CHUNK * size, 0);
    Ok(out)
}
