//! Shading of sixteen samples: gradients by central differences, and the light that they reflect.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use glam::DVec3;

use super::field::{Field, Pairs, Stage};
use super::modulation::{Modulation, RowMixture, StepOptics};
use super::{LANES, Lanes, ln, opacity_of_depth, pick, splat};
use vr_core::{Light, Placement, Shading, turning};

/// Shading, the same for all rays.
#[derive(Clone, Debug)]
pub struct PacketShading {
    /// Coefficients.
    pub shading: Arc<Shading>,
    /// The lights.
    pub lights: Vec<Light>,
    /// Matrix from gradients per index step to world gradients, but for their length.
    pub to_world: [[f32; 3]; 3],
    /// Factor on the extinction by the gradient; `None` where it has none.
    pub modulation: Option<Modulation>,
    /// Rows of the transfer function that the gradient mixes; `None` where it has none. With rows there are no factors.
    pub rows: Option<RowMixture>,
    /// True if colours reflect light.
    pub reflects: bool,
}

impl PacketShading {
    /// Shading for gradients of a grid whose axes are taken in this order.
    pub fn new(shading: Arc<Shading>, lights: &[Light], placement: &Placement, axes: [usize; 3]) -> Self {
        let (matrix, _) = placement.scaled_gradient_matrix(1.0);
        let to_world = std::array::from_fn(|row| axes.map(|a| matrix.col(a)[row] as f32));
        Self { shading, lights: lights.to_vec(), to_world, modulation: None, rows: None, reflects: true }
    }

    /// True if light and opacity follow the gradient, apart from what is reflected.
    #[inline(always)]
    pub fn follows_gradients(&self) -> bool {
        self.modulation.is_some() || self.rows.is_some()
    }
}

/// The lights as the rays of a packet see them.
#[derive(Clone, Debug, Default)]
pub struct PacketLights {
    lights: Vec<PacketLight>,
    /// Directions of the rays that they were made for.
    directions: Option<[[f64; LANES]; 3]>,
}

/// The lights as one ray sees them.
#[derive(Clone, Debug, Default)]
pub struct SeenLights(Vec<SeenLight>);

#[derive(Clone, Debug)]
struct SeenLight {
    /// Unit vector towards the light.
    to_light: [f32; 3],
    /// Unit vector between light and eye; zero where they are opposite.
    half: [f32; 3],
    color: [f32; 3],
}

impl SeenLights {
    /// The lights for a ray of this (unit) direction.
    pub fn along(lights: &[Light], direction: DVec3) -> Self {
        let seen = |light: &Light| {
            let to_eye = -direction;
            let to_light = light.direction.map_or(to_eye, DVec3::normalize);
            let half = (to_light + to_eye).normalize_or_zero();
            let [to_light, half, color] = [to_light, half, light.color.into()].map(|v: DVec3| v.as_vec3().to_array());
            SeenLight { to_light, half, color }
        };
        Self(lights.iter().map(seen).collect())
    }
}

/// A light as the rays of a packet see it.
#[derive(Clone, Debug)]
pub struct PacketLight {
    /// Unit vectors towards the light.
    pub to_light: [Lanes; 3],
    /// Unit vectors between light and eye; zero where they are opposite.
    pub half: [Lanes; 3],
    /// Linear RGB.
    pub color: [f32; 3],
}

impl PacketLights {
    /// The lights, one by one.
    #[inline(always)]
    pub fn lights(&self) -> &[PacketLight] {
        &self.lights
    }

    /// Makes them for rays of these (unit) directions, unless they are for those already.
    pub fn look_along(&mut self, lights: &[Light], directions: &[[f64; LANES]; 3]) {
        if self.directions.as_ref() == Some(directions) {
            return;
        }
        let [x, y, z] = directions;
        let seen: [_; LANES] = std::array::from_fn(|i| SeenLights::along(lights, DVec3::new(x[i], y[i], z[i])));
        self.gather(&seen.each_ref());
        self.directions = Some(*directions);
    }

    /// Makes them from those of sixteen rays, which see the same lights.
    #[inline]
    pub fn gather(&mut self, rays: &[&SeenLights; LANES]) {
        self.directions = None;
        let count = rays[0].0.len();
        let none = PacketLight { to_light: [Lanes::ZERO; 3], half: [Lanes::ZERO; 3], color: [0.0; 3] };
        self.lights.resize(count, none);
        for (k, light) in self.lights.iter_mut().enumerate() {
            light.color = rays[0].0[k].color;
            for (i, ray) in rays.iter().enumerate() {
                let seen = &ray.0[k];
                for a in 0..3 {
                    light.to_light[a].0[i] = seen.to_light[a];
                    light.half[a].0[i] = seen.half[a];
                }
            }
        }
    }
}

