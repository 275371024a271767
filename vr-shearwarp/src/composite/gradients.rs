//! Gradients at sixteen samples, and the light that they reflect.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::{DMat3, DVec3};
use vr_core::{Light, Shading};
use vr_kernels::vector::{LANES, PacketLights, SeenLights, pick, reflect, splat};

use super::cells::{Edges, Interpolated, Places, interpolated};
use super::kernel::Chunk;
use crate::factorization::{Factorization, IndexView};

/// Gradients in the world, in units of steepness.
pub(crate) enum Gradients<'a> {
    /// No sample looks at any.
    None,
    /// Those of voxels, component by component in the order of the voxels, interpolated.
    OfVoxels([&'a [f32]; 3]),
    /// Those of the trilinear filter itself, by a matrix from differences of codes along u, v and w. Slices lie between layers.
    OfFilter([[f32; 3]; 3]),
}

impl Gradients<'_> {
    /// Those of the filter, given a matrix from gradients per index step, of codes, to the world.
    pub(crate) fn of_filter(to_world: DMat3, axes: [usize; 3]) -> Self {
        let columns = axes.map(|axis| to_world.col(axis).as_vec3().to_array());
        Self::OfFilter(std::array::from_fn(|row| columns.map(|column| column[row])))
    }

    /// Gradients at sixteen places.
    #[inline(always)]
    pub(super) fn at<S: Simd, P: Interpolated, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        voxels: &[P],
        edges: &Edges<N>,
        places: &Places<S>,
    ) -> [f32x16<S>; 3] {
        match self {
            Self::None => [splat(simd, 0.0); 3],
            Self::OfVoxels([x, y, z]) => [
                interpolated::<S, f32, N, UNIT>(simd, x, edges, places),
                interpolated::<S, f32, N, UNIT>(simd, y, edges, places),
                interpolated::<S, f32, N, UNIT>(simd, z, edges, places),
            ],
            Self::OfFilter(to_world) => {
                let differences = differences::<S, P, N, UNIT>(simd, voxels, edges, places);
                let mut world = [splat(simd, 0.0); 3];
                for (row, sum) in world.iter_mut().enumerate() {
                    for (column, difference) in differences.into_iter().enumerate() {
                        *sum += difference * to_world[row][column];
                    }
                }
                world
            }
        }
    }

    /// The gradient at a voxel.
    #[inline(always)]
    pub(super) fn at_voxel(&self, voxel: usize) -> [f32; 3] {
        match self {
            Self::None => [0.0; 3],
            Self::OfVoxels(components) => components.map(|c| c[voxel]),
            Self::OfFilter(_) => unreachable!("refused: around a voxel the filter's gradient jumps"),
        }
    }
}

/// The trilinear filter's own derivatives along u, v and w: of the weights along a row, across rows, and across layers.
#[inline(always)]
fn differences<S: Simd, P: Interpolated, const N: usize, const UNIT: bool>(
    simd: S,
    voxels: &[P],
    edges: &Edges<N>,
    places: &Places<S>,
) -> [f32x16<S>; 3] {
    let (mut down, mut behind) = (0.0, 0.0);
    for n in 0..N {
        down += if n % 2 == 1 { edges.weights[n] } else { 0.0 };
        behind += if n >= 2 { edges.weights[n] } else { 0.0 };
    }
    let (mut across, mut along) = (*edges, *edges);
    for n in 0..N {
        let of_layer = if n >= 2 { behind } else { 1.0 - behind };
        let of_row = if n % 2 == 1 { down } else { 1.0 - down };
        across.weights[n] = if n % 2 == 1 { of_layer } else { -of_layer };
        along.weights[n] = if n >= 2 { of_row } else { -of_row };
    }
    let end = |weight: f32| {
        let weight = splat(simd, weight);
        Places { first: places.first, cell: places.cell, weight, of_voxels: weight }
    };
    let right: f32x16<S> = interpolated::<S, P, N, UNIT>(simd, voxels, edges, &end(1.0));
    let left: f32x16<S> = interpolated::<S, P, N, UNIT>(simd, voxels, edges, &end(0.0));
    [
        right - left,
        interpolated::<S, P, N, UNIT>(simd, voxels, &across, places),
        interpolated::<S, P, N, UNIT>(simd, voxels, &along, places),
    ]
}

/// Shading by gradients.
pub(crate) struct GradientShading<'a> {
    /// `None` where colours reflect no light.
    shading: Option<&'a Shading>,
    lights: &'a [Light],
    /// Lights along parallel rays; `None` in perspective.
    parallel: Option<PacketLights>,
    view: &'a IndexView,
    factorization: &'a Factorization,
}

impl<'a> GradientShading<'a> {
    pub(crate) fn new(
        (shading, lights): (Option<&'a Shading>, &'a [Light]),
        (view, factorization): (&'a IndexView, &'a Factorization),
    ) -> Self {
        let mut made = Self { shading, lights, parallel: None, view, factorization };
        if !view.is_perspective() {
            made.parallel = Some(made.lights_at(0, 0));
        }
        made
    }

    /// The lights as the rays of the sixteen texels from (x, y) on see them.
    fn lights_at(&self, x: usize, y: usize) -> PacketLights {
        let f = self.factorization;
        let along = |i: usize| -> DVec3 {
            let step = f.step((x + i) as f64, y as f64);
            (f.sign * self.view.world_vector(step)).normalize()
        };
        let seen: [SeenLights; LANES] = std::array::from_fn(|i| SeenLights::along(self.lights, along(i)));
        let mut lights = PacketLights::default();
        lights.gather(&seen.each_ref());
        lights
    }

    /// Light of sixteen texels' samples, shaded by their gradients.
    #[inline(always)]
    pub(super) fn shaded<S: Simd>(
        &self,
        simd: S,
        at: &Chunk,
        gradient: [f32x16<S>; 3],
        mut samples: [f32x16<S>; 4],
    ) -> [f32x16<S>; 4] {
        let Some(shading) = self.shading else { return samples };
        let own;
        let lights = match &self.parallel {
            Some(lights) => lights,
            None => {
                own = self.lights_at(at.x, at.y);
                &own
            }
        };
        let [x, y, z] = gradient;
        let flat = (x.abs() + y.abs() + z.abs()).simd_le(splat(simd, 0.0));
        let reflected = reflect(simd, shading, lights, gradient);
        let last = samples[3];
        for c in 0..3 {
            samples[c] = pick(flat, samples[c], samples[c] * reflected[c] + reflected[3 + c] * last);
        }
        samples
    }
}

/// Lengths of sixteen vectors.
#[inline(always)]
pub(super) fn lengths<S: Simd>([x, y, z]: [f32x16<S>; 3]) -> f32x16<S> {
    (x * x + y * y + z * z).sqrt()
}
