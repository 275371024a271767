//! The renderer's model along a ray, in f64: sheet by sheet, or splat by splat.

mod gather;
#[cfg(test)]
mod picked;

use std::collections::BTreeMap;

use glam::DVec3;
use vr_core::{
    Compositing, Control, DiscreteModel, IndexRay, Layer, PointMixing, Ray, Rays, RenderError, Scene, SegmentTerm, View,
};

use crate::ghosts::Ghosts;
use crate::gradient_optics::GradientOptics;
use crate::grid_gradients::{Gradients, world_gradient};
use crate::input::{SplatInput, profile};
use crate::kernel::Profile;
use crate::projection::SplatView;
use crate::sample_shader::tinted;
use crate::sheets::{AT_LAYER, ImageSheets, MIN_MET, OwnSheets, is_boxed, splat_view, takes_middles};
use crate::sight::Sight;
use crate::splatter::{Buffers, CompositingOrder, Splatter};
use crate::voxel_optics::optics_of;

use gather::{ExactSplat, Line, gather};

/// What a ray meets of a sheet, or of a sample on its own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    /// θ and b of what was classified before.
    Light(SegmentTerm),
    /// A value over a length, at a depth; the gradient in the world, where the light of points depends on it; and the colour of points that have one.
    Value { value: f64, length: f64, depth: f64, gradient: Option<DVec3>, color: Option<[f64; 3]> },
    /// Nothing, in a cell that is missing.
    Vacuum,
}

