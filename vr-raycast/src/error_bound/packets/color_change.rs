//! Change of colours along steps by the light that they reflect, with a bound of what it is off by.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::DVec3;
use vr_core::{Light, Shading};
use vr_kernels::vector::{Field, LANES, Lanes, PacketLights, Pairs, Stage, pick, power_of, splat};

use super::super::normals::Gradients;
use super::super::reflection::Reflection;
use super::gradients::{Corners, Derivatives};

/// Reflection in a scene, the same for all rays.
#[derive(Clone, Debug)]
pub(super) struct PacketReflection {
    pub(super) lights: Vec<Light>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    power: f32,
    /// Sums of the lights' colours, and the largest of their components.
    total: [f32; 3],
    brightest_light: f32,
    /// Largest component of a colour before it reflects.
    brightest_color: f32,
    /// Rows of the matrix from gradients per index step to the world, by a common factor, and the lengths of its columns.
    to_world: [[f32; 3]; 3],
    columns: [f32; 3],
    /// Bound of the length of any gradient of the volume, in these units.
    steepest: f32,
}

/// Steps of sixteen rays inside cells.
pub(super) struct Places {
    /// Numbers of the cells.
    pub(super) cell: [Lanes; 3],
    /// Fractions of the cell in the middle.
    pub(super) middle: [Lanes; 3],
    /// Lengths.
    pub(super) length: Lanes,
    /// Distance by which a step may end behind its cell.
    pub(super) margin: Lanes,
    /// Cells per unit along each axis, and the lengths of the rays in units.
    pub(super) delta: [Lanes; 3],
    pub(super) whole: Lanes,
}

/// Change of colours along sixteen steps: a channel c becomes c · factor + added, both known at the begin, in the middle and at the end.
pub(super) struct ColorChange {
    pub(super) factor: [[Lanes; 3]; 3],
    pub(super) added: [[Lanes; 3]; 3],
    /// Bounds of what the parabolas through these are off by.
    pub(super) factor_off: Lanes,
    pub(super) added_off: Lanes,
    /// The part of the bounds that shorter steps do not lessen, of light per opacity.
    pub(super) blurred: Lanes,
    /// Bound of what light per opacity is off by behind the face of the cell.
    pub(super) beyond: Lanes,
}

impl ColorChange {
    pub(super) const NONE: Self = Self {
        factor: [[Lanes([1.0; LANES]); 3]; 3],
        added: [[Lanes::ZERO; 3]; 3],
        factor_off: Lanes::ZERO,
        added_off: Lanes::ZERO,
        blurred: Lanes::ZERO,
        beyond: Lanes::ZERO,
    };
}

/// Unit of rounding of f32.
pub(super) const U: f32 = 1.0 / (1 << 24) as f32;
/// Share of its third derivative that a function is off by, at most, from the parabola through its ends and its middle: √3/216.
const PARABOLA: f32 = 0.00802;
/// Error of an interpolated gradient, relative to the longest in its cell: some 15 roundings of the interpolation and twelve of the place, of differences up to
/// twice that length, in each of three components.
const NOISE: f32 = 84.0 * U;
/// Distance from a face, in cells, within which a place may lie beyond it: many times what its fraction is off by.
const NEAR: f32 = 64.0 * U;

impl PacketReflection {
    /// Takes the reflection of a scene over; `None` where packets have no bound for it: under gradients of the filter, which jump from cell to cell, and
    /// highlights of a power below 3 (but 2), the third derivatives of which have no bound. `span`: the difference of the largest and the smallest value.
    pub(super) fn new(reflection: &Reflection, gradients: &Gradients, brightest_color: f64, span: f64) -> Option<Self> {
        let shading: &Shading = &reflection.shading;
        if gradients.analytic || (shading.specular > 0.0 && shading.power < 3.0 && shading.power != 2.0) {
            return None;
        }
        let total = [0, 1, 2].map(|c| reflection.lights.iter().map(|light| light.color[c]).sum::<f64>());
        let most = total.into_iter().fold(0.0, f64::max);
        let rows = &gradients.to_world;
        let columns = [0, 1, 2].map(|a| DVec3::new(rows[0][a], rows[1][a], rows[2][a]).length());
        let up = |x: f64| x as f32 * (1.0 + 1e-6);
        Some(Self {
            lights: reflection.lights.clone(),
            ambient: shading.ambient as f32,
            diffuse: shading.diffuse as f32,
            specular: shading.specular as f32,
            power: shading.power as f32,
            total: total.map(|x| x as f32),
            brightest_light: up(most),
            brightest_color: up(brightest_color),
            to_world: rows.map(|row| row.map(|x| x as f32)),
            columns: columns.map(up),
            steepest: up(span * columns.iter().sum::<f64>()),
        })
    }

