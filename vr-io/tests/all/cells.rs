//! Meshes of cells: small files of every form, told apart, chosen from, and refused where they make no sense.

use crate::shared::data;
use glam::DVec3;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::{Field, Volume};
use vr_io::{CellsOrPoints, Loaded, ReadOptions, read};

/// A cube of 2×1×1 hexahedra, f = x + 10 y + 100 z at its vertices.
const POINTS: &str = "0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 2 1 1";
const VALUES: &str = "0 1 2 10 11 12 100 101 102 110 111 112";
const HEXAHEDRA: [&str; 2] = ["0 1 4 3 6 7 10 9", "1 2 5 4 7 8 11 10"];

fn load(name: &str, bytes: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Loaded, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, options).map_err(|e| e.to_string())
}

fn mesh(loaded: &Loaded) -> &CellMesh {
    match &loaded.volume {
        Volume::Cells(mesh) => mesh,
        other => panic!("found {}: {:?}", other.kind(), loaded.notes),
    }
}

fn volume(mesh: &CellMesh) -> f64 {
    let six = |cell| {
        let [a, b, c, d] = mesh.corners(cell);
        (b - a).cross(c - a).dot(d - a)
    };
    (0..mesh.cells().len()).map(six).sum::<f64>() / 6.0
}

/// Checks that a file holds the two hexahedra: a linear field is linear in tetrahedra, too.
#[track_caller]
fn is_the_two_cubes(loaded: &Loaded) {
    let mesh = mesh(loaded);
    assert!((volume(mesh) - 2.0).abs() < 1e-12, "{}", volume(mesh));
    assert_eq!((mesh.cells().len(), mesh.vertices().len()), (12, 12), "{:?}", loaded.notes);
    for at in [DVec3::new(0.3, 0.2, 0.9), DVec3::new(1.7, 0.9, 0.4)] {
        let expected = at.dot(DVec3::new(1.0, 10.0, 100.0));
        assert!((mesh.value(at).unwrap() - expected).abs() < 1e-9, "{at}");
    }
}

fn legacy(data_set: &str, rest: &str) -> String {
    format!("# vtk DataFile Version 4.2\ntest\nASCII\nDATASET {data_set}\n{rest}")
}

fn legacy_hexahedra(cell_data: &str) -> String {
    let cells: Vec<String> = HEXAHEDRA.iter().map(|cell| format!("8 {cell}")).collect();
    legacy(
        "UNSTRUCTURED_GRID",
        &format!(
            "POINTS 12 float\n{POINTS}\nCELLS 2 18\n{}\nCELL_TYPES 2\n12 12\nPOINT_DATA 12\nSCALARS f double\nLOOKUP_TABLE default\n\
             {VALUES}\nCELL_DATA 2\n{cell_data}",
            cells.join("\n")
        ),
    )
}

/// A piece of an unstructured grid as text.
fn vtu_piece(points: &str, values: &str, cells: &[&str], types: &str, more: &str) -> String {
    let mut end = 0;
    let ends: Vec<String> = cells
        .iter()
        .map(|cell| {
            end += cell.split_whitespace().count();
            end.to_string()
        })
        .collect();
    format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\"><PointData Scalars=\"f\"><DataArray type=\"Float64\" Name=\"f\">{values}</DataArray>\
         </PointData>{more}<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">{points}</DataArray></Points><Cells>\
         <DataArray type=\"Int32\" Name=\"connectivity\">{}</DataArray><DataArray type=\"Int32\" Name=\"offsets\">{}</DataArray>\
         <DataArray type=\"UInt8\" Name=\"types\">{types}</DataArray></Cells></Piece>",
        values.split_whitespace().count(),
        cells.len(),
        cells.join(" "),
        ends.join(" "),
    )
}

fn vtk_file(kind: &str, body: &str) -> String {
    format!("<VTKFile type=\"{kind}\" version=\"0.1\" byte_order=\"LittleEndian\"><{kind}>{body}</{kind}></VTKFile>")
}

