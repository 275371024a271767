//! Account of one ray: the renderer's steps beside the reference.

use vr_core::{Compositing, Probe, Ray, Rays, RenderError, View};
use vr_physics::{Pixel, RaySegment, Reference};

use super::Seen;
use super::rows::{self, Row};
use crate::scene_setup::Setup;

/// Names of the components of a pixel.
pub const CHANNELS: [&str; 4] = ["red", "green", "blue", "opacity"];

/// Account of one pixel.
pub struct Account<'a> {
    /// The scene.
    pub setup: &'a Setup,
    /// Name of the renderer.
    pub renderer: &'static str,
    /// The view, one ray a pixel.
    pub view: &'a View,
    /// Column and row.
    pub pixel: [u32; 2],
    /// The ray through its centre.
    pub ray: Ray,
    /// The renderer's pixel.
    pub rgba: [f64; 4],
    /// Depth of the pixel.
    pub depth: Option<f32>,
    /// The model that the renderer integrates, where that is not the scene as it is.
    pub model: Option<String>,
    /// The renderer's steps, if it can list them.
    pub probe: Option<Probe>,
    /// The reference.
    pub exact: Pixel,
    /// Parts of the reference, cut where the renderer's steps begin and end, too.
    pub segments: Vec<RaySegment>,
    /// Steps of the renderer, each beside the reference.
    pub rows: Vec<Row>,
}

impl<'a> Account<'a> {
    /// Solves the ray part by part, and sets the renderer's steps beside the parts.
    ///
    /// # Errors
    /// Errors of the reference, for a scene that it cannot solve.
    pub fn new(
        setup: &'a Setup,
        renderer: &'static str,
        view: &'a View,
        pixel: [u32; 2],
        seen: Seen,
        exact: Pixel,
    ) -> Result<Self, RenderError> {
        let ray = Rays::new(view)?.at(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
        let steps = seen.probe.iter().flat_map(|probe| &probe.steps);
        let mut cuts: Vec<f64> = steps.flat_map(|step| [step.begin, step.end()]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let segments = Reference::default().segments(&setup.scene, view, &ray, &cuts)?;
        let rgba = seen.rgba.map(f64::from);
        let mut account = Self {
            setup,
            renderer,
            view,
            pixel,
            ray,
            rgba,
            depth: seen.depth,
            model: seen.model,
            probe: None,
            exact,
            segments,
            rows: Vec::new(),
        };
        if let Some(probe) = seen.probe {
            account.rows = rows::rows(&setup.scene, &probe, &account.segments, account.channel());
            account.probe = Some(probe);
        }
        Ok(account)
    }

    /// Returns the error of the pixel, component by component.
    pub fn error(&self) -> [f64; 4] {
        std::array::from_fn(|c| self.rgba[c] - self.exact.rgba[c])
    }

    /// Returns the component with the largest error.
    pub fn channel(&self) -> usize {
        let error = self.error().map(f64::abs);
        (0..4).max_by(|&a, &b| error[a].total_cmp(&error[b])).unwrap_or(3)
    }

    /// Returns the world distances along the ray at which it enters the volume and leaves it; `None` where it misses.
    pub fn chord(&self) -> Option<[f64; 2]> {
        Some([self.segments.first()?.from, self.segments.last()?.to])
    }

    /// True if light is integrated along the ray, rather than one value picked.
    pub fn has_light(&self) -> bool {
        self.setup.scene.compositing.integrates_light()
    }

    /// Returns the part of the final error from behind the renderer's last step, which the reference includes.
    pub fn left_out(&self) -> f64 {
        let Some(Some(end)) = self.segments.last().filter(|_| self.probe.is_some()).map(|end| end.light) else {
            return 0.0;
        };
        let before = self.rows.last().and_then(|row| row.light).map_or([0.0; 4], |light| light.exact);
        let c = self.channel();
        before[c] - rows::rgba(&end)[c]
    }

    /// Returns the step that shows the value that was picked; `None` where light is integrated, or the value has no place.
    pub fn picked(&self) -> Option<usize> {
        let depth = f64::from(self.depth.filter(|depth| depth.is_finite() && !self.has_light())?);
        let off = |row: &Row| (row.step.samples[0].at - depth).abs();
        (0..self.rows.len()).min_by(|&a, &b| off(&self.rows[a]).total_cmp(&off(&self.rows[b])))
    }
}

/// Returns the opacity at which a compositing ends the light; 1 if it never does.
pub fn level(compositing: Compositing) -> f64 {
    if let Compositing::Accumulate { level } = compositing { level } else { 1.0 }
}
