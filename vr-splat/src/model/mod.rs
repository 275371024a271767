//! The renderer's model along a ray, in f64: sheet by sheet, or splat by splat.

mod gather;

use std::collections::BTreeMap;

use glam::DVec3;
use vr_core::{Control, DiscreteModel, IndexRay, Layer, Ray, Rays, RenderError, Scene, SegmentTerm, View};

use crate::input::{SplatInput, profile};
use crate::kernel::Profile;
use crate::projection::SplatView;
use crate::sheets::{ImageSheets, OwnSheets, is_boxed, splat_view};
use crate::splatter::{Buffers, Splatter};
use crate::voxel_optics::optics_of;

use gather::{ExactSplat, Line, gather};

/// The terms of every ray: θ and b of each sheet or splat.
pub(crate) struct SplatModel {
    renderer: Splatter,
    scene: Scene,
    view: View,
    rays: Rays,
    seen: SplatView,
    input: SplatInput,
    layer: Option<Layer>,
}

impl SplatModel {
    pub(crate) fn new(
        renderer: &Splatter,
        scene: &Scene,
        input: &SplatInput,
        view: &View,
    ) -> Result<Self, RenderError> {
        // Subpixels are asked for one by one, in pixels of the picture.
        let coarse = View { supersampling: 1, ..view.clone() };
        Ok(Self {
            renderer: renderer.clone(),
            scene: scene.clone(),
            view: view.clone(),
            rays: Rays::new(view)?,
            seen: splat_view(renderer, scene, input, &coarse)?,
            input: input.clone(),
            layer: scene.layer(view, &Control::default())?,
        })
    }

    /// Between which depths a ray is inside of what cuts it.
    fn ends(&self, ray: &Ray, line: &Line) -> Option<[f64; 2]> {
        let Self { input, view, seen, .. } = self;
        let depth = |s: f64| s / line.stretch - seen.base;
        let layer = self.layer.as_ref().map_or(f64::INFINITY, |layer| {
            let [column, row] = line.pixel;
            layer.depth((row * view.size[0] + column) as usize)
        });
        match input {
            SplatInput::Grid(grid) if is_boxed(&self.renderer, input) => {
                let inside = IndexRay::new(ray, grid.placement(), grid.dims(), &view.clip, layer)?;
                Some([inside.start, inside.end].map(|s| depth(s + inside.offset)))
            }
            _ => {
                let [from, to] = ray.inside(&view.clip)?;
                (from < to.min(layer)).then(|| [depth(from), depth(to.min(layer))])
            }
        }
    }

    /// θ and b of so much optical depth and emission.
    fn term(light: [f64; 3], tau: f64) -> SegmentTerm {
        let weight = vr_core::optics::source_weight(tau);
        SegmentTerm { transparency: libm::exp(-tau), light: light.map(|q| q * weight) }
    }

    /// θ and b of a homogeneous piece of a value, classified and shaded at a depth.
    fn step(&self, line: &Line, depth: f64, value: f64, length: f64) -> SegmentTerm {
        let mut light = self.scene.transfer.step(value, length);
        if let (Some(shading), SplatInput::Grid(grid)) = (self.scene.reflection(), &self.input) {
            let gradient = DVec3::from(grid.central_differences_at(line.index_at(grid, depth).to_array()));
            let world = grid.placement().gradient_to_world(gradient);
            light = shading.along(&self.scene.lights, line.direction).shade(light, world.to_array());
        }
        let [r, g, b, alpha] = light;
        SegmentTerm { transparency: 1.0 - alpha, light: [r, g, b] }
    }
}

