//! CSV file with all rows of the table.

use std::path::Path;
use vr_study::ray::{RayAccount, Row};

use super::tables::front;
use crate::failure::Failure;

/// Writes one row per step of the renderer or, if it cannot tell, per part of the reference; whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, account: &RayAccount<'_>) -> Result<(), Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::failed(format!("{}: cannot be written: {e}", path.display()));
    let mut text = csv::Writer::from_writer(Vec::new());
    let filled = if account.probe.is_some() { steps(&mut text, account) } else { parts(&mut text, account) };
    filled.map_err(|e| failed(&e))?;
    let text = text.into_inner().map_err(|e| failed(&e))?;
    vr_io::write_bytes(path, &text).map_err(Failure::failed)
}

type Text = csv::Writer<Vec<u8>>;

const STEP: [&str; 12] = [
    "step", "begin", "length", "sample", "index_x", "index_y", "index_z", "value", "values", "kappa", "faces", "knots",
];
const STEP_LIGHT: [&str; 20] = [
    "color_r",
    "color_g",
    "color_b",
    "theta",
    "light_r",
    "light_g",
    "light_b",
    "radiance_r",
    "radiance_g",
    "radiance_b",
    "opacity",
    "tau",
    "exact_r",
    "exact_g",
    "exact_b",
    "exact_opacity",
    "exact_tau",
    "error",
    "change",
    "meets_vacuum",
];

fn steps(text: &mut Text, account: &RayAccount<'_>) -> csv::Result<()> {
    let light = account.has_light();
    text.write_record(STEP.iter().chain(STEP_LIGHT.iter().filter(|_| light)))?;
    for row in &account.rows {
        text.write_record(step(row))?;
    }
    Ok(())
}

fn step(row: &Row) -> Vec<String> {
    let samples = &row.step.samples;
    let middle = &samples[samples.len() / 2];
    let mut cells = vec![row.number.to_string()];
    cells.extend([row.step.begin, row.step.length, middle.at].map(number));
    cells.extend(middle.index.map(number));
    cells.push(number(middle.value));
    cells.push(several(samples.iter().map(|s| s.value)));
    cells.push(number(row.extinction[samples.len() / 2]));
    cells.push(
        row.faces
            .iter()
            .map(|&(axis, at)| format!("{}{at}", ["x", "y", "z"][axis.min(2)]))
            .collect::<Vec<_>>()
            .join(" "),
    );
    cells.push(several(row.knots.iter().copied()));
    if let Some(l) = row.light {
        cells.extend(l.color.map(number));
        cells.push(number(row.step.transparency));
        cells.extend(row.step.light.map(number));
        cells.extend(l.running.map(number));
        cells.push(number(l.depth));
        cells.extend(l.exact.map(number));
        cells.extend([l.exact_depth, l.error, l.change].map(number));
        cells.push(row.meets_vacuum.to_string());
    }
    cells
}

const PART: [&str; 6] = ["part", "from", "to", "front", "value_from", "value_to"];
const PART_LIGHT: [&str; 9] =
    ["theta", "light_r", "light_g", "light_b", "radiance_r", "radiance_g", "radiance_b", "tau", "certainty"];

fn parts(text: &mut Text, account: &RayAccount<'_>) -> csv::Result<()> {
    text.write_record(PART.iter().chain(PART_LIGHT.iter().filter(|_| account.has_light())))?;
    for (i, part) in account.segments.iter().enumerate() {
        let mut cells = vec![i.to_string(), number(part.from), number(part.to), front(part)];
        cells.extend(part.values.map(number));
        if let Some(l) = part.light {
            cells.push(number(l.transparency));
            cells.extend(l.light.map(number));
            cells.extend(l.radiance.map(number));
            cells.extend([l.depth, l.running.value()].map(number));
        }
        text.write_record(cells)?;
    }
    Ok(())
}

/// Formats a number by the shortest digits that give it back; NaN is empty.
fn number(x: f64) -> String {
    if x.is_nan() { String::new() } else { format!("{x:?}") }
}

fn several(values: impl Iterator<Item = f64>) -> String {
    values.map(number).collect::<Vec<_>>().join(" ")
}