/// Shading and lights for the samples of a packet.
#[derive(Clone, Copy)]
pub struct Shade<'a> {
    /// Shading, the same for all rays.
    pub shading: &'a PacketShading,
    /// Lights as the rays of this packet see them.
    pub lights: &'a PacketLights,
}

impl Shade<'_> {
    /// Shades light of sixteen samples: c becomes c·(ka + kd Σ L|n·l|), and ks Σ L|n·h|^p times opacity is added. Where the gradient is
    /// zero, it stays. `at`: cells and fractions in them; `step`: extents, in index space, of the steps that the samples are the middles of, over which
    /// normals are followed as [`vr_core::RayShading::reflect_turning`] has it; zero for samples that stand for themselves.
    ///
    /// Its own function: there are samples that need no shading, and instances of it for each kernel would be many.
    #[inline(never)]
    pub fn apply<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        light: &mut [Lanes; 4],
        stage: &mut Stage<T>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.apply_here(simd, field, at, step, light, stage),
        );
    }

    #[inline(always)]
    fn apply_here<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        light: &mut [Lanes; 4],
        stage: &mut Stage<T>,
    ) {
        let [g, turn] = gradient(simd, field, at, step, stage);
        self.light_by(simd, g, turn, light);
    }

    /// Shades as [`apply`](Self::apply) does, after the factors of [`PacketShading::modulation`]: light and opacity of steps that absorb are made anew.
    ///
    /// Its own function, as that is.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what `apply` takes, and one more")]
    pub fn apply_modulated<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        optics: &StepOptics,
        light: &mut [Lanes; 4],
        stage: &mut Stage<T>,
    ) {
        let gradients = central_differences(simd, field, at, step, stage);
        self.apply_by(simd, &gradients, Some(optics), light, |_| ());
    }

    /// Changes the light of steps by their gradients, and by how these turn from begin to end: light and opacity are made anew first, where there are
    /// `optics` to make them from; then `tint` multiplies the light by colours of its places; and what is left reflects.
    #[inline(always)]
    pub fn apply_by<S: Simd>(
        &self,
        simd: S,
        [gradient, turn]: &[[Lanes; 3]; 2],
        optics: Option<&StepOptics>,
        light: &mut [Lanes; 4],
        tint: impl FnOnce(&mut [Lanes; 4]),
    ) {
        if let Some(optics) = optics {
            self.modulate(simd, gradient, optics, light);
        }
        tint(light);
        if self.shading.reflects {
            self.apply_to_turning(simd, gradient, turn, light);
        }
    }

    /// Shades light of sixteen samples whose gradients are known, and that stand for themselves.
    ///
    /// Its own function, as [`apply`](Self::apply) is.
    #[inline(never)]
    pub fn apply_to_gradients<S: Simd>(&self, simd: S, gradient: &[Lanes; 3], light: &mut [Lanes; 4]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let none = splat(simd, 0.0);
                let gradient = [gradient[0].load(simd), gradient[1].load(simd), gradient[2].load(simd)];
                self.light_by(simd, gradient, [none; 3], light);
            },
        );
    }

    /// Shades light of steps whose gradients are known, and how they turn from their begin to their end.
    ///
    /// Its own function, as [`apply`](Self::apply) is.
    #[inline(never)]
    pub fn apply_to_turning<S: Simd>(&self, simd: S, gradient: &[Lanes; 3], turn: &[Lanes; 3], light: &mut [Lanes; 4]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let gradient = [gradient[0].load(simd), gradient[1].load(simd), gradient[2].load(simd)];
                let turn = [turn[0].load(simd), turn[1].load(simd), turn[2].load(simd)];
                self.light_by(simd, gradient, turn, light);
            },
        );
    }

    /// Shades light by gradients, and by how they change over the steps.
    #[inline(always)]
    fn light_by<S: Simd>(&self, simd: S, g: [f32x16<S>; 3], turn: [f32x16<S>; 3], light: &mut [Lanes; 4]) {
        // World gradients in the middles of the steps, and what they reflect.
        let (w, turn) = (world(&self.shading.to_world, g), world(&self.shading.to_world, turn));
        let shading = &self.shading.shading;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let length = largest(w);
        let flat = length.simd_le(zero);
        let mut reflected = reflect(simd, shading, self.lights, w);
        // Follow the normals that turn within their steps.
        let alpha = light[3].load(simd);
        let share = (largest(turn) / (pick(flat, one, length) * (turning::SMALLEST as f32)) - one).min(one);
        let turns = share.simd_gt(zero) & alpha.simd_gt(zero) & !flat;
        if turns.any_true() {
            let share = pick(turns, share, zero);
            let node = turning::NODE as f32;
            let turn = [turn[0] * node, turn[1] * node, turn[2] * node];
            let near = reflect(simd, shading, self.lights, [w[0] - turn[0], w[1] - turn[1], w[2] - turn[2]]);
            let far = reflect(simd, shading, self.lights, [w[0] + turn[0], w[1] + turn[1], w[2] + turn[2]]);
            let lean = alpha * ((alpha * (1.0 / 3.0) + 0.5) * alpha + 1.0) * (1.0 / (24.0 * node));
            let (own, outer) = (turning::MIDDLE as f32, splat(simd, turning::SIDE as f32));
            for c in 0..6 {
                let middle = reflected[c];
                let mean = near[c] * (outer + lean) + middle * own + far[c] * (outer - lean);
                reflected[c] = middle + (mean - middle) * share;
            }
        }
        for c in 0..3 {
            let old = light[c].load(simd);
            light[c] = Lanes::new(pick(flat, old, old * reflected[c] + reflected[3 + c] * alpha));
        }
    }
}

