//! Small adaptive meshes in every format: 4×4×2 unit cells from (1, 2, 3) on, of which the lower half in x is refined by 2, with a linear field.
#![allow(dead_code, reason = "each test file uses its part")]

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;

/// Corner of the mesh.
pub const ORIGIN: DVec3 = DVec3::new(1.0, 2.0, 3.0);

/// The field.
pub fn value(at: DVec3) -> f64 {
    at.dot(DVec3::new(1.0, 10.0, 100.0))
}

/// Levels: spacing, first and last cell of the one block.
const LEVELS: [(f64, [i64; 3]); 2] = [(1.0, [3, 3, 1]), (0.5, [3, 7, 3])];

/// Middles of the cells from a first to a last one, x running fastest.
fn middles(spacing: f64, first: [i64; 3], last: [i64; 3]) -> Vec<DVec3> {
    let mut middles = Vec::new();
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                middles.push(ORIGIN + spacing * (DVec3::new(x as f64, y as f64, z as f64) + 0.5));
            }
        }
    }
    middles
}

/// Files in a folder that lives as long.
pub struct Folder(tempfile::TempDir);

impl Default for Folder {
    fn default() -> Self {
        Self(tempfile::tempdir().unwrap())
    }
}

impl Folder {
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    pub fn remove(&self, name: &str) {
        std::fs::remove_file(self.path().join(name)).unwrap();
    }

    /// Takes bytes off the end of a file.
    pub fn cut(&self, name: &str, bytes: usize) {
        let path = self.path().join(name);
        let mut all = std::fs::read(&path).unwrap();
        all.truncate(all.len() - bytes);
        std::fs::write(path, all).unwrap();
    }

    /// Replaces text that a file must hold.
    #[track_caller]
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.path().join(name)).unwrap();
        assert!(text.contains(from), "no {from:?} in {text}");
        self.write(name, text.replacen(from, to, 1));
    }
}

/// A plotfile of AMReX with the components `density`, which is 1, and `Y(a b)`, the field; ghost cells of another value around each box.
pub fn amrex(double: bool, big: bool, ghosts: i64) -> Folder {
    let folder = Folder::default();
    let mut header = "HyperCLaw-V1.1\n2\ndensity\nY(a b)\n3\n0.5\n1\n1 2 3\n5 6 5\n2\n((0,0,0) (3,3,1) (0,0,0)) ((0,0,0) (7,7,3) (0,0,0))\n\
                      20 20\n1 1 1\n0.5 0.5 0.5\n0\n0\n"
        .to_owned();
    for (level, (spacing, last)) in LEVELS.into_iter().enumerate() {
        write!(header, "{level} 1 0.5\n20\n1 9\n2 9\n3 9\nLevel_{level}/Cell\n").unwrap();
        let shown = |[x, y, z]: [i64; 3]| format!("({x},{y},{z})");
        let list = format!(
            "1\n1\n2\n{ghosts}\n(1 0\n((0,0,0) {} (0,0,0))\n)\n1\nFabOnDisk: Cell_D_00000 0\n\n1,2\n1.0,1.0,\n\n1,2\n1.0,1.0,\n",
            shown(last)
        );
        folder.write(&format!("Level_{level}/Cell_H"), list);
        let bytes = if double { 8 } else { 4 };
        let order: Vec<String> =
            (1..=bytes).map(|i| if big { i } else { bytes + 1 - i }).map(|i: usize| i.to_string()).collect();
        let format = if double { "64 11 52 0 1 12 0 1023" } else { "32 8 23 0 1 9 0 127" };
        let (first, end) = ([-ghosts; 3], last.map(|i| i + ghosts));
        let mut fab = format!(
            "FAB ((8, ({format})),({bytes}, ({})))({} {} (0,0,0)) 2\n",
            order.join(" "),
            shown(first),
            shown(end)
        )
        .into_bytes();
        let cells = middles(spacing, first, end);
        let high = ORIGIN + spacing * DVec3::from_array(last.map(|i| i as f64 + 1.0));
        let is_inside = |at: &DVec3| at.cmpgt(ORIGIN).all() && at.cmplt(high).all();
        let numbers = cells
            .iter()
            .map(|at| if is_inside(at) { 1.0 } else { 77.0 })
            .chain(cells.iter().map(|at| if is_inside(at) { value(*at) } else { -77.0 }));
        for number in numbers {
            let bytes = match (double, big) {
                (true, true) => number.to_be_bytes().to_vec(),
                (true, false) => number.to_le_bytes().to_vec(),
                (false, true) => (number as f32).to_be_bytes().to_vec(),
                (false, false) => (number as f32).to_le_bytes().to_vec(),
            };
            fab.extend(bytes);
        }
        folder.write(&format!("Level_{level}/Cell_D_00000"), fab);
    }
    folder.write("Header", header);
    folder
}

