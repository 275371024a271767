//! The kind of data that the beginning of a VTK file announces.

/// The form of a file, and the kind of data in it: empty where the beginning does not tell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    /// The word behind DATASET, in capitals.
    Legacy(String),
    /// The root's attribute `type`.
    Xml(String),
}

/// Tells what the first bytes of a file announce; `None` where it is none of VTK's.
pub(crate) fn content(head: &[u8]) -> Option<Content> {
    if head.starts_with(b"# vtk DataFile") {
        return Some(Content::Legacy(data_set(head).unwrap_or_default()));
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    if !text.starts_with(b"<") {
        return None;
    }
    const TAG: &[u8] = b"<VTKFile";
    let tag = text.windows(TAG.len()).position(|w| w == TAG)?;
    let attributes = String::from_utf8_lossy(&text[tag + TAG.len()..]);
    Some(Content::Xml(attribute(&attributes, "type").unwrap_or_default().to_owned()))
}

/// The kinds of data that are not read, as messages name them.
pub(crate) fn unsupported(head: &[u8]) -> Option<&'static str> {
    Some(match content(head)? {
        Content::Legacy(kind) => match kind.as_str() {
            // Where it is read, this comes out of a compressed file.
            "STRUCTURED_POINTS" | "POLYDATA" | "UNSTRUCTURED_GRID" | "STRUCTURED_GRID" | "RECTILINEAR_GRID" => PACKED,
            _ => return None,
        },
        Content::Xml(kind) => match kind.as_str() {
            "HyperTreeGrid" => "VTK HyperTreeGrid (.htg: a tree of cells)",
            "vtkMultiBlockDataSet" | "vtkPartitionedDataSet" | "vtkPartitionedDataSetCollection" => {
                "VTK blocks (a list of files, each of which may be read)"
            }
            "Collection" => "VTK Collection (.pvd: a list of files, each of which may be read)",
            "ImageData"
            | "PImageData"
            | "RectilinearGrid"
            | "PRectilinearGrid"
            | "PolyData"
            | "UnstructuredGrid"
            | "StructuredGrid"
            | "PUnstructuredGrid"
            | "PStructuredGrid"
            | "vtkOverlappingAMR"
            | "vtkNonOverlappingAMR"
            | "vtkHierarchicalBoxDataSet" => PACKED,
            kind if kind.starts_with('P') => "VTK parallel file (a list of files, each of which may be read)",
            _ => "VTK (XML)",
        },
    })
}

const PACKED: &str = "VTK in a compressed file (it can be read when unpacked)";

fn data_set(head: &[u8]) -> Option<String> {
    let lines = head.split(|&c| c == b'\n').take(12).filter_map(|line| str::from_utf8(line).ok());
    let mut words = lines.map(str::split_ascii_whitespace);
    words.find_map(|mut words| {
        words
            .next()
            .filter(|first| first.eq_ignore_ascii_case("DATASET"))
            .and(words.next())
            .map(str::to_ascii_uppercase)
    })
}

/// Value of an attribute of the tag that goes on here.
fn attribute<'t>(mut tag: &'t str, name: &str) -> Option<&'t str> {
    loop {
        let (key, after) = tag.split_once('=')?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|&c| c == '"' || c == '\'')?;
        let (value, rest) = after[1..].split_once(quote)?;
        if key.contains('>') {
            return None;
        }
        if key.trim() == name {
            return Some(value);
        }
        tag = rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_both_forms() {
        let xml = |text: &str| content(text.as_bytes());
        let image = Some(Content::Xml("ImageData".to_owned()));
        assert_eq!(xml("<?xml version=\"1.0\"?>\n<VTKFile header_type=\"UInt64\" type = 'ImageData'>"), image);
        assert_eq!(xml("\u{feff}<!-- a = \"b\" -->\n<VTKFile\ntype=\"ImageData\"\n>"), image);
        assert_eq!(xml("<VTKFile version=\"1.0\"> <a type=\"ImageData\"/>"), Some(Content::Xml(String::new())));
        assert_eq!(xml("<svg type=\"ImageData\">"), None);
        assert_eq!(xml("type=\"ImageData\" <VTKFile"), None);
        let legacy = b"# vtk DataFile Version 3.0\n\xff title\r\n\nASCII\r\nDataset  structured_points\r\n";
        assert_eq!(content(legacy), Some(Content::Legacy("STRUCTURED_POINTS".to_owned())));
        assert_eq!(content(b"# vtk DataFile Version 3.0\n"), Some(Content::Legacy(String::new())));
    }

    #[test]
    fn what_is_not_read_is_named() {
        let of = |kind: &str| unsupported(format!("<VTKFile type=\"{kind}\">").as_bytes()).unwrap();
        assert!(of("HyperTreeGrid").contains("HyperTreeGrid (.htg"));
        assert!(of("PPolyData").contains("parallel"));
        for packed in ["RectilinearGrid", "PImageData", "PUnstructuredGrid", "vtkOverlappingAMR"] {
            assert!(of(packed).contains("when unpacked"), "{packed}");
        }
        assert_eq!(unsupported(b"NRRD0004"), None);
    }
}