/// Factors on the three colours, and the three lights that are added to an opaque sample, for sixteen world gradients of any length; where one is zero, as
/// if it were across everything.
#[inline(always)]
pub fn reflect<S: Simd>(simd: S, shading: &Shading, lights: &PacketLights, w: [f32x16<S>; 3]) -> [f32x16<S>; 6] {
    // Scaled by its largest component, so that the square neither underflows nor overflows.
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let longest = largest(w);
    let flat = longest.simd_le(zero);
    let scale = one / pick(flat, one, longest);
    let n = [w[0] * scale, w[1] * scale, w[2] * scale];
    let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    let norm = one / pick(flat, one, square).sqrt();
    let (ambient, diffuse) = (shading.ambient as f32, shading.diffuse as f32);
    let (specular, power) = (shading.specular as f32, shading.power as f32);
    let ambient = splat(simd, ambient);
    let mut sums = [ambient, ambient, ambient, zero, zero, zero];
    for seen in &lights.lights {
        let facing = (dot(simd, n, &seen.to_light) * norm).abs().min(one) * diffuse;
        let highlight = power_of(simd, (dot(simd, n, &seen.half) * norm).abs().min(one), power) * specular;
        for c in 0..3 {
            sums[c] += facing * seen.color[c];
            sums[3 + c] += highlight * seen.color[c];
        }
    }
    sums
}

/// Largest whole exponent for which a power is a product: its rounding grows with the exponent.
const MAX_PRODUCT: f32 = 64.0;

/// Powers of numbers in [0, 1] with an exponent of at least 0.
#[inline(always)]
pub fn power_of<S: Simd>(simd: S, x: f32x16<S>, exponent: f32) -> f32x16<S> {
    if exponent <= MAX_PRODUCT && exponent == exponent.trunc() {
        // By squares: a few products in the place of a logarithm and an exponential.
        let (mut power, mut square, mut left) = (splat(simd, 1.0), x, exponent as u32);
        loop {
            if left & 1 == 1 {
                power *= square;
            }
            left >>= 1;
            if left == 0 {
                return power;
            }
            square *= square;
        }
    }
    // x^p = e^(p ln x).
    let depth = ln(simd, x.max(splat(simd, f32::MIN_POSITIVE))).min(splat(simd, 0.0)) * -exponent;
    splat(simd, 1.0) - opacity_of_depth(simd, depth)
}

/// Gradients by central differences at cells and fractions in them, and how they change over steps of these extents in index space: both per index step.
///
/// Its own function: there are samples that need no gradient, and instances of it for each kernel would be many.
#[inline(never)]
pub fn central_differences<S: Simd, T: Pairs>(
    simd: S,
    field: &Field<'_, T>,
    at: &[[Lanes; 3]; 2],
    step: &[Lanes; 3],
    stage: &mut Stage<T>,
) -> [[Lanes; 3]; 2] {
    let mut found = [[Lanes::ZERO; 3]; 2];
    simd.vectorize(
        #[inline(always)]
        || {
            let both = gradient(simd, field, at, step, stage);
            for (found, of_axes) in found.iter_mut().zip(both) {
                *found = [Lanes::new(of_axes[0]), Lanes::new(of_axes[1]), Lanes::new(of_axes[2])];
            }
        },
    );
    found
}

