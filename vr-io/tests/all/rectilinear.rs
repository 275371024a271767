//! Rectilinear grids of VTK in every form, parallel lists of them and of images, and what is refused.

use crate::shared::data;
use crate::small_points::{Packed, Stored, base64, packed};
use glam::DVec3;
use vr_core::{Field, RectilinearGrid, Volume};
use vr_io::{Loaded, ReadOptions, read};

/// Planes of a grid of 4×3×3 points, uneven along x and y.
const AXES: [&[f32]; 3] = [&[0.0, 1.0, 1.5, 4.0], &[10.0, 11.0, 13.0], &[-1.0, 1.0, 2.0]];

fn value(at: DVec3) -> f64 {
    at.dot(DVec3::new(1.0, 10.0, 100.0))
}

/// Middles of the cells between planes, or the points themselves, x running fastest.
fn places(axes: [&[f32]; 3], of_cells: bool) -> Vec<DVec3> {
    let along = axes.map(|axis| -> Vec<f64> {
        if of_cells {
            axis.windows(2).map(|pair| (f64::from(pair[0]) + f64::from(pair[1])) / 2.0).collect()
        } else {
            axis.iter().map(|&x| x.into()).collect()
        }
    });
    let mut all = Vec::new();
    for &z in &along[2] {
        for &y in &along[1] {
            all.extend(along[0].iter().map(|&x| DVec3::new(x, y, z)));
        }
    }
    all
}

fn words<T: ToString>(numbers: impl IntoIterator<Item = T>) -> String {
    numbers.into_iter().map(|x| x.to_string() + " ").collect()
}

fn values(axes: [&[f32]; 3], of_cells: bool) -> Vec<f32> {
    places(axes, of_cells).into_iter().map(|at| value(at) as f32).collect()
}

fn load(name: &str, bytes: impl AsRef<[u8]>, options: &ReadOptions) -> Result<Loaded, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let loaded = read(&path, options).map_err(|e| e.to_string());
    if let Err(message) = &loaded {
        assert!(!message.contains('\n'), "{message}");
    }
    loaded
}

fn array(name: &str) -> ReadOptions {
    ReadOptions { array: Some(name.to_owned()), ..ReadOptions::default() }
}

fn grid(loaded: &Loaded) -> &RectilinearGrid {
    loaded.volume.rectilinear().unwrap_or_else(|| panic!("{}: {:?}", loaded.volume.kind(), loaded.notes))
}

#[track_caller]
fn is_the_grid(loaded: &Loaded) {
    let grid = grid(loaded);
    assert_eq!(grid.dims(), [4, 3, 3], "{:?}", loaded.notes);
    for at in [DVec3::new(0.5, 10.5, 0.0), DVec3::new(3.9, 12.0, -0.9), DVec3::new(1.5, 13.0, 1.0)] {
        assert!((grid.value(at).unwrap() - value(at)).abs() < 1e-4, "{at}: {:?}", grid.value(at));
    }
}

/// A legacy file with the field of points and of cells.
fn legacy(binary: bool) -> Vec<u8> {
    let mut file = format!(
        "# vtk DataFile Version 3.0\ntest\n{}\nDATASET RECTILINEAR_GRID\nDIMENSIONS 4 3 3\n",
        if binary { "BINARY" } else { "ASCII" }
    )
    .into_bytes();
    let put = |file: &mut Vec<u8>, line: String, numbers: Vec<f32>| {
        file.extend(line.bytes());
        if binary {
            file.extend(numbers.iter().flat_map(|x| x.to_be_bytes()));
            file.push(b'\n');
        } else {
            file.extend((words(numbers) + "\n").bytes());
        }
    };
    for (name, axis) in ["X", "Y", "Z"].into_iter().zip(AXES) {
        put(&mut file, format!("{name}_COORDINATES {} float\n", axis.len()), axis.to_vec());
    }
    put(&mut file, "POINT_DATA 36\nSCALARS f float 1\nLOOKUP_TABLE default\n".into(), values(AXES, false));
    put(&mut file, "CELL_DATA 12\nSCALARS c float 1\nLOOKUP_TABLE default\n".into(), values(AXES, true));
    file
}