fn vtu(body: &str) -> String {
    vtk_file("UnstructuredGrid", body)
}

#[test]
fn every_form_holds_the_two_cubes() {
    let plain = ReadOptions::default();
    let loaded = load("a.vtk", legacy_hexahedra(""), &plain).unwrap();
    is_the_two_cubes(&loaded);
    assert_eq!((loaded.info.format, &loaded.info.columns[..]), ("VTK (legacy)", &["f".to_owned()][..]));
    assert!(
        loaded.notes.iter().any(|n| n.contains("2 cells that are no tetrahedra are split: 12")),
        "{:?}",
        loaded.notes
    );
    // From version 5 on, offsets stand before the vertices.
    let lists =
        format!("CELLS 3 16\nOFFSETS vtktypeint64\n0 8 16\nCONNECTIVITY vtktypeint64\n{}\n", HEXAHEDRA.join("\n"));
    let old = legacy_hexahedra("");
    let (begin, end) = (old.find("CELLS").unwrap(), old.find("CELL_TYPES").unwrap());
    let new = format!("{}{lists}{}", &old[..begin], &old[end..]);
    is_the_two_cubes(&load("b.vtk", new, &plain).unwrap());
    is_the_two_cubes(&load("c.vtu", vtu(&vtu_piece(POINTS, VALUES, &HEXAHEDRA, "12 12", "")), &plain).unwrap());
    // Voxels have another order.
    let voxels = ["0 1 3 4 6 7 9 10", "1 2 4 5 7 8 10 11"];
    is_the_two_cubes(&load("d.vtu", vtu(&vtu_piece(POINTS, VALUES, &voxels, "11 11", "")), &plain).unwrap());
    // Curvilinear grids need no list.
    let lattice = format!(
        "DIMENSIONS 3 2 2\nPOINTS 12 float\n{POINTS}\nPOINT_DATA 12\nSCALARS f double\nLOOKUP_TABLE default\n{VALUES}\n"
    );
    is_the_two_cubes(&load("e.vtk", legacy("STRUCTURED_GRID", &lattice), &plain).unwrap());
    let vts = vtu_piece(POINTS, VALUES, &[], "", "").replace("NumberOfPoints", "Extent=\"4 6 0 1 2 3\" N");
    let loaded = load("f.vts", vtk_file("StructuredGrid", &vts), &plain).unwrap();
    is_the_two_cubes(&loaded);
    assert_eq!(loaded.info.format, "VTK StructuredGrid");
}

#[test]
fn polyhedra_and_prisms_are_split() {
    // A box as the faces of a polyhedron, beside a hexahedron.
    let faces = "6 4 1 2 5 4 4 7 8 11 10 4 1 2 8 7 4 4 5 11 10 4 1 4 10 7 4 2 5 11 8";
    let count = faces.split_whitespace().count();
    let body = vtu_piece(POINTS, VALUES, &HEXAHEDRA, "12 42", "");
    let more = format!(
        "<DataArray type=\"Int64\" Name=\"faces\">{faces}</DataArray><DataArray type=\"Int64\" Name=\"faceoffsets\">-1 {count}</DataArray></Cells>"
    );
    is_the_two_cubes(&load("a.vtu", vtu(&body.replace("</Cells>", &more)), &ReadOptions::default()).unwrap());
    // As VTK 9.4 and later write them.
    let (mut connectivity, mut ends) = (Vec::new(), Vec::new());
    for face in ["1 2 5 4", "7 8 11 10", "1 2 8 7", "4 5 11 10", "1 4 10 7", "2 5 11 8"] {
        connectivity.push(face);
        ends.push((4 * connectivity.len()).to_string());
    }
    let more = format!(
        "<DataArray type=\"Int64\" Name=\"face_connectivity\">{}</DataArray><DataArray type=\"Int64\" Name=\"face_offsets\">{}</DataArray>\
         <DataArray type=\"Int64\" Name=\"polyhedron_to_faces\">0 1 2 3 4 5</DataArray>\
         <DataArray type=\"Int64\" Name=\"polyhedron_offsets\">0 6</DataArray></Cells>",
        connectivity.join(" "),
        ends.join(" ")
    );
    is_the_two_cubes(&load("b.vtu", vtu(&body.replace("</Cells>", &more)), &ReadOptions::default()).unwrap());
    let list = legacy_hexahedra("")
        .replace("CELLS 2 18", &format!("CELLS 2 {}", 10 + count))
        .replace("12 12\nPOINT", "12 42\nPOINT");
    let list = list.replace(&format!("8 {}", HEXAHEDRA[1]), &format!("{count} {faces}"));
    is_the_two_cubes(&load("c.vtk", list, &ReadOptions::default()).unwrap());
    let error = load("d.vtu", vtu(&body), &ReadOptions::default()).unwrap_err();
    assert!(error.contains("d.vtu: Cells, array polyhedron_offsets: found nothing"), "{error}");
}