/// The terms of every ray: θ and b of each sheet or splat.
pub(crate) struct SplatModel {
    renderer: Splatter,
    scene: Scene,
    view: View,
    rays: Rays,
    seen: SplatView,
    input: SplatInput,
    layer: Option<Layer>,
    sight: Sight,
    ghosts: Option<Ghosts>,
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
            sight: Sight::new(view)?,
            ghosts: Ghosts::new(renderer, input),
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
            SplatInput::Grid(grid) if is_boxed(&self.renderer, &self.scene, input) => {
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
    fn step(
        &self,
        line: &Line,
        depth: f64,
        (value, length): (f64, f64),
        gradient: Option<DVec3>,
        color: Option<[f64; 3]>,
    ) -> SegmentTerm {
        let tinted = |[r, g, b, alpha]: [f64; 4]| {
            let [x, y, z] = color.unwrap_or([1.0; 3]);
            [r * x, g * y, b * z, alpha]
        };
        let mut light = tinted(self.scene.transfer.step(value, length));
        if let Some(optics) = GradientOptics::new(&self.scene) {
            let world = match (&self.input, gradient) {
                (SplatInput::Grid(grid), _) => {
                    let place = line.index_at(grid, depth).to_array();
                    world_gradient(grid, Gradients::new(&optics.shading, &self.renderer, grid).at(grid, place))
                }
                (SplatInput::Points(_), gradient) => gradient.unwrap_or_default(),
            };
            if optics.follows {
                light = tinted(optics.step(value, world.length(), length));
            }
            if optics.reflects {
                let along = optics.shading.along(&self.scene.lights, line.direction);
                light = along.shade(light, world.to_array());
            }
        }
        let [r, g, b, alpha] = light;
        SegmentTerm { transparency: 1.0 - alpha, light: [r, g, b] }
    }

    /// (q, κ) of a splat that is classified itself, per world unit.
    fn optics(&self, splat: &ExactSplat) -> [f64; 4] {
        let tint = self.scene.volume.colors().map(|colors| colors.color(splat.index.map(|x| x as f64)));
        let tint = tint.unwrap_or([1.0; 3]);
        let Some(optics) = GradientOptics::new(&self.scene) else {
            return tinted(optics_of(&self.scene.transfer, splat.value), tint);
        };
        let (place, world) = match &self.input {
            SplatInput::Grid(grid) => {
                let index = splat.index.map(|x| x as f64);
                let gradient = Gradients::new(&optics.shading, &self.renderer, grid).at(grid, index);
                (grid.placement().to_world(DVec3::from_array(index)), world_gradient(grid, gradient))
            }
            SplatInput::Points(points) => {
                let place = points.positions()[splat.index[0]];
                (place, points.gradient(place).unwrap_or_default())
            }
        };
        let row = tinted(optics.of_voxel(splat.value, world.length()), tint);
        if !optics.reflects {
            return row;
        }
        optics.shading.along(&self.scene.lights, self.sight.towards(place)).shade(row, world.to_array())
    }

    /// All that the ray through a point of the image meets, in the order of compositing.
    fn parts(&self, line: &Line, ends: [f64; 2]) -> Vec<Part> {
        let Self { view, seen, input, .. } = self;
        let own = match (input, self.renderer.buffers) {
            (SplatInput::Grid(grid), Buffers::Axis) => OwnSheets::new(&self.renderer, grid, view).ok(),
            _ => None,
        };
        let picks = !self.scene.compositing.integrates_light();
        let splats = gather(&self.renderer, input, seen, line, own.as_ref(), self.ghosts.as_ref());
        let profile = profile(&self.renderer, input);
        let whole = |s: &ExactSplat| s.section(&profile, line, ends[0], ends[1]);
        match self.renderer.buffers {
            Buffers::Samples => {
                let mut splats = splats;
                splats.sort_by(|a, b| (a.place.z as f32).total_cmp(&(b.place.z as f32)));
                // A mean weighs what it takes, however little.
                let takes_all = !picks || self.scene.compositing == Compositing::Average;
                let met = |s: &&ExactSplat| takes_all || whole(s) > MIN_MET * seen.unit;
                let one = |s: &ExactSplat| {
                    if picks {
                        // On its own, a sample has its own value wherever its kernel is met.
                        return Part::Value {
                            value: s.value,
                            length: whole(s),
                            depth: s.place.z,
                            gradient: None,
                            color: None,
                        };
                    }
                    Part::Light(Self::lit(std::iter::once((self.optics(s), whole(s)))))
                };
                splats.iter().filter(met).map(one).collect()
            }
            Buffers::Axis => {
                let mut sheets: BTreeMap<u32, Vec<(&ExactSplat, f64)>> = BTreeMap::new();
                for s in &splats {
                    sheets.entry(s.sheet).or_default().push((s, whole(s)));
                }
                let part = |(turn, sheet): (&u32, &Vec<(&ExactSplat, f64)>)| {
                    let parts = sheet.iter().copied();
                    if self.renderer.splats_light() {
                        return Part::Light(Self::lit(parts.map(|(s, weight)| (self.optics(s), weight))));
                    }
                    let length: f64 = parts.clone().map(|(_, w)| w).sum();
                    let sum: f64 = parts.map(|(s, w)| w * s.value).sum();
                    let depth = own.as_ref().map_or(0.0, |own| line.depth_at(own.axis, own.layers[*turn as usize]));
                    // Where a sheet is sampled there may be nothing.
                    if length > 0.0 && !line.in_vacuum(input, depth, AT_LAYER) {
                        let color = self.color_at(line, depth);
                        Part::Value { value: sum / length, length, depth, gradient: None, color }
                    } else {
                        Part::Vacuum
                    }
                };
                sheets.iter().map(part).collect()
            }
            Buffers::Image => self.image_sheets(line, &profile, &splats, ends),
        }
    }
}

impl DiscreteModel for SplatModel {
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm> {
        let ray = self.rays.at(x, y);
        let line = Line::new(&self.seen, &self.input, &ray, [x, y]);
        let Some(ends) = self.ends(&ray, &line) else { return Vec::new() };
        let term = |part: Part| match part {
            Part::Light(term) => term,
            Part::Value { value, length, depth, gradient, color } => {
                self.step(&line, depth, (value, length), gradient, color)
            }
            Part::Vacuum => Self::term([0.0; 3], 0.0),
        };
        let mut terms: Vec<SegmentTerm> = self.parts(&line, ends).into_iter().map(term).collect();
        if self.renderer.buffers == Buffers::Axis && self.renderer.order == CompositingOrder::BackToFront {
            terms.reverse();
        }
        terms
    }
}

impl SplatModel {
    /// θ and b of classified splats: (q, κ) of each, and ∫ of its kernel.
    fn lit(parts: impl Iterator<Item = ([f64; 4], f64)>) -> SegmentTerm {
        let (mut light, mut tau) = ([0.0; 3], 0.0);
        for (optics, weight) in parts {
            for c in 0..3 {
                light[c] += weight * optics[c];
            }
            tau += weight * optics[3];
        }
        // A sinc's sides may outweigh its middle: less than nothing sends nothing.
        if tau < 0.0 { Self::term([0.0; 3], 0.0) } else { Self::term(light, tau) }
    }

    /// The colour of the voxels at a depth of a ray; `None` where they have none.
    fn color_at(&self, line: &Line, depth: f64) -> Option<[f64; 3]> {
        let colors = self.scene.volume.colors()?;
        Some(colors.color(line.index_at(colors.values(), depth).to_array()))
    }

