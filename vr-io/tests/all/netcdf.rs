//! NetCDF's classic formats: fixed variables and records, packed numbers, coordinates, and files that lie.

use std::path::PathBuf;

use glam::DVec3;
use vr_core::{Calibration, Voxel, with_grid};
use vr_io::{Loaded, ReadOptions, read};

/// z, y, x.
const SIZES: [usize; 3] = [3, 4, 5];

/// A classic file, written as one of the three versions.
struct Writer {
    version: u8,
    header: Vec<u8>,
}

impl Writer {
    fn new(version: u8) -> Self {
        Self { version, header: Vec::new() }
    }

    fn word(&mut self, n: u32) -> &mut Self {
        self.header.extend(n.to_be_bytes());
        self
    }

    fn size(&mut self, n: u64) -> &mut Self {
        if self.version == 5 {
            self.header.extend(n.to_be_bytes());
            return self;
        }
        self.word(n as u32)
    }

    fn padded(&mut self, bytes: &[u8]) -> &mut Self {
        self.header.extend(bytes);
        self.header.resize(self.header.len().next_multiple_of(4), 0);
        self
    }

    fn name(&mut self, name: &str) -> &mut Self {
        self.size(name.len() as u64).padded(name.as_bytes())
    }

    fn attributes(&mut self, attributes: &[(&str, Value)]) -> &mut Self {
        self.word(if attributes.is_empty() { 0 } else { 12 }).size(attributes.len() as u64);
        for (name, value) in attributes {
            self.name(name);
            match value {
                Value::Text(text) => self.word(2).size(text.len() as u64).padded(text.as_bytes()),
                Value::Short(n) => self.word(3).size(1).padded(&n.to_be_bytes()),
                Value::Double(x) => self.word(6).size(1).padded(&x.to_be_bytes()),
            };
        }
        self
    }
}