    /// Returns the largest factor on a colour.
    pub(super) fn largest_factor(&self) -> f64 {
        f64::from(self.ambient + self.diffuse * self.brightest_light).max(1.0) * (1.0 + 1e-6)
    }

    /// Finds how colours change along steps, under the lights for these rays.
    ///
    /// Its own function: it is not needed where nothing can be seen.
    #[inline(never)]
    pub(super) fn along<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        lights: &PacketLights,
        places: &Places,
        stage: &mut Stage<T>,
        change: &mut ColorChange,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let corners = Corners::new(simd, field, &places.cell, &self.to_world, &self.columns, stage);
                self.of_gradients(simd, &corners, lights, places, change);
            },
        )
    }

    /// Bounds how a unit normal turns, and what light and highlights are off by for that; the README beside the folder derives it.
    #[inline(always)]
    fn of_gradients<S: Simd>(
        &self,
        simd: S,
        corners: &Corners<S>,
        lights: &PacketLights,
        places: &Places,
        change: &mut ColorChange,
    ) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let is_flat = corners.reach.simd_le(zero);
        // Gradients relative to the longest in the cell, so that no square is too small or too large.
        let scale = one / pick(is_flat, one, corners.reach);
        let delta = load(simd, &places.delta);
        let steps = places.length.load(simd);
        let step = [delta[0] * steps, delta[1] * steps, delta[2] * steps];
        let middle = load(simd, &places.middle);
        let Derivatives { value, first, second, third } = corners.along(middle, step, scale);
        // A ray that hardly leaves a face may lie in the next cell for long.
        let beside_face = self.may_lie_beyond(simd, places, [middle, step]);
        let noise = pick(beside_face, scale * (4.0 * NEAR * self.steepest), zero) + NOISE;
        let (rise, bend, twist) = (length(first), length(second), length(third));
        // The gradient's departure from a line along the step, and the slope of that.
        let (beside, slope_beside) = (bend * (1.0 / 8.0) + twist * (1.0 / 48.0), bend * 0.5 + twist * (1.0 / 8.0));
        // Its shadow on the direction in the middle is no longer than itself.
        let size = length(value);
        let along = dot(value, first).abs() / size.max(splat(simd, f32::MIN_POSITIVE));
        let shortest = size * (1.0 - 8.0 * U) - along * 0.5 - beside - noise;
        let is_known = shortest.simd_gt(noise * 8.0);
        let per_length = one / pick(is_known, shortest, one);
        let longest = size + rise * 0.5 + beside;
        // Bounds of the first three derivatives of the normal.
        let across = length(cross(value, first)) + rise * (noise + longest * (8.0 * U));
        let turn = (across + slope_beside * longest + rise * beside) * per_length * per_length;
        let (steep, bent) = (rise + slope_beside, bend + twist * 0.5);
        let curved = (bent + turn * steep * 2.0) * per_length + turn * turn;
        let twisted = (twist + (steep * curved + bent * turn) * 3.0) * per_length + (turn * turn + curved) * turn * 3.0;
        let turning = [turn, curved, twisted];
        let blur = noise * per_length * 1.1 + 8.0 * U;

        // Normals at three places.
        let mut normals = [value; 3];
        for a in 0..3 {
            let (even, odd) = (value[a] + second[a] * (1.0 / 8.0), first[a] * 0.5 + third[a] * (1.0 / 48.0));
            (normals[0][a], normals[2][a]) = (even - odd, even + odd);
        }
        for normal in &mut normals {
            let inverse = one / dot(*normal, *normal).max(splat(simd, f32::MIN_POSITIVE)).sqrt();
            *normal = [normal[0] * inverse, normal[1] * inverse, normal[2] * inverse];
        }
        let ambient = splat(simd, self.ambient);
        let (mut factor, mut added) = ([[ambient; 3]; 3], [[zero; 3]; 3]);
        let (mut factor_off, mut added_off, mut blurred) = (zero, zero, zero);
        for light in lights.lights() {
            let most = light.color[0].max(light.color[1]).max(light.color[2]);
            let (diffuse, specular) = (self.diffuse * most, self.specular * most);
            let facing = Cosines::new(simd, &normals, &light.to_light, turn * 0.25 + blur);
            factor_off += pick(facing.vanishes, facing.high * 1.25, twisted * PARABOLA) * diffuse;
            blurred += blur * facing.sine() * (diffuse * self.brightest_color);
            for c in 0..3 {
                for i in 0..3 {
                    factor[c][i] += facing.at[i] * (self.diffuse * light.color[c]);
                }
            }
            if self.specular == 0.0 {
                continue;
            }
            let shining = Cosines::new(simd, &normals, &light.half, turn * 0.25 + blur);
            let off = self.highlight_off(simd, &shining, turning, blur);
            added_off += off[0] * specular;
            blurred += off[1] * specular;
            for i in 0..3 {
                let highlight = power_of(simd, shining.at[i], self.power);
                for c in 0..3 {
                    added[c][i] += highlight * (self.specular * light.color[c]);
                }
            }
        }

        // Take the middle of all that reflection can make where these bounds say less than that.
        let range = self.range();
        let light_off = factor_off * self.brightest_color + added_off;
        let is_better =
            is_known & light_off.simd_le(splat(simd, self.brightest_color * range.factor_off + range.added_off));
        let stays = is_flat & !beside_face;
        let choose = |own: f32x16<S>, any: f32, unlit: f32| {
            pick(stays, splat(simd, unlit), pick(is_better, own, splat(simd, any)))
        };
        let steepness = self.diffuse * self.brightest_light * self.brightest_color
            + self.specular * self.brightest_light * self.power.sqrt();
        let everything = self.brightest_color * self.largest_factor() as f32 + self.specular * self.brightest_light;
        // Behind the face the gradient is that of the next cell, and differs by slopes of the gradient over two margins; before a face that was leaped to, over four.
        let beyond = places.margin.load(simd) * (64.0 * self.steepest * steepness) * scale * per_length;
        change.factor_off = Lanes::new(choose(factor_off, range.factor_off, 0.0));
        change.added_off = Lanes::new(choose(added_off, range.added_off, 0.0));
        change.blurred = Lanes::new(choose(blurred, 0.0, 0.0));
        change.beyond = Lanes::new(choose(beyond.min(splat(simd, everything)), everything, everything));
        for c in 0..3 {
            for i in 0..3 {
                change.factor[c][i] = Lanes::new(choose(factor[c][i], range.factor[c], 1.0));
                change.added[c][i] = Lanes::new(choose(added[c][i], range.added[c], 0.0));
            }
        }
    }

    /// Bounds what a parabola misses of a highlight, a power of a cosine, and what that is off by for an error `blur` of the normal.
    ///
    /// The third derivative of yᵖ is p(p − 1)(p − 2)yᵖ⁻³ y′³ + 3p(p − 1)yᵖ⁻² y′y″ + p yᵖ⁻¹ y‴, and |y′| ≤ turn √(1 − y²), as what turns is across the normal.
    #[inline(always)]
    fn highlight_off<S: Simd>(
        &self,
        simd: S,
        shining: &Cosines<S>,
        [turn, curved, twisted]: [f32x16<S>; 3],
        blur: f32x16<S>,
    ) -> [f32x16<S>; 2] {
        let power = self.power;
        let high = shining.high.max(splat(simd, 1e-3));
        let most = power_of(simd, high, power);
        let per_cosine = splat(simd, 1.0) / high;
        let sine = shining.sine();
        let turned = turn * sine;
        let slope = most * per_cosine * power;
        let cubed = turned * per_cosine * turned * per_cosine * ((power - 1.0) * (power - 2.0));
        let third = slope * ((cubed + curved * per_cosine * (3.0 * (power - 1.0))) * turned + twisted);
        let rounding = most * ((64.0 + 4.0 * power) * U);
        [(third * PARABOLA).min(most * 1.25), slope * sine * blur + rounding]
    }

    /// Returns the middle of what reflection may make of colours, and half the width.
    fn range(&self) -> Range {
        let ends = |c: usize| (self.ambient.min(1.0), (self.ambient + self.diffuse * self.total[c]).max(1.0));
        let widest = [0, 1, 2].map(|c| ends(c).1 - ends(c).0).into_iter().fold(0.0, f32::max);
        Range {
            factor: [0, 1, 2].map(|c| 0.5 * (ends(c).0 + ends(c).1)),
            added: self.total.map(|total| 0.5 * self.specular * total),
            factor_off: 0.5 * widest * (1.0 + 8.0 * U),
            added_off: 0.5 * self.specular * self.brightest_light * (1.0 + 8.0 * U),
        }
    }

    /// Returns the rays that move so little across some faces that they may lie beyond one for longer than steps end behind their cells.
    #[inline(always)]
    fn may_lie_beyond<S: Simd>(&self, simd: S, places: &Places, [middle, step]: [[f32x16<S>; 3]; 2]) -> mask32x16<S> {
        let zero = splat(simd, 0.0);
        let whole = places.whole.load(simd);
        let mut beyond = zero.simd_gt(zero);
        for a in 0..3 {
            // A ray that runs along faces has an exact coordinate.
            let moves = (places.delta[a].load(simd) * whole).abs();
            let is_slow = moves.simd_gt(zero) & moves.simd_lt(splat(simd, 16.0));
            let room = step[a].abs() * 0.5 + NEAR;
            let near = (middle[a] - room).simd_le(zero) | (middle[a] + room).simd_ge(splat(simd, 1.0));
            beyond |= is_slow & near;
        }
        beyond
    }
}

