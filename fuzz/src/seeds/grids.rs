//! Grids of 4×3×2 numbers.

use crate::tiny;
use crate::tiny::{i16_bytes, join, metaimage as mha, nifti_1, nifti_2, nrrd as nrrd_file, zlib};

use super::kept;

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    tiny::gzip(bytes)
}

pub fn nrrd() -> Vec<Vec<u8>> {
    let placed = "type: short\nendian: little\nencoding: raw\nspace: left-posterior-superior\n\
                  space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nkinds: domain domain domain";
    let spaced =
        "type: short\nendian: big\nencoding: gzip\nspacings: 1 2 3\naxis mins: 0 0 0\nunits: \"mm\" \"mm\" \"um\"";
    let text: String = (0..24).map(|i| format!("{i} ")).collect();
    vec![
        nrrd_file(placed, &i16_bytes(false)),
        nrrd_file(spaced, &tiny::gzip(&i16_bytes(true))),
        nrrd_file("type: short\nendian: big\nencoding: bzip2", &tiny::bzip2(&i16_bytes(true))),
        nrrd_file("type: double\nencoding: ascii\nline skip: 0\nbyte skip: 0", text.as_bytes()),
        nrrd_file("type: uchar\nencoding: raw\ndata file: x%02d.raw 1 4 1", b""),
    ]
}

pub fn metaimage() -> Vec<Vec<u8>> {
    let fields = "ElementType = MET_SHORT\nElementSpacing = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n\
                  BinaryDataByteOrderMSB = False\nHeaderSize = 0\nElementNumberOfChannels = 1";
    let packed = "ElementType = MET_SHORT\nCompressedData = True";
    vec![mha(fields, "LOCAL", &i16_bytes(false)), mha(packed, "LOCAL", &zlib(&i16_bytes(false)))]
}

pub fn nifti() -> Vec<Vec<u8>> {
    vec![join(nifti_1(false, b"n+1\0"), &i16_bytes(false)), join(nifti_2(true), &i16_bytes(true))]
}

/// Damaged as they are packed.
pub fn packed() -> Vec<Vec<u8>> {
    nifti().iter().map(|file| gzip(file)).collect()
}

pub fn mrc() -> Vec<Vec<u8>> {
    let mut map = vec![0u8; 1024];
    for (i, n) in [4i32, 3, 2, 1, 0, 0, 0, 4, 3, 2].into_iter().enumerate() {
        map[4 * i..4 * i + 4].copy_from_slice(&n.to_le_bytes());
    }
    for i in 0..3 {
        map[40 + 4 * i..][..4].copy_from_slice(&9f32.to_le_bytes());
        map[52 + 4 * i..][..4].copy_from_slice(&80f32.to_le_bytes());
        map[64 + 4 * i] = i as u8 + 1;
    }
    map[208..216].copy_from_slice(b"MAP \x44\x44\0\0");
    vec![join(map, &i16_bytes(false))]
}

pub fn pvm() -> Vec<Vec<u8>> {
    // 24 steps of 0 after the header's own bytes would do; the packed one ends in its middle.
    let packed = b"DDS v3d\n\x00\x00\x00\x2a\x75\x28\x13\x77\x91\x3b\x5c\x00".to_vec();
    vec![join(b"PVM2\n4 3 2\n1 2 3\n2\n".to_vec(), &i16_bytes(true)), packed]
}

pub fn slc() -> Vec<Vec<u8>> {
    let slices = [b"7 X\x0c\x09\x00....".as_slice(), b"15 X\x8cabcdefghijkl\x00."].concat();
    vec![join(b"11111\n4 3 2 8\n1 1 1\n0 0 0 1\n1 1 Xpic".to_vec(), &slices)]
}

pub fn npy() -> Vec<Vec<u8>> {
    let header = "{'descr': '<i2', 'fortran_order': True, 'shape': (2, 3, 4), }\n";
    let head = [b"\x93NUMPY\x01\0", (header.len() as u16).to_le_bytes().as_slice(), header.as_bytes()].concat();
    vec![join(head, &i16_bytes(false))]
}

