//! Readers, and what must hold of what they give.

use std::fmt::Display;
use std::path::Path;

use vr_core::{OpacityRule, TransferFunction};
use vr_io::{Encode, PointOptions, ReadOptions, TransferFile};

/// A message is one line, whatever the file says.
fn one_line(message: &impl Display) -> Result<(), String> {
    let message = message.to_string();
    if message.contains(['\n', '\r']) { Err(format!("two lines: {message:?}")) } else { Ok(()) }
}

fn finite((low, high): (glam::DVec3, glam::DVec3)) -> Result<(), String> {
    if low.is_finite() && high.is_finite() { Ok(()) } else { Err(format!("bounds {low} to {high}")) }
}

pub(crate) fn volume(path: &Path) -> Result<(), String> {
    match vr_io::read(path, &ReadOptions::default()) {
        Ok(loaded) => {
            loaded.notes.iter().try_for_each(one_line)?;
            finite(loaded.volume.bounds())
        }
        Err(e) => one_line(&e),
    }
}

pub(crate) fn points(path: &Path) -> Result<(), String> {
    match vr_io::read_points(path, &PointOptions::default()) {
        Ok(loaded) => {
            loaded.notes.iter().try_for_each(one_line)?;
            finite(loaded.points.bounds())
        }
        Err(e) => one_line(&e),
    }
}

pub(crate) fn mesh(path: &Path) -> Result<(), String> {
    match vr_io::read_mesh(path) {
        Ok(loaded) => finite(loaded.mesh.bounds()),
        Err(e) => one_line(&e),
    }
}

pub(crate) fn transfer(path: &Path) -> Result<(), String> {
    match vr_io::read_transfer(path) {
        // Points that are read make a transfer function.
        Ok(TransferFile { points, notes, .. }) => {
            notes.iter().try_for_each(one_line)?;
            TransferFunction::new(points, OpacityRule::Power, 1.0).map(drop).or_else(|e| one_line(&e))
        }
        Err(e) => one_line(&e),
    }
}

pub(crate) fn color_maps(path: &Path) -> Result<(), String> {
    match vr_io::read_color_maps(path) {
        Ok(maps) => maps.iter().try_for_each(|map| {
            let points = map.over((-1.0, 1.0));
            TransferFunction::new(points, OpacityRule::Power, 1.0).map(drop).map_err(|e| e.to_string())
        }),
        Err(e) => one_line(&e),
    }
}

pub(crate) fn labels(path: &Path) -> Result<(), String> {
    vr_io::read_label_list(path).map(drop).or_else(|e| one_line(&e))
}

pub(crate) fn scene(path: &Path) -> Result<(), String> {
    vr_io::load_scene(path).map(drop).or_else(|e| one_line(&e))
}

pub(crate) fn keys(path: &Path) -> Result<(), String> {
    vr_io::read_keys(path).map(drop).or_else(|e| one_line(&e))
}

pub(crate) fn picture(path: &Path) -> Result<(), String> {
    vr_io::read_picture(path, Encode::Srgb).map(drop).or_else(|e| one_line(&e))
}

pub(crate) fn record(path: &Path) -> Result<(), String> {
    vr_io::read_record(path).map(drop).or_else(|e| one_line(&e))
}
