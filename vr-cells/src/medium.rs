//! Light of a stretch on which the value is linear.

use vr_core::transfer::Optical;
use vr_core::{OpacityRule, RayShading, Scene, Shading, TransferFunction};

/// Nodes of Gauss's rule of three points on [0, 1], and its weights.
const NODES: [f64; 3] = [0.112_701_665_379_258_31, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];
/// Integrals from 0 to each node of the polynomial through three nodes (the collocation of Gauss, order 6).
const UP_TO_NODE: [[f64; 3]; 3] = [
    [0.138_888_888_888_888_9, -0.035_976_667_524_938_9, 0.009_789_444_015_308_32],
    [0.300_263_194_980_864_6, 0.222_222_222_222_222_2, -0.022_485_417_203_086_8],
    [0.267_988_333_762_469_5, 0.480_421_111_969_383_3, 0.138_888_888_888_888_9],
];
/// Optical depth of a stretch that is integrated at once: of κ e^(−τ) the rule misses some 10⁻⁵ τ⁶, measured.
const AT_ONCE: f64 = 0.5;
/// Halvings of a stretch at most: beside a wall extinction goes to infinity.
const HALVINGS: u32 = 40;

/// Halvings at most for a normal that turns, for a logarithm that bends, and to find the place of a level.
const TURNS: u32 = 6;
const BENDS: u32 = 12;
const PLACES: u32 = 30;
/// Light at stake where a normal turns, times the fourth power of the sine: a highlight is missed by about as much.
const SEEN_TURN: f64 = 1e-6;
/// Optical depth of a stretch below which its light needs no second look, and transparency before which no light counts.
const FAINT: f64 = 1e-4;
const DARK: f64 = 1e-12;

/// Light and transparency of a ray so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    pub(crate) rgb: [f64; 3],
    /// Transparency of all that the ray has passed.
    pub(crate) clear: f64,
    /// Segment of the transfer function that held last.
    segment: usize,
}

impl Light {
    /// Light of a ray that has met nothing yet.
    pub(crate) const NONE: Self = Self { rgb: [0.0; 3], clear: 1.0, segment: 0 };
}

/// A stretch inside one segment of the transfer function: everything is linear.
#[derive(Clone, Copy)]
struct Stretch<'a> {
    /// Distances.
    ends: [f64; 2],
    values: [f64; 2],
    optics: [Optical; 2],
    gradients: Option<[[f64; 3]; 2]>,
    shade: Option<&'a RayShading<f64>>,
}

impl Stretch<'_> {
    /// Returns its first half and its second.
    fn halves(&self) -> [Self; 2] {
        let mean = |[a, b]: [f64; 2]| 0.5 * (a + b);
        let (middle, value) = (mean(self.ends), mean(self.values));
        let optics = Optical::lerp(0.5, &self.optics[0], &self.optics[1]);
        let gradient = self.gradients.map(|[a, b]| mixed(a, b, 0.5));
        [0, 1].map(|half| {
            let mut part = *self;
            part.ends[1 - half] = middle;
            part.values[1 - half] = value;
            part.optics[1 - half] = optics;
            if let (Some(gradients), Some(gradient)) = (&mut part.gradients, gradient) {
                gradients[1 - half] = gradient;
            }
            part
        })
    }
}

/// A medium: a transfer function, and the shading of a scene.
pub(crate) struct Medium<'a> {
    pub(crate) transfer: &'a TransferFunction,
    /// Shading by whose gradients opacity is multiplied; `None` under rows, which follow the gradient by themselves.
    modulation: Option<&'a Shading>,
    extinction: &'a ExtinctionTable,
}

/// Extinction by opacity, per world unit: linear between 4096 places, to 10⁻⁶ of that of an opaque unit.
pub(crate) struct ExtinctionTable {
    /// Extinction at each place, and one beyond the last.
    places: Vec<f64>,
    per_place: f64,
    bends: bool,
}

/// Largest opacity of the table: above it the logarithm of the power rule is too steep.
const STEEP: f64 = 0.9;

