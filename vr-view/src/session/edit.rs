//! Edits: what a person does to the scene and the view, one message each.

use serde::Deserialize;
use vr_core::{ControlPoint, Plane};
use vr_io::{CameraSection, ShadingSection};

/// Change of the scene, the view or the renderer.
///
/// In JSON, `kind` names it and the other keys are its own: `{"kind": "orbit", "right": 5, "up": 0}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Edit {
    /// Turns the camera about its target, in degrees: to the right about the picture's upright axis, then up.
    Orbit {
        /// Degrees to the right.
        right: f64,
        /// Degrees up.
        up: f64,
    },
    /// Turns the picture about the line of sight, counterclockwise as it is seen.
    Roll {
        /// Degrees.
        degrees: f64,
    },
    /// Moves the camera across the view, in heights of the picture at the target.
    Pan {
        /// Heights to the right.
        right: f64,
        /// Heights up.
        up: f64,
    },
    /// Comes nearer by a factor; the place that is seen at `at` stays where it is.
    Zoom {
        /// Factor by which things at the target grow.
        factor: f64,
        /// Place in the picture: heights to the right of its middle, and above it.
        at: [f64; 2],
    },
    /// Looks at all that is visible from a side.
    Side {
        /// The side.
        side: Side,
    },
    /// Frames what is visible, from where the camera is.
    Fit,
    /// Puts the camera where it was when the scene was opened.
    ResetCamera,
    /// Takes a camera as scene files state it; all of it must be stated.
    Camera {
        /// The camera.
        camera: CameraSection,
    },
    /// Chooses the projection; what is seen at the target keeps its size.
    Projection {
        /// True for rays from the eye.
        perspective: bool,
    },
    /// Sets the vertical angle of a perspective; the eye moves so that what is seen at the target keeps its size.
    FieldOfView {
        /// Degrees.
        degrees: f64,
    },
    /// Sets width and height of the picture at rest, in pixels.
    Size {
        /// Width and height.
        size: [u32; 2],
    },
    /// Begins or ends a gesture: edits in between are undone as one.
    Gesture {
        /// True where it begins.
        begins: bool,
    },
    /// Replaces the points of the transfer function, in linear light.
    Transfer {
        /// The points, in order of their values.
        points: Vec<ControlPoint>,
    },
    /// Sets the world length that the opacities belong to.
    UnitDistance {
        /// World units.
        length: f64,
    },
    /// Takes a preset, fitted to the values of the volume.
    Preset {
        /// Its name, as `vr help presets` lists it.
        name: String,
    },
    /// Finds the transfer function from the volume.
    AutomaticLook,
    /// Sets shading and lights.
    Shading {
        /// The section of a scene file.
        shading: ShadingSection,
    },
    /// Sets the world box that is kept.
    Crop {
        /// Lower and upper corner; `None` keeps all.
        corners: Option<[[f64; 3]; 2]>,
    },
    /// Sets the half spaces that are kept.
    Planes {
        /// The planes.
        planes: Vec<Plane>,
    },
    /// Sets the linear colour behind everything.
    Background {
        /// Linear RGB.
        color: [f32; 3],
    },
    /// Chooses a renderer at its defaults.
    Renderer {
        /// Its name.
        name: String,
    },
    /// Chooses how good the picture at rest is.
    Quality {
        /// The quality.
        quality: Quality,
    },
    /// Takes back the last change that was no move of the camera.
    Undo,
    /// Makes the change again that was taken back last.
    Redo,
}

impl Edit {
    /// True if the edit asks what is visible, or what the values are: for a survey of the volume.
    pub(super) fn needs_survey(&self) -> bool {
        matches!(self, Self::Preset { .. } | Self::AutomaticLook | Self::Fit | Self::Side { .. })
    }
}

/// Side of a volume from which it is looked at: the file's own sides, or those of a patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// +z; a patient's face.
    Front,
    /// −z; a patient's back.
    Back,
    /// −x; a patient's right.
    Left,
    /// +x; a patient's left.
    Right,
    /// +y; a patient's head.
    Top,
    /// −y; a patient's feet.
    Bottom,
}

impl Side {
    /// Azimuth and elevation in degrees from which [`vr_io::framing`] sees this side.
    pub(super) const fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Left => (-90.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
        }
    }
}

/// Quality of the picture at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// The renderer's option `quality` at `draft`.
    Draft,
    /// The renderer's option `quality` at `normal`.
    Normal,
    /// The renderer's option `quality` at `fine`.
    Fine,
    /// Every pixel proven to be within [`PROVEN`].
    Proven,
}

impl Quality {
    /// Word of the renderers' option `quality`; `None` where it is a promise.
    pub(super) const fn option(self) -> Option<&'static str> {
        match self {
            Self::Draft => Some("draft"),
            Self::Normal => Some("normal"),
            Self::Fine => Some("fine"),
            Self::Proven => None,
        }
    }
}

/// Largest error of a pixel under [`Quality::Proven`]: a level of 8 bits, as `vr render --quality proven` has it.
pub const PROVEN: f64 = 4e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_and_strange_ones_refused() {
        let read = |text: &str| serde_json::from_str::<Edit>(text);
        assert_eq!(read(r#"{"kind": "orbit", "right": 5, "up": -1.5}"#).unwrap(), Edit::Orbit { right: 5.0, up: -1.5 });
        assert_eq!(read(r#"{"kind": "fit"}"#).unwrap(), Edit::Fit);
        let side = r#"{"kind": "side", "side": "front"}"#;
        assert_eq!(read(side).unwrap(), Edit::Side { side: Side::Front });
        for wrong in [
            r#"{"kind": "orbit", "right": 5}"#,
            r#"{"kind": "orbit", "right": 5, "up": 1e999}"#,
            r#"{"kind": "orbit", "right": 5, "up": 0, "further": 1}"#,
            r#"{"kind": "explode"}"#,
            r#"{"kind": "size", "size": [-1, 4]}"#,
            "[]",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