/// All that reflection may make of colours.
struct Range {
    factor: [f32; 3],
    added: [f32; 3],
    factor_off: f32,
    added_off: f32,
}

/// Sizes of the cosines between the normals of steps and a direction.
struct Cosines<S: Simd> {
    /// At the begin, in the middle and at the end.
    at: [f32x16<S>; 3],
    /// Bounds along the step.
    low: f32x16<S>,
    high: f32x16<S>,
    /// Rays whose cosine may change its sign.
    vanishes: mask32x16<S>,
}

impl<S: Simd> Cosines<S> {
    /// Takes the cosines at three places. `beside`: what they may change by in a quarter of the step.
    #[inline(always)]
    fn new(simd: S, normals: &[[f32x16<S>; 3]; 3], towards: &[Lanes; 3], beside: f32x16<S>) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let towards = load(simd, towards);
        let [a, b, c] = [dot(normals[0], towards), dot(normals[1], towards), dot(normals[2], towards)];
        let at = [a.abs().min(one), b.abs().min(one), c.abs().min(one)];
        let low = at[0].min(at[1]).min(at[2]) - beside;
        let vanishes = (a * b).simd_lt(zero) | (b * c).simd_lt(zero) | low.simd_le(zero);
        let low = pick(vanishes, zero, low);
        Self { at, low, high: (at[0].max(at[1]).max(at[2]) + beside).min(one), vanishes }
    }

    /// Returns a bound of the sines.
    #[inline(always)]
    fn sine(&self) -> f32x16<S> {
        // Cosines are rounded beside 1.
        (self.low * self.low * -1.0 + (1.0 + 16.0 * U)).sqrt()
    }
}

