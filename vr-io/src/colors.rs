//! Voxels that are colours: all components of a file, of which a coloured grid is made.

use std::path::Path;

use vr_core::{Calibration, ColorGrid, ColorValue, GridError, Placement, memory, number_text};

use crate::error::FileError;
use crate::layout::Layout;
use crate::read::{ReadOptions, component};
use crate::source::Source;
use crate::voxels::Voxels;

/// Components of all voxels, those of a voxel together.
enum Components {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// Reads all components of a described file, and notes on what was made of them.
pub(crate) fn load(
    path: &Path,
    source: Source,
    layout: &Layout,
    placement: Placement,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<ColorGrid, FileError> {
    let count = layout.components;
    // The components, as they come and side by side, and then four channels and a value a voxel.
    let numbers_of_voxel = 2 * count as u64 + 5;
    let bytes = (layout.count() as u64).saturating_mul(numbers_of_voxel * source.scalar().bytes() as u64);
    memory::check("the volume", bytes).map_err(|e| FileError::new(path, e))?;
    let components = match layout.interleaved() {
        Some(rows) => numbers(source.load(path, &rows, options, notes)?),
        None => one_by_one(path, source, layout, options, notes)?,
    };
    let grid = match components {
        Components::U8(all) => ColorGrid::from_components(layout.dims, &all, count, placement),
        Components::U16(all) => ColorGrid::from_components(layout.dims, &all, count, placement),
        Components::F32(mut all) => {
            into_unit_range(&mut all, notes);
            ColorGrid::from_components(layout.dims, &all, count, placement)
        }
    };
    let grid = grid.map_err(|e: GridError| FileError::new(path, e))?;
    let kind = if count == 4 { "RGBA" } else { "RGB" };
    let source = grid.value_source();
    let unused = if count == 4 && source != ColorValue::Opacity { ", for all opacities are equal" } else { "" };
    notes.push(format!("voxels are {kind} and are drawn in their colours; the value is {}{unused}", source.name()));
    Ok(grid)
}

/// Numbers of any type as components.
fn numbers(voxels: Voxels) -> Components {
    match voxels {
        Voxels::U8(all) => Components::U8(all.as_ref().to_vec()),
        Voxels::U16(all) => Components::U16(all.as_ref().to_vec()),
        Voxels::F32(all) => Components::F32(all.as_ref().to_vec()),
        // Wider floats, stored as distances from one of them.
        Voxels::Framed(all, frame) => {
            let map = frame.calibration(Calibration::default()).unwrap_or_default();
            Components::F32(all.into_iter().map(|stored| map.value(f64::from(stored)) as f32).collect())
        }
        // No format here has colours of these types.
        Voxels::I8(all) => Components::F32(all.as_ref().iter().map(|&c| f32::from(c)).collect()),
        Voxels::I16(all) => Components::F32(all.as_ref().iter().map(|&c| f32::from(c)).collect()),
    }
}

/// Reads a file once for each component: where all numbers of one come before those of the next, or a decoder gives one at a time.
fn one_by_one(
    path: &Path,
    first: Source,
    layout: &Layout,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Components, FileError> {
    let count = layout.components;
    let mut parts = vec![numbers(first.load(path, layout, options, notes)?)];
    for k in 1..count {
        // What is worth a note was noted with the first.
        if let Some((source, layout)) = component(path, k, options)? {
            parts.push(numbers(source.load(path, &layout, options, &mut Vec::new())?));
        }
    }
    fn together<T: Copy>(parts: &[&Vec<T>]) -> Vec<T> {
        let voxels = parts.iter().map(|part| part.len()).min().unwrap_or(0);
        (0..voxels).flat_map(|i| parts.iter().map(move |part| part[i])).collect()
    }
    // One type for all: a file has one.
    let bytes: Vec<_> = parts.iter().filter_map(|p| if let Components::U8(c) = p { Some(c) } else { None }).collect();
    let words: Vec<_> = parts.iter().filter_map(|p| if let Components::U16(c) = p { Some(c) } else { None }).collect();
    let floats: Vec<_> = parts.iter().filter_map(|p| if let Components::F32(c) = p { Some(c) } else { None }).collect();
    Ok(if bytes.len() == count {
        Components::U8(together(&bytes))
    } else if words.len() == count {
        Components::U16(together(&words))
    } else {
        Components::F32(together(&floats))
    })
}

/// Divides floats by the largest, where that is beyond 1: full light is 1.
fn into_unit_range(components: &mut [f32], notes: &mut Vec<String>) {
    let largest = components.iter().copied().filter(|c| c.is_finite()).fold(0.0, f32::max);
    if largest > 1.0 {
        components.iter_mut().for_each(|c| *c /= largest);
        notes.push(format!("components up to {} are divided by that: full light is 1", number_text(largest.into())));
    }
}
