//! Images, rectilinear grids and cells of VTK.

use std::path::Path;

use crate::small_images;

pub fn vti() -> Vec<Vec<u8>> {
    small_images::all_vti().into_iter().map(|(_, file)| file).collect()
}

pub fn image() -> Vec<Vec<u8>> {
    vec![small_images::vtk(false), small_images::vtk(true)]
}

pub fn rectilinear() -> Vec<Vec<u8>> {
    let axes = "X_COORDINATES 3 float\n0 1 4\nY_COORDINATES 2 double\n0 2\nZ_COORDINATES 2 int\n5 3\n";
    let data = "POINT_DATA 12\nSCALARS f float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\nCELL_DATA 2\nVECTORS v float\n0 1 2 3 4 5\n";
    vec![legacy("RECTILINEAR_GRID", &format!("DIMENSIONS 3 2 2\n{axes}{data}"))]
}

pub fn vtr() -> Vec<Vec<u8>> {
    let array = |numbers: &str| format!("<DataArray type=\"Float32\" Name=\"f\">{numbers}</DataArray>");
    let piece = format!(
        "<Piece Extent=\"0 2 0 1 0 1\"><PointData>{}<DataArray type=\"UInt8\" Name=\"vtkGhostType\">0 0 0 2 0 0 0 0 0 0 0 0</DataArray></PointData>\
         <CellData/><Coordinates>{}{}{}</Coordinates></Piece>",
        array("0 1 2 3 4 5 6 7 8 9 10 11"),
        array("0 1 4"),
        array("0 1"),
        array("0 1")
    );
    let text = format!(
        "<VTKFile type=\"RectilinearGrid\" version=\"0.1\"><RectilinearGrid WholeExtent=\"0 2 0 1 0 1\">{piece}</RectilinearGrid></VTKFile>"
    );
    vec![text.into_bytes()]
}

pub fn pvtr() -> Vec<Vec<u8>> {
    let list = "<VTKFile type=\"PRectilinearGrid\" version=\"0.1\"><PRectilinearGrid WholeExtent=\"0 2 0 1 0 1\">\
                <Piece Extent=\"0 2 0 1 0 1\" Source=\"a.vtr\"/></PRectilinearGrid></VTKFile>";
    vec![list.into()]
}

/// The pieces that a list names.
pub fn pieces(folder: &Path) {
    std::fs::write(folder.join("a.vtr"), &vtr()[0]).expect("a seed");
}

/// A cube of 2×1×1 hexahedra, f = x + 10 y + 100 z at its vertices.
const POINTS: &str = "0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 1 1 1 2 1 1";
const VALUES: &str = "0 1 2 10 11 12 100 101 102 110 111 112";
const HEXAHEDRA: &str = "0 1 4 3 6 7 10 9 1 2 5 4 7 8 11 10";

pub fn cells() -> Vec<Vec<u8>> {
    let data = format!(
        "POINT_DATA 12\nSCALARS f double\nLOOKUP_TABLE default\n{VALUES}\nCELL_DATA 2\nSCALARS c float\nLOOKUP_TABLE default\n1 2\n"
    );
    let cells = "CELLS 2 18\n8 0 1 4 3 6 7 10 9\n8 1 2 5 4 7 8 11 10\nCELL_TYPES 2\n12 12\n";
    let tetrahedra = "CELLS 2 10\n4 0 1 3 6\n4 1 2 4 7\nCELL_TYPES 2\n10 10\n";
    [cells, tetrahedra]
        .map(|cells| legacy("UNSTRUCTURED_GRID", &format!("POINTS 12 float\n{POINTS}\n{cells}{data}")))
        .to_vec()
}

pub fn vtu() -> Vec<Vec<u8>> {
    let array = |kind: &str, name: &str, numbers: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{numbers}</DataArray>")
    };
    let text = format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\"><UnstructuredGrid><Piece NumberOfPoints=\"12\" NumberOfCells=\"2\">\
         <PointData Scalars=\"f\">{}</PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">{POINTS}</DataArray></Points>\
         <Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        array("Float64", "f", VALUES),
        array("Int32", "connectivity", HEXAHEDRA),
        array("Int32", "offsets", "8 16"),
        array("UInt8", "types", "12 12"),
    );
    vec![text.into_bytes()]
}

fn legacy(data_set: &str, rest: &str) -> Vec<u8> {
    format!("# vtk DataFile Version 4.2\ntest\nASCII\nDATASET {data_set}\n{rest}").into_bytes()
}
