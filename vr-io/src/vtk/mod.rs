//! VTK's files, XML and legacy: what points and images have in common, and images.
//!
//! The formats are those of the VTK User's Guide (11th edition, 2010, "VTK file formats"), and where it is silent those of VTK 9's readers and
//! writers: `vtkXMLDataElement`, `vtkXMLWriter`, `vtkDataReader`, `vtkDataWriter`.

mod blanking;
mod coded;
mod content;
mod data_array;
mod image;
mod lattice_file;
mod legacy;
mod piece_arrays;
mod rectilinear;
mod words;
mod xml;

pub(crate) use content::{Content, content, unsupported};
pub(crate) use data_array::{DataArray, named_arrays};
pub(crate) use image::{Candidate, Extent, ImageFormat, by_content, by_extension, choose, describe};
pub(crate) use lattice_file::{IMAGE, LatticeFile};
pub(crate) use legacy::{Array, CellLines, Legacy};
pub(crate) use piece_arrays::PieceArrays;
pub(crate) use rectilinear::{RectilinearFormat, by_content as rectilinear_by_content, read as read_rectilinear};
pub(crate) use words::exactly;
pub(crate) use xml::{Store, XmlFile, root};
