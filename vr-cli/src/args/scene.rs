//! Flags for everything that a scene file can say; they override it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use vr_core::{Filter, GradientMethod, OpacityRule};
use vr_io::{ColorEncoding, CompositingName, LookName, ProjectionName};

use super::{Background, LabelArgs, ResampleArgs, ScatteringArgs, VolumeArgs, value};
use crate::failure::Failure;
use crate::transfer_box::TransferBox;

/// A scene: a file, and what overrides it.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The volume.
    #[command(flatten)]
    pub volume: VolumeArgs,
    /// Resampling of a volume that is no grid.
    #[command(flatten)]
    pub resample: ResampleArgs,
    /// A scene file (TOML); all other flags override it
    #[arg(long, value_name = "FILE", help_heading = "Scene")]
    pub scene: Option<PathBuf>,
    /// Reconstruction filter: nearest, trilinear, bspline, catmull-rom or gaussian
    #[arg(long, value_name = "NAME", value_parser = value::word::<Filter>, help_heading = "Scene")]
    pub filter: Option<Filter>,
    /// `[transfer]`.
    #[command(flatten)]
    pub transfer: TransferArgs,
    /// `[shading]`.
    #[command(flatten)]
    pub shading: ShadingArgs,
    /// `[scattering]`.
    #[command(flatten)]
    pub scattering: ScatteringArgs,
    /// `[labels]`.
    #[command(flatten)]
    pub labels: LabelArgs,
    /// `[mesh]`.
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// `[camera]`.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// `[clip]` and `[image]`.
    #[command(flatten)]
    pub image: ImageArgs,
    /// Compositing of the field along a ray.
    #[command(flatten)]
    pub compositing: CompositingArgs,
}

/// `[transfer]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Transfer function")]
pub struct TransferArgs {
    /// Look without a transfer function: auto finds one from the volume, with shading; flat spreads a preset over the values
    #[arg(long, value_name = "LOOK", value_parser = value::word::<LookName>, conflicts_with_all = ["transfer", "point"])]
    pub look: Option<LookName>,
    /// A preset by name, such as ct-bone, mr-angio or pet-hot; vr presets shows those that suit a volume
    #[arg(long, value_name = "NAME", conflicts_with_all = ["look", "transfer", "point"])]
    pub preset: Option<String>,
    /// A preset, or a file of ParaView (.json, .xml), 3D Slicer (.vp), VTK (.xml), ImageJ (.lut), a table (.csv) or TOML
    #[arg(long, value_name = "PRESET|FILE")]
    pub transfer: Option<PathBuf>,
    /// A control point: value, linear RGB, opacity; repeat it in order of the values
    #[arg(long, value_name = "V,R,G,B,A", value_parser = value::point, allow_hyphen_values = true,
          conflicts_with = "transfer")]
    pub point: Vec<[f64; 5]>,
    /// A box of values and of gradient magnitudes (value per world unit), with soft edges: what lies in it has a linear RGB and an opacity, all else is
    /// clear; may be repeated
    #[arg(long, value_name = "V,V,G,G,R,G,B,A", value_parser = TransferBox::parse, allow_hyphen_values = true,
          conflicts_with_all = ["look", "preset", "transfer", "point"])]
    pub transfer_box: Vec<TransferBox>,
    /// Values that a preset or a file is stretched over; those of the volume if absent
    #[arg(long, value_name = "LOW,HIGH", value_parser = value::pair, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// World length that the opacities belong to; the mean distance of voxels if absent
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub unit_distance: Option<f64>,
    /// Meaning of the opacities: power or extinction
    #[arg(long, value_name = "RULE", value_parser = value::word::<OpacityRule>)]
    pub opacity_rule: Option<OpacityRule>,
    /// Encoding of the control points' colours: linear or srgb
    #[arg(long, value_name = "ENCODING", value_parser = value::word::<ColorEncoding>)]
    pub colors: Option<ColorEncoding>,
}

