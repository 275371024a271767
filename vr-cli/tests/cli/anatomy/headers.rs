//! The phantom in formats of one header and its voxels.

use glam::{DMat3, DQuat, DVec3};

use super::phantom::Phantom;

/// Signs that turn RAS to LPS, and back.
pub const LPS: DVec3 = DVec3::new(-1.0, -1.0, 1.0);
const LAS: DVec3 = DVec3::new(-1.0, 1.0, 1.0);

fn numbers(numbers: impl IntoIterator<Item = f64>, separator: &str) -> String {
    numbers.into_iter().map(|x| x.to_string()).collect::<Vec<_>>().join(separator)
}

/// An NRRD file with this `space`; a space of time has an axis of it, of one frame.
pub fn nrrd(phantom: &Phantom, space: &str) -> Vec<u8> {
    let lower = space.to_lowercase();
    let signs = match lower.as_str() {
        "lps" | "left-posterior-superior" => LPS,
        "las" | "left-anterior-superior" => LAS,
        _ => DVec3::ONE,
    };
    let timed = lower.ends_with("time") || lower == "rast";
    let vector = |v: DVec3, time: f64| {
        let v = (signs * v).to_array();
        format!("({})", numbers(v.into_iter().chain(timed.then_some(time)), ","))
    };
    let [x, y, z] = [0, 1, 2].map(|i| vector(phantom.axes.col(i), 0.0));
    let last = if timed { format!(" {}", vector(DVec3::ZERO, 1.0)) } else { String::new() };
    let sizes = numbers(phantom.dims.map(|n| n as f64).into_iter().chain(timed.then_some(1.0)), " ");
    let mut file = format!(
        "NRRD0005\ntype: int16\ndimension: {}\nspace: {space}\nsizes: {sizes}\nspace directions: {x} {y} {z}{last}\n\
         kinds: domain domain domain{}\nendian: little\nencoding: raw\nspace origin: {}\n\n",
        if timed { 4 } else { 3 },
        if timed { " time" } else { "" },
        vector(phantom.origin, 0.0),
    )
    .into_bytes();
    file.extend(phantom.bytes());
    file
}

/// Transforms that a NIfTI header has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forms {
    /// True if the sform is there.
    pub sform: bool,
    pub qform: Qform,
    /// Value of `pixdim[0]` of a grid that is no mirror image; one that is has −1 in any case.
    pub qfac: f32,
}

/// The qform of a NIfTI header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Qform {
    None,
    /// Its own.
    Right,
    /// One that places the volume elsewhere: the sform counts.
    Elsewhere,
}

/// A NIfTI-1 file.
pub fn nifti(phantom: &Phantom, forms: Forms) -> Vec<u8> {
    let mut file = vec![0; 352];
    let mut put = |offset: usize, bytes: &[u8]| file[offset..offset + bytes.len()].copy_from_slice(bytes);
    let float = |x: f64| (x as f32).to_le_bytes();
    put(0, &348i32.to_le_bytes());
    for (i, n) in [3].into_iter().chain(phantom.dims).chain([1; 4]).enumerate() {
        put(40 + 2 * i, &(n as i16).to_le_bytes());
    }
    // 16-bit integers; mm.
    put(70, &4i16.to_le_bytes());
    put(72, &16i16.to_le_bytes());
    put(108, &float(352.0));
    put(112, &float(1.0));
    put(123, &[2]);
    put(344, b"n+1\0");

    let mut directions = phantom.directions();
    let mirrored = directions.determinant() < 0.0;
    if mirrored {
        directions.z_axis = -directions.z_axis;
    }
    put(76, &if mirrored { -1.0 } else { forms.qfac }.to_le_bytes());
    for (i, step) in phantom.spacing().to_array().into_iter().enumerate() {
        put(80 + 4 * i, &float(step));
    }
    if forms.qform != Qform::None {
        put(252, &1i16.to_le_bytes());
        let turn = DQuat::from_mat3(&directions);
        // The real part is not written, and not negative.
        let turn = if turn.w < 0.0 { -turn } else { turn };
        for (i, part) in [turn.x, turn.y, turn.z].into_iter().enumerate() {
            put(256 + 4 * i, &float(if forms.qform == Qform::Right { part } else { 0.0 }));
        }
        for (i, place) in phantom.origin.to_array().into_iter().enumerate() {
            put(268 + 4 * i, &float(place));
        }
    }
    if forms.sform {
        put(254, &2i16.to_le_bytes());
        let rows = phantom.axes.transpose();
        for row in 0..3 {
            let numbers = rows.col(row).to_array().into_iter().chain([phantom.origin[row]]);
            for (i, number) in numbers.enumerate() {
                put(280 + 16 * row + 4 * i, &float(number));
            }
        }
    }
    file.extend(phantom.bytes());
    file
}

