//! Detection of a file's format: by its content first, by its name second.

use std::io::Read;
use std::path::Path;

use crate::amr::{self, AmrFormat};
use crate::cells::{self, CellFormat, plot3d};
use crate::encoding::Encoding;
use crate::error::{FieldError, FileError, FileErrorKind, VOLUMES};
use crate::points::{self, PointFormat};
use crate::raw::RawDescription;
use crate::read::file_head;
use crate::vtk::{self, ImageFormat, RectilinearFormat};
use crate::{advice, memory_folder, mrc, netcdf, npy, opendx, pvm, slc, slices, vdb, voreen, zarr};

/// The formats that are read.
#[derive(Debug, PartialEq)]
pub(crate) enum Format {
    Nrrd,
    MetaImage,
    Nifti,
    Mrc,
    Pvm,
    Slc,
    Npy,
    /// The header of a raw file.
    DxGeneral,
    /// Data Explorer's own files.
    DxNative,
    Vvd,
    Dat,
    /// A stack of pages in one file.
    Tiff,
    /// A stack of pictures, one a file.
    Slices,
    /// A folder of chunks.
    Zarr,
    Dicom,
    /// NetCDF's classic formats.
    NetCdf,
    Vdb,
    /// Grids in HDF5, NetCDF-4 among them.
    #[cfg(feature = "hdf5")]
    Hdf5,
    /// No header; what the name says.
    Raw(RawDescription),
    VtkImage(ImageFormat),
    Rectilinear(RectilinearFormat),
    Amr(AmrFormat),
    Points(PointFormat),
    Cells(CellFormat),
}

impl Format {
    /// True if files of this format hold arrays under names, of which [`crate::ReadOptions::array`] chooses one.
    pub fn has_named_arrays(&self) -> bool {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5 => true,
            Self::VtkImage(_) | Self::NetCdf | Self::Vdb | Self::Cells(_) | Self::Rectilinear(_) | Self::Amr(_) => true,
            _ => false,
        }
    }
}

/// The format of a file of which the first bytes are given.
pub(crate) fn detect(path: &Path, head: &[u8]) -> Result<Format, FileError> {
    let unpacked = unpack(head);
    // What no other file begins with.
    if head.starts_with(b"NRRD") {
        return Ok(Format::Nrrd);
    }
    if is_dicom(head) {
        return Ok(Format::Dicom);
    }
    if is_nifti(&unpacked) {
        return Ok(Format::Nifti);
    }
    if let Some(format) = by_content(&unpacked) {
        return Ok(format);
    }
    if let Some(format) = points::by_content(head) {
        return Ok(Format::Points(format));
    }
    if let Some(format) = cells::by_content(head) {
        return Ok(Format::Cells(format));
    }
    if let Some(format) = vtk::by_content(head) {
        return Ok(Format::VtkImage(format));
    }
    if let Some(format) = vtk::rectilinear_by_content(head) {
        return Ok(Format::Rectilinear(format));
    }
    if let Some(format) = amr::by_content(path, head) {
        return Ok(Format::Amr(format));
    }
    if is_tiff(head) {
        return Ok(Format::Tiff);
    }
    if head.starts_with(b"\x89PNG") || head.starts_with(&[0xff, 0xd8, 0xff]) {
        return Ok(Format::Slices);
    }
    if let Some(format) = unsupported_by_content(&unpacked) {
        return Err(FileError::new(path, FileErrorKind::Unsupported { format }));
    }
    if is_metaimage(head) {
        return Ok(Format::MetaImage);
    }
    // The content says nothing: the name must.
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let plain = name.trim_end_matches(".gz").trim_end_matches(".bz2");
    match Path::new(plain).extension().and_then(|e| e.to_str()).unwrap_or_default() {
        "nrrd" | "nhdr" => return Ok(Format::Nrrd),
        "mha" | "mhd" => return Ok(Format::MetaImage),
        "nii" | "hdr" | "img" => return Ok(Format::Nifti),
        "tif" | "tiff" => return Ok(Format::Tiff),
        "dcm" | "ima" => return Ok(Format::Dicom),
        extension => {
            if slices::is_slice(Path::new(plain)) {
                return Ok(Format::Slices);
            }
            if let Some(described) = RawDescription::from_name(path) {
                let wrong = |e: FieldError| advice::header_beside(path).unwrap_or_else(|| e.in_file(path));
                return described.map(Format::Raw).map_err(wrong);
            }
            if let Some(format) = by_extension(extension) {
                return Ok(format);
            }
            // A compressed text has another ending.
            if let Some(format) = points::by_extension(extension).filter(|_| plain == name) {
                return Ok(Format::Points(format));
            }
            if let Some(format) = vtk::by_extension(extension).filter(|_| plain == name) {
                return Ok(Format::VtkImage(format));
            }
            if plot3d::is_plot3d(path) {
                return Ok(Format::Cells(CellFormat::Plot3d));
            }
            if let Some(format) = unsupported_by_extension(extension) {
                return Err(FileError::new(path, FileErrorKind::Unsupported { format }));
            }
            if is_bare_dicom(head) {
                return Ok(Format::Dicom);
            }
        }
    }
    let unrecognised = || FileError::new(path, FileErrorKind::Unrecognised { supported: VOLUMES });
    Err(advice::header_beside(path).unwrap_or_else(unrecognised))
}