/// `[shading]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Shading")]
pub struct ShadingArgs {
    /// Shade (Blinn-Phong, a headlight unless --light says otherwise); so does every flag of this group
    #[arg(long)]
    pub shading: bool,
    /// Do not shade, whatever the scene file says
    #[arg(long, conflicts_with_all = ["shading", "ambient", "diffuse", "specular", "power", "light", "headlight", "gradient",
          "gradient_opacity"])]
    pub no_shading: bool,
    /// Ambient coefficient
    #[arg(long, value_name = "KA", allow_hyphen_values = true)]
    pub ambient: Option<f64>,
    /// Diffuse coefficient
    #[arg(long, value_name = "KD", allow_hyphen_values = true)]
    pub diffuse: Option<f64>,
    /// Specular coefficient
    #[arg(long, value_name = "KS", allow_hyphen_values = true)]
    pub specular: Option<f64>,
    /// Specular exponent
    #[arg(long, value_name = "P", allow_hyphen_values = true)]
    pub power: Option<f64>,
    /// World vector towards a light, and its linear RGB if it is not white; may be repeated
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", value_parser = value::light, allow_hyphen_values = true)]
    pub light: Vec<([f64; 3], [f64; 3])>,
    /// Keep a light along the line of sight beside those of --light, of a linear colour if it is not to be white
    #[arg(long, value_name = "R,G,B", value_parser = value::triple::<f64>, num_args = 0..=1, require_equals = true,
          default_missing_value = "1,1,1")]
    pub headlight: Option<[f64; 3]>,
    /// Source of the normals: central-differences or analytic
    #[arg(long, value_name = "METHOD", value_parser = value::word::<GradientMethod>)]
    pub gradient: Option<GradientMethod>,
    /// Factor on the extinction at a gradient magnitude; repeat it in order of the magnitudes
    #[arg(long, value_name = "MAGNITUDE,FACTOR", value_parser = value::pair, allow_hyphen_values = true)]
    pub gradient_opacity: Vec<[f64; 2]>,
}

/// `[mesh]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Opaque surface")]
pub struct MeshArgs {
    /// A surface in the volume's world, for renderers that take one: STL, OBJ or PLY; lit as the volume is shaded, or by a headlight
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Linear RGB of the surface; the colours of its vertices, or grey, if absent
    #[arg(long, value_name = "R,G,B", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub mesh_color: Option<[f64; 3]>,
}

/// Extent that an automatic camera shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fit {
    /// The visible part of the volume.
    Visible,
    /// The whole volume.
    Box,
}

/// `[camera]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// Extent that fills the picture: visible (what can be seen) or box (the whole volume)
    #[arg(long, value_name = "WHAT", default_value = "visible", conflicts_with_all = ["eye", "target", "up"])]
    pub fit: Fit,
    /// See everything from this many degrees to the right of the volume's front: the +z side, a patient's face
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, conflicts_with_all = ["eye", "target", "up"])]
    pub azimuth: Option<f64>,
    /// See everything from this many degrees above: the +y side, a patient's head
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, conflicts_with_all = ["eye", "target", "up"])]
    pub elevation: Option<f64>,
    /// Position of the eye
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// Point that the middle of the picture shows
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,
    /// World vector that points up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub up: Option<[f64; 3]>,
    /// Projection, orthographic or perspective; --height and --fov imply it
    #[arg(long, value_name = "KIND", value_parser = value::word::<ProjectionName>)]
    pub projection: Option<ProjectionName>,
    /// Orthographic: world height of the picture
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, conflicts_with = "fov")]
    pub height: Option<f64>,
    /// Perspective: vertical angle in degrees
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub fov: Option<f64>,
}

/// `[clip]` and `[image]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Image")]
pub struct ImageArgs {
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub size: Option<[u32; 2]>,
    /// Supersampling: a pixel is the mean of N x N rays
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Linear RGB behind everything, #RRGGBB, white, grey or black; transparent keeps the opacity in a PNG, as --alpha does
    #[arg(long, value_name = "COLOR", allow_hyphen_values = true)]
    pub background: Option<Background>,
    /// Lower and upper corner of the world box that is kept
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = value::corners, allow_hyphen_values = true)]
    pub crop: Option<[[f64; 3]; 2]>,
    /// Keep the side of a plane where normal . x >= offset; may be repeated
    #[arg(long, value_name = "X,Y,Z,OFFSET", value_parser = value::plane, allow_hyphen_values = true)]
    pub clip_plane: Vec<([f64; 3], f64)>,
}

impl ImageArgs {
    /// Refuses a transparent background, for commands that write no picture with opacity.
    ///
    /// # Errors
    /// [`Failure::Usage`] naming the commands that keep it.
    pub fn check_opaque(&self) -> Result<(), Failure> {
        if self.background == Some(Background::Transparent) {
            let message =
                "nothing here keeps opacity; must be a colour (vr render keeps it, and so do turntable and animate)";
            return Err(Failure::usage(format!("--background: found transparent, but {message}")));
        }
        Ok(())
    }
}

/// Compositing of the field along a ray.
#[derive(Debug, Args)]
#[command(next_help_heading = "Compositing")]
pub struct CompositingArgs {
    /// Operator along a ray: over, first, average, maximum, minimum or accumulate
    #[arg(long, value_name = "NAME", value_parser = value::word::<CompositingName>)]
    pub compositing: Option<CompositingName>,
    /// first: value to reach
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub threshold: Option<f64>,
    /// accumulate: opacity to stop at
    #[arg(long, value_name = "OPACITY", allow_hyphen_values = true)]
    pub level: Option<f64>,
}
