//! Files of rectilinear grids and adaptive meshes: told of, drawn, chosen from by flags, refused in one line.

use crate::harness::Vr;

/// 4×3×3 points between uneven planes, with a scalar and a vector.
fn rectilinear() -> String {
    let (heat, wind): (String, String) = (0..36).map(|i| (format!("{i} "), format!("0 {i} 0 "))).unzip();
    format!(
        "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 4 3 3\nX_COORDINATES 4 float\n0 1 1.5 4\n\
         Y_COORDINATES 3 float\n10 11 13\nZ_COORDINATES 3 float\n-1 1 2\nPOINT_DATA 36\nSCALARS heat float 1\nLOOKUP_TABLE default\n{heat}\n\
         VECTORS wind float\n{wind}\n"
    )
}

/// An image of n³ cells with edges of 4 / n in the box from 0 to 4, or of its lower half in x.
fn image(n: usize, half: bool) -> String {
    let edge = 4.0 / n as f64;
    let nx = if half { n / 2 } else { n };
    let values: String = (0..nx * n * n).map(|i| format!("{} ", (i % nx) as f64 * edge)).collect();
    format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 {nx} 0 {n} 0 {n}\" Origin=\"0 0 0\" Spacing=\"{edge} {edge} {edge}\">\
         <Piece Extent=\"0 {nx} 0 {n} 0 {n}\"><CellData><DataArray type=\"Float32\" Name=\"heat\">{values}</DataArray></CellData></Piece>\
         </ImageData></VTKFile>"
    )
}

const LIST: &str = "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\
                    <Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 3 0 3 0 3\" file=\"coarse.vti\"/></Block>\
                    <Block level=\"1\" spacing=\"0.5 0.5 0.5\"><DataSet index=\"0\" amr_box=\"0 3 0 7 0 7\" file=\"fine.vti\"/></Block>\
                    </vtkOverlappingAMR></VTKFile>";

fn mesh() -> Vr {
    let vr = Vr::new();
    vr.write("coarse.vti", image(4, false));
    vr.write("fine.vti", image(8, true));
    vr.write("m.vthb", LIST);
    vr
}

#[test]
fn rectilinear_grids_are_told_of_and_drawn() {
    let vr = Vr::new();
    vr.write("g.vtk", rectilinear());
    let run = vr.run("info g.vtk").succeeded();
    for word in ["VTK (legacy)", "heat, wind", "4×3×3", "0 to 35"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    let run = vr.run("info g.vtk --value wind").succeeded();
    assert!(run.stderr.contains("'wind' has 3 components: their length is taken"), "{}", run.stderr);
    vr.run("render g.vtk -o g.png --size 16").succeeded();
    assert!(vr.exists("g.png"));
    let refused = vr.run("info g.vtk --value cold");
    assert!(refused.code != 0 && refused.stderr.contains("must be one of heat, wind"), "{}", refused.stderr);
}

#[test]
fn adaptive_meshes_are_told_of_and_drawn() {
    let vr = mesh();
    let run = vr.run("info m.vthb").succeeded();
    for word in ["VTK AMR", "heat"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    vr.run("render m.vthb -o m.png --size 16").succeeded();
    assert!(vr.exists("m.png"));
}

#[test]
fn a_block_that_is_missing_is_named() {
    let vr = mesh();
    vr.write("m.vthb", LIST.replace("fine.vti", "finer.vti"));
    let refused = vr.run("render m.vthb -o m.png --size 16");
    assert!(refused.code != 0 && !vr.exists("m.png"));
    assert!(refused.stderr.contains("m.vthb: data file finer.vti"), "{}", refused.stderr);
}
