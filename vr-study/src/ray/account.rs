//! Account of one pixel's ray, as a whole.

use vr_core::{Compositing, Control, Model, ParameterError, Probe, Ray, Rays, RenderError, Renderer, Scene, View};
use vr_physics::{Pixel, RaySegment, Reference};

use super::profile::is_seen;
use super::rows::{self, Row};

/// Names of the components of a pixel.
pub const CHANNELS: [&str; 4] = ["red", "green", "blue", "opacity"];

/// Opacity behind which nothing more is to be seen, unless the renderer still has steps there.
const HIDDEN: f64 = 0.9999;
/// Margin before and behind what can be seen, in lengths of it.
const MARGIN: f64 = 0.04;

/// Account of the one ray through a pixel's centre, whatever else the picture's pixel is made of.
pub struct RayAccount<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The view, one ray a pixel.
    pub view: View,
    /// Name of the renderer.
    pub renderer: &'static str,
    /// Column and row.
    pub pixel: [u32; 2],
    /// The ray through its centre.
    pub ray: Ray,
    /// The renderer's pixel, premultiplied linear RGBA.
    pub rgba: [f64; 4],
    /// World distance along the ray to what is seen; `None` from a renderer that gives no depth.
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

/// A renderer's pixel.
struct Seen {
    rgba: [f32; 4],
    depth: Option<f32>,
    probe: Option<Probe>,
    model: Option<String>,
}

impl<'a> RayAccount<'a> {
    /// Asks the renderer for its steps, solves the ray part by part, and sets the steps beside the parts. A renderer that cannot list
    /// its steps draws the picture instead, of which the pixel is taken.
    ///
    /// # Errors
    /// A pixel that the picture does not have; errors of the renderer, and of the reference for a scene that it cannot solve; cancellation.
    pub fn of(
        (scene, view): (&'a Scene, &View),
        pixel: [u32; 2],
        renderer: &dyn Renderer,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let view = View { supersampling: 1, ..view.clone() };
        let rays = Rays::new(&view)?;
        if pixel[0] >= view.size[0] || pixel[1] >= view.size[1] {
            return Err(ParameterError::new("pixel", pixel, "must be one of the picture's").into());
        }
        let seen = look(renderer, (scene, &view), pixel, control)?;
        let reference = Reference::default();
        let exact = reference.solve_pixels(scene, &view, &Model::Canonical, &[pixel], control)?.pixels[0];
        let ray = rays.at(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
        let steps = seen.probe.iter().flat_map(|probe| &probe.steps);
        let mut cuts: Vec<f64> = steps.flat_map(|step| [step.begin, step.end()]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let segments = reference.segments(scene, &view, &ray, &cuts)?;
        let mut account = Self {
            scene,
            view,
            renderer: renderer.name(),
            pixel,
            ray,
            rgba: seen.rgba.map(f64::from),
            depth: seen.depth,
            model: seen.model,
            probe: None,
            exact,
            segments,
            rows: Vec::new(),
        };
        if let Some(probe) = seen.probe {
            account.rows = rows::rows(scene, &probe, &account.segments, account.channel());
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

    /// Returns the world distances along the ray between which something can be seen, with a margin; `None` where it misses the volume.
    pub fn extent(&self) -> Option<[f64; 2]> {
        let [from, to] = self.chord()?;
        let seen = |segment: &&RaySegment| is_seen(segment);
        let Some(first) = self.segments.iter().find(seen) else { return Some([from, to]) };
        let hidden = |s: &&RaySegment| s.light.is_some_and(|l| l.opacity() >= HIDDEN);
        let behind = self.segments.iter().find(hidden).or(self.segments.iter().rfind(seen)).map_or(to, |s| s.to);
        let lit = |row: &&Row| row.step.transparency < 1.0;
        let begin = self.rows.iter().find(lit).map_or(first.from, |row| row.step.begin.min(first.from));
        let end = self.rows.last().map_or(behind, |row| {
            let early = self.probe.as_ref().is_some_and(|probe| probe.ended_early);
            if early { row.step.end().max(behind) } else { behind }
        });
        let margin = MARGIN * (end - begin);
        Some([(begin - margin).max(from), (end + margin).min(to)])
    }

    /// True if light is integrated along the ray, rather than one value picked.
    pub fn has_light(&self) -> bool {
        self.scene.compositing.integrates_light()
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

/// Asks the renderer for its steps; one that cannot list them draws the picture instead, of which the pixel is taken.
fn look(
    renderer: &dyn Renderer,
    (scene, view): (&Scene, &View),
    pixel @ [x, y]: [u32; 2],
    control: &Control,
) -> Result<Seen, RenderError> {
    let mut prepared = renderer.prepare(scene, control)?;
    let model = match prepared.model(view)? {
        Model::Canonical => None,
        other => Some(format!("{other:?}")),
    };
    if let Some(probe) = prepared.probe(view, pixel, control)? {
        return Ok(Seen { rgba: probe.rgba, depth: Some(probe.depth), probe: Some(probe), model });
    }
    let frame = prepared.render(view, control)?.frame;
    let depth = frame.depth().map(|depth| depth[y as usize * view.size[0] as usize + x as usize]);
    Ok(Seen { rgba: frame.pixel(x, y), depth, probe: None, model })
}

/// Returns the opacity at which a compositing ends the light; 1 if it never does.
pub(super) fn level(compositing: Compositing) -> f64 {
    if let Compositing::Accumulate { level } = compositing { level } else { 1.0 }
}