#[test]
fn arrays_are_chosen_by_name_and_component() {
    let cell_data = "SCALARS level float\nLOOKUP_TABLE default\n5 7\nVECTORS wind float\n3 4 0 0 0 2\n";
    let with = |value: Option<&str>, component| {
        let options = ReadOptions { array: value.map(str::to_owned), component, ..ReadOptions::default() };
        load("a.vtk", legacy_hexahedra(cell_data), &options)
    };
    let loaded = with(None, None).unwrap();
    is_the_two_cubes(&loaded);
    assert!(
        loaded.notes.iter().any(|n| n.contains("array 'f' of the points is taken, the active scalars")),
        "{:?}",
        loaded.notes
    );
    assert_eq!(loaded.info.columns, ["f", "level", "wind"]);
    let level = with(Some("level"), None).unwrap();
    assert_eq!(mesh(&level).value_range(), (5.0, 7.0));
    assert!(matches!(mesh(&level).values(), CellValues::Cells(values) if values.len() == 12));
    assert_eq!(mesh(&level).value(DVec3::new(1.5, 0.5, 0.4)), Some(7.0));
    let wind = with(Some("wind"), None).unwrap();
    assert_eq!(mesh(&wind).value_range(), (2.0, 5.0), "lengths");
    assert!(wind.notes.iter().any(|n| n.contains("'wind' has 3 components: their length")), "{:?}", wind.notes);
    assert_eq!(mesh(&with(Some("wind"), Some(2)).unwrap()).value_range(), (0.0, 2.0));
    assert!(with(Some("wind"), Some(3)).unwrap_err().contains("component: found 3; array 'wind' has 3"));
    assert!(with(Some("heat"), None).unwrap_err().contains("array: found heat; must be one of f, level, wind"));
    assert_eq!(mesh(&with(Some("1"), None).unwrap()).value_range(), (1.0, 1.0));
}

#[test]
fn cells_may_be_taken_as_points() {
    let as_ = |kind| ReadOptions { cells_or_points: Some(kind), ..ReadOptions::default() };
    let loaded = load("a.vtk", legacy_hexahedra(""), &as_(CellsOrPoints::Points)).unwrap();
    assert_eq!(loaded.volume.points().unwrap().count(), 12);
    let lattice = format!(
        "DIMENSIONS 3 2 2\nPOINTS 12 float\n{POINTS}\nPOINT_DATA 12\nSCALARS value double\nLOOKUP_TABLE default\n{VALUES}\n"
    );
    let loaded = load("e.vtk", legacy("STRUCTURED_GRID", &lattice), &as_(CellsOrPoints::Points)).unwrap();
    assert_eq!(loaded.volume.points().unwrap().values()[11], 112.0);
    assert!(loaded.notes.iter().any(|n| n.contains("2 cells are left out")), "{:?}", loaded.notes);
    // Without cells of three dimensions, or without values, there are points alone.
    let flat = vtu(&vtu_piece(POINTS, VALUES, &["0 1 4", "1 2"], "5 3", ""));
    let loaded = load("f.vtu", &flat, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.volume.points().unwrap().count(), 12);
    assert!(loaded.notes[0].contains("none of its 2 cells has three dimensions"), "{:?}", loaded.notes);
    let error = load("f.vtu", &flat, &as_(CellsOrPoints::Cells)).unwrap_err();
    assert!(error.contains("as: found cells; the file cannot be taken so: none of its 2 cells"), "{error}");
    let bare = legacy_hexahedra("");
    let bare = &bare[..bare.find("POINT_DATA").unwrap()];
    let loaded = load("g.vtk", bare, &ReadOptions::default()).unwrap();
    assert!(loaded.volume.points().is_some() && loaded.notes[0].contains("no array of values"), "{:?}", loaded.notes);
    let error = load("h.csv", "x,y,z\n0,0,0\n1,0,0\n", &as_(CellsOrPoints::Cells)).unwrap_err();
    assert!(error.contains("as: found cells; only files of cells"), "{error}");
}

