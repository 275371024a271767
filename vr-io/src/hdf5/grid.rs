//! Datasets of HDF5 as variables.

use std::path::Path;

use hdf5_reader::group::Group;
use hdf5_reader::{Attribute as Stored, Dataset, Hdf5File, SliceInfo, SliceInfoElem};

use crate::decode::with_scalar;
use crate::error::{FileError, FileErrorKind, shown};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::variables::{self, Attribute, Store, Variable};

use super::{damaged, open, scalar_of};

/// Most datasets that are looked at, and groups within groups.
const MAX_DATASETS: usize = 4096;
const MAX_DEPTH: usize = 32;

/// Everything that a file says about the chosen dataset.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    let file = open(path).map_err(in_file)?;
    let root = file.root_group().map_err(|e| in_file(damaged("/", e)))?;
    let mut datasets = Vec::new();
    collect(&root, "", 0, &mut datasets).map_err(in_file)?;
    let is_netcdf = root.attribute("_NCProperties").is_ok() || datasets.iter().any(|(_, d)| is_of_netcdf(d));
    let variables = datasets.iter().filter_map(|(name, dataset)| variable(name, dataset, &datasets)).collect();
    let format = if is_netcdf { "NetCDF-4" } else { "HDF5" };
    let fill_is_known = is_netcdf;
    variables::describe(path, format, Grids { file, variables, fill_is_known }, options)
}

fn is_of_netcdf(dataset: &Dataset) -> bool {
    dataset.attribute("_Netcdf4Dimid").is_ok() || dataset.attribute("_Netcdf4Coordinates").is_ok()
}

/// All datasets of a group and the groups in it, by path.
fn collect(group: &Group, path: &str, depth: usize, found: &mut Vec<(String, Dataset)>) -> Result<(), FileErrorKind> {
    let place = |error| damaged(if path.is_empty() { "/" } else { path }, error);
    let (groups, datasets) = group.member_names().map_err(place)?;
    for name in datasets {
        let Ok(dataset) = group.dataset(&name) else { continue };
        if found.len() >= MAX_DATASETS {
            let allowed = format!("must be at most {MAX_DATASETS}");
            return Err(FileErrorKind::field("datasets", format_args!("more than {MAX_DATASETS}"), allowed));
        }
        found.push((format!("{path}/{name}"), dataset));
    }
    // A group may lead back to one that it is in.
    if depth < MAX_DEPTH {
        for name in groups {
            if let Ok(inner) = group.group(&name) {
                collect(&inner, &format!("{path}/{name}"), depth + 1, found)?;
            }
        }
    }
    Ok(())
}

/// A dataset of numbers as a variable, its axes named by the scales that are attached, by labels, or by the tags of ilastik.
fn variable(name: &str, dataset: &Dataset, all: &[(String, Dataset)]) -> Option<Variable> {
    let scalar = scalar_of(dataset.dtype())?;
    let shape: Vec<usize> = dataset.shape().iter().map(|&n| usize::try_from(n).ok()).collect::<Option<_>>()?;
    // A scale is a dimension of its own.
    let is_scale = dataset.attribute("CLASS").ok().and_then(|a| a.read_string().ok());
    let is_scale = is_scale.is_some_and(|class| class.trim_end_matches('\0') == "DIMENSION_SCALE");
    let dimensions = if is_scale && shape.len() == 1 {
        vec![Some(name.to_owned())]
    } else {
        scales(dataset, shape.len(), all)
            .or_else(|| labels(dataset, shape.len()))
            .or_else(|| axis_tags(dataset, shape.len()))
            .unwrap_or_else(|| vec![None; shape.len()])
    };
    Some(Variable { name: name.to_owned(), shape, dimensions, scalar })
}

/// Paths of the scales that are attached to the axes: references in DIMENSION_LIST.
fn scales(dataset: &Dataset, axes: usize, all: &[(String, Dataset)]) -> Option<Vec<Option<String>>> {
    let list = dataset.attribute("DIMENSION_LIST").ok()?;
    let size = dataset.vlen_reference_size();
    if list.raw_data.len() < axes.checked_mul(size)? {
        return None;
    }
    let scale = |reference: &[u8]| {
        // An address is of 8 bytes but in files that state otherwise, which NetCDF-4 writes none of.
        let bytes = dataset.resolve_vlen_reference_bytes(reference, 8).ok()?;
        let address = u64::from_le_bytes(*bytes.first_chunk()?);
        all.iter().find(|(_, d)| d.address() == address).map(|(name, _)| name.clone())
    };
    Some(list.raw_data.chunks_exact(size).take(axes).map(scale).collect())
}

fn labels(dataset: &Dataset, axes: usize) -> Option<Vec<Option<String>>> {
    let labels = dataset.attribute("DIMENSION_LABELS").ok()?.read_strings().ok()?;
    let name = |label: String| Some(label.trim_matches(['\0', ' ']).to_owned()).filter(|label| !label.is_empty());
    (labels.len() == axes).then(|| labels.into_iter().map(name).collect())
}

/// Keys of the axes in JSON, as vigra and ilastik write it.
fn axis_tags(dataset: &Dataset, axes: usize) -> Option<Vec<Option<String>>> {
    let text = dataset.attribute("axistags").ok()?.read_string().ok()?;
    let json: serde_json::Value = serde_json::from_str(text.trim_end_matches('\0')).ok()?;
    let list = json.get("axes")?.as_array()?;
    let key = |axis: &serde_json::Value| axis.get("key")?.as_str().map(str::to_owned);
    (list.len() == axes).then(|| list.iter().map(key).collect())
}

/// A file.
struct Grids {
    file: Hdf5File,
    variables: Vec<Variable>,
    /// True if numbers that were never written hold NetCDF's fill value.
    fill_is_known: bool,
}

impl Store for Grids {
    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn attribute(&self, variable: &str, name: &str) -> Option<Attribute> {
        value(&self.file.dataset(variable).ok()?.attribute(name).ok()?)
    }

    fn read(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Vec<u8>, FileErrorKind> {
        let place = |e| damaged(&shown(&variable.name), e);
        let dataset = self.file.dataset(&variable.name).map_err(place)?;
        let part = |(&start, &count): (&usize, &usize)| SliceInfoElem::Slice {
            start: start as u64,
            end: (start + count) as u64,
            step: 1,
        };
        let selection = SliceInfo { selections: start.iter().zip(count).map(part).collect() };
        with_scalar!(variable.scalar, S => {
            let (numbers, _) = dataset.read_slice::<S>(&selection).map_err(place)?.into_raw_vec_and_offset();
            Ok(bytemuck::cast_slice::<S, u8>(&numbers).to_vec())
        })
    }

    fn endian(&self) -> Endian {
        Endian::NATIVE
    }

    fn default_fill(&self, scalar: ScalarType) -> Option<f64> {
        variables::netcdf_fill(scalar).filter(|_| self.fill_is_known)
    }
}

/// An attribute's text or numbers.
fn value(stored: &Stored) -> Option<Attribute> {
    if let Ok(text) = stored.read_string() {
        return Some(Attribute::Text(text));
    }
    let scalar = scalar_of(&stored.datatype)?;
    #[allow(clippy::unnecessary_cast, reason = "one of the ten types is f64")]
    let numbers = with_scalar!(scalar, S => {
        let list = stored.read_1d::<S>().or_else(|_| stored.read_scalar::<S>().map(|x| vec![x])).ok()?;
        list.into_iter().map(|x| x as f64).collect()
    });
    Some(Attribute::Numbers(numbers))
}
