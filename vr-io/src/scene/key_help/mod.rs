//! Meaning, unit, range and default of every key of a scene file.

mod volume;

use vr_core::transfer::Preset;

use super::volume_section::VolumeSource;

/// A key of a section.
pub(super) struct KeyHelp {
    /// Name of the key.
    pub key: &'static str,
    /// Meaning, unit and range.
    pub meaning: String,
    /// Value where the key is absent.
    pub absent: Absent,
}

/// Value of a key that is absent.
#[derive(Clone, Copy)]
pub(super) enum Absent {
    /// This one, as TOML.
    Usual(&'static str),
    /// None, or one that depends on the rest of the scene; an example of a value as TOML.
    Example(&'static str),
    /// None, where an example would say nothing.
    Nothing,
}

use Absent::{Example, Nothing, Usual};
use volume::volume;

fn key(key: &'static str, absent: Absent, meaning: impl Into<String>) -> KeyHelp {
    KeyHelp { key, meaning: meaning.into(), absent }
}

/// Sections of a scene file in the order in which they are written, each with a line on what it is; `[volume]` comes with the keys that
/// mean something to its source.
pub(super) fn sections(source: Option<&VolumeSource>) -> [(&'static str, &'static str, Vec<KeyHelp>); 11] {
    [
        ("volume", "Volume: numbers in space. It has one source: path, phantom, data or points.", volume(source)),
        ("transfer", "Transfer function: from the value of the volume to colour and opacity.", transfer()),
        ("shading", "Shading: how surfaces in the volume reflect light (Blinn-Phong).", shading()),
        (
            "scattering",
            "Scattering: the medium scatters the light that shines into it, with shadows. Drawn by the renderer light; goes without [shading].",
            scattering(),
        ),
        (
            "camera",
            "Camera, in the world units of the volume. What is absent is that of a camera which sees all that is visible.",
            camera(),
        ),
        ("mesh", "Opaque surface among the volume, lit as [shading] says.", mesh()),
        (
            "labels",
            "Labels beside the volume: a mask or a segmentation, drawn by the ray caster and the reference.",
            labels(),
        ),
        ("clip", "Parts that are cut away, of volume and surface.", clip()),
        ("image", "Picture.", image()),
        (
            "annotations",
            "Words and signs over the finished picture; an EXR file, which is data, has none.",
            annotations(),
        ),
        ("render", "Renderer, its options, and what becomes of the values along a ray.", render()),
    ]
}

fn transfer() -> Vec<KeyHelp> {
    vec![
        key(
            "look",
            Usual("\"auto\""),
            "Choice where neither points nor preset nor file is given: auto finds transfer function, shading and filter from the volume; \
             flat spreads a preset over the values.",
        ),
        key(
            "preset",
            Example("\"viridis\""),
            format!("Transfer function by name, in place of points: {}.", Preset::NAMES.join(", ")),
        ),
        key(
            "range",
            Example("[0.0, 255.0]"),
            "Values that a preset or a file is stretched over; absent: its own, or those of the volume.",
        ),
        key(
            "file",
            Example("\"map.json\""),
            "Transfer function of ParaView, 3D Slicer, VTK, ImageJ, a table or TOML in place of points, relative to the folder of this file.",
        ),
        key(
            "unit_distance",
            Example("1.0"),
            "World length that the opacities below belong to, above 0: light that crosses so much of one value is dimmed by its opacity. \
             A larger one makes everything more transparent. Absent: the mean distance of voxels.",
        ),
        key(
            "opacity_rule",
            Usual("\"power\""),
            "Meaning of the opacities: power (opacity of one unit distance) or extinction (extinction times one unit distance).",
        ),
        key(
            "colors",
            Usual("\"linear\""),
            "Encoding of the colours of the points: linear light, or srgb as colour pickers show it.",
        ),
        key(
            "points",
            Nothing,
            "Points in order of their values, straight lines between them, constant outside: value in the units of the volume, colour as \
             red, green, blue (1 is white), opacity from 0 (invisible) to 1 (a wall). Emission, on all points or none: light per world \
             unit in place of colour times extinction.",
        ),
        key(
            "rows",
            Nothing,
            "Rows in place of points, for a transfer function of two dimensions, value and gradient: each with gradient (a magnitude, in value per world \
             unit, in order) and points, as above, of opacities up to 0.999. Between two rows extinction and emission change linearly with the \
             magnitude; beyond the first and the last they stay.",
        ),
    ]
}

fn scattering() -> Vec<KeyHelp> {
    vec![
        key(
            "albedo",
            Usual("\"color\""),
            "Share of the extinction that is scattering, the rest being absorption: color (that of the transfer function; the medium does not glow \
             then), or a number from 0 to 1, or one for each of red, green and blue (the colour is that of the glow then).",
        ),
        key(
            "phase",
            Usual("\"isotropic\""),
            "Directions of scattered light: isotropic, rayleigh, { henyey-greenstein = g } with the mean cosine g between -1 and 1, \
             { double-henyey-greenstein = { g = [0.8, -0.3], share = 0.7 } }, or { tabulated = [[-1.0, 0.5], [1.0, 1.5]] }: cosine and value.",
        ),
        key(
            "environment",
            Usual("[0.0, 0.0, 0.0]"),
            "Radiance that comes from all sides and is scattered, 0 to 1e6; it is not seen behind the medium (image.background is).",
        ),
        key(
            "environment_map",
            Example("\"sky.exr\""),
            "Picture of the light from all sides, which adds to the environment: an equirectangular EXR, or another picture by the sRGB curve, relative \
             to the folder of this file. Its top is +y, its middle -z. Goes with model = \"full\" of the renderer light.",
        ),
        key(
            "lights",
            Usual("[{ headlight = true, color = [1.0, 1.0, 1.0] }]"),
            "Lights at infinity: each is either a headlight or has a direction, a world vector towards it; and a colour. One of colour L sheds pi L on \
             a surface that faces it, so that a white one shows L.",
        ),
        key(
            "point_lights",
            Example("[{ position = [0.0, 2.0, 0.0], color = [4.0, 4.0, 4.0] }]"),
            "Lights at a place in the world, which shine in all directions: one of colour L sheds pi L / d^2 at the distance d. They go with \
             model = \"full\" of the renderer light.",
        ),
        key(
            "surfaces",
            Example(
                "[{ shape = { sphere = { centre = [0.0, 2.0, 0.0], radius = 0.3 } }, emission = [9.0, 9.0, 9.0] }]",
            ),
            "Opaque surfaces, which are seen, shade and light the medium: each has a shape ({ plane = { point = [x, y, z], normal = [x, y, z] } }, \
             { sphere = { centre = [x, y, z], radius = r } }, { triangle = [three points] }, { parallelogram = { corner = [x, y, z], edges = [two \
             vectors] } }, or { box = { low = [x, y, z], high = [x, y, z], faces = [\"-y\", \"+x\"] } } of all or some faces), an emission (radiance, \
             linear RGB), a reflectance (0 to 1, linear RGB) and a finish: matte, mirror, or { gloss = exponent }. They go with model = \"full\" of the \
             renderer light.",
        ),
    ]
}

fn shading() -> Vec<KeyHelp> {
    vec![
        key("enabled", Usual("true"), "True to shade; false shows the colours of the transfer function as they are."),
        key("ambient", Usual("0.2"), "Light from everywhere, 0 to 1000."),
        key("diffuse", Usual("0.7"), "Light that a rough surface reflects, 0 to 1000."),
        key("specular", Usual("0.3"), "Strength of highlights, 0 to 1000."),
        key("power", Usual("20.0"), "Sharpness of highlights, 0 to 10000."),
        key(
            "lights",
            Usual("[{ headlight = true, color = [1.0, 1.0, 1.0] }]"),
            "Lights: each with headlight = true (from the eye) or a direction (a world vector towards the light), and a colour.",
        ),
        key(
            "gradient",
            Usual("\"central-differences\""),
            "Source of the normals: central-differences (smooth) or analytic (of the filter itself).",
        ),
        key(
            "gradient_opacity",
            Example("[[0.0, 0.0], [10.0, 1.0]]"),
            "Factor on the extinction by the steepness of the values: pairs of magnitude (value per world unit) and factor, in order. \
             Absent: no influence.",
        ),
    ]
}

fn camera() -> Vec<KeyHelp> {
    vec![
        key(
            "projection",
            Usual("\"orthographic\""),
            "orthographic (parallel rays, sizes can be measured) or perspective.",
        ),
        key("eye", Example("[0.0, 0.0, 9.0]"), "Position of the eye; it goes without azimuth and elevation."),
        key("target", Example("[0.0, 0.0, 0.0]"), "Point in the middle of the picture."),
        key("up", Example("[0.0, 1.0, 0.0]"), "Vector that points up in the picture; any length, not along the view."),
        key(
            "azimuth",
            Example("30.0"),
            "Angle in degrees about the upright axis from which all is seen, in place of eye; 0 looks along -z, or into a patient's face. Absent: 30, \
             or 15 of a patient.",
        ),
        key(
            "elevation",
            Example("20.0"),
            "Angle in degrees above the level from which all is seen, in place of eye. Absent: 20, or 10 of a patient.",
        ),
        key(
            "height",
            Example("2.0"),
            "Orthographic: world height of the picture, above 0. A smaller one zooms in. Absent: all fits.",
        ),
        key("fov", Example("30.0"), "Perspective: vertical angle of view in degrees, above 0, below 180. Absent: 30."),
    ]
}

fn mesh() -> Vec<KeyHelp> {
    vec![
        key(
            "path",
            Example("\"surface.stl\""),
            "STL, OBJ or PLY file in the world of the volume, relative to the folder of this file.",
        ),
        key(
            "color",
            Example("[0.8, 0.8, 0.8]"),
            "Linear red, green, blue of all of it; absent: the colours of the file, or grey.",
        ),
    ]
}

fn labels() -> Vec<KeyHelp> {
    vec![
        key(
            "file",
            Example("\"segmentation.seg.nrrd\""),
            "Volume of whole numbers, each the name of a region, in the world of the volume; relative to the folder of this file.",
        ),
        key(
            "names",
            Example("\"labels.txt\""),
            "List of the names and colours of labels, of ITK-SNAP, FreeSurfer or Slicer; relative to the folder of this file.",
        ),
        key("mask", Usual("false"), "True to show the volume where there is a label, and nothing elsewhere."),
        key(
            "as",
            Example("\"solid\""),
            "The way in which labels are drawn: solid (one colour, a lit surface at the boundary), tinted (the opacities of the volume in the \
             colour of the label) or volume. Absent: solid.",
        ),
        key(
            "label",
            Example("[{ label = 1, color = [1.0, 0.0, 0.0], opacity = 0.5, visible = true, as = \"solid\" }]"),
            "Choices about single labels, by number (0 is the background) or name; the later of two about one comes first.",
        ),
    ]
}

fn clip() -> Vec<KeyHelp> {
    vec![
        key(
            "box",
            Example("[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]"),
            "Lower and upper corner of the world box that is kept; absent: everything.",
        ),
        key(
            "planes",
            Example("[{ normal = [0.0, 0.0, 1.0], offset = 0.5 }]"),
            "Planes: what lies where normal . x >= offset is kept, of all of them.",
        ),
    ]
}

fn image() -> Vec<KeyHelp> {
    vec![
        key("size", Usual("[512, 512]"), "Width and height in pixels, 1 to 65536."),
        key("samples", Usual("1"), "Supersampling, 1 to 64: a pixel is the mean of so many rays squared."),
        key(
            "background",
            Usual("[0.0, 0.0, 0.0]"),
            "Linear red, green, blue behind everything, 0 or more; EXR files leave it out.",
        ),
    ]
}

fn annotations() -> Vec<KeyHelp> {
    vec![
        key("title", Example("\"Head, T1\""), "Title in the upper left corner, in Latin, Greek or Cyrillic letters."),
        key(
            "marker",
            Usual("false"),
            "True for axes that turn with the camera: R L A P S I of a patient, x y z of anything else.",
        ),
        key("scale", Usual("false"), "True for a bar of a round length."),
        key(
            "legend",
            Usual("false"),
            "True for the colours and opacities of the values, with their unit where it is known.",
        ),
    ]
}

fn render() -> Vec<KeyHelp> {
    vec![
        key("renderer", Example("\"raycast\""), "Renderer; absent: raycast, or splat for scattered points."),
        key(
            "compositing",
            Usual("\"over\""),
            "What becomes of the values along a ray: over (light is emitted and absorbed), first (surface of one value), average, maximum, \
             minimum, or accumulate (opacity up to a level).",
        ),
        key("threshold", Example("0.5"), "first: the value of the surface, in the units of the volume."),
        key("level", Example("0.95"), "accumulate: opacity to stop at, above 0, at most 1."),
        key(
            "max_error",
            Example("0.001"),
            "Bound of the error of every pixel, in parts of max(1, largest magnitude), for renderers that can keep one.",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{GridDescription, SceneFileError, parse_scene};

    /// Names of the keys that the parser knows in a section.
    fn parsed_keys(section: &str) -> Vec<String> {
        match parse_scene(&format!("[{section}]\nqqqqqq = 1\n"), Path::new("")) {
            Err(SceneFileError::UnknownKey { mut known, .. }) => {
                known.sort();
                known
            }
            other => panic!("{section}: {other:?}"),
        }
    }

    #[test]
    fn every_section_has_its_help() {
        let Err(SceneFileError::UnknownKey { known, .. }) = parse_scene("[qqqqqq]\n", Path::new("")) else { panic!() };
        assert_eq!(known, sections(None).map(|(name, ..)| name), "in this order");
    }

    #[test]
    fn every_key_has_its_help_and_no_other() {
        let sources = [
            VolumeSource::File(Default::default()),
            VolumeSource::Phantom { name: String::new(), size: None },
            VolumeSource::PhantomPoints { name: String::new(), count: None },
            VolumeSource::Grid { data: Vec::new(), grid: GridDescription::default() },
            VolumeSource::Points { points: Vec::new(), kernel: None, mixing: None, colors: None },
        ];
        let of_all = sources.iter().flat_map(|source| volume(Some(source)));
        let mut volume_keys: Vec<&str> = of_all.map(|help| help.key).collect();
        volume_keys.sort_unstable();
        volume_keys.dedup();
        assert_eq!(volume_keys, parsed_keys("volume"));
        // Keys of `[render]` that are not known are a renderer's.
        for (name, _, help) in sections(None).into_iter().filter(|(name, ..)| !["volume", "render"].contains(name)) {
            let mut keys: Vec<&str> = help.iter().map(|help| help.key).collect();
            keys.sort_unstable();
            assert_eq!(keys, parsed_keys(name), "{name}");
        }
    }

    #[test]
    fn defaults_and_examples_are_taken() {
        let required =
            "[camera]\neye = [0,0,9]\ntarget = [0,0,0]\nup = [0,1,0]\n[mesh]\npath = \"x\"\n[labels]\nfile = \"x\"\n";
        for (name, _, keys) in sections(None) {
            for KeyHelp { key, meaning, absent } in keys {
                assert!(meaning.ends_with('.'), "{name}.{key}: {meaning}");
                let (Usual(value) | Example(value)) = absent else { continue };
                let mut table: toml::Table = toml::from_str(required).unwrap();
                let value: toml::Table =
                    toml::from_str(&format!("{key} = {value}")).unwrap_or_else(|e| panic!("{key}: {e}"));
                let section = table.entry(name).or_insert_with(|| toml::Value::Table(toml::Table::new()));
                section.as_table_mut().unwrap().extend(value);
                if name == "volume" && key != "path" {
                    section.as_table_mut().unwrap().insert("path".to_owned(), "x".into());
                }
                if ["resample_filter", "conserve"].contains(&key) {
                    section.as_table_mut().unwrap().insert("resample".to_owned(), "finest".into());
                }
                let text = toml::to_string(&table).unwrap();
                parse_scene(&text, Path::new("x.toml")).unwrap_or_else(|e| panic!("{name}.{key}: {e}"));
            }
        }
    }
}