impl ExtinctionTable {
    pub(crate) fn new(transfer: &TransferFunction) -> Self {
        const PLACES: usize = 4096;
        let places = (0..=PLACES + 1).map(|i| transfer.extinction(STEEP * i as f64 / PLACES as f64)).collect();
        Self { places, per_place: PLACES as f64 / STEEP, bends: transfer.rule() == OpacityRule::Power }
    }

    /// Extinction at three opacities; `None` if one is too large.
    #[inline]
    fn at(&self, opacities: [f64; 3]) -> Option<[f64; 3]> {
        if opacities[0].max(opacities[2]) > STEEP {
            return None;
        }
        Some(opacities.map(|opacity| {
            let place = opacity * self.per_place;
            let index = (place as usize).min(self.places.len() - 2);
            let [low, high] = [self.places[index], self.places[index + 1]];
            low + (high - low) * (place - index as f64)
        }))
    }

    /// True if extinction is no linear function of opacity.
    fn bends(&self) -> bool {
        self.bends
    }
}

/// A change of opacity on the way: the distance at which the transparency fell to a level.
pub(crate) struct Crossing {
    pub(crate) level: f64,
    pub(crate) at: Option<f64>,
    /// True if nothing is added behind.
    pub(crate) ends: bool,
}

impl<'a> Medium<'a> {
    /// The medium of a scene.
    pub(crate) fn of(scene: &'a Scene, extinction: &'a ExtinctionTable) -> Self {
        let modulation =
            scene.shading.as_deref().filter(|_| scene.has_gradient_opacity() && !scene.transfer.has_rows());
        Self { transfer: &scene.transfer, modulation, extinction }
    }

    /// Adds the light of a stretch between two distances, on which the value and the gradient are linear.
    #[inline]
    pub(crate) fn add(
        &self,
        light: &mut Light,
        ends: [f64; 2],
        values: [f64; 2],
        gradients: Option<[[f64; 3]; 2]>,
        shade: Option<&RayShading<f64>>,
        crossing: &mut Crossing,
    ) {
        let segments = self.transfer.segments();
        let [first, last] = values;
        let mut index = light.segment;
        while index > 0 && first < segments[index].from {
            index -= 1;
        }
        while index + 1 < segments.len() && first >= segments[index].to {
            index += 1;
        }
        // A falling value leaves the segment below the point at which it stands.
        if last < first && index > 0 && segments[index].from == first {
            index -= 1;
        }
        let mix = |t: f64| ends[0] + (ends[1] - ends[0]) * t;
        let mut from = 0.0;
        loop {
            light.segment = index;
            let segment = &segments[index];
            let leaves = if last > first && last >= segment.to {
                Some((segment.to - first) / (last - first))
            } else if last < first && last < segment.from {
                Some((segment.from - first) / (last - first))
            } else {
                None
            };
            let to = leaves.map_or(1.0, |t| t.clamp(from, 1.0));
            if to > from && !segment.is_clear() {
                let value = |t: f64| (first + (last - first) * t).clamp(segment.from, segment.to);
                let stretch = Stretch {
                    ends: [mix(from), mix(to)],
                    values: [value(from), value(to)],
                    optics: [segment.at(value(from)), segment.at(value(to))],
                    gradients: gradients.map(|[a, b]| [from, to].map(|t| mixed(a, b, t))),
                    shade,
                };
                let is_plain = gradients.is_none() && !self.transfer.has_emission();
                if !(is_plain && self.add_at_once(light, &stretch, crossing)) {
                    self.add_stretch(light, &stretch, 0, crossing);
                }
                if ends_ray(light, crossing) {
                    return;
                }
            }
            if leaves.is_none() || to >= 1.0 {
                return;
            }
            from = to;
            index = if last > first { index + 1 } else { index - 1 };
        }
    }