#[test]
fn flat_hidden_and_broken_cells_are_left_out_and_told() {
    // A ghost, a triangle, a repeated cell and one without a volume.
    let cells = [HEXAHEDRA[0], HEXAHEDRA[1], "0 1 4", "0 1 3 6", "0 1 3 6", "0 1 2 1"];
    let ghosts = "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\">0 1 0 0 0 0</DataArray></CellData>";
    let loaded =
        load("a.vtu", vtu(&vtu_piece(POINTS, VALUES, &cells, "12 12 5 10 10 10", ghosts)), &ReadOptions::default())
            .unwrap();
    for note in
        ["1 cells of fewer than three", "1 cells that the file marks as ghosts", "have no volume", "repeat others"]
    {
        assert!(loaded.notes.iter().any(|n| n.contains(note)), "no {note:?} in {:?}", loaded.notes);
    }
    assert_eq!(loaded.info.columns, ["f"], "marks are no choice");
    let nan = VALUES.replace("112", "nan");
    let loaded =
        load("b.vtu", vtu(&vtu_piece(POINTS, &nan, &HEXAHEDRA, "12 12", "")), &ReadOptions::default()).unwrap();
    assert!(loaded.notes.iter().any(|n| n.contains("have a value that is not finite")), "{:?}", loaded.notes);
    assert!(volume(mesh(&loaded)) < 2.0);
    // A blanked point hides the cells at it.
    let vts = vtu_piece(POINTS, VALUES, &[], "", "").replace("NumberOfPoints", "Extent=\"0 2 0 1 0 1\" N");
    let marks = "<DataArray type=\"UInt8\" Name=\"vtkGhostType\">0 0 0 0 0 2 0 0 0 0 0 0</DataArray></PointData>";
    let loaded =
        load("c.vts", vtk_file("StructuredGrid", &vts.replace("</PointData>", marks)), &ReadOptions::default())
            .unwrap();
    assert_eq!(volume(mesh(&loaded)), 1.0);
}

#[test]
fn quadratic_cells_are_taken_by_their_corners() {
    let points = "0 0 0 1 0 0 0 1 0 0 0 1 .5 0 0 .5 .5 0 0 .5 0 0 0 .5 .5 0 .5 0 .5 .5";
    let body = vtu_piece(points, "0 1 2 3 4 5 6 7 8 9", &["0 1 2 3 4 5 6 7 8 9"], "24", "");
    let loaded = load("a.vtu", vtu(&body), &ReadOptions::default()).unwrap();
    assert_eq!(mesh(&loaded).cells(), [[0, 1, 2, 3]]);
    assert!(
        loaded.notes.iter().any(|n| n.contains("1 cells of higher order are taken by their corners")),
        "{:?}",
        loaded.notes
    );
}

