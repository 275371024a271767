//! Plot of a ray: value, opacity and light along it, by depth, from the renderer of the picture at rest and from the reference.

use serde::Serialize;
use vr_core::{Control, Frame, RenderError, Renderer, Scene, View};
use vr_physics::Certainty;
use vr_study::ray::RayAccount;

/// Parts of the ray: more than a panel has pixels to tell apart.
const PARTS: usize = 240;

/// Account of the ray through a pixel's centre, as `vr ray` prints it, in curves over depth. Colours are premultiplied linear RGBA.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RayPlot {
    /// Column and row.
    pub pixel: [u32; 2],
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Rays along each side of a pixel of the picture: where there are several, the picture's pixel is their mean.
    pub supersampling: u32,
    /// Name of the renderer.
    pub renderer: &'static str,
    /// The renderer's pixel.
    pub rgba: [f64; 4],
    /// The reference's.
    pub exact: [f64; 4],
    /// `rgba` − `exact`.
    pub error: [f64; 4],
    /// Bound or estimate of the error of `exact`, of any component.
    pub bound: f64,
    /// True if that is a bound.
    pub is_proven: bool,
    /// `rgba` and `exact` before the background, as a screen has them.
    pub screen: [[u8; 3]; 2],
    /// Number of the renderer's steps; `None` from a renderer that cannot list them.
    pub steps: Option<usize>,
    /// The model that the renderer integrates, where that is not the scene as it is.
    pub model: Option<String>,
    /// True if light is integrated along the ray, rather than one value picked.
    pub has_light: bool,
    /// Parts of equal length of the stretch where something can be seen, front to back; none where the ray misses the volume.
    pub parts: Vec<PlotPart>,
}

/// A part of a ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlotPart {
    /// World distances along the ray at which it begins and ends.
    pub ends: [f64; 2],
    /// Smallest and largest value; `None` in vacuum.
    pub values: Option<[f64; 2]>,
    /// Opacity of the part alone.
    pub opacity: f64,
    /// The reference of the ray up to its end.
    pub exact: [f64; 4],
    /// The renderer's sum up to its end; `None` from a renderer that cannot list its steps.
    pub drawn: Option<[f64; 4]>,
}

impl RayPlot {
    /// Asks a renderer and the reference for a pixel.
    pub(super) fn of(
        (scene, view): (&Scene, &View),
        pixel: [u32; 2],
        renderer: &dyn Renderer,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let account = RayAccount::of((scene, view), pixel, renderer, control)?;
        let profile = match account.extent() {
            Some(extent) => account.profile(extent, PARTS)?,
            None => Vec::new(),
        };
        let parts = profile.into_iter().map(|part| PlotPart {
            ends: [part.from, part.to],
            values: part.values,
            opacity: 1.0 - part.transparency,
            exact: part.exact,
            drawn: account.running_at(part.to),
        });
        let (bound, is_proven) = match account.exact.certainty {
            Certainty::Bound(error) => (error, true),
            Certainty::Estimate(error) => (error, false),
        };
        let both = [account.rgba, account.exact.rgba].map(|rgba| rgba.map(|c| c as f32));
        let screen = vr_io::screen_rgba(&Frame::new([2, 1], both.to_vec(), None), scene.background);
        Ok(Self {
            pixel,
            size: view.size,
            supersampling: view.supersampling,
            renderer: account.renderer,
            rgba: account.rgba,
            exact: account.exact.rgba,
            error: account.error(),
            bound,
            is_proven,
            screen: [0, 4].map(|i| [screen[i], screen[i + 1], screen[i + 2]]),
            steps: account.probe.as_ref().map(|probe| probe.steps.len()),
            has_light: account.has_light(),
            parts: parts.collect(),
            model: account.model.clone(),
        })
    }
}
