//! The phantom as DICOM slices.

use std::path::Path;

use super::headers::LPS;
use super::phantom::Phantom;

/// Order of the slices of a series, by number and name of file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Along the third axis.
    Forward,
    /// Against it.
    Backward,
    /// Every third one, then those between.
    Mixed,
}

/// Writes a folder of slices, one for each step of the third axis.
pub fn write(folder: &Path, phantom: &Phantom, order: Order) {
    std::fs::create_dir(folder).unwrap();
    let [columns, rows, slices] = phantom.dims;
    for slice in 0..slices {
        let number = match order {
            Order::Forward => slice,
            Order::Backward => slices - 1 - slice,
            Order::Mixed => slice % 3 * slices + slice / 3,
        };
        let position = LPS * (phantom.origin + phantom.axes.z_axis * slice as f64);
        let directions = phantom.directions();
        let orientation = [directions.x_axis, directions.y_axis].map(|d| (LPS * d).to_array()).concat();
        let spacing = phantom.spacing();
        let count = columns * rows;
        let voxels: Vec<u8> =
            phantom.values[slice * count..(slice + 1) * count].iter().flat_map(|v| v.to_le_bytes()).collect();
        let short = |n: usize| (n as u16).to_le_bytes().to_vec();
        let elements = [
            (0x0008_0018, "UI", format!("1.2.3.{}", slice + 1).into_bytes()),
            (0x0008_0060, "CS", b"MR".to_vec()),
            (0x0020_000e, "UI", b"1.2.3".to_vec()),
            (0x0020_0013, "IS", (number + 1).to_string().into_bytes()),
            (0x0020_0032, "DS", decimals(&position.to_array())),
            (0x0020_0037, "DS", decimals(&orientation)),
            (0x0028_0002, "US", short(1)),
            (0x0028_0004, "CS", b"MONOCHROME2".to_vec()),
            (0x0028_0010, "US", short(rows)),
            (0x0028_0011, "US", short(columns)),
            // Between rows first.
            (0x0028_0030, "DS", decimals(&[spacing.y, spacing.x])),
            (0x0028_0100, "US", short(16)),
            (0x0028_0101, "US", short(16)),
            (0x0028_0102, "US", short(15)),
            (0x0028_0103, "US", short(1)),
            (0x7fe0_0010, "OW", voxels),
        ];
        let mut file = vec![0; 128];
        file.extend(b"DICM");
        let syntax = element(0x0002_0010, "UI", b"1.2.840.10008.1.2.1".to_vec());
        file.extend(element(0x0002_0000, "UL", (syntax.len() as u32).to_le_bytes().to_vec()));
        file.extend(syntax);
        for (tag, kind, value) in elements {
            file.extend(element(tag, kind, value));
        }
        std::fs::write(folder.join(format!("{number:03}.dcm")), file).unwrap();
    }
}

/// Decimal strings of at most 16 characters, as the standard asks for.
fn decimals(numbers: &[f64]) -> Vec<u8> {
    let word = |x: &f64| {
        let exact = x.to_string();
        if exact.len() <= 16 { exact } else { format!("{x:.12}") }
    };
    numbers.iter().map(word).collect::<Vec<_>>().join("\\").into_bytes()
}

fn element(tag: u32, kind: &str, mut value: Vec<u8>) -> Vec<u8> {
    if value.len() % 2 == 1 {
        value.push(if kind == "UI" { 0 } else { b' ' });
    }
    let mut bytes = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes).concat();
    bytes.extend(kind.as_bytes());
    if kind == "OW" {
        bytes.extend([0, 0]);
        bytes.extend((value.len() as u32).to_le_bytes());
    } else {
        bytes.extend((value.len() as u16).to_le_bytes());
    }
    bytes.extend(value);
    bytes
}