// Functions in the place of closures, which are not inlined for certain.

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, v: &[Lanes; 3]) -> [f32x16<S>; 3] {
    [v[0].load(simd), v[1].load(simd), v[2].load(simd)]
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length of a vector, or a little more.
#[inline(always)]
fn length<S: Simd>(v: [f32x16<S>; 3]) -> f32x16<S> {
    dot(v, v).sqrt() * (1.0 + 4.0 * U)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_bound::seeded::runner;
    use proptest::prelude::*;
    use std::sync::Arc;
    use vr_core::filter::Lattice;
    use vr_core::{
        Calibration, ControlPoint, Filter, GridVolume, Light, OpacityRule, Placement, RayShading, Scene,
        TransferFunction, UniformGrid, Volume, gradient_at_sample,
    };
    use vr_kernels::vector::baseline;

    const SIDE: usize = 4;

    /// Step through a cell of a small volume, under two lights.
    #[derive(Clone, Debug)]
    struct Case {
        samples: Vec<f32>,
        spacing: [f64; 3],
        cell: [usize; 3],
        from: [f64; 3],
        to: [f64; 3],
        length: f64,
        power: f64,
        sun: [f64; 3],
        view: [f64; 3],
    }

    fn cases() -> impl Strategy<Value = Case> {
        // Samples that are mostly 0, bytes, and any numbers; and a large number that hardly changes.
        let sample = prop_oneof![Just(0.0f32), (0u8..4).prop_map(f32::from), -1.0f32..1.0];
        let rough = prop::collection::vec(sample, SIDE.pow(3));
        let samples =
            (rough, prop_oneof![4 => Just(1.0f32), 1 => 0.0f32..0.1, 1 => Just(1e12)], 0.0f32..1.0, any::<bool>())
                .prop_map(|(rough, roughness, slope, steep)| {
                    let ramp =
                        |i: usize| if steep { 3.0 * slope * (i % SIDE) as f32 + (i / SIDE % SIDE) as f32 } else { 0.0 };
                    rough.iter().enumerate().map(|(i, r)| ramp(i) + roughness * r).collect()
                });
        let place = prop::array::uniform3(0.0f64..1.0);
        let direction =
            || prop::array::uniform3(-1.0f64..1.0).prop_filter("long enough", |v| DVec3::from(*v).length() > 0.1);
        let power = prop_oneof![Just(2.0), Just(3.0), Just(20.0), Just(150.0), 3.0f64..40.0];
        let spacing = prop_oneof![Just([1.0; 3]), Just([0.5, 1.0, 7.0])];
        let cell = prop::array::uniform3(0usize..SIDE - 1);
        (samples, spacing, cell, place.clone(), place, 0.0f64..1.0, power, (direction(), direction())).prop_map(
            |(samples, spacing, cell, from, to, length, power, (sun, view))| {
                let length = length.powi(3);
                Case { samples, spacing, cell, from, to, length, power, sun, view }
            },
        )
    }

    /// Returns factor and added light for a world gradient, in f64.
    fn reflected(ray: &RayShading<f64>, gradient: [f64; 3]) -> [f64; 2] {
        let n = DVec3::from(gradient);
        if n == DVec3::ZERO {
            return [1.0, 0.0];
        }
        let n = n.normalize();
        let mut found = [ray.ambient, 0.0];
        for light in &ray.lights {
            found[0] += ray.diffuse * light.color[0] * n.dot(DVec3::from(light.to_light)).abs();
            found[1] +=
                ray.specular * light.color[0] * libm::pow(n.dot(DVec3::from(light.half)).abs().min(1.0), ray.power);
        }
        found
    }

    /// Returns the largest share of the bound that the light of a white medium is off by along a step.
    fn share(case: &Case) -> f64 {
        let placement = Placement::from_spacing(case.spacing).unwrap();
        let grid = UniformGrid::new([SIDE; 3], case.samples.clone(), placement, Calibration::default()).unwrap();
        let volume = Arc::new(GridVolume::new(grid.into(), Filter::Trilinear));
        let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
        let look = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let shading = Shading { power: case.power, ..Shading::default() };
        let mut scene = Scene::new(Volume::Grid(volume.clone()), look);
        scene.shading = Some(Arc::new(shading));
        scene.lights = vec![Light::default(), Light { direction: Some(case.sun.into()), color: [0.7; 3] }];
        let reflection = Reflection::new(&scene, 1.0).unwrap();
        let gradients = Gradients::new(&scene, &volume).unwrap();
        let packets = PacketReflection::new(&reflection, &gradients, 1.0, 1e13).unwrap();
        let direction = DVec3::from(case.view).normalize();
        let mut lights = PacketLights::default();
        lights.look_along(&scene.lights, &[0, 1, 2].map(|a| [direction[a]; LANES]));
        let lattice = Lattice { samples: &case.samples[..], dims: [SIDE; 3] };
        // Fractions of the cell at both ends; the whole ray is long, so that no axis is slow.
        let to: [f64; 3] = std::array::from_fn(|a| case.from[a] + case.length * (case.to[a] - case.from[a]));
        let lanes = |x: f64| Lanes([x as f32; LANES]);
        let places = Places {
            cell: case.cell.map(|c| lanes(c as f64)),
            middle: std::array::from_fn(|a| lanes(0.5 * (case.from[a] + to[a]))),
            length: lanes(case.length),
            margin: lanes(0.0),
            delta: std::array::from_fn(|a| lanes(case.to[a] - case.from[a])),
            whole: lanes(1e6),
        };
        let mut change = ColorChange::NONE;
        let mut stage = Stage::default();
        packets.along(baseline(), &Field::new(&lattice), &lights, &places, &mut stage, &mut change);
        let ray = &reflection.shading.along(&scene.lights, direction);
        let corner = |i: usize| std::array::from_fn(|a| case.cell[a] + (i >> a & 1));
        let corners: [[f64; 3]; 8] = std::array::from_fn(|i| gradient_at_sample(&lattice, corner(i)));
        let [factor_off, added_off, blurred] =
            [&change.factor_off, &change.added_off, &change.blurred].map(|l| f64::from(l.0[3]));
        let mut worst = 0.0f64;
        for k in 0..=40 {
            let t = f64::from(k) / 40.0;
            let at: [f64; 3] = std::array::from_fn(|a| case.from[a] + t * (to[a] - case.from[a]));
            let weight = |i: usize| (0..3).map(|a| if i >> a & 1 == 1 { at[a] } else { 1.0 - at[a] }).product::<f64>();
            let per_index: [f64; 3] = std::array::from_fn(|a| (0..8).map(|i| weight(i) * corners[i][a]).sum());
            let world = gradients.to_world.map(|row| (0..3).map(|a| row[a] * per_index[a]).sum());
            let want = reflected(ray, world);
            let parabola = |ends: &[Lanes; 3]| {
                let [a, b, c] = ends.map(|l| f64::from(l.0[3]));
                a + (c - a) * t + (b - 0.5 * (a + c)) * 4.0 * t * (1.0 - t)
            };
            let off = (parabola(&change.factor[0]) + parabola(&change.added[0]) - want[0] - want[1]).abs();
            // The sum itself is rounded to f32.
            worst = worst.max((off - 1e-6).max(0.0) / (factor_off + added_off + blurred).max(1e-12));
        }
        worst
    }

    #[test]
    fn reflected_light_keeps_its_bound() {
        let found = std::cell::RefCell::new(Vec::new());
        runner(20_000, 24)
            .run(&cases(), |case| {
                let share = share(&case);
                found.borrow_mut().push(share);
                prop_assert!(share <= 1.0, "{share}");
                Ok(())
            })
            .unwrap();
        let found = found.into_inner();
        let half = found.iter().filter(|&&share| share > 0.3).count();
        println!("{} steps, {half} of them use 0.3 of their bound or more", found.len());
        // The bound is not far above the errors.
        assert!(half > 100, "{half}");
    }
}