/// A list of VTK in version 1.1 or 1.0, with the field and the vector `place`; level 1 is in two images. `ghosts` gives one of them a layer of
/// copies with other values, `blanked` hides one of its cells.
pub fn vthb(version: &str) -> Folder {
    let folder = Folder::default();
    let old = version == "1.0";
    let kind = if old { "vtkHierarchicalBoxDataSet" } else { "vtkOverlappingAMR" };
    let attributes = if old { "" } else { " origin=\"1 2 3\" grid_description=\"XYZ\"" };
    let shown = if old { "1.0" } else { "1.1" };
    let block = |level: usize, spacing: f64, inner: &str| {
        let tail = if old {
            "refinement_ratio=\"2\"".to_owned()
        } else {
            format!("spacing=\"{spacing} {spacing} {spacing}\"")
        };
        format!("<Block level=\"{level}\" {tail}>{inner}</Block>\n")
    };
    let coarse = block(0, 1.0, "<DataSet index=\"0\" amr_box=\"0 3 0 3 0 1\" file=\"a/0.vti\"/>");
    let fine = block(
        1,
        0.5,
        "<DataSet index=\"0\" amr_box=\"0 3 0 7 0 1\" file=\"a/1.vti\"/><DataSet index=\"1\" amr_box=\"0 3 0 7 2 3\" file=\"a/2.vti\"/><DataSet index=\"2\"/>",
    );
    let empty = if old { String::new() } else { block(2, 0.25, "") };
    folder.write(
        "a.vthb",
        format!("<VTKFile type=\"{kind}\" version=\"{shown}\"><{kind}{attributes}>\n{coarse}{fine}{empty}</{kind}></VTKFile>\n"),
    );
    folder.write("a/0.vti", image(1.0, [0, 0, 0], [3, 3, 1], false, ""));
    let ghosts = version == "ghosts";
    let marks = if version == "blanked" { "32 ".to_owned() + &"0 ".repeat(63) } else { String::new() };
    folder.write("a/1.vti", image(0.5, [0, 0, 0], [3, 7, 1], false, &marks));
    folder.write("a/2.vti", image(0.5, [0, 0, 2], [if ghosts { 4 } else { 3 }, 7, 3], ghosts, ""));
    folder
}

/// An image of cells; with a last layer in x of copies with other values, or marks of its own.
fn image(spacing: f64, first: [i64; 3], last: [i64; 3], copies: bool, marks: &str) -> String {
    let origin = ORIGIN + spacing * DVec3::from_array(first.map(|i| i as f64));
    let n = [0, 1, 2].map(|a| last[a] - first[a] + 1);
    let cells = middles(spacing, first, last);
    let is_copy = |i: usize| copies && i as i64 % n[0] == n[0] - 1;
    let words = |of: &dyn Fn(usize) -> String| (0..cells.len()).map(|i| of(i) + " ").collect::<String>();
    let values = words(&|i| if is_copy(i) { "-77".to_owned() } else { value(cells[i]).to_string() });
    let places = words(&|i| format!("{} {} {}", cells[i].x, cells[i].y, cells[i].z));
    let marks = if copies { words(&|i| u8::from(is_copy(i)).to_string()) } else { marks.to_owned() };
    let ghosts = if marks.is_empty() {
        String::new()
    } else {
        format!("<DataArray type=\"UInt8\" Name=\"vtkGhostType\">{marks}</DataArray>")
    };
    format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 {0} 0 {1} 0 {2}\" Origin=\"{3} {4} {5}\" \
         Spacing=\"{spacing} {spacing} {spacing}\"><Piece Extent=\"0 {0} 0 {1} 0 {2}\"><PointData/><CellData>\
         <DataArray type=\"Float64\" Name=\"place\" NumberOfComponents=\"3\">{places}</DataArray><DataArray type=\"Float64\" Name=\"f\">{values}</DataArray>\
         {ghosts}</CellData></Piece></ImageData></VTKFile>\n",
        n[0], n[1], n[2], origin.x, origin.y, origin.z
    )
}