/// The format of a folder: of one that is a volume by itself, or of the files in it.
pub(crate) fn detect_folder(path: &Path) -> Result<Format, FileError> {
    if zarr::is_zarr(path) {
        return Ok(Format::Zarr);
    }
    if let Some(format) = amr::of_folder(path) {
        return Ok(Format::Amr(format));
    }
    if holds_dicom(path) {
        return Ok(Format::Dicom);
    }
    if slices::is_folder_of_slices(path) {
        return Ok(Format::Slices);
    }
    Err(advice::folder_of_files(path))
}

/// The beginning of what a compressed beginning unpacks to.
fn unpack(head: &[u8]) -> Vec<u8> {
    let encoding = Encoding::of_file(head);
    let mut out = Vec::new();
    // The head ends in the middle of the stream: what came out until then will do.
    let _ = encoding.reader(head).take(4096).read_to_end(&mut out);
    out
}

/// The format of one of the smaller families that the beginning of a file shows.
fn by_content(head: &[u8]) -> Option<Format> {
    type Test = fn(&[u8]) -> bool;
    let tests: [(Test, Format); 9] = [
        (npy::holds_volume, Format::Npy),
        (mrc::is_mrc, Format::Mrc),
        (pvm::is_pvm, Format::Pvm),
        (slc::is_slc, Format::Slc),
        (voreen::is_vvd, Format::Vvd),
        (voreen::is_dat, Format::Dat),
        (opendx::is_native, Format::DxNative),
        (netcdf::is_netcdf, Format::NetCdf),
        (vdb::is_vdb, Format::Vdb),
    ];
    tests.into_iter().find(|(is, _)| is(head)).map(|(_, format)| format)
}

/// The format of one of the smaller families that the end of a name tells, in lower case.
fn by_extension(extension: &str) -> Option<Format> {
    Some(match extension {
        "mrc" | "map" | "ccp4" => Format::Mrc,
        "pvm" => Format::Pvm,
        "slc" => Format::Slc,
        "general" => Format::DxGeneral,
        "dx" => Format::DxNative,
        "vvd" => Format::Vvd,
        "dat" => Format::Dat,
        _ => return None,
    })
}

fn is_nifti(head: &[u8]) -> bool {
    let size = head.first_chunk().map(|b| (i32::from_le_bytes(*b), i32::from_be_bytes(*b)));
    match size {
        Some((348, _) | (_, 348)) => head.get(344..347).is_some_and(|m| m == b"n+1" || m == b"ni1"),
        Some((540, _) | (_, 540)) => head.get(4..7).is_some_and(|m| m == b"n+2" || m == b"ni2"),
        _ => false,
    }
}

