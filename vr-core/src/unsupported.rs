//! Features of scenes and views that a renderer cannot draw.

use std::fmt;

use crate::volume::Volume;

/// A refusal: a renderer, as it is configured, cannot draw a feature of a scene or view.
///
/// # Examples
/// ```
/// use vr_core::{Feature, Unsupported};
///
/// let what = "the filter 'nearest': slices are interpolated linearly".to_owned();
/// let refusal = Unsupported { renderer: "shear-warp", feature: Feature::Filter, what };
/// assert_eq!(
///     refusal.to_string(),
///     "renderer shear-warp does not support the filter 'nearest': slices are interpolated linearly"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("renderer {renderer} does not support {what}")]
pub struct Unsupported {
    /// The renderer.
    pub renderer: &'static str,
    /// The feature that it lacks.
    pub feature: Feature,
    /// The feature in words, with the reason, as a message ends: `the filter 'nearest': slices are interpolated linearly`.
    pub what: String,
}

impl Unsupported {
    /// Kinds that a renderer of grids draws, for [`Self::volume_kind`].
    pub const GRIDS: &str = "uniform grids, to which others can be resampled";

    /// The refusal of a kind of volume by a renderer that draws others.
    ///
    /// # Examples
    /// ```
    /// use vr_core::{CellMesh, Unsupported, Volume};
    /// use vr_core::cells::CellValues;
    /// use glam::DVec3;
    ///
    /// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let mesh = CellMesh::new(corners, vec![[0, 1, 2, 3]], CellValues::Cells(vec![1.0]))?;
    /// let refusal = Unsupported::volume_kind("shear-warp", &Volume::from(mesh), Unsupported::GRIDS);
    /// assert_eq!(
    ///     refusal.to_string(),
    ///     "renderer shear-warp does not support volumes of the kind 'mesh of cells'; it draws uniform grids, to which others can be resampled"
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn volume_kind(renderer: &'static str, volume: &Volume, draws: &str) -> Self {
        let what = format!("volumes of the kind '{}'; it draws {draws}", volume.kind());
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
    /// Scattering of light in the medium.
    Scattering,
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
            Self::Scattering => "scattering",
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