pub fn dx_general() -> Vec<Vec<u8>> {
    vec![join(b"grid = 4x3x2\nformat = lsb binary\ntype = short\nend\n".to_vec(), &i16_bytes(false))]
}

pub fn dx() -> Vec<Vec<u8>> {
    let grid = "object 1 class gridpositions counts 4 3 2\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\ndelta 0 0 1\n\
                object 3 class array type float rank 0 items 24 data follows\n";
    let numbers: String = (0..24).map(|i| format!("{i}.5 ")).collect();
    vec![join(grid.into(), numbers.as_bytes())]
}

pub fn vvd() -> Vec<Vec<u8>> {
    let text = "<VoreenData version=\"1\"><Volumes><Volume><RawData filename=\"a.raw\" format=\"int16\" x=\"4\" y=\"3\" z=\"2\" />\
                <MetaData><MetaItem name=\"Spacing\"><value x=\"1\" y=\"2\" z=\"3\" /></MetaItem></MetaData></Volume></Volumes></VoreenData>";
    vec![text.into()]
}

pub fn dat() -> Vec<Vec<u8>> {
    vec![b"ObjectFileName: a.raw\nResolution: 4 3 2\nSliceThickness: 1 2 3\nFormat: SHORT\n".to_vec()]
}

pub fn netcdf() -> Vec<Vec<u8>> {
    vec![kept("small_grids/cf.nc")]
}

pub fn hdf5() -> Vec<Vec<u8>> {
    vec![kept("small_grids/grids.h5")]
}

/// A slice of 4×3 numbers in explicit little-endian, with the elements that place it.
pub fn dicom() -> Vec<Vec<u8>> {
    fn element(group: u16, number: u16, kind: &[u8; 2], value: &[u8]) -> Vec<u8> {
        let mut value = value.to_vec();
        value.resize(value.len().next_multiple_of(2), b' ');
        let mut bytes = [group.to_le_bytes(), number.to_le_bytes()].concat();
        bytes.extend(kind);
        match kind {
            b"OB" | b"OW" => {
                bytes.extend([0, 0]);
                bytes.extend((value.len() as u32).to_le_bytes());
            }
            _ => bytes.extend((value.len() as u16).to_le_bytes()),
        }
        [bytes, value].concat()
    }
    let short = |n: u16| n.to_le_bytes();
    let syntax = element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1\0");
    let meta = [element(2, 0, b"UL", &(syntax.len() as u32).to_le_bytes()), syntax].concat();
    let slice = [
        element(8, 0x16, b"UI", b"1.2.840.10008.5.1.4.1.1.2\0"),
        element(8, 0x60, b"CS", b"CT"),
        element(0x20, 0xd, b"UI", b"1.2.3.4\0"),
        element(0x20, 0xe, b"UI", b"1.2.3.5\0"),
        element(0x20, 0x32, b"DS", b"0\\0\\7"),
        element(0x20, 0x37, b"DS", b"1\\0\\0\\0\\1\\0"),
        element(0x28, 2, b"US", &short(1)),
        element(0x28, 4, b"CS", b"MONOCHROME2"),
        element(0x28, 0x10, b"US", &short(3)),
        element(0x28, 0x11, b"US", &short(4)),
        element(0x28, 0x30, b"DS", b"0.5\\0.5"),
        element(0x28, 0x100, b"US", &short(16)),
        element(0x28, 0x101, b"US", &short(12)),
        element(0x28, 0x102, b"US", &short(11)),
        element(0x28, 0x103, b"US", &short(0)),
        element(0x28, 0x1052, b"DS", b"-1024"),
        element(0x28, 0x1053, b"DS", b"1"),
        element(0x7fe0, 0x10, b"OW", &i16_bytes(false)[..24]),
    ]
    .concat();
    vec![[vec![0; 128], b"DICM".to_vec(), meta, slice].concat()]
}

/// The description of an array whose chunks are all absent, and count as zero.
pub fn zarr() -> Vec<Vec<u8>> {
    let array = r#"{"zarr_format": 3, "node_type": "array", "shape": [2, 3, 4], "data_type": "int16",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 3, 4]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}, "fill_value": 0,
        "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "gzip", "configuration": {"level": 5}}]}"#;
    vec![array.into()]
}