    /// Adds an unshaded stretch that is thin enough for one rule, by a table of extinction; false if it is not.
    #[inline]
    fn add_at_once(&self, light: &mut Light, stretch: &Stretch<'_>, crossing: &Crossing) -> bool {
        let length = stretch.ends[1] - stretch.ends[0];
        let [a, b] = &stretch.optics;
        let between = |x: f64, y: f64| NODES.map(|t| x + (y - x) * t);
        let Some(extinction) = self.extinction.at(between(a.opacity, b.opacity)) else { return false };
        let steepest = length * extinction[0].max(extinction[2]);
        if steepest > AT_ONCE || (steepest > FAINT && self.extinction.bends() && bends([a.opacity, b.opacity])) {
            return false;
        }
        let depth = length * dot(WEIGHTS, extinction);
        let left = light.clear * falling(depth);
        if left < crossing.level && crossing.at.is_none() {
            return false;
        }
        let weights: [f64; 3] = std::array::from_fn(|k| {
            let before = length * dot(UP_TO_NODE[k], extinction);
            light.clear * length * WEIGHTS[k] * extinction[k] * falling(before)
        });
        for c in 0..3 {
            light.rgb[c] += dot(weights, between(a.color[c], b.color[c]));
        }
        light.clear = left;
        true
    }

    /// Adds a stretch of any kind, in halves where one rule does not do.
    fn add_stretch(&self, light: &mut Light, stretch: &Stretch<'_>, halved: u32, crossing: &mut Crossing) {
        if self.extinction.bends() && stretch.optics.iter().all(|o| o.opacity == 1.0) {
            return self.add_opaque(light, stretch, halved, crossing);
        }
        let length = stretch.ends[1] - stretch.ends[0];
        let nodes = NODES.map(|t| self.at_node(stretch, t));
        let extinction = nodes.map(|(extinction, _)| extinction);
        let depth = length * dot(WEIGHTS, extinction);
        let steepest = length * extinction.into_iter().fold(0.0, f64::max);

        // Look closer where the rule does not follow the light: thick stretches, normals that turn, functions of the gradient's magnitude, which bend
        // at their points, and logarithms; and at the place where the transparency falls to the level.
        let at_stake = |gradients| light.clear * depth.min(1.0) * turn(gradients) * turn(gradients);
        let curved = halved < TURNS && stretch.gradients.is_some_and(|gradients| at_stake(gradients) > SEEN_TURN);
        let follows = self.modulation.is_some() || self.transfer.has_rows();
        let opacities = stretch.optics.each_ref().map(|o| o.opacity);
        // The nodes may all lie where the gradient leaves nothing: what matters is how much there could be.
        let at_most = length * self.transfer.extinction(opacities[0].max(opacities[1]));
        let bent = follows
            && halved < BENDS
            && stretch.gradients.is_some_and(|g| light.clear * at_most * lengthening(g) > FAINT);
        let uneven = self.extinction.bends() && halved < BENDS && depth > FAINT && bends(opacities);
        let falls = light.clear * (-depth).exp() < crossing.level && crossing.at.is_none();
        let sought = falls && halved < PLACES;
        if halved < HALVINGS && light.clear > DARK && (steepest > AT_ONCE || curved || bent || uneven || sought) {
            return self.add_halves(light, stretch, halved, crossing);
        }

        for (k, (_, source)) in nodes.into_iter().enumerate() {
            let before = length * dot(UP_TO_NODE[k], extinction);
            let weight = light.clear * WEIGHTS[k] * length * (-before).exp();
            for c in 0..3 {
                light.rgb[c] += weight * source[c];
            }
        }
        light.clear *= (-depth).exp();
        if falls {
            crossing.at = Some(stretch.ends[1]);
        }
    }

    /// Adds both halves of a stretch, the second one unless the first ends the ray.
    fn add_halves(&self, light: &mut Light, stretch: &Stretch<'_>, halved: u32, crossing: &mut Crossing) {
        for part in stretch.halves() {
            self.add_stretch(light, &part, halved + 1, crossing);
            if ends_ray(light, crossing) {
                return;
            }
        }
    }

    /// Extinction, and light that is sent, per world unit, at a fraction of a stretch.
    fn at_node(&self, stretch: &Stretch<'_>, t: f64) -> (f64, [f64; 3]) {
        let gradient = stretch.gradients.map(|[a, b]| mixed(a, b, t));
        let (tint, added) = reflected(stretch.shade, gradient);
        if self.transfer.has_rows() {
            let [from, to] = stretch.values;
            let mixture = self.transfer.mixture(from + (to - from) * t, gradient.map_or(0.0, length_of));
            let source = std::array::from_fn(|c| mixture.emission[c] * tint[c] + mixture.extinction * added[c]);
            return (mixture.extinction, source);
        }
        let optical = Optical::lerp(t, &stretch.optics[0], &stretch.optics[1]);
        let extinction = self.transfer.extinction(optical.opacity) * self.factor(gradient);
        if self.transfer.has_emission() {
            return (extinction, optical.emission);
        }
        (extinction, std::array::from_fn(|c| extinction * (optical.color[c] * tint[c] + added[c])))
    }

