//! Features of scenes and views that a renderer cannot draw.

use std::fmt;

use crate::volume::Volume;

/// A refusal: a renderer, as it is configured, cannot draw a feature of a scene or view.
///
/// # Examples
/// ```
/// use vr_core::{Feature, Unsupported};
///
/// let what = "opaque surfaces: a texel of the intermediate image is no pixel".to_owned();
/// let refusal = Unsupported { renderer: "shear-warp", feature: Feature::Surfaces, what };
/// assert_eq!(
///     refusal.to_string(),
///     "renderer shear-warp does not support opaque surfaces: a texel of the intermediate image is no pixel"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("renderer {renderer} does not support {what}")]
pub struct Unsupported {
    /// The renderer.
    pub renderer: &'static str,
    /// The feature that it lacks.
    pub feature: Feature,
    /// The feature in words, with the reason, as a message ends: `opaque surfaces: a texel of the intermediate image is no pixel`.
    pub what: String,
}

impl Unsupported {
    /// The refusal of a kind of volume.
    pub fn volume_kind(renderer: &'static str, volume: &Volume) -> Self {
        let what = format!("volumes of the kind '{}'", volume.kind());
        Self { renderer, feature: Feature::VolumeKind, what }
    }
}

/// A feature of a scene or view that a renderer may lack.
///
/// # Examples
/// ```
/// use std::collections::BTreeSet;
/// use vr_core::Feature;
///
/// let lacking = BTreeSet::from([Feature::Surfaces, Feature::Color]);
/// let words: Vec<String> = lacking.iter().map(Feature::to_string).collect();
/// assert_eq!(words.join(", "), "colour, opaque surfaces");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Feature {
    /// Volumes of this kind.
    VolumeKind,
    /// Size: volumes as large as this, or as many pixels.
    Size,
    /// Missing values in the volume.
    MissingValues,
    /// A transfer function that changes faster than f32 tells values apart.
    Precision,
    /// The reconstruction filter.
    Filter,
    /// The compositing operator.
    Compositing,
    /// Shading.
    Shading,
    /// Gradients of the reconstruction filter itself.
    AnalyticGradients,
    /// Opacity that follows the gradient.
    GradientOpacity,
    /// Colours, or lights of a colour.
    Color,
    /// Opaque surfaces among the volume.
    Surfaces,
    /// Perspective projection.
    Perspective,
    /// Several rays a pixel.
    Supersampling,
    /// A promised error.
    MaxError,
    /// A model of a renderer's own.
    Model,
    /// A setting of the renderer that does not go with the scene.
    Setting,
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::VolumeKind => "kind of volume",
            Self::Size => "size",
            Self::MissingValues => "missing values",
            Self::Precision => "precision",
            Self::Filter => "filter",
            Self::Compositing => "compositing",
            Self::Shading => "shading",
            Self::AnalyticGradients => "analytic gradients",
            Self::GradientOpacity => "gradient opacity",
            Self::Color => "colour",
            Self::Surfaces => "opaque surfaces",
            Self::Perspective => "perspective",
            Self::Supersampling => "supersampling",
            Self::MaxError => "a promised error",
            Self::Model => "model",
            Self::Setting => "setting",
        })
    }
}