/// A MetaImage file; these fields tell the directions.
pub fn metaimage(phantom: &Phantom, fields: &str) -> Vec<u8> {
    let mut file = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n{fields}\n\
         Offset = {}\nCenterOfRotation = 0 0 0\nElementSpacing = {}\nDimSize = {}\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
        numbers((LPS * phantom.origin).to_array(), " "),
        numbers(phantom.spacing().to_array(), " "),
        numbers(phantom.dims.map(|n| n as f64), " "),
    )
    .into_bytes();
    file.extend(phantom.bytes());
    file
}

/// The field of a MetaImage file that tells directions by numbers.
pub fn transform_matrix(phantom: &Phantom) -> String {
    // One axis a line, in LPS.
    let rows = DMat3::from_diagonal(LPS) * phantom.directions();
    format!("TransformMatrix = {}", numbers(rows.to_cols_array(), " "))
}

/// A VTK image, appended raw. VTK knows no patients: its world is the patient's by agreement.
pub fn vti(phantom: &Phantom) -> Vec<u8> {
    let extent = phantom.dims.map(|n| format!("0 {}", n - 1)).join(" ");
    // Row by row.
    let direction = numbers(phantom.directions().transpose().to_cols_array(), " ");
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{direction}\">\n<Piece Extent=\"{extent}\">\n\
         <PointData Scalars=\"v\"><DataArray type=\"Int16\" Name=\"v\" format=\"appended\" offset=\"0\"/></PointData>\n\
         </Piece></ImageData>\n<AppendedData encoding=\"raw\">\n_",
        numbers(phantom.origin.to_array(), " "),
        numbers(phantom.spacing().to_array(), " "),
    )
    .into_bytes();
    let voxels = phantom.bytes();
    file.extend((voxels.len() as u32).to_le_bytes());
    file.extend(voxels);
    file.extend(b"\n</AppendedData></VTKFile>\n");
    file
}

/// An MRC file of mode 1, whose columns, rows and sections run along these axes of the cell, from 0; of a phantom that is upright.
pub fn mrc(phantom: &Phantom, along: [usize; 3]) -> Vec<u8> {
    let mut file = vec![0; 1024];
    let mut put = |word: usize, bytes: [u8; 4]| file[4 * word..4 * word + 4].copy_from_slice(&bytes);
    let spacing = phantom.spacing();
    for i in 0..3 {
        put(i, (phantom.dims[i] as i32).to_le_bytes());
        put(16 + i, (along[i] as i32 + 1).to_le_bytes());
        // Intervals and lengths of the cell are those of its own axes.
        put(7 + along[i], (phantom.dims[i] as i32).to_le_bytes());
        put(10 + along[i], ((spacing[i] * phantom.dims[i] as f64) as f32).to_le_bytes());
        put(13 + i, 90f32.to_le_bytes());
        put(49 + i, (phantom.origin[i] as f32).to_le_bytes());
    }
    put(3, 1i32.to_le_bytes());
    put(22, 1i32.to_le_bytes());
    put(27, 20140i32.to_le_bytes());
    put(52, *b"MAP ");
    put(53, [0x44, 0x44, 0, 0]);
    file.extend(phantom.bytes());
    file
}