#[test]
fn legacy_files_in_both_forms() {
    for binary in [false, true] {
        let loaded = load("a.vtk", legacy(binary), &ReadOptions::default()).unwrap();
        is_the_grid(&loaded);
        assert_eq!(
            (loaded.info.format, &loaded.info.columns[..]),
            ("VTK (legacy)", &["f".to_owned(), "c".to_owned()][..])
        );
        let cells = load("a.vtk", legacy(binary), &array("c")).unwrap();
        // Values of cells stand in their middles.
        assert_eq!((grid(&cells).dims(), grid(&cells).bounds().0), ([3, 2, 2], DVec3::new(0.5, 10.5, 0.0)));
        let at = DVec3::new(1.0, 11.0, 1.0);
        assert!((grid(&cells).value(at).unwrap() - value(at)).abs() < 1e-4);
        assert!(cells.notes.iter().any(|n| n.contains("belong to cells")), "{:?}", cells.notes);
    }
}

/// A piece in the form of XML: an extent, and the field of its points; `scale` makes positions other ones.
struct Pieces {
    text: String,
    appended: Vec<u8>,
    stored: Stored,
    how: Packed,
}

impl Pieces {
    fn array(&mut self, begin: &str, numbers: &[f32]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let (header, data) = packed(&bytes, self.how, false, false);
        match self.stored {
            Stored::Ascii => format!("<DataArray {begin} format=\"ascii\">{}</DataArray>", words(numbers)),
            Stored::Inline => {
                format!("<DataArray {begin} format=\"binary\">{}</DataArray>", base64(&header, &data, self.how))
            }
            _ => {
                let offset = self.appended.len();
                if self.stored == Stored::AppendedRaw {
                    self.appended.extend([header, data].concat());
                } else {
                    self.appended.extend(base64(&header, &data, self.how).bytes());
                }
                format!("<DataArray {begin} format=\"appended\" offset=\"{offset}\"/>")
            }
        }
    }

    fn piece(&mut self, first: [usize; 3], axes: [&[f32]; 3], more: &str) {
        let last = [0, 1, 2].map(|a| first[a] + axes[a].len() - 1);
        let extent = words([first[0], last[0], first[1], last[1], first[2], last[2]]);
        let field = self.array("type=\"Float32\" Name=\"f\"", &values(axes, false));
        let coordinates: String = axes.iter().map(|axis| self.array("type=\"Float32\" Name=\"Array\"", axis)).collect();
        self.text += &format!(
            "<Piece Extent=\"{extent}\"><PointData>{field}{more}</PointData><CellData/><Coordinates>{coordinates}</Coordinates></Piece>"
        );
    }

    fn file(self, whole: &str) -> Vec<u8> {
        let compressor = match self.how {
            Packed::No => "",
            Packed::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            Packed::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
        };
        let mut file = format!(
            "<VTKFile type=\"RectilinearGrid\" version=\"0.1\" byte_order=\"LittleEndian\"{compressor}><RectilinearGrid WholeExtent=\"{whole}\">{}</RectilinearGrid>",
            self.text
        )
        .into_bytes();
        if !self.appended.is_empty() {
            let encoding = if self.stored == Stored::AppendedRaw { "raw" } else { "base64" };
            file.extend(format!("<AppendedData encoding=\"{encoding}\">_").bytes());
            file.extend(&self.appended);
            file.extend(b"</AppendedData>");
        }
        file.extend(b"</VTKFile>");
        file
    }
}

fn pieces(stored: Stored, how: Packed) -> Pieces {
    Pieces { text: String::new(), appended: Vec::new(), stored, how }
}

fn plain(first: [usize; 3], axes: [&[f32]; 3], more: &str) -> String {
    let mut file = pieces(Stored::Ascii, Packed::No);
    file.piece(first, axes, more);
    String::from_utf8(file.file("0 3 0 2 0 2")).unwrap()
}

#[test]
fn xml_files_in_every_encoding() {
    for stored in [Stored::Ascii, Stored::Inline, Stored::AppendedRaw, Stored::AppendedBase64] {
        for how in [Packed::No, Packed::Zlib, Packed::Lz4] {
            let mut file = pieces(stored, how);
            file.piece([0; 3], AXES, "");
            let loaded = load("a.vtr", file.file("0 3 0 2 0 2"), &ReadOptions::default()).unwrap();
            is_the_grid(&loaded);
            assert_eq!((loaded.info.format, loaded.info.placed_by), ("VTK RectilinearGrid", "coordinates"));
        }
    }
}

