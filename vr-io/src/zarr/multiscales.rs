//! `multiscales` of OME-Zarr: one image at several resolutions, its axes, and where the voxels lie.
//!
//! Version 0.4 has it in `.zattrs`, 0.5 under `ome` in `zarr.json`. Before 0.4 there were no transformations, before 0.3 no names of axes,
//! which were t, c, z, y, x then.

use serde_json::Value;

use crate::error::FieldError;
use crate::layout::Role;

use super::json;
use super::roles::{self, NamedAxis};

/// One image.
#[derive(Debug)]
pub(super) struct Multiscales {
    /// Slowest first, as the arrays have them.
    pub axes: Vec<NamedAxis>,
    /// Finest first.
    pub levels: Vec<Level>,
}

/// One resolution. Voxel i of an axis lies at scale·i + translation.
#[derive(Debug)]
pub(super) struct Level {
    pub path: String,
    pub scale: Vec<f64>,
    pub translation: Vec<f64>,
    /// True if the file says where the voxels lie.
    pub is_placed: bool,
}

impl Multiscales {
    /// The first image that the attributes of a group describe; `None` where they describe none.
    pub fn read(attributes: &Value, notes: &mut Vec<String>) -> Result<Option<Self>, FieldError> {
        let ome = attributes.get("ome").unwrap_or(attributes);
        let Some(list) = ome.get("multiscales").and_then(Value::as_array) else { return Ok(None) };
        let Some(first) = list.first() else { return Ok(None) };
        if list.len() > 1 {
            notes.push(format!("multiscales describes {} images: the first is taken", list.len()));
        }
        let axes = axes(first.get("axes"))?;
        let datasets = first.get("datasets");
        let allowed = "must be a list of one or more, each with a path";
        let wrong = || FieldError::new("datasets", json::shown(datasets), allowed);
        let datasets_list = datasets.and_then(Value::as_array).filter(|d| !d.is_empty()).ok_or_else(wrong)?;
        let whole = transformations(first.get("coordinateTransformations"), axes.len())?;
        let mut levels = Vec::new();
        for dataset in datasets_list {
            let path = dataset.get("path").and_then(Value::as_str).ok_or_else(wrong)?.to_owned();
            let own = transformations(dataset.get("coordinateTransformations"), axes.len())?;
            let is_placed = own.is_some() || whole.is_some();
            let identity = || (vec![1.0; axes.len()], vec![0.0; axes.len()]);
            let (inner, outer) = (own.unwrap_or_else(identity), whole.clone().unwrap_or_else(identity));
            // First the level's own, then that of all levels.
            let each = |f: &dyn Fn(usize) -> f64| (0..axes.len()).map(f).collect::<Vec<f64>>();
            levels.push(Level {
                path,
                scale: each(&|a| inner.0[a] * outer.0[a]),
                translation: each(&|a| inner.1[a] * outer.0[a] + outer.1[a]),
                is_placed,
            });
        }
        Ok(Some(Self { axes, levels }))
    }
}

fn axes(value: Option<&Value>) -> Result<Vec<NamedAxis>, FieldError> {
    let Some(value) = value else {
        return ["t", "c", "z", "y", "x"].iter().map(|name| axis(name, None, None)).collect();
    };
    let allowed = "must be a list of axes with a name each, 3 to 5";
    let wrong = || FieldError::new("axes", json::shown(Some(value)), allowed);
    let list = value.as_array().filter(|l| (3..=5).contains(&l.len())).ok_or_else(wrong)?;
    let text = |v: &Value, key: &str| v.get(key).and_then(Value::as_str).map(str::to_owned);
    list.iter()
        .map(|entry| match entry.as_str() {
            Some(name) => axis(name, None, None),
            None => axis(&text(entry, "name").ok_or_else(wrong)?, text(entry, "type"), text(entry, "unit")),
        })
        .collect()
}

fn axis(name: &str, kind: Option<String>, unit: Option<String>) -> Result<NamedAxis, FieldError> {
    let role = match kind.as_deref() {
        Some("space") => Some(Role::Space),
        Some("time") => Some(Role::Frame),
        Some("channel") => Some(Role::Component),
        _ => roles::by_name(name),
    };
    let role = role.ok_or_else(|| FieldError::new("axes", name, "must be of space, time or channel"))?;
    Ok(NamedAxis { name: name.to_owned(), role, unit })
}

type Transformation = (Vec<f64>, Vec<f64>);

/// Scale and translation of every axis; `None` where there is no list.
fn transformations(value: Option<&Value>, count: usize) -> Result<Option<Transformation>, FieldError> {
    const FIELD: &str = "coordinateTransformations";
    let Some(value) = value.filter(|v| !v.is_null()) else { return Ok(None) };
    let wrong = |found: &Value| FieldError::new(FIELD, found, "must be a list of scale and translation, written out");
    let (mut scale, mut translation) = (vec![1.0; count], vec![0.0; count]);
    for entry in value.as_array().ok_or_else(|| wrong(value))? {
        match entry.get("type").and_then(Value::as_str) {
            Some("scale") => {
                let factors = json::numbers(entry.get("scale"), "scale", count)?;
                for (a, factor) in factors.iter().enumerate() {
                    scale[a] *= factor;
                    translation[a] *= factor;
                }
            }
            Some("translation") => {
                let shifts = json::numbers(entry.get("translation"), "translation", count)?;
                shifts.iter().enumerate().for_each(|(a, shift)| translation[a] += shift);
            }
            Some("identity") => {}
            _ => return Err(wrong(entry)),
        }
    }
    Ok(Some((scale, translation)))
}