/// `Key = value` lines, among them one of the keys that every MetaImage has.
fn is_metaimage(head: &[u8]) -> bool {
    head.split(|&c| c == b'\n')
        .map_while(|line| str::from_utf8(line).ok()?.split_once('='))
        .any(|(key, _)| matches!(key.trim(), "ObjectType" | "NDims" | "DimSize"))
}

/// TIFF and BigTIFF.
fn is_tiff(head: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| head.starts_with(*magic))
}

fn unsupported_by_content(head: &[u8]) -> Option<&'static str> {
    let begins = |magic: &[u8]| head.starts_with(magic);
    let at = |offset: usize, magic: &[u8]| head.get(offset..).is_some_and(|rest| rest.starts_with(magic));
    let contains = |text: &[u8]| head.windows(text.len()).any(|w| w == text);
    if let Some(kind) = vtk::unsupported(head) {
        Some(kind)
    } else if begins(b"# vtk DataFile") {
        Some("VTK (legacy)")
    } else if begins(b"<") && contains(b"<VTKFile") {
        Some("VTK (XML)")
    } else if at(128, b"DICM") {
        Some("DICOM in a compressed file")
    } else if begins(b"PK\x03\x04") {
        Some("ZIP (unpack it)")
    } else {
        None
    }
}

/// DICOM's prefix, after 128 bytes of anything.
fn is_dicom(head: &[u8]) -> bool {
    head.get(128..132) == Some(b"DICM")
}

/// A DICOM data set without meta information. Its first bytes may begin other files, too: this comes last.
fn is_bare_dicom(head: &[u8]) -> bool {
    matches!(head, [8, 0, 0 | 1 | 5 | 8, 0, ..])
}

/// True if there are DICOM files in a folder, as far as names and some beginnings tell.
fn holds_dicom(folder: &Path) -> bool {
    // Files are opened one by one: a folder of something else may hold many.
    const MAX_OPENED: usize = 256;
    let Ok(entries) = memory_folder::entries(folder) else { return false };
    let paths: Vec<_> = entries.flatten().collect();
    let named =
        |p: &Path| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("dcm") || e.eq_ignore_ascii_case("ima"));
    paths.iter().any(|p| named(p))
        || paths
            .iter()
            .take(MAX_OPENED)
            .filter(|p| memory_folder::is_file(p))
            .any(|p| file_head(p).is_ok_and(|head| is_dicom(&head)))
}

