//! Small images of VTK in every form: the voxels of `tiny`, as the scalars "density stored" beside a vector and an array of cells.
#![allow(dead_code, reason = "each test file uses its part")]

use crate::small_points::{Packed, Stored, base64, packed};
use crate::tiny::{COUNT, i16_bytes, sample};

/// Three numbers for each point, of which the second is that of the scalars times 10.
pub fn vectors() -> Vec<f32> {
    (0..COUNT).flat_map(|i| [i as f32, (sample(i) * 10) as f32, -0.5]).collect()
}

fn floats(numbers: &[f32], big: bool) -> Vec<u8> {
    numbers.iter().flat_map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() }).collect()
}

fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|x| x.to_string() + " ").collect()
}

fn scalar_words() -> String {
    words((0..COUNT).map(sample))
}

/// An array of a .vti file.
pub struct Array<'a> {
    pub begin: &'a str,
    pub bytes: Vec<u8>,
    pub words: String,
}

/// Pieces of a .vti file: an extent, arrays of points, arrays of cells.
pub type Piece<'a> = (&'a str, Vec<Array<'a>>, Vec<Array<'a>>);

/// A .vti file of any form: the attributes of its image, and its pieces.
pub fn vti_of(image: &str, pieces: &[Piece<'_>], stored: Stored, how: Packed, wide: bool, big: bool) -> Vec<u8> {
    let mut appended: Vec<u8> = Vec::new();
    let mut array = |a: &Array<'_>| {
        let (header, data) = packed(&a.bytes, how, wide, big);
        let begin = a.begin;
        match stored {
            Stored::Ascii => format!("<DataArray {begin} format=\"ascii\">\n {}\n</DataArray>\n", a.words),
            Stored::Inline => format!(
                "<DataArray {begin} format=\"binary\">\n<InformationKey name=\"x\">1</InformationKey>\n {}\n</DataArray>\n",
                base64(&header, &data, how)
            ),
            _ => {
                let offset = appended.len();
                match stored {
                    Stored::AppendedRaw => appended.extend([header, data].concat()),
                    _ => appended.extend(base64(&header, &data, how).bytes()),
                }
                format!("<DataArray {begin} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    };
    let mut text = String::new();
    for (extent, points, cells) in pieces {
        let points: String = points.iter().map(&mut array).collect();
        let cells: String = cells.iter().map(&mut array).collect();
        text += &format!(
            "<Piece Extent=\"{extent}\">\n<PointData Scalars=\"density stored\">\n{points}</PointData>\n\
             <CellData>\n{cells}</CellData>\n</Piece>\n"
        );
    }
    let order = if big { "BigEndian" } else { "LittleEndian" };
    let header = if wide { " header_type=\"UInt64\"" } else { "" };
    let compressor = match how {
        Packed::No => "",
        Packed::Zlib => " compressor=\"vtkZLibDataCompressor\"",
        Packed::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
    };
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{order}\"{header}{compressor}>\n\
         <ImageData {image}>\n{text}</ImageData>\n"
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

/// The arrays of the points: a vector, and the scalars.
pub fn point_arrays(big: bool) -> Vec<Array<'static>> {
    vec![
        Array {
            begin: "type=\"Float32\" Name=\"velocity\" NumberOfComponents=\"3\"",
            bytes: floats(&vectors(), big),
            words: words(vectors()),
        },
        Array { begin: "type=\"Int16\" Name=\"density stored\"", bytes: i16_bytes(big), words: scalar_words() },
    ]
}

pub const IMAGE: &str =
    "WholeExtent=\"0 3 0 2 0 1\" Origin=\"1 2 3\" Spacing=\"0.5 1 2\" Direction=\"1 0 0 0 1 0 0 0 1\"";

/// The image of `tiny`, in one piece.
pub fn vti(stored: Stored, how: Packed, wide: bool, big: bool) -> Vec<u8> {
    let piece = ("0 3 0 2 0 1", point_arrays(big), Vec::new());
    vti_of(IMAGE, &[piece], stored, how, wide, big)
}

/// Every way to write that file.
pub fn all_vti() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for big in [false, true] {
        files.push((format!("ascii {big}"), vti(Stored::Ascii, Packed::No, false, big)));
        for stored in [Stored::Inline, Stored::AppendedBase64, Stored::AppendedRaw] {
            for how in [Packed::No, Packed::Zlib, Packed::Lz4] {
                for wide in [false, true] {
                    files.push((format!("{stored:?} {how:?} {wide} {big}"), vti(stored, how, wide, big)));
                }
            }
        }
    }
    files
}

/// A legacy file of the image of `tiny`: a vector, the scalars, and a field; with a field of the whole file, cell data, and metadata.
pub fn vtk(binary: bool) -> Vec<u8> {
    let form = if binary { "BINARY" } else { "ASCII" };
    let mut file = format!(
        "# vtk DataFile Version 5.1\n\n{form}\nDATASET STRUCTURED_POINTS\nFIELD FieldData 1\nTIME 1 1 double\n"
    )
    .into_bytes();
    let put = |file: &mut Vec<u8>, line: &str, bytes: &[u8], words: &str| {
        file.extend(line.bytes());
        file.extend(if binary { bytes } else { words.as_bytes() });
        file.push(b'\n');
    };
    put(&mut file, "", &0.5f64.to_be_bytes(), "0.5");
    file.extend(b"DIMENSIONS 4 3 2\nSPACING 0.5 1 2\nORIGIN 1 2 3\n");
    put(&mut file, "CELL_DATA 6\nSCALARS level unsigned_char\nLOOKUP_TABLE default\n", &[9; 6], &"9 ".repeat(6));
    put(&mut file, "POINT_DATA 24\nVECTORS velocity float\n", &floats(&vectors(), true), &words(vectors()));
    file.extend(b"METADATA\nINFORMATION 0\n\n");
    put(&mut file, "SCALARS density%20stored short 1\nLOOKUP_TABLE default\n", &i16_bytes(true), &scalar_words());
    let bytes: Vec<u8> = (0..COUNT as u8).collect();
    put(&mut file, "FIELD FieldData 2\nindex 1 24 unsigned_char\n", &bytes, &words(&bytes));
    put(&mut file, "even 1 24 bit\n", &[0b1010_1010; 3], &"1 0 ".repeat(12));
    file
}

/// A file of each kind.
pub fn few() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.vti", vti(Stored::Ascii, Packed::No, false, false)),
        ("b.vti", vti(Stored::Inline, Packed::Zlib, true, true)),
        ("c.vti", vti(Stored::AppendedBase64, Packed::No, false, false)),
        ("d.vti", vti(Stored::AppendedRaw, Packed::Lz4, false, false)),
        ("e.vti", vti(Stored::AppendedRaw, Packed::No, true, false)),
        ("f.vti", halves()),
        ("g.vtk", vtk(false)),
        ("h.vtk", vtk(true)),
    ]
}

/// The image of `tiny` in two pieces that share the points of x = 2, and an empty one.
pub fn halves() -> Vec<u8> {
    let part = |from: usize, to: usize| {
        let places = (0..COUNT).filter(|i| (from..=to).contains(&(i % 4)));
        let numbers: Vec<i64> = places.map(sample).collect();
        let bytes = numbers.iter().flat_map(|&n| (n as i16).to_le_bytes()).collect();
        vec![Array { begin: "type=\"Int16\" Name=\"density stored\"", bytes, words: words(numbers) }]
    };
    let pieces = [
        ("12 13 0 2 0 1", part(2, 3), Vec::new()),
        ("0 -1 0 -1 0 -1", Vec::new(), Vec::new()),
        ("10 12 0 2 0 1", part(0, 2), Vec::new()),
    ];
    vti_of("WholeExtent=\"10 13 0 2 0 1\"", &pieces, Stored::AppendedRaw, Packed::Zlib, false, false)
}
