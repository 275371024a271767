//! The mesh of a file.

use std::path::Path;
use std::sync::Arc;

use vr_core::Volume;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};

use crate::chosen::Chosen;
use crate::error::{FieldError, FileError};
use crate::narrow::Narrowed;
use crate::read::{Loaded, ReadOptions};

use super::align::align;
use super::amr_file::{AmrFile, count_of};

/// Reads the blocks of one array.
///
/// # Errors
/// A choice that the file does not have; blocks that are not whole, or make no mesh.
pub(super) fn load(file: &dyn AmrFile, path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let (facts, hierarchy) = (file.facts(), file.hierarchy());
    facts.check_frame(options.frame).map_err(in_file)?;
    let mut notes = file.notes();
    let options = &options.with_point_value();
    let chosen = Chosen::of_arrays(file.arrays(), options, &mut notes).map_err(in_file)?;
    let (mut blocks, mut narrowed) = (Vec::new(), Narrowed::default());
    for (number, block) in hierarchy.boxes.iter().enumerate() {
        let dims = block.dims(chosen.of_cells);
        let many = || in_file(FieldError::new(format!("block {number}"), format!("{dims:?}"), "must have fewer cells"));
        let count = count_of(dims, 1).ok_or_else(many)?;
        let numbers = file.numbers(number, chosen.array.unwrap_or_default())?;
        let values = narrowed.take(&chosen.values(numbers, count).map_err(in_file)?);
        blocks.push(AmrBlock { level: block.level, first: block.first, dims, values });
    }
    notes.extend(narrowed.notes());
    if chosen.of_cells {
        let (whole, aligned) = align(blocks, &hierarchy.ratios);
        blocks = whole;
        if aligned.grown > 0 {
            let coarser = aligned.from_coarser;
            let from = if coarser > 0 { format!(", {coarser} of the values from these") } else { String::new() };
            notes.push(format!("{} blocks end within coarser cells, and are grown to whole ones{from}", aligned.grown));
        }
    }
    let centring = if chosen.of_cells { AmrCentring::Cells } else { AmrCentring::Points };
    let grid = AmrGrid::new(hierarchy.origin, hierarchy.spacing, hierarchy.ratios.clone(), blocks, centring)
        .map_err(|e| FileError::new(path, e))?;
    let repeated = grid.repeated_values();
    if repeated > 0 {
        notes.push(format!("{repeated} values belong to two blocks of a level, which agree on them"));
    }
    let columns = file.arrays().iter().map(|array| array.name.clone()).collect();
    let info = facts.into_info(hierarchy.placed_by, chosen.components, columns);
    Ok(Loaded { volume: Volume::Amr(Arc::new(grid)), info, notes })
}
