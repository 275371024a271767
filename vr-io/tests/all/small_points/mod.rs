//! Small files of points in every format: the same three points with the same columns.
#![allow(dead_code, reason = "each test file uses its part")]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Positions, smoothing lengths, temperatures.
pub const POINTS: [[f32; 5]; 3] =
    [[0.0, 0.0, 0.0, 0.5, 10.0], [1.0, -2.0, 0.5, 0.25, 20.0], [3.0, 1.5, 1e3, 1.0, 30.0]];

fn column(i: usize) -> Vec<f32> {
    POINTS.iter().map(|p| p[i]).collect()
}

fn positions() -> Vec<f32> {
    POINTS.iter().flat_map(|p| [p[0], p[1], p[2]]).collect()
}

fn words(numbers: &[f32]) -> String {
    numbers.iter().map(|x| format!("{x} ")).collect()
}

fn big(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_be_bytes()).collect()
}

fn little(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A Gadget snapshot with masses of 8 from its header, densities of 2 in deflated chunks, and internal energies in place of temperatures;
/// written by hdf5-pure 0.47.
pub const GADGET: &[u8] = include_bytes!("gadget.h5");

pub fn csv() -> String {
    let row = |p: &[f32; 5]| p.map(|x| x.to_string()).join(",") + "\n";
    "x,y,z,h,Temperature\n".to_owned() + &POINTS.iter().map(row).collect::<String>()
}

pub fn npy() -> Vec<u8> {
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 3), }\n";
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &little(&positions())].concat()
}

/// An unstructured grid of one triangle, of version 3: with a field before the points, cell data, and every kind of attribute.
pub fn vtk_text() -> String {
    format!(
        "# vtk DataFile Version 3.0\nthree points\nASCII\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTIME 1 1 double\n0.5\n\
         POINTS 3 float\n{}\n\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\nCELL_DATA 1\nSCALARS id int\nLOOKUP_TABLE default\n7\n\
         POINT_DATA 3\nSCALARS h float 1\nLOOKUP_TABLE default\n{}\nVECTORS v float\n1 2 3 4 5 6 7 8 9\n\
         FIELD FieldData 2\nTemperature 1 3 float\n{}\nkind%20of 1 3 vtktypeint64\n1 2 3\nMETADATA\nINFORMATION 0\n\n",
        words(&positions()),
        words(&column(3)),
        words(&column(4))
    )
}

/// Poly data of version 5.1, whose cells are in two parts.
pub fn vtk_binary() -> Vec<u8> {
    let mut file = b"# vtk DataFile Version 5.1\nthree points\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n".to_vec();
    file.extend(big(&positions()));
    file.extend(b"\nMETADATA\nINFORMATION 0\n\nVERTICES 2 3\nOFFSETS vtktypeint64\n");
    file.extend([0i64, 3].iter().flat_map(|i| i.to_be_bytes()));
    file.extend(b"\nCONNECTIVITY vtktypeint64\n");
    file.extend([0i64, 1, 2].iter().flat_map(|i| i.to_be_bytes()));
    file.extend(b"\nPOINT_DATA 3\nSCALARS h float\nLOOKUP_TABLE default\n");
    file.extend(big(&column(3)));
    file.extend(b"\nFIELD FieldData 1\nTemperature 1 3 float\n");
    file.extend(big(&column(4)));
    file.extend(b"\n");
    file
}

/// Storage of numbers in an XML file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stored {
    Ascii,
    Inline,
    AppendedBase64,
    AppendedRaw,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Packed {
    No,
    Zlib,
    Lz4,
}

/// An array as VTK packs it: pieces of 8 bytes where it is compressed, so that there are several, and a smaller one at the end. The header
/// apart from the data.
pub fn packed(bytes: &[u8], how: Packed, wide: bool, big: bool) -> (Vec<u8>, Vec<u8>) {
    const BLOCK: usize = 8;
    let word = |n: usize| {
        let mut word = if wide { (n as u64).to_le_bytes().to_vec() } else { (n as u32).to_le_bytes().to_vec() };
        if big {
            word.reverse();
        }
        word
    };
    if how == Packed::No {
        return (word(bytes.len()), bytes.to_vec());
    }
    let pack = |block: &[u8]| match how {
        Packed::Zlib => super::tiny::zlib(block),
        _ => lz4_flex::block::compress(block),
    };
    let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(pack).collect();
    let mut header = [word(blocks.len()), word(BLOCK), word(bytes.len() % BLOCK)].concat();
    blocks.iter().for_each(|block| header.extend(word(block.len())));
    (header, blocks.concat())
}

pub fn base64(header: &[u8], data: &[u8], how: Packed) -> String {
    // Only a header with sizes of blocks is a run of its own.
    match how {
        Packed::No => STANDARD.encode([header, data].concat()),
        _ => STANDARD.encode(header) + &STANDARD.encode(data),
    }
}

/// PolyData in two pieces and an empty one.
pub fn vtp(stored: Stored, how: Packed, wide: bool) -> Vec<u8> {
    let mut appended: Vec<u8> = Vec::new();
    let mut array = |name: &str, components: usize, numbers: &[f32]| {
        let bytes = little(numbers);
        let (header, data) = packed(&bytes, how, wide, false);
        let begin = format!("<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        match stored {
            Stored::Ascii => format!("{begin} format=\"ascii\">\n {}\n</DataArray>\n", words(numbers)),
            Stored::Inline => format!("{begin} format=\"binary\">\n {}\n</DataArray>\n", base64(&header, &data, how)),
            _ => {
                let offset = appended.len();
                match stored {
                    Stored::AppendedRaw => appended.extend([header, data].concat()),
                    _ => appended.extend(base64(&header, &data, how).bytes()),
                }
                format!(
                    "{begin} format=\"appended\" offset=\"{offset}\"><InformationKey name=\"x\">1</InformationKey></DataArray>\n"
                )
            }
        }
    };
    let mut pieces = String::new();
    for part in [0..2, 2..3, 3..3] {
        let positions = array("Points", 3, &positions()[3 * part.start..3 * part.end]);
        let h = array("h", 1, &column(3)[part.clone()]);
        let temperature = array("Temperature", 1, &column(4)[part.clone()]);
        pieces += &format!(
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\">\n<PointData>\n{h}{temperature}</PointData>\n<CellData/>\n\
             <Points>\n{positions}</Points>\n</Piece>\n",
            part.len(),
            part.len()
        );
    }
    let header = if wide { " header_type=\"UInt64\"" } else { "" };
    let compressor = match how {
        Packed::No => "",
        Packed::Zlib => " compressor=\"vtkZLibDataCompressor\"",
        Packed::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
    };
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"{header}{compressor}>\n\
         <PolyData>\n{pieces}</PolyData>\n"
    )
    .into_bytes();
    if !appended.is_empty() {
        let encoding = if stored == Stored::AppendedRaw { "raw" } else { "base64" };
        file.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").bytes());
        file.extend(&appended);
        file.extend(b"\n</AppendedData>\n");
    }
    file.extend(b"</VTKFile>\n");
    file
}

/// Every way to write that file.
pub fn all_vtp() -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("ascii".to_owned(), vtp(Stored::Ascii, Packed::No, false))];
    for stored in [Stored::Inline, Stored::AppendedBase64, Stored::AppendedRaw] {
        for how in [Packed::No, Packed::Zlib, Packed::Lz4] {
            for wide in [false, true] {
                files.push((format!("{stored:?} {how:?} {wide}"), vtp(stored, how, wide)));
            }
        }
    }
    files
}