/// The two cubes in two pieces, each with vertices of its own; in the second a ghost of the first.
fn two_pieces() -> [String; 2] {
    let points: Vec<&str> = POINTS.split_whitespace().collect();
    let values: Vec<&str> = VALUES.split_whitespace().collect();
    let first = [0, 1, 3, 4, 6, 7, 9, 10];
    let pick = |list: &[usize]| {
        let places: Vec<String> = list.iter().map(|&v| points[3 * v..3 * v + 3].join(" ")).collect();
        let numbers: Vec<&str> = list.iter().map(|&v| values[v]).collect();
        (places.join(" "), numbers.join(" "))
    };
    let (places, numbers) = pick(&first);
    let left = vtu_piece(&places, &numbers, &["0 1 2 3 4 5 6 7"], "11", "");
    let ghosts = "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\">1 0</DataArray></CellData>";
    let (places, numbers) = pick(&(0..12).rev().collect::<Vec<_>>());
    let turned: Vec<String> = HEXAHEDRA
        .iter()
        .map(|cell| {
            cell.split_whitespace()
                .map(|v| (11 - v.parse::<usize>().unwrap()).to_string())
                .collect::<Vec<_>>()
                .join(" ")
        })
        .collect();
    let right = vtu_piece(&places, &numbers, &[&turned[0], &turned[1]], "12 12", ghosts);
    [left, right]
}

