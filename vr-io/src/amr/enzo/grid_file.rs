//! A file with groups of grids, in the plain form that Enzo gives it, or in any other that `hdf5-reader` knows.

use std::path::Path;

use crate::error::FileErrorKind;
#[cfg(feature = "hdf5")]
use crate::hdf5;
use crate::plain_hdf5::PlainHdf5;
use crate::scalar::ScalarType;

/// A file of grids.
pub(super) enum GridFile {
    Plain(PlainHdf5),
    #[cfg(feature = "hdf5")]
    Other(hdf5_reader::Hdf5File),
}

/// Name, shape and type of a dataset.
pub(super) type Field = (String, Vec<u64>, ScalarType);

impl GridFile {
    /// Opens the file of a group.
    ///
    /// # Errors
    /// A file that is damaged; one of another form in builds without the feature `hdf5`.
    pub fn open(path: &Path, group: &str) -> Result<Self, FileErrorKind> {
        if let Some(mut file) = PlainHdf5::open(path)?
            && !plain_fields(&mut file, group)?.is_empty()
        {
            return Ok(Self::Plain(file));
        }
        #[cfg(feature = "hdf5")]
        {
            hdf5::open(path).map(Self::Other)
        }
        #[cfg(not(feature = "hdf5"))]
        Err(FileErrorKind::Feature { format: "HDF5 in another form than Enzo gives it", feature: "hdf5" })
    }

    /// Datasets of numbers in a group.
    pub fn fields(&mut self, group: &str) -> Result<Vec<Field>, FileErrorKind> {
        match self {
            Self::Plain(file) => plain_fields(file, group),
            #[cfg(feature = "hdf5")]
            Self::Other(file) => {
                let found = file.group(group).map_err(|e| hdf5::damaged(group, e))?;
                let (_, members) = found.member_names().map_err(|e| hdf5::damaged(group, e))?;
                let field = |name: String| {
                    let dataset = found.dataset(&name).ok()?;
                    Some((name, dataset.shape().to_vec(), hdf5::scalar_of(dataset.dtype())?))
                };
                Ok(members.into_iter().filter_map(field).collect())
            }
        }
    }

    /// All numbers of a dataset of a group; `None` where there is no such dataset of numbers of that shape.
    pub fn numbers(&mut self, group: &str, name: &str, shape: &[u64]) -> Result<Option<Vec<f64>>, FileErrorKind> {
        match self {
            Self::Plain(file) => {
                let members = file.members(group)?.unwrap_or_default();
                let Some((_, header)) = members.into_iter().find(|(member, _)| member == name) else { return Ok(None) };
                let found = file.dataset(header)?.filter(|dataset| dataset.shape == shape);
                found.map(|dataset| file.numbers(&dataset)).transpose()
            }
            #[cfg(feature = "hdf5")]
            Self::Other(file) => {
                let place = format!("{group}/{name}");
                let dataset = file.dataset(&place).map_err(|e| hdf5::damaged(&place, e))?;
                let Some(scalar) = hdf5::scalar_of(dataset.dtype()).filter(|_| dataset.shape() == shape) else {
                    return Ok(None);
                };
                let bytes = dataset.read_native_bytes().map_err(|e| hdf5::damaged(&place, e))?;
                Ok(Some(crate::decode::numbers_as_f64(&bytes, scalar, crate::scalar::Endian::NATIVE)))
            }
        }
    }
}

fn plain_fields(file: &mut PlainHdf5, group: &str) -> Result<Vec<Field>, FileErrorKind> {
    let mut fields = Vec::new();
    for (name, header) in file.members(group)?.unwrap_or_default() {
        if let Some(dataset) = file.dataset(header)? {
            fields.push((name, dataset.shape, dataset.scalar));
        }
    }
    Ok(fields)
}