    /// Factor on extinction at a gradient.
    fn factor(&self, gradient: Option<[f64; 3]>) -> f64 {
        match (self.modulation, gradient) {
            (Some(shading), Some(gradient)) => shading.modulation(length_of(gradient)),
            _ => 1.0,
        }
    }

    /// Adds a stretch of infinite extinction: a wall, which begins where the gradient leaves any of it.
    fn add_opaque(&self, light: &mut Light, stretch: &Stretch<'_>, halved: u32, crossing: &mut Crossing) {
        let factor_at = |t: f64| self.factor(stretch.gradients.map(|[a, b]| mixed(a, b, t)));
        if factor_at(0.0) > 0.0 {
            self.meet_wall(light, stretch, crossing);
        } else if halved < PLACES && (NODES.into_iter().any(|t| factor_at(t) > 0.0) || factor_at(1.0) > 0.0) {
            self.add_halves(light, stretch, halved, crossing);
        }
    }

    /// Adds the light of a wall at the beginning of a stretch.
    fn meet_wall(&self, light: &mut Light, stretch: &Stretch<'_>, crossing: &mut Crossing) {
        if !self.transfer.has_emission() {
            let color = stretch.optics[0].color;
            let (tint, added) = reflected(stretch.shade, stretch.gradients.map(|[gradient, _]| gradient));
            // Under an accumulation's level, no more than up to it.
            let share = if crossing.ends { light.clear - crossing.level } else { light.clear };
            for c in 0..3 {
                light.rgb[c] += share.max(0.0) * (color[c] * tint[c] + added[c]);
            }
        }
        if crossing.at.is_none() {
            crossing.at = Some(stretch.ends[0]);
        }
        light.clear = if crossing.ends { crossing.level } else { 0.0 };
    }
}

/// True if nothing behind counts.
fn ends_ray(light: &Light, crossing: &Crossing) -> bool {
    light.clear == 0.0 || (crossing.ends && crossing.at.is_some())
}

/// Factor on a colour, and light that is added; the colour as it is where nothing is shaded.
pub(crate) fn reflected(shade: Option<&RayShading<f64>>, gradient: Option<[f64; 3]>) -> ([f64; 3], [f64; 3]) {
    match (shade, gradient) {
        (Some(shade), Some(gradient)) => shade.reflect(gradient),
        _ => ([1.0; 3], [0.0; 3]),
    }
}

fn length_of(gradient: [f64; 3]) -> f64 {
    dot(gradient, gradient).sqrt()
}

/// e^(−x) for x in [0, 1]: the fourth power of the series at x/4, to 10⁻⁷.
#[inline]
fn falling(x: f64) -> f64 {
    let y = -0.25 * x;
    let root =
        1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0))))));
    let square = root * root;
    square * square
}

/// True if the logarithm of the power rule, −ln(1 − α), bends too much between two opacities for the rule, which misses 6·10⁻⁵ (Δα/(1 − α))⁶ of it.
#[inline]
fn bends([a, b]: [f64; 2]) -> bool {
    (b - a).abs() > 0.3 * (1.0 - a.max(b))
}

/// Part of a gradient's magnitude by which it changes between two ends.
fn lengthening([a, b]: [[f64; 3]; 2]) -> f64 {
    let [a, b] = [length_of(a), length_of(b)];
    if a == b { 0.0 } else { 1.0 - a.min(b) / a.max(b) }
}

/// Square of the sine of the angle by which a gradient turns between two ends; 1 beyond a right angle.
fn turn([a, b]: [[f64; 3]; 2]) -> f64 {
    let cosine = dot(a, b);
    if cosine <= 0.0 { 1.0 } else { (1.0 - cosine * cosine / (dot(a, a) * dot(b, b))).max(0.0) }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn mixed(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}