/// Gradients per index step, and how they change over a step of an extent in index space: central differences at the voxels, one-sided at the faces of
/// the box, interpolated trilinearly. Positions are the numbers of the cells (whole numbers), and fractions in them.
///
/// Interpolation commutes with shifts by whole voxels. So a component is the difference of two interpolations, a voxel on and a voxel
/// back, with weights (1 − t)/w₀ and t/w₁ along the axis, w the voxels that each difference spans; beyond a face lies the last voxel
/// again. Planes of voxels are interpolated across the axis first, and subtracted then: where the field is constant, the gradient is
/// zero to the last bit, and nothing is shaded by what rounding leaves.
#[inline(always)]
fn gradient<S: Simd, T: Pairs>(
    simd: S,
    field: &Field<'_, T>,
    [cell, fraction]: &[[Lanes; 3]; 2],
    step: &[Lanes; 3],
    stage: &mut Stage<T>,
) -> [[f32x16<S>; 3]; 2] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let cell = [cell[0].load(simd), cell[1].load(simd), cell[2].load(simd)];
    let t = [fraction[0].load(simd), fraction[1].load(simd), fraction[2].load(simd)];
    let step = [step[0].load(simd), step[1].load(simd), step[2].load(simd)];
    let cells = [cell[0].to_int::<i32x16<S>>(), cell[1].to_int::<i32x16<S>>(), cell[2].to_int::<i32x16<S>>()];
    field.surround(simd, cells, &mut stage.around);
    let (mut gradient, mut turn) = ([zero; 3], [zero; 3]);
    for a in 0..3 {
        let last = splat(simd, field.last_cell[a] as f32);
        let (first, at_last) = (cell[a].simd_le(zero), cell[a].simd_ge(last));
        let half = splat(simd, 0.5);
        let (per_back, per_on) = (pick(first, one, half), pick(at_last, one, half));
        let (back, on) = ((one - t[a]) * per_back, t[a] * per_on);
        let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
        // The planes across the axis, before the cell to behind it: each its value and its change.
        let [before, low, high, behind] = stage.around.planes(simd, a);
        let [before, low, high, behind] = [
            plane(before, [t[b], t[c]], [step[b], step[c]]),
            plane(low, [t[b], t[c]], [step[b], step[c]]),
            plane(high, [t[b], t[c]], [step[b], step[c]]),
            plane(behind, [t[b], t[c]], [step[b], step[c]]),
        ];
        let (at_low, at_high) = (high[0] - before[0], behind[0] - low[0]);
        gradient[a] = back * at_low + on * at_high;
        let (turn_low, turn_high) = (high[1] - before[1], behind[1] - low[1]);
        turn[a] = back * turn_low + on * turn_high + step[a] * (per_on * at_high - per_back * at_low);
    }
    [gradient, turn]
}

// Functions in the place of closures, which are not inlined for certain.

/// Returns the world gradient of one per index step.
#[inline(always)]
pub(super) fn world<S: Simd>(m: &[[f32; 3]; 3], v: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [
        v[0] * m[0][0] + v[1] * m[0][1] + v[2] * m[0][2],
        v[0] * m[1][0] + v[1] * m[1][1] + v[2] * m[1][2],
        v[0] * m[2][0] + v[1] * m[2][1] + v[2] * m[2][2],
    ]
}

/// Returns the size of the largest component.
#[inline(always)]
pub(super) fn largest<S: Simd>(v: [f32x16<S>; 3]) -> f32x16<S> {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [f32x16<S>; 3], b: &[Lanes; 3]) -> f32x16<S> {
    a[0] * b[0].load(simd) + a[1] * b[1].load(simd) + a[2] * b[2].load(simd)
}

/// Bilinear interpolation in a plane of four voxels, and its change over a step.
#[inline(always)]
fn plane<S: Simd>(
    [v00, v10, v01, v11]: [f32x16<S>; 4],
    [t, u]: [f32x16<S>; 2],
    [along_t, along_u]: [f32x16<S>; 2],
) -> [f32x16<S>; 2] {
    let (rise_0, rise_1) = (v10 - v00, v11 - v01);
    let (row_0, row_1) = (v00 + t * rise_0, v01 + t * rise_1);
    let across = row_1 - row_0;
    [row_0 + u * across, along_u * across + along_t * (rise_0 + u * (rise_1 - rise_0))]
}
