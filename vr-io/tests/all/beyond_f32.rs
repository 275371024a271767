//! Numbers of 64 bits that are beyond f32: kept, counted as missing, or refused, and said in a line by each reader that can meet them.

use vr_io::{Loaded, ReadOptions, parse_scene, read, read_points};

/// Numbers of eight places; the last one is far beyond f32, which ends at 3.4e38.
const NUMBERS: [f64; 8] = [0.0, 1e299, 2e299, 3e299, 4e299, 5e299, 6e299, 1e300];

fn bytes() -> Vec<u8> {
    NUMBERS.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn words() -> String {
    NUMBERS.iter().map(|x| format!("{x:e} ")).collect()
}

fn with_header(header: &str) -> Vec<u8> {
    [header.as_bytes(), &bytes()].concat()
}

fn npy(shape: &str) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}\n");
    [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &bytes()].concat()
}

fn vtk(kind: &str, numbers: &str) -> Vec<u8> {
    format!("# vtk DataFile Version 3.0\ntest\nASCII\nDATASET {kind}\nPOINT_DATA {numbers}\n").into_bytes()
}

fn vti() -> String {
    format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 2 0 2 0 2\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\
         <Piece Extent=\"0 2 0 2 0 2\"><CellData><DataArray type=\"Float64\" Name=\"s\">{}</DataArray></CellData></Piece>\
         </ImageData></VTKFile>",
        words()
    )
}

/// Reads the first of some files that lie beside each other.
fn load(files: &[(&str, Vec<u8>)]) -> Loaded {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    read(folder.path().join(files[0].0), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn scalars(kind: &str) -> String {
    format!("8\nSCALARS s {kind} 1\nLOOKUP_TABLE default\n{}", words())
}

#[test]
fn uniform_grids_keep_them_and_say_so() {
    let image = "STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1";
    let even = "RECTILINEAR_GRID\nDIMENSIONS 2 2 2\nX_COORDINATES 2 float\n0 1\nY_COORDINATES 2 float\n0 1\nZ_COORDINATES 2 float\n0 1";
    for (name, file) in [
        ("x_2x2x2_float64.raw", bytes()),
        ("x.npy", npy("2, 2, 2")),
        (
            "x.nrrd",
            with_header("NRRD0004\ntype: double\ndimension: 3\nsizes: 2 2 2\nendian: little\nencoding: raw\n\n"),
        ),
        (
            "x.mha",
            with_header(
                "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n",
            ),
        ),
        ("x.vtk", vtk(image, &scalars("double"))),
        ("x.vti", vti().into_bytes()),
    ] {
        let loaded = load(&[(name, file)]);
        let (low, high) = loaded.volume.value_range().unwrap();
        assert!(low == 0.0 && (high / 1e300 - 1.0).abs() < 1e-6, "{name}: {low} {high}");
        let said = loaded.notes.iter().any(|note| note.contains("from 0.000000e0 to 1.000000e300, beyond f32"));
        assert!(said, "{name}: {:?}", loaded.notes);
    }
    // Grids that may be uneven hold 32 bits, whatever their planes turn out to be; so do files that say `float`.
    for (name, file) in [("even.vtk", vtk(even, &scalars("double"))), ("float.vtk", vtk(image, &scalars("float")))] {
        let loaded = load(&[(name, file)]);
        let said = loaded.notes.iter().any(|note| note.contains("7 of 8") && note.contains("infinite, or beyond f32"));
        assert!(said, "{name}: {:?}", loaded.notes);
    }
}

#[test]
fn other_volumes_count_them_as_missing_and_say_so() {
    let uneven = "RECTILINEAR_GRID\nDIMENSIONS 2 2 2\nX_COORDINATES 2 float\n0 1\nY_COORDINATES 2 float\n0 3\nZ_COORDINATES 2 float\n0 1";
    let list = "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\
                <Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 1 0 1 0 1\" file=\"x.vti\"/></Block>\
                </vtkOverlappingAMR></VTKFile>";
    for files in
        [vec![("x.vtk", vtk(uneven, &scalars("double")))], vec![("x.vthb", list.into()), ("x.vti", vti().into_bytes())]]
    {
        let loaded = load(&files);
        let said = loaded.notes.iter().any(|note| note.contains("7 of 8 values are infinite, or beyond f32"));
        assert!(said, "{}: {:?}", files[0].0, loaded.notes);
    }
}

#[test]
fn meshes_of_cells_keep_them() {
    let points = "UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10";
    let values = "4\nSCALARS s double 1\nLOOKUP_TABLE default\n0 1 2 1e300";
    let loaded = load(&[("x.vtk", vtk(points, values))]);
    assert_eq!(loaded.volume.value_range(), Some((0.0, 1e300)), "{}", loaded.volume.kind());
}

#[test]
fn points_and_inline_numbers_are_refused_by_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    std::fs::write(&path, "x,y,z,value\n0,0,0,1\n1,1,1,1e300\n").unwrap();
    let error = read_points(&path, &Default::default()).map(drop).unwrap_err().to_string();
    assert!(error.contains("1e300") && error.contains("below 3.4e38"), "{error}");
    // An array of N×3 has positions alone, in f64: those within 10³⁰ are kept to the last digit, and others are refused by the number of the point.
    let points = |far: f64| {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n";
        let numbers = [0.0, 0.25, 0.5, 1.0, far, 2.0].map(f64::to_le_bytes).concat();
        let bytes =
            [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), &numbers].concat();
        let path = folder.path().join("x.npy");
        std::fs::write(&path, bytes).unwrap();
        read_points(&path, &Default::default()).map_err(|e| e.to_string())
    };
    assert_eq!(points(1.0 + 1e-12).unwrap().points.positions()[1].y, 1.0 + 1e-12);
    let error = points(1e300).map(drop).unwrap_err();
    assert!(error.contains("x.npy") && error.contains("point 1") && error.contains("1e300"), "{error}");
    let scene = parse_scene("[volume]\ndata = [0, 1, 2, 3, 4, 5, 6, 1e300]\ndims = [2, 2, 2]\n", "x.toml".as_ref());
    let error = vr_io::resolve_scene(&scene.unwrap(), "x.toml".as_ref()).map(drop).unwrap_err().to_string();
    assert!(error.contains("volume.data[7]") && error.contains("1e300"), "{error}");
}