impl DiscreteModel for SplatModel {
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm> {
        let Self { view, rays, seen, input, .. } = self;
        let ray = rays.at(x, y);
        let line = Line::new(seen, input, &ray, [x, y]);
        let Some(ends) = self.ends(&ray, &line) else { return Vec::new() };
        let own = match (input, self.renderer.buffers) {
            (SplatInput::Grid(grid), Buffers::Axis) => OwnSheets::new(&self.renderer, grid, view).ok(),
            _ => None,
        };
        let splats = gather(&self.renderer, input, seen, &line, own.as_ref());
        let profile = profile(&self.renderer, input);
        let whole = |s: &ExactSplat| s.section(&profile, &line, ends[0], ends[1]);
        let mut terms = match self.renderer.buffers {
            Buffers::Samples => {
                let mut splats = splats;
                splats.sort_by(|a, b| (a.place.z as f32).total_cmp(&(b.place.z as f32)));
                let one = |s: &ExactSplat| self.lit(std::iter::once((s, whole(s))));
                splats.iter().map(one).collect()
            }
            Buffers::Axis => {
                let mut sheets: BTreeMap<u32, Vec<(&ExactSplat, f64)>> = BTreeMap::new();
                for s in &splats {
                    sheets.entry(s.sheet).or_default().push((s, whole(s)));
                }
                let term = |(turn, sheet): (&u32, &Vec<(&ExactSplat, f64)>)| {
                    let parts = sheet.iter().copied();
                    if self.renderer.splats_light() {
                        return self.lit(parts);
                    }
                    let length: f64 = parts.clone().map(|(_, w)| w).sum();
                    let sum: f64 = parts.map(|(s, w)| w * s.value).sum();
                    let depth = own.as_ref().map_or(0.0, |own| line.depth_at(own.axis, own.layers[*turn as usize]));
                    // Where a sheet is sampled there may be nothing.
                    if length > 0.0 && !line.in_vacuum(input, depth) {
                        self.step(&line, depth, sum / length, length)
                    } else {
                        Self::term([0.0; 3], 0.0)
                    }
                };
                sheets.iter().map(term).collect()
            }
            Buffers::Image => self.image_sheets(&line, &profile, &splats, ends),
        };
        if own.is_some() && self.renderer.order == crate::splatter::CompositingOrder::BackToFront {
            terms.reverse();
        }
        terms
    }
}

impl SplatModel {
    /// θ and b of classified splats, each with ∫ of its kernel.
    fn lit<'s>(&self, parts: impl Iterator<Item = (&'s ExactSplat, f64)>) -> SegmentTerm {
        let (mut light, mut tau) = ([0.0; 3], 0.0);
        for (splat, weight) in parts {
            let optics = optics_of(&self.scene.transfer, splat.value);
            for c in 0..3 {
                light[c] += weight * optics[c];
            }
            tau += weight * optics[3];
        }
        // A sinc's sides may outweigh its middle: less than nothing sends nothing.
        if tau < 0.0 { Self::term([0.0; 3], 0.0) } else { Self::term(light, tau) }
    }

    fn image_sheets(
        &self,
        line: &Line,
        profile: &Profile,
        splats: &[ExactSplat],
        [near, far]: [f64; 2],
    ) -> Vec<SegmentTerm> {
        let Self { input, seen, .. } = self;
        let Ok(sheets) = ImageSheets::new(&self.renderer, &self.scene.volume, input, seen) else { return Vec::new() };
        let half = seen.half_depth();
        // The splats that each sheet has a section of.
        let mut parts: BTreeMap<u32, Vec<&ExactSplat>> = BTreeMap::new();
        for s in splats {
            let at = |depth: f64| (depth / sheets.distance).floor().clamp(0.0, f64::from(sheets.count - 1)) as u32;
            for sheet in at(s.place.z - half / s.scale)..=at(s.place.z + half / s.scale) {
                parts.entry(sheet).or_default().push(s);
            }
        }
        // One term a sheet, front to back.
        let mut terms = Vec::new();
        for (sheet, parts) in parts {
            let [from, to] = [sheet, sheet + 1].map(|k| (f64::from(k) * sheets.distance).max(near).min(far));
            if from >= to {
                continue;
            }
            let radial = matches!(profile, Profile::Radial(_));
            let middle = 0.5 * (from + to);
            // Products are taken in the middle of a sheet.
            let section = |s: &ExactSplat| {
                if radial {
                    s.section(profile, line, from, to)
                } else {
                    s.at(profile, line, middle) * (to - from) * line.stretch
                }
            };
            let weighed = parts.iter().map(|s| (*s, section(s)));
            if self.renderer.splats_light() {
                terms.push(self.lit(weighed));
                continue;
            }
            let (mut sum, mut weight) = (0.0, 0.0);
            for (s, w) in weighed {
                sum += w * s.value;
                weight += w;
            }
            let (length, divisor) = if matches!(input, SplatInput::Grid(_)) {
                ((to - from) * line.stretch, weight)
            } else {
                // From the first support's front to the last one's back.
                let chords = parts.iter().map(|s| s.chord(line)).map(|[a, b]| [a.max(from), b.min(to)]);
                let inside = chords.filter(|[a, b]| a < b);
                let [front, back] = inside.fold([to, from], |[f, l], [a, b]| [f.min(a), l.max(b)]);
                let covered = (back - front).max(0.0) * line.stretch;
                (covered, covered)
            };
            if divisor > 0.0 && !line.in_vacuum(input, middle) {
                terms.push(self.step(line, middle, sum / divisor, length));
            }
        }
        terms
    }
}
