//! Detection of a file's format: by its content first, by its name second.

use std::io::Read;
use std::path::Path;

use crate::encoding::Encoding;
use crate::error::{FileError, FileErrorKind, VOLUMES};
use crate::points::{self, PointFormat};
use crate::raw::RawDescription;
use crate::read::file_head;

/// The formats that are read.
#[derive(Debug, PartialEq)]
pub(crate) enum Format {
    Nrrd,
    MetaImage,
    Nifti,
    Dicom,
    /// No header; what the name says.
    Raw(RawDescription),
    Points(PointFormat),
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
    if let Some(format) = points::by_content(head) {
        return Ok(Format::Points(format));
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
        "dcm" | "ima" => return Ok(Format::Dicom),
        extension => {
            if let Some(described) = RawDescription::from_name(path) {
                return described.map(Format::Raw).map_err(|e| e.in_file(path));
            }
            // A compressed text has another ending.
            if let Some(format) = points::by_extension(extension).filter(|_| plain == name) {
                return Ok(Format::Points(format));
            }
            if let Some(format) = unsupported_by_extension(extension) {
                return Err(FileError::new(path, FileErrorKind::Unsupported { format }));
            }
            if is_bare_dicom(head) {
                return Ok(Format::Dicom);
            }
        }
    }
    Err(FileError::new(path, FileErrorKind::Unrecognised { supported: VOLUMES }))
}

/// The format of a folder: of one that is a volume by itself, or of the files in it.
pub(crate) fn detect_folder(path: &Path) -> Result<Format, FileError> {
    let has = |name: &str| path.join(name).exists();
    let format = if has(".zgroup") || has(".zarray") || has(".zattrs") || has("zarr.json") {
        "Zarr (a folder)"
    } else if holds_dicom(path) {
        return Ok(Format::Dicom);
    } else {
        "folder of files"
    };
    Err(FileError::new(path, FileErrorKind::Unsupported { format }))
}

/// The beginning of what a compressed beginning unpacks to.
fn unpack(head: &[u8]) -> Vec<u8> {
    let encoding = Encoding::of_file(head);
    let mut out = Vec::new();
    // The head ends in the middle of the stream: what came out until then will do.
    let _ = encoding.reader(head).take(4096).read_to_end(&mut out);
    out
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

fn unsupported_by_content(head: &[u8]) -> Option<&'static str> {
    let begins = |magic: &[u8]| head.starts_with(magic);
    let at = |offset: usize, magic: &[u8]| head.get(offset..).is_some_and(|rest| rest.starts_with(magic));
    let contains = |text: &[u8]| head.windows(text.len()).any(|w| w == text);
    if begins(b"# vtk DataFile") {
        Some("VTK (legacy)")
    } else if begins(b"<") && contains(b"<VTKFile") {
        Some("VTK (XML)")
    } else if begins(b"<") && contains(b"<VolumeData") {
        Some("Voreen (.vvd)")
    } else if at(128, b"DICM") {
        Some("DICOM in a compressed file")
    } else if begins(b"CDF\x01") || begins(b"CDF\x02") || begins(b"CDF\x05") {
        Some("netCDF")
    } else if begins(&[0x20, 0x42, 0x44, 0x56]) {
        Some("OpenVDB")
    } else if begins(b"PVM\n") || begins(b"PVM2\n") || begins(b"PVM3\n") || begins(b"DDS v3") {
        Some("PVM")
    } else if begins(b"11111\n") || begins(b"11111 ") {
        Some("SLC")
    } else if at(208, b"MAP ") {
        Some("MRC/CCP4")
    } else if begins(b"II*\0") || begins(b"MM\0*") {
        Some("TIFF")
    } else if begins(b"\x89PNG") {
        Some("PNG")
    } else if begins(b"PK\x03\x04") {
        Some("ZIP")
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
    let Ok(entries) = folder.read_dir() else { return false };
    let paths: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    let named =
        |p: &Path| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("dcm") || e.eq_ignore_ascii_case("ima"));
    paths.iter().any(|p| named(p))
        || paths.iter().take(MAX_OPENED).filter(|p| p.is_file()).any(|p| file_head(p).is_ok_and(|head| is_dicom(&head)))
}

fn unsupported_by_extension(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "vtk" | "vti" | "vtr" | "vts" | "pvti" | "pvtp" | "pvtu" => "VTK",
        "h5" | "hdf5" | "nc" => "HDF5/netCDF",
        "zarr" => "Zarr",
        "vdb" | "nvdb" => "OpenVDB",
        "pvm" => "PVM",
        "slc" => "SLC",
        "mrc" | "map" => "MRC/CCP4",
        "tif" | "tiff" => "TIFF",
        "mgz" | "mgh" => "MGH",
        "vvd" => "Voreen (.vvd)",
        "general" | "dx" => "OpenDX",
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
        for grid in [legacy("STRUCTURED_POINTS"), xml("ImageData")] {
            let message = detect(Path::new("x.vtk"), grid.as_bytes()).unwrap_err().to_string();
            assert!(message.contains("unsupported format VTK"), "{message}");
        }
    }

    #[test]
    fn names_what_it_does_not_read() {
        let message = detect(Path::new("x.raw"), b"CDF\x01....").unwrap_err().to_string();
        assert!(message.contains("unsupported format netCDF; supported are NRRD"), "{message}");
        let message = detect(Path::new("x.unheard"), b"....").unwrap_err().to_string();
        assert!(message.contains("not recognised"), "{message}");
    }
}
