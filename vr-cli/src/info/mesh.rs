//! `vr info` of a mesh.

use std::path::Path;

use serde::Serialize;
use vr_io::LoadedMesh;

use crate::args::VolumeArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::number;

/// Returns the file that flags name, if it is a mesh and no flag makes a volume of it.
pub fn named(args: &VolumeArgs) -> Option<&Path> {
    let VolumeArgs { path, frame, component, transform, dims, .. } = args;
    let about_volumes = frame.is_some() || component.is_some() || transform.is_some() || dims.is_some();
    path.as_deref().filter(|path| !about_volumes && vr_io::is_mesh(path))
}

/// Describes a mesh.
///
/// # Errors
/// Any fault of the file.
pub fn run(path: &Path, console: Console) -> Result<(), Failure> {
    let LoadedMesh { mesh, format, notes } = vr_io::read_mesh(path).map_err(Failure::failed)?;
    for note in &notes {
        console.note(note);
    }
    let (low, high) = mesh.bounds();
    let json = Json {
        mesh: path.display().to_string(),
        format,
        triangles: mesh.triangles().len(),
        vertices: mesh.positions().len(),
        bounds: [low.to_array(), high.to_array()],
        normals: mesh.normals().is_some(),
        colors: mesh.colors().is_some(),
        notes: &notes,
    };
    console.result(&json.text(), &json)
}

#[derive(Serialize)]
struct Json<'a> {
    mesh: String,
    format: &'a str,
    triangles: usize,
    vertices: usize,
    /// Lower and upper corner, in the world.
    bounds: [[f64; 3]; 2],
    normals: bool,
    colors: bool,
    notes: &'a [String],
}

impl Json<'_> {
    fn text(&self) -> String {
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        let given = match (self.normals, self.colors) {
            (true, true) => "normals and colours",
            (true, false) => "normals",
            (false, true) => "colours",
            (false, false) => "positions alone",
        };
        format!(
            "mesh         {}\nformat       {}\nsize         {} triangles, {} vertices\nbounds       {low} to {high}\n\
             vertices     {given}\ntry          vr render VOLUME --mesh {0}\n",
            self.mesh, self.format, self.triangles, self.vertices
        )
    }
}