enum Value {
    Text(&'static str),
    Short(i16),
    Double(f64),
}

/// A variable: name, dimensions, attributes, nc_type, and its bytes; of a record variable those of each record.
struct Variable {
    name: &'static str,
    dimensions: Vec<u64>,
    attributes: Vec<(&'static str, Value)>,
    kind: u32,
    records: Vec<Vec<u8>>,
}

/// Puts a file together: dimensions by name and size (0 counts records), then the variables.
fn file(version: u8, dimensions: &[(&str, usize)], variables: &[Variable], count: u32) -> Vec<u8> {
    let is_record = |v: &Variable| v.dimensions.first().is_some_and(|&d| dimensions[d as usize].1 == 0);
    let records: Vec<&Variable> = variables.iter().filter(|v| is_record(v)).collect();
    let header = |begins: &[u64]| {
        let mut w = Writer::new(version);
        w.header.extend([b'C', b'D', b'F', version]);
        let count = if version == 5 && count == u32::MAX { u64::MAX } else { u64::from(count) };
        w.size(count).word(10).size(dimensions.len() as u64);
        for (name, size) in dimensions {
            w.name(name).size(*size as u64);
        }
        w.attributes(&[("title", Value::Text("made by a test"))]);
        w.word(11).size(variables.len() as u64);
        for (variable, begin) in variables.iter().zip(begins) {
            w.name(variable.name).size(variable.dimensions.len() as u64);
            for &dimension in &variable.dimensions {
                w.size(dimension);
            }
            w.attributes(&variable.attributes).word(variable.kind).size(variable.records[0].len() as u64);
            if version == 1 {
                w.word(*begin as u32)
            } else {
                w.header.extend(begin.to_be_bytes());
                &mut w
            };
        }
        w.header
    };
    // The header is as long whatever the places are.
    let mut end = header(&vec![0; variables.len()]).len() as u64;
    let padded = |n: usize| if records.len() == 1 { n as u64 } else { n.next_multiple_of(4) as u64 };
    let mut begins = vec![0; variables.len()];
    for fixed in [true, false] {
        for (variable, begin) in variables.iter().zip(&mut begins).filter(|(v, _)| is_record(v) != fixed) {
            *begin = end;
            end += if fixed {
                variable.records[0].len().next_multiple_of(4) as u64
            } else {
                padded(variable.records[0].len())
            };
        }
    }
    let mut bytes = header(&begins);
    for variable in variables.iter().filter(|v| !is_record(v)) {
        bytes.extend(&variable.records[0]);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    for record in 0..records.first().map_or(0, |v| v.records.len()) {
        for variable in &records {
            let start = bytes.len();
            bytes.extend(&variable.records[record]);
            bytes.resize(start + padded(variable.records[record].len()) as usize, 0);
        }
    }
    bytes
}

fn numbers() -> impl Iterator<Item = i16> {
    (0..SIZES.iter().product::<usize>()).map(|i| (i * 7 % 251) as i16)
}

fn shorts(add: i16) -> Vec<u8> {
    numbers().flat_map(|n| (n + add).to_be_bytes()).collect()
}

fn line(count: usize, first: f32, step: f32) -> Vec<Vec<u8>> {
    vec![(0..count).flat_map(|i| (first + step * i as f32).to_be_bytes()).collect()]
}

fn coordinate(name: &'static str, dimension: u64, unit: &'static str, first: f32, step: f32) -> Variable {
    let size = SIZES[dimension as usize - 1];
    let attributes = vec![("units", Value::Text(unit))];
    Variable { name, dimensions: vec![dimension], attributes, kind: 5, records: line(size, first, step) }
}

const DIMENSIONS: [(&str, usize); 4] = [("time", 0), ("z", 3), ("y", 4), ("x", 5)];

fn put(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.nc");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn load(bytes: &[u8], options: &ReadOptions) -> Loaded {
    let (_folder, path) = put(bytes);
    read(path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(bytes: &[u8], options: &ReadOptions) -> String {
    let (_folder, path) = put(bytes);
    read(path, options).unwrap_err().to_string()
}

fn values(loaded: &Loaded) -> Vec<f64> {
    let grid = loaded.volume.grid().unwrap();
    with_grid!(grid.values(), g => g.samples().iter().map(|v| grid.calibration().value(v.to_f32().into())).collect())
}

/// Two frames of packed numbers between records of another variable, and a field without time.
fn weather(version: u8, count: u32) -> Vec<u8> {
    let variables = [
        coordinate("z", 1, "m", 10.0, 20.0),
        coordinate("y", 2, "m", 3.0, -0.5),
        coordinate("x", 3, "km", 0.0, 0.25),
        Variable { name: "odd", dimensions: vec![0], attributes: vec![], kind: 1, records: vec![vec![1], vec![2]] },
        Variable {
            name: "temperature",
            dimensions: vec![0, 1, 2, 3],
            attributes: vec![
                ("scale_factor", Value::Double(0.5)),
                ("add_offset", Value::Double(273.0)),
                ("_FillValue", Value::Short(7)),
            ],
            kind: 3,
            records: vec![shorts(0), shorts(1000)],
        },
        Variable { name: "rho", dimensions: vec![1, 2, 3], attributes: vec![], kind: 3, records: vec![shorts(-100)] },
    ];
    file(version, &DIMENSIONS, &variables, count)
}

#[test]
fn every_version_gives_frames_calibration_and_places() {
    for version in [1, 2, 5] {
        for count in [2, u32::MAX] {
            let options = ReadOptions { array: Some("temperature".into()), frame: Some(1), ..Default::default() };
            let loaded = load(&weather(version, count), &options);
            let grid = loaded.volume.grid().unwrap();
            assert_eq!((grid.dims(), loaded.info.frames), ([5, 4, 3], 2));
            assert_eq!(grid.calibration(), Calibration { slope: 0.5, intercept: 273.0 });
            let expected: Vec<f64> = numbers().map(|n| 0.5 * f64::from(n + 1000) + 273.0).collect();
            assert_eq!(values(&loaded), expected);
            // Units are brought to that of x; y runs backwards.
            assert_eq!(grid.placement().origin(), DVec3::new(0.0, 0.003, 0.01));
            assert_eq!(grid.placement().axes().y_axis, DVec3::new(0.0, -0.0005, 0.0));
            assert_eq!((loaded.info.units.as_deref(), loaded.info.placed_by), (Some("km"), "coordinates"));
        }
        // The fill value is there in the first frame.
        let options = ReadOptions { array: Some("temperature".into()), ..Default::default() };
        let loaded = load(&weather(version, 2), &options);
        let missing: Vec<usize> = (0..60).filter(|&i| values(&loaded)[i].is_nan()).collect();
        assert_eq!(missing, numbers().enumerate().filter(|(_, n)| *n == 7).map(|(i, _)| i).collect::<Vec<_>>());
        assert!(!missing.is_empty() && loaded.notes.iter().any(|n| n.contains("NaN")), "{:?}", loaded.notes);
    }
}

#[test]
fn the_largest_variable_is_taken_and_the_others_are_named() {
    let loaded = load(&weather(2, 2), &ReadOptions::default());
    assert_eq!(loaded.info.frames, 2);
    let notes = loaded.notes.join("; ");
    assert!(notes.contains("of 2 variables that are volumes temperature is taken"), "{notes}");
    assert!(notes.contains("rho (3×4×5)") && notes.contains("frame 0 is taken, of 0 to 1"), "{notes}");
    let options = ReadOptions { array: Some("rho".into()), ..Default::default() };
    let rho = load(&weather(2, 2), &options);
    assert_eq!(values(&rho), numbers().map(|n| f64::from(n - 100)).collect::<Vec<_>>());
    assert_eq!(rho.info.scalar, vr_io::ScalarType::I16);
    let options = ReadOptions { array: Some("pressure".into()), ..Default::default() };
    let message = refused(&weather(2, 2), &options);
    assert!(message.contains("array: found pressure; the file has temperature (2×3×4×5), rho (3×4×5)"), "{message}");
}

#[test]
fn one_record_variable_of_bytes_is_not_padded() {
    let records = (0..3u8).map(|t| (0..15).map(|i| 20 * t + i).collect()).collect();
    let variable = Variable { name: "v", dimensions: vec![0, 1, 2], attributes: vec![], kind: 1, records };
    let loaded = load(&file(1, &[("time", 0), ("y", 3), ("x", 5)], &[variable], 3), &ReadOptions::default());
    assert_eq!(loaded.volume.grid().unwrap().dims(), [5, 3, 3]);
    let expected: Vec<f64> = (0..3).flat_map(|t| (0..15).map(move |i| f64::from(20 * t + i))).collect();
    assert_eq!(values(&loaded), expected);
    assert!(loaded.notes.iter().any(|n| n.contains("time is shown as the third")), "{:?}", loaded.notes);
}

#[test]
fn degrees_and_pressures_give_directions_alone() {
    let dimensions = [("none", 0), ("plev", 3), ("lat", 4), ("lon", 5)];
    let mut pressure = coordinate("plev", 1, "hPa", 1000.0, -300.0);
    pressure.attributes.push(("positive", Value::Text("down")));
    let variables = [
        pressure,
        coordinate("lat", 2, "degrees_north", 90.0, -10.0),
        coordinate("lon", 3, "degrees_east", 0.0, 10.0),
        Variable {
            name: "u",
            dimensions: vec![1, 2, 3],
            attributes: vec![("_Unsigned", Value::Text("true"))],
            kind: 3,
            records: vec![shorts(-1)],
        },
    ];
    let loaded = load(&file(2, &dimensions, &variables, 0), &ReadOptions::default());
    let axes = loaded.volume.grid().unwrap().placement().axes();
    assert_eq!([axes.x_axis, axes.y_axis, axes.z_axis], [DVec3::X, DVec3::NEG_Y, DVec3::Z]);
    assert_eq!(values(&loaded)[0], 65535.0);
    assert!(loaded.notes.iter().any(|n| n.contains("lon in degrees_east")), "{:?}", loaded.notes);
}

#[test]
fn uneven_coordinates_are_told() {
    let mut z = coordinate("z", 1, "m", 0.0, 1.0);
    z.records = vec![[0f32, 1.0, 4.0].into_iter().flat_map(f32::to_be_bytes).collect()];
    let field =
        Variable { name: "v", dimensions: vec![1, 2, 3], attributes: vec![], kind: 3, records: vec![shorts(0)] };
    let all = [z, coordinate("y", 2, "m", 0.0, 1.0), coordinate("x", 3, "m", 0.0, 1.0), field];
    let loaded = load(&file(1, &DIMENSIONS, &all, 0), &ReadOptions::default());
    assert_eq!(loaded.volume.grid().unwrap().placement().spacing().z, 2.0);
    assert!(loaded.notes.iter().any(|n| n.contains("steps along z are uneven, 1 to 3")), "{:?}", loaded.notes);
}

#[test]
fn damaged_files_are_refused_in_words() {
    let whole = weather(2, 2);
    // Every truncation is an error, or leaves the variable whole.
    for length in 4..whole.len() - 60 * 2 - 8 {
        let message = refused(&whole[..length], &ReadOptions { frame: Some(1), ..Default::default() });
        assert!(message.contains("x.nc: "), "{message}");
    }
    let message = refused(&whole[..whole.len() - 40], &ReadOptions { frame: Some(1), ..Default::default() });
    assert!(message.contains("claims 120 bytes") && message.contains("is the file whole?"), "{message}");
    // Counts that are not there: nothing is allocated for them.
    let mut bytes = whole.clone();
    bytes[12..16].copy_from_slice(&u32::MAX.to_be_bytes());
    assert!(refused(&bytes, &ReadOptions::default()).contains("header: found its end"), "{bytes:?}");
    let huge = [("none", 0), ("z", 1 << 30), ("y", 1 << 30), ("x", 1 << 30)];
    let field =
        Variable { name: "v", dimensions: vec![1, 2, 3], attributes: vec![], kind: 5, records: vec![vec![0; 8]] };
    let message = refused(&file(5, &huge, &[field], 0), &ReadOptions::default());
    assert!(message.contains("x.nc: "), "{message}");
    // Any byte may be wrong.
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        let (_folder, path) = put(&bytes);
        let _ = read(path, &ReadOptions::default());
    }
}