#[test]
fn pieces_are_welded_at_their_seams() {
    let [left, right] = two_pieces();
    let loaded = load("a.vtu", vtu(&format!("{left}{right}")), &ReadOptions::default()).unwrap();
    is_the_two_cubes(&loaded);
    let surface = mesh(&loaded).neighbours().iter().flatten().filter(|&&n| n == vr_core::cells::NO_CELL).count();
    assert_eq!(surface, 20, "two triangles on each of ten squares: no crack between the cubes");
    // In files of their own, named by a list.
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a_0.vtu", &vtu(&left));
    write("a_1.vtu", &vtu(&right));
    write("a_2.vtu", &vtu("<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>"));
    let list = |names: &[&str]| {
        let pieces: Vec<String> = names.iter().map(|name| format!("<Piece Source=\"{name}\"/>")).collect();
        vtk_file("PUnstructuredGrid", &pieces.join(""))
    };
    write("a.pvtu", &list(&["a_2.vtu", "a_0.vtu", "a_1.vtu"]));
    let loaded = read(folder.path().join("a.pvtu"), &ReadOptions::default()).unwrap();
    is_the_two_cubes(&loaded);
    assert_eq!((loaded.info.format, loaded.info.files.len()), ("VTK PUnstructuredGrid", 4));
    write("b.pvtu", &list(&["a_0.vtu", "nowhere.vtu"]));
    let error = read(folder.path().join("b.pvtu"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("b.pvtu: data file") && error.contains("nowhere.vtu"), "{error}");
    write("c.pvtu", &list(&[]));
    assert!(
        read(folder.path().join("c.pvtu"), &ReadOptions::default())
            .unwrap_err()
            .to_string()
            .contains("must name files")
    );
}

/// A PLOT3D file: integers and records of numbers, with or without marks.
fn plot3d(big: bool, marks: bool, double: bool, several: bool, records: &[Vec<f64>]) -> Vec<u8> {
    let mut out = Vec::new();
    let int = |n: i32| if big { n.to_be_bytes() } else { n.to_le_bytes() };
    let mut record = |bytes: Vec<u8>| {
        let mark = int(bytes.len() as i32);
        if marks {
            out.extend(mark);
        }
        out.extend(bytes);
        if marks {
            out.extend(mark);
        }
    };
    if several {
        record(int(1).to_vec());
    }
    record([3, 2, 2].into_iter().flat_map(int).collect());
    for numbers in records {
        let bytes = numbers.iter().flat_map(|&x| match (double, big) {
            (true, true) => x.to_be_bytes().to_vec(),
            (true, false) => x.to_le_bytes().to_vec(),
            (false, true) => (x as f32).to_be_bytes().to_vec(),
            (false, false) => (x as f32).to_le_bytes().to_vec(),
        });
        record(bytes.collect());
    }
    out
}

#[test]
fn plot3d_of_every_form_holds_the_two_cubes() {
    let numbers = |text: &str| text.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
    let points = numbers(POINTS);
    let axes: Vec<f64> =
        (0..3).flat_map(|axis| points.iter().skip(axis).step_by(3).copied().collect::<Vec<_>>()).collect();
    let (density, threes) = (numbers(VALUES), vec![3.0; 12]);
    let q = [density, threes, vec![4.0; 12], vec![0.0; 12], vec![9.0; 12]].concat();
    let flow = vec![0.5, 0.0, 100.0, 0.0];
    for form in 0..16 {
        let bit = |k: u32| form >> k & 1 == 1;
        let folder = tempfile::tempdir().unwrap();
        let of = |records: &[Vec<f64>]| plot3d(bit(0), bit(1), bit(2), bit(3), records);
        let (grid, solution) = (folder.path().join("finxyz.bin"), folder.path().join("finq.bin"));
        std::fs::write(&grid, of(std::slice::from_ref(&axes))).unwrap();
        std::fs::write(&solution, of(&[flow.clone(), q.clone()])).unwrap();
        let loaded = read(&grid, &ReadOptions::default()).unwrap();
        is_the_two_cubes(&loaded);
        assert_eq!((loaded.info.format, loaded.info.files.len()), ("PLOT3D", 2));
        is_the_two_cubes(&read(&solution, &ReadOptions::default()).unwrap());
        let momentum = ReadOptions { array: Some("momentum".into()), ..ReadOptions::default() };
        assert_eq!(mesh(&read(&grid, &momentum).unwrap()).value_range(), (5.0, 5.0));
        // A byte more or less is another format.
        let mut longer = std::fs::read(&grid).unwrap();
        longer.push(0);
        std::fs::write(&grid, longer).unwrap();
        assert!(read(&grid, &ReadOptions::default()).unwrap_err().to_string().contains("not recognised"));
    }
}

#[test]
fn nonsense_is_refused_by_its_place() {
    let vtu_of = |cells: &[&str], types: &str| {
        load("x.vtu", vtu(&vtu_piece(POINTS, VALUES, cells, types, "")), &ReadOptions::default())
    };
    let error = |cells: &[&str], types: &str| vtu_of(cells, types).unwrap_err();
    assert!(error(&["0 1 4 99"], "10").ends_with("x.vtu: cell 0: found vertex 99; there are 12, counted from 0"));
    assert!(error(&["0 1 4 -1"], "10").contains("found vertex -1"));
    assert!(error(&["0 1 4"], "10").contains("cell 0: found 3 vertices; its type needs 4"));
    assert!(error(&["0 1 4 3"], "41").contains("cell 0, type: found 41"));
    assert!(error(&["0 1 2 1"], "10").contains("no cell with a volume"));
    let broken = |from: &str, to: &str| {
        let text = legacy_hexahedra("");
        assert!(text.contains(from), "{from}");
        load("x.vtk", text.replace(from, to), &ReadOptions::default()).unwrap_err()
    };
    assert!(broken("CELL_TYPES 2\n12 12", "CELL_TYPES 1\n12").contains("CELL_TYPES: found 1; there are 2 cells"));
    assert!(broken("CELLS 2 18\n8 ", "CELLS 2 18\n18 ").contains("CELLS, cell 0: found vertices beyond the end"));
    assert!(broken("CELLS 2 18\n8 ", "CELLS 2 18\n-3 ").contains("CELLS, cell 0: found no length"));
    assert!(broken("0 0 0 1 0 0", "nan 0 0 1 0 0").contains("vertex 0: found the position"));
    // Claims beyond all memory.
    for (claim, place) in [("9000000000000000", "offsets"), ("18446744073709551615", "offsets"), ("4e4", "offsets")] {
        let text = vtu(&vtu_piece(POINTS, VALUES, &["0 1 4 3"], "10", ""))
            .replace(">4</DataArray>", &format!(">{claim}</DataArray>"));
        let text = text.replace("type=\"Int32\" Name=\"offsets\"", "type=\"Float64\" Name=\"offsets\"");
        let error = load("x.vtu", text, &ReadOptions::default()).unwrap_err();
        assert!(error.contains(place) || error.contains("connectivity"), "{error}");
    }
    let lattice = |dims: &str| {
        legacy(
            "STRUCTURED_GRID",
            &format!(
                "DIMENSIONS {dims}\nPOINTS 12 float\n{POINTS}\nPOINT_DATA 12\nSCALARS f double\nLOOKUP_TABLE default\n{VALUES}\n"
            ),
        )
    };
    for dims in ["3 2 3", "99999999999 99999999999 99999999999", "0 2 2"] {
        let error = load("x.vtk", lattice(dims), &ReadOptions::default()).unwrap_err();
        assert!(error.contains("DIMENSIONS: found") && error.contains("number of points, 12"), "{error}");
    }
    // Cut anywhere, a file is refused or, where only the end of its values is missing in text, shorter; it is never a panic.
    for text in [legacy_hexahedra(""), vtu(&vtu_piece(POINTS, VALUES, &HEXAHEDRA, "12 12", ""))] {
        for end in (0..text.len()).step_by(7) {
            let _ = load("x.vtk", &text[..end], &ReadOptions::default());
        }
    }
}

#[test]
fn real_meshes_have_their_sizes() {
    // Volumes are those that vtkCellSizeFilter of VTK 9.7 gives; of curved hexahedra, tetrahedra fill a little more or less.
    let files = [
        ("post.vtk", 8750, 27.794_876_508_6, 1e-6, (0.355, 1.641)),
        ("tetraMesh.vtk", 160, f64::NAN, 0.0, (0.0, 4.0)),
        ("uGridEx.vtk", 14, 2.333_333_333, 1e-6, (0.0, 14.0)),
        ("fire_ug.vtu", 0, 35.547_498, 1e-4, (298.0, 692.0)),
        ("Tetrahedron.vtu", 96, 8.0, 1e-6, (0.0, 1.733)),
        ("disk_out_ref.ex2", 0, 1629.657, 1e-3, (293.1499, 913.1501)),
        ("bluntfinxyz.bin", 224_759, 931.162_696, 1e-6, (0.193, 4.978)),
    ];
    for (name, cells, expected, tolerance, range) in files {
        let Some(path) = data(&format!("unstructured/{name}")) else { return };
        let loaded = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        let mesh = mesh(&loaded);
        println!(
            "{name}: {} tetrahedra, volume {}, {:?}: {:?}",
            mesh.cells().len(),
            volume(mesh),
            mesh.value_range(),
            loaded.notes
        );
        assert!(cells == 0 || mesh.cells().len() == cells, "{name}: {}", mesh.cells().len());
        let error = (volume(mesh) / expected - 1.0).abs();
        assert!(expected.is_nan() || error < tolerance, "{name}: {} for {expected}", volume(mesh));
        let (low, high) = mesh.value_range();
        assert!(low >= range.0 - 1e-3 * range.1 && high <= range.1 * 1.001, "{name}: {low} to {high}");
    }
}

#[test]
fn real_broken_meshes_are_refused_or_mended() {
    let Some(folder) = data("bad") else { return };
    let load = |name: &str| read(folder.join(name), &ReadOptions::default());
    let error = load("tets_bad_index.vtk").unwrap_err().to_string();
    assert!(error.contains("tets_bad_index.vtk: cell") && error.contains("there are 154"), "{error}");
    let inverted = load("tets_inverted.vtk").unwrap();
    assert_eq!(mesh(&inverted).cells().len(), 300);
    let degenerate = load("tets_degenerate.vtk").unwrap();
    assert!(
        degenerate.notes.iter().any(|n| n == "20 of 300 tetrahedra have no volume, and are left out"),
        "{:?}",
        degenerate.notes
    );
    let nan = load("tets_nan_scalar.vtk").unwrap();
    assert!(nan.notes.iter().any(|n| n.contains("not finite: they are vacuum")), "{:?}", nan.notes);
    let bare = load("tets_no_scalars.vtk").unwrap();
    assert!(bare.volume.points().is_some() && bare.notes[0].contains("no array of values"), "{:?}", bare.notes);
}