#[test]
fn pieces_are_joined_on_their_planes() {
    let halves = [AXES[0][..2].to_vec(), AXES[0][1..].to_vec()];
    let left = [&halves[0][..], AXES[1], AXES[2]];
    let right = [&halves[1][..], AXES[1], AXES[2]];
    let mut file = pieces(Stored::Ascii, Packed::No);
    file.piece([0; 3], left, "");
    file.piece([1, 0, 0], right, "");
    let text = String::from_utf8(file.file("0 3 0 2 0 2")).unwrap();
    let loaded = load("a.vtr", &text, &ReadOptions::default()).unwrap();
    is_the_grid(&loaded);
    assert!(loaded.notes.iter().any(|n| n.contains("from 2 pieces")), "{:?}", loaded.notes);
    // The first plane that both have, at two places.
    let apart = text.replacen("0 1 </DataArray>", "0 1.25 </DataArray>", 1);
    let error = load("a.vtr", apart, &ReadOptions::default()).unwrap_err();
    assert!(error.contains("Coordinates, axis 0: found plane 1 at 1.25 and at 1"), "{error}");

    // In files of their own.
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a_0.vtr", &plain([0; 3], left, ""));
    write("a_1.vtr", &plain([1, 0, 0], right, ""));
    let list = |second: &str| {
        format!(
            "<VTKFile type=\"PRectilinearGrid\" version=\"0.1\"><PRectilinearGrid WholeExtent=\"0 3 0 2 0 2\"><Piece Extent=\"0 1 0 2 0 2\" Source=\"a_0.vtr\"/>\
             <Piece Extent=\"1 3 0 2 0 2\" Source=\"{second}\"/></PRectilinearGrid></VTKFile>"
        )
    };
    let path = folder.path().join("a.pvtr");
    write("a.pvtr", &list("a_1.vtr"));
    let loaded = read(&path, &ReadOptions::default()).unwrap();
    is_the_grid(&loaded);
    assert_eq!((loaded.info.format, loaded.info.files.len()), ("VTK PRectilinearGrid", 3));
    for (second, word) in [("a_2.vtr", "data file"), ("../a_1.vtr", "inside of the folder"), ("a.pvtr", "VTKFile type")]
    {
        write("a.pvtr", &list(second));
        let error = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn images_in_files_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let image = |extent: &str, values: &str| {
        format!(
            "<VTKFile type=\"ImageData\" version=\"0.1\"><ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"1 2 3\" Spacing=\"2 1 1\"><Piece Extent=\"{extent}\">\
             <PointData><DataArray type=\"UInt8\" Name=\"f\">{values}</DataArray></PointData></Piece></ImageData></VTKFile>"
        )
    };
    write("0.vti", image("0 1 0 1 0 1", "0 1 3 4 6 7 9 10"));
    write("1.vti", image("1 2 0 1 0 1", "1 2 4 5 7 8 10 11"));
    let list = "<VTKFile type=\"PImageData\" version=\"0.1\"><PImageData WholeExtent=\"0 2 0 1 0 1\" GhostLevel=\"0\" Origin=\"1 2 3\" Spacing=\"2 1 1\">\
                <Piece Extent=\"0 1 0 1 0 1\" Source=\"0.vti\"/><Piece Extent=\"1 2 0 1 0 1\" Source=\"1.vti\"/></PImageData></VTKFile>";
    write("a.pvti", list.into());
    let loaded = read(folder.path().join("a.pvti"), &ReadOptions::default()).unwrap();
    let grid = loaded.volume.grid().unwrap();
    assert_eq!((grid.dims(), grid.value_range()), ([3, 2, 2], Some((0.0, 11.0))));
    assert_eq!(
        (grid.placement().origin(), grid.placement().spacing()),
        (DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 1.0, 1.0))
    );
    assert_eq!((loaded.info.format, loaded.info.files.len()), ("VTK PImageData", 3));
    write("1.vti", image("1 2 0 1 0 1", "1 2 4 5 7 8 10"));
    let error = read(folder.path().join("a.pvti"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("1.vti: array f: found 7 numbers"), "{error}");
}

#[test]
fn even_planes_make_a_uniform_grid() {
    let steps: Vec<f32> = (0..4).map(|i| 0.1 * i as f32).collect();
    let falling: Vec<f32> = vec![3.0, 2.0, 1.0];
    let axes = [&steps[..], &falling, &[-1.0, 1.0, 3.0]];
    let loaded = load("a.vtr", plain([0; 3], axes, ""), &ReadOptions::default()).unwrap();
    let grid = loaded.volume.grid().unwrap_or_else(|| panic!("{}", loaded.volume.kind()));
    let spacing = grid.placement().spacing();
    assert!((spacing - DVec3::new(0.1, 1.0, 2.0)).length() < 1e-6, "{spacing}");
    assert_eq!(grid.bounds().0.y, 1.0);
    assert!(loaded.notes.iter().any(|n| n.contains("a uniform grid is made")), "{:?}", loaded.notes);
}

#[test]
fn blanked_points_and_vectors() {
    let marks: String = (0..36).map(|i| if i == 5 { "2 " } else { "0 " }).collect();
    let vectors: String = (0..36).map(|i| format!("{i} 0 3 ")).collect();
    let more = format!(
        "<DataArray type=\"UInt8\" Name=\"vtkGhostType\">{marks}</DataArray><DataArray type=\"Float64\" Name=\"v\" NumberOfComponents=\"3\">{vectors}</DataArray>"
    );
    let text = plain([0; 3], AXES, &more);
    let loaded = load("a.vtr", &text, &ReadOptions::default()).unwrap();
    assert_eq!(grid(&loaded).lattice().value_stats().nan, 1);
    assert_eq!(loaded.info.columns, ["f", "v"], "marks are no choice");
    let length = load("a.vtr", &text, &array("v")).unwrap();
    assert!(length.notes.iter().any(|n| n.contains("their length")), "{:?}", length.notes);
    let third = load("a.vtr", &text, &ReadOptions { component: Some(2), ..array("v") }).unwrap();
    assert_eq!(third.volume.value_range(), Some((3.0, 3.0)));
    let error = load("a.vtr", &text, &ReadOptions { component: Some(3), ..array("v") }).unwrap_err();
    assert!(error.contains("component: found 3; array 'v' has 3"), "{error}");
}

#[test]
fn what_is_wrong_is_said() {
    let text = String::from_utf8(legacy(false)).unwrap();
    let error = |from: &str, to: &str| load("a.vtk", text.replacen(from, to, 1), &ReadOptions::default()).unwrap_err();
    assert!(error("X_COORDINATES 4 float\n0 1 1.5 4 \n", "").contains("X_COORDINATES: found nothing"));
    assert!(error("0 1 1.5 4", "0 1 0.5 4").contains("place 2 is 0.5 after 1"));
    assert!(error("0 1 1.5 4", "0 nan 1.5 4").contains("must be finite"));
    assert!(error("DIMENSIONS 4 3 3", "DIMENSIONS 4 3 1").contains("Z_COORDINATES: found 3"));
    assert!(error("DIMENSIONS 4 3 3", "DIMENSIONS 9223372036854775807 3 3").contains("DIMENSIONS"));
    let flat = [AXES[0], AXES[1], &AXES[2][..1]];
    let flat = load("a.vtr", plain([0; 3], flat, ""), &ReadOptions::default()).unwrap_err();
    assert!(flat.contains("axis 2: found 1 places"), "{flat}");
    let far = plain([0; 3], AXES, "").replacen("Extent=\"0 3 0 2 0 2 \"", "Extent=\"0 4000000000000 0 2 0 2\"", 1);
    let far = load("a.vtr", far, &ReadOptions::default()).unwrap_err();
    assert!(far.contains("4000000000001") || far.contains("numbers"), "{far}");
    let error = load("a.vtr", plain([0; 3], AXES, ""), &ReadOptions { frame: Some(2), ..ReadOptions::default() });
    assert!(error.unwrap_err().contains("frame: found 2"));
}

/// The numbers are those that VTK 9.7 and numpy find.
#[test]
fn the_shared_grid_is_what_vtk_finds() {
    let Some(path) = data("vtk/cth.vtr") else { return };
    let loaded = read(&path, &array("Pressure")).unwrap();
    let pressure = grid(&loaded);
    assert_eq!((pressure.dims(), loaded.info.columns.len()), ([128, 64, 64], 9));
    let (low, high) = pressure.value_range().unwrap();
    assert_eq!((low as f32, high as f32), (-2.359452e10, 1.120_376_26e11));
    let samples = vr_core::with_grid!(pressure.lattice().values(), g => {
        use vr_core::Voxel;
        g.samples().iter().map(|s| f64::from(s.to_f32())).sum::<f64>()
    });
    assert!((samples - 5607811848542.879).abs() < 1.0, "{samples}");
    let (low, high) = pressure.bounds();
    assert!(
        (low.x - (-7.5 - 7.39062023) / 2.0).abs() < 1e-8 && (high.y - (3.0 + 2.90625) / 2.0).abs() < 1e-12,
        "{low} {high}"
    );
    // The active scalars.
    let mass = read(&path, &ReadOptions::default()).unwrap();
    assert!(matches!(mass.volume, Volume::Rectilinear(_)));
    assert!(mass.notes.iter().any(|n| n.contains("'Mass for Body, Nose' of the cells is taken")), "{:?}", mass.notes);
}