    fn image_sheets(&self, line: &Line, profile: &Profile, splats: &[ExactSplat], [near, far]: [f64; 2]) -> Vec<Part> {
        let Self { input, seen, .. } = self;
        let Ok(sheets) = ImageSheets::new(&self.renderer, &self.scene.volume, input, seen) else { return Vec::new() };
        let half = seen.half_depth();
        let sloped = matches!(input, SplatInput::Points(_)) && GradientOptics::new(&self.scene).is_some();
        // Classified once, for all sheets that have a section of it: a gradient may be a sum over many kernels.
        let classified = |s: &ExactSplat| if self.renderer.splats_light() { self.optics(s) } else { [0.0; 4] };
        // The splats that each sheet has a section of, with their (q, κ).
        let mut parts: BTreeMap<u32, Vec<(&ExactSplat, [f64; 4])>> = BTreeMap::new();
        for s in splats {
            let optics = classified(s);
            let at = |depth: f64| (depth / sheets.distance).floor().clamp(0.0, f64::from(sheets.count - 1)) as u32;
            for sheet in at(s.place.z - half / s.scale)..=at(s.place.z + half / s.scale) {
                parts.entry(sheet).or_default().push((s, optics));
            }
        }
        // One part a sheet, front to back.
        let mut found = Vec::new();
        for (sheet, parts) in parts {
            let [from, to] = [sheet, sheet + 1].map(|k| (f64::from(k) * sheets.distance).max(near).min(far));
            if from >= to {
                continue;
            }
            let radial = matches!(profile, Profile::Radial(_));
            let middle = 0.5 * (from + to);
            // Products are evaluated in the middle of a sheet, and so is every kernel where weights are divided out.
            let section = |s: &ExactSplat| {
                if radial && !takes_middles(&self.renderer, input) {
                    s.section(profile, line, from, to)
                } else {
                    s.at(profile, line, middle) * (to - from) * line.stretch
                }
            };
            // Sections are most of the work: each is taken once.
            if self.renderer.splats_light() {
                found.push(Part::Light(Self::lit(parts.into_iter().map(|(s, optics)| (optics, section(s))))));
                continue;
            }
            let weighed: Vec<(&ExactSplat, f64)> = parts.iter().map(|(s, _)| (*s, section(s))).collect();
            let (mut sum, mut weight) = (0.0, 0.0);
            for (s, w) in &weighed {
                sum += w * s.value;
                weight += w;
            }
            let (length, divisor) = if matches!(input, SplatInput::Grid(_)) {
                ((to - from) * line.stretch, weight)
            } else {
                // From the first support's front to the last one's back.
                let chords = parts.iter().map(|(s, _)| s.chord(line)).map(|[a, b]| [a.max(from), b.min(to)]);
                let inside = chords.filter(|[a, b]| a < b);
                let [front, back] = inside.fold([to, from], |[f, l], [a, b]| [f.min(a), l.max(b)]);
                let covered = (back - front).max(0.0) * line.stretch;
                (covered, covered)
            };
            let points = if let SplatInput::Points(points) = input { Some(points) } else { None };
            let is_mean = points.is_some_and(|points| points.mixing() == PointMixing::Mean);
            let divisor = if is_mean { weight } else { divisor };
            // The mean over what is covered, as that of the value is; of a mean by the quotient rule.
            // From the value that weighs most, so that where one point reaches alone there is none to the last bit.
            let heaviest = weighed.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            let base = heaviest.map_or(0.0, |(s, _)| s.value);
            let apart: f64 = weighed.iter().map(|(s, w)| w * (s.value - base)).sum();
            let from_value = if is_mean && weight > 0.0 { base + apart / weight } else { 0.0 };
            let sections =
                parts.iter().map(|(s, _)| s.gradient_section(profile, line, from, to) * (s.value - from_value));
            let sloped = sloped && divisor > 0.0;
            let gradient = sloped.then(|| seen.frame * sections.sum::<DVec3>() / divisor);
            let colors = points.and_then(|points| points.colors()).filter(|_| weight > 0.0);
            let color = colors.map(|colors| {
                let light = |s: &ExactSplat| DVec3::from(colors[s.index[0]].map(f64::from));
                (weighed.iter().map(|(s, w)| light(s) * *w).sum::<DVec3>() / weight).to_array()
            });
            let color = color.or_else(|| self.color_at(line, middle));
            if divisor > 0.0 && !line.in_vacuum(input, middle, 0.0) {
                found.push(Part::Value { value: sum / divisor, length, depth: middle, gradient, color });
            } else if divisor > 0.0 {
                found.push(Part::Vacuum);
            }
        }
        found
    }
}