fn unsupported_by_extension(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "vtr" | "pvtr" | "vts" | "pvtp" | "pvtu" | "pvts" | "vthb" | "vth" => "VTK (this file does not begin as one)",
        "p3d" | "xyz" | "q" => "PLOT3D (binary, of three dimensions; the sizes in this file do not fit its length)",
        "h5" | "hdf5" | "nc" => "HDF5 or NetCDF (this file begins as neither)",
        "zarr" => "Zarr (a folder)",
        "nvdb" => "NanoVDB",
        "vdb" => "OpenVDB (this file does not begin as one)",
        "mgz" | "mgh" => "MGH",
        "ex2" | "exo" => "ExodusII",
        "stl" | "obj" | "ply" => "mesh (a surface, not a volume)",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_comes_before_the_name() {
        assert_eq!(detect(Path::new("x.mhd"), b"NRRD0004\ntype: u8\n").unwrap(), Format::Nrrd);
        assert_eq!(detect(Path::new("x.nrrd"), b"ObjectType = Image\nNDims = 3\n").unwrap(), Format::MetaImage);
        assert_eq!(detect(Path::new("x.nii"), b"").unwrap(), Format::Nifti);
        assert!(matches!(detect(Path::new("a_2x2x2_uint8.raw"), &[0; 8]).unwrap(), Format::Raw(_)));
    }

    #[test]
    fn a_described_raw_file_may_begin_with_anything() {
        let path = Path::new("a_2x2x2_uint32.raw");
        assert!(matches!(detect(path, &[8, 0, 0, 0, 9, 0, 0, 0]).unwrap(), Format::Raw(_)));
    }

    #[test]
    fn points_are_told_from_grids() {
        let points = |name, head: &[u8]| detect(Path::new(name), head).unwrap();
        assert_eq!(points("x.csv", b"x,y,z\n"), Format::Points(PointFormat::Delimited));
        assert_eq!(points("x", b"\x93NUMPY\x01\0"), Format::Points(PointFormat::Npy));
        assert_eq!(points("x.raw", b"\x89HDF\r\n\x1a\n...."), Format::Points(PointFormat::Hdf5));
        let legacy = |kind| format!("# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET {kind}\n");
        assert_eq!(points("x.vtk", legacy("POLYDATA").as_bytes()), Format::Points(PointFormat::VtkLegacy));
        let xml = |kind| format!("<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\">\n");
        assert_eq!(points("x", xml("UnstructuredGrid").as_bytes()), Format::Points(PointFormat::VtkXml));
        let image = |head: String| detect(Path::new("x"), head.as_bytes()).unwrap();
        assert_eq!(image(legacy("STRUCTURED_POINTS")), Format::VtkImage(ImageFormat::Legacy));
        assert_eq!(image(xml("ImageData")), Format::VtkImage(ImageFormat::Xml));
        assert_eq!(image(legacy("STRUCTURED_GRID")), Format::Cells(CellFormat::VtkLegacy));
        assert_eq!(image(xml("PUnstructuredGrid")), Format::Cells(CellFormat::VtkParallel));
        assert_eq!(image(xml("PImageData")), Format::VtkImage(ImageFormat::Xml));
        assert_eq!(image(xml("PRectilinearGrid")), Format::Rectilinear(RectilinearFormat::Xml));
        assert_eq!(image(legacy("RECTILINEAR_GRID")), Format::Rectilinear(RectilinearFormat::Legacy));
        assert_eq!(image(xml("vtkOverlappingAMR")), Format::Amr(AmrFormat::Vthb));
        let message = detect(Path::new("x.vtk"), xml("HyperTreeGrid").as_bytes()).unwrap_err().to_string();
        assert!(message.contains("unsupported format VTK HyperTreeGrid"), "{message}");
    }

    #[test]
    fn smaller_families_are_told_by_content_and_by_name() {
        let told = |name, head: &[u8]| detect(Path::new(name), head).unwrap();
        assert_eq!(told("x.raw", b"PVM3\n1 2 3\n"), Format::Pvm);
        assert_eq!(told("x", b"DDS v3e\n...."), Format::Pvm);
        assert_eq!(told("x", b"11111\n2 2 2 8\n"), Format::Slc);
        assert_eq!(told("x.map", &[[0; 208].as_slice(), b"MAP DA"].concat()), Format::Mrc);
        assert_eq!(told("x.mrc.gz", b"...."), Format::Mrc);
        assert_eq!(told("x", b"<?xml version=\"1.0\" ?>\n<VoreenData version=\"1\">"), Format::Vvd);
        assert_eq!(told("x", b"ObjectFileName: x.raw\n"), Format::Dat);
        assert_eq!(told("x", b"# dx\nobject 1 class gridpositions counts 2 2 2\n"), Format::DxNative);
        assert_eq!(told("x.general", b"grid = 2x2x2\n"), Format::DxGeneral);
        let array =
            |shape| format!("\x01\0\x46\0{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}{:30}", "");
        let npy = |shape| told("x", &[b"\x93NUMPY", array(shape).as_bytes()].concat());
        assert_eq!(npy("(9, 3)"), Format::Points(PointFormat::Npy));
        assert_eq!(npy("(9, 3, 3)"), Format::Npy);
    }

    #[test]
    fn names_what_it_does_not_read() {
        let message = detect(Path::new("x.raw"), b"PK\x03\x04....").unwrap_err().to_string();
        assert!(message.contains("unsupported format ZIP (unpack it); supported are NRRD"), "{message}");
        let message = detect(Path::new("x.unheard"), b"....").unwrap_err().to_string();
        assert!(message.contains("not recognised"), "{message}");
    }
}
