//! Packets of sixteen rays that keep account of their error: the cost of each step follows from how the field and the transfer function can vary within it.
//!
//! The README beside `error_bound` has the proof. A ray whose account does not balance is left to the cell-by-cell integrator.

mod cell;
mod color_change;
mod cost_table;
mod gradients;
mod march;
#[cfg(test)]
mod midpoints;
mod path;
mod step;
mod stretch;
mod voxel_tints;

use fearless_simd::{Level, Simd};
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{ColorGrid, Counts, Filter, GridVolume, Layer, ParameterError, Rays, View, with_grid};
use vr_kernels::vector::{self, Chords, Field, LANES, Lanes, PacketLights, Pairs, Stage, Vectorized};

use super::blocks;
use super::normals::Gradients;
use super::optics::Optics;
use super::reflection::Reflection;
use crate::leap::ClearSpace;
use crate::near_depths::NearDepths;
use crate::silhouette::Hull;
use crate::tracer::RaySample;
use color_change::PacketReflection;
use cost_table::CostTable;
use march::{Marched, Medium, Packet, march};
use voxel_tints::VoxelTints;

/// Tables of a scene for packets whose error is bounded.
#[derive(Clone, Debug)]
pub(super) struct BoundedPackets {
    level: Level,
    clear: ClearSpace,
    costs: CostTable,
    hull: Hull,
    /// `None` where colours reflect no light.
    reflection: Option<PacketReflection>,
    /// Largest component of a colour of the transfer function.
    brightest_color: f64,
    /// World length of the smallest voxel edge.
    unit: f64,
    span: f32,
    noise: f32,
}

impl BoundedPackets {
    /// Prepares a scene; `None` if these packets have no bounds for it: with other filters than trilinear, missing voxels, emission given on its own, or
    /// reflection that jumps.
    pub(super) fn new(
        level: Level,
        volume: &GridVolume,
        optics: &Optics,
        reflected: Option<(&Reflection, &Gradients)>,
    ) -> Option<Self> {
        if volume.filter() != Filter::Trilinear || volume.vacuum_cells().is_some() {
            return None;
        }
        let dims = volume.dims();
        if dims.iter().product::<usize>() > i32::MAX as usize {
            return None;
        }
        let (low, high) = volume.value_stats().range?;
        let unit = volume.placement().spacing().min_element();
        let span = (high - low).next_up();
        let (reflection, brightness) = match reflected {
            Some((reflection, gradients)) => {
                let packets = PacketReflection::new(reflection, gradients, optics.brightest, f64::from(span))?;
                let brightness = [reflection.brightest, packets.largest_factor()];
                (Some(packets), brightness)
            }
            None => (None, [optics.brightest, 1.0]),
        };
        let costs = CostTable::new(optics, [low, high], unit, brightness)?;
        let clear = ClearSpace::of_cells(volume, |from, to| !blocks::is_clear(optics, from, to));
        let hull = Hull::new(dims, clear.visible_blocks(dims));
        // Rounding of three linear interpolations, each of a difference, a product and a sum; and of the knots' places.
        let noise = f64::from(low.abs().max(high.abs())) * 24.0 * libm::exp2(-24.0) + optics.knot_error;
        let noise = noise as f32 * (1.0 + 1e-6);
        Some(Self { level, clear, costs, hull, reflection, brightest_color: optics.brightest, unit, span, noise })
    }
}

/// Packets of the rays of one view.
pub(crate) struct PacketView<'a> {
    packets: &'a BoundedPackets,
    near: NearDepths,
    forward: DVec3,
    /// Error that a ray may have, relative to max(1, its radiance).
    error: f32,
}

impl<'a> PacketView<'a> {
    pub(super) fn new(
        packets: &'a BoundedPackets,
        volume: &GridVolume,
        view: &View,
        error: f64,
    ) -> Result<Self, ParameterError> {
        let near = packets.hull.near_depths(view, volume.placement())?;
        // Rounded down.
        let error = error as f32 * (1.0 - 1e-6);
        Ok(Self { packets, near, forward: view.camera.frame()?.z_axis, error })
    }

    /// True if rays through the pixels from `low` to `high`, both included, meet clear blocks alone.
    pub(super) fn is_clear(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        self.near.is_clear(low, high)
    }

    /// Traces up to sixteen rays through a volume, with colours or without, and returns the mask of those whose bound is not kept: the caller has to trace these by other means.
    pub(super) fn trace(
        &self,
        (volume, colors): (&GridVolume, Option<&ColorGrid>),
        rays: &Rays,
        (view, layer): (&View, Option<&Layer>),
        spots: &[ImageSample],
        values: &mut [RaySample],
        counts: &mut Counts,
    ) -> u32 {
        with_grid!(volume.values(), grid => {
            let lattice = vr_core::filter::Lattice { samples: grid.samples(), dims: grid.dims() };
            let medium = Medium {
                field: Field::new(&lattice),
                dims: grid.dims(),
                clear: &self.packets.clear,
                costs: &self.packets.costs,
                span: self.packets.span,
                noise: self.packets.noise,
                error: self.error,
                reflection: self.packets.reflection.as_ref(),
                tints: colors.map(|colors| VoxelTints::new(colors, self.packets.brightest_color)),
            };
            vector::run(self.packets.level, Trace { view: self, medium: &medium, volume, rays, seen: (view, layer), spots, values, counts })
        })
    }
}

/// Arguments of [`PacketView::trace`], for a medium.
struct Trace<'a, T> {
    view: &'a PacketView<'a>,
    medium: &'a Medium<'a, T>,
    volume: &'a GridVolume,
    rays: &'a Rays,
    seen: (&'a View, Option<&'a Layer>),
    spots: &'a [ImageSample],
    values: &'a mut [RaySample],
    counts: &'a mut Counts,
}

impl<T: Pairs> Vectorized for Trace<'_, T> {
    type Output = u32;
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u32 {
        let seeing = self.view.near.at_spots(self.spots);
        let Some((packet, begin)) = seeing.map(|nearest| self.packet(&nearest)).filter(|(p, _)| p.hits != 0) else {
            return 0;
        };
        let mut stages = [Stage::default(), Stage::default()];
        let Marched { rgba, half, kept, ended, samples } = march(simd, self.medium, &packet, &mut stages);
        self.counts.rays += u64::from(kept.count_ones());
        self.counts.samples += u64::from(samples);
        self.counts.terminated += u64::from((ended & kept).count_ones());
        for (i, value) in self.values.iter_mut().enumerate() {
            if kept >> i & 1 == 1 {
                value.rgba = [rgba[0].0[i], rgba[1].0[i], rgba[2].0[i], rgba[3].0[i]];
                value.depth = (begin[i] + f64::from(half.0[i]) * self.view.packets.unit) as f32;
            }
        }
        packet.hits & !kept
    }
}

impl<T> Trace<'_, T> {
    /// Sets rays up. Returns the world distances at which they enter, too.
    fn packet(&self, nearest: &[f64; LANES]) -> (Packet, [f64; LANES]) {
        let (view, layer) = self.seen;
        let (mut x, mut y, mut far) = ([0.0; LANES], [0.0; LANES], [f64::INFINITY; LANES]);
        let mut backdrop = Lanes::ZERO;
        for i in 0..LANES {
            let spot = &self.spots[i.min(self.spots.len() - 1)];
            (x[i], y[i]) = (spot.x, spot.y);
            if let Some(layer) = layer {
                far[i] = layer.depth(spot.pixel);
                backdrop.0[i] = super::backdrop(layer, spot.pixel);
            }
        }
        let placement = self.volume.placement();
        let chords = Chords::new(self.rays, [&x, &y], placement, self.volume.dims(), &view.clip, &far);
        let unit = self.view.packets.unit;
        let forward = self.view.forward.to_array();
        let mut packet = Packet {
            hits: 0,
            base: [[0.0; LANES]; 3],
            delta: [[0.0; LANES]; 3],
            rounded_delta: [Lanes::ZERO; 3],
            first: Lanes::ZERO,
            end: Lanes([f32::NEG_INFINITY; LANES]),
            backdrop,
            lights: PacketLights::default(),
        };
        if let Some(reflection) = &self.view.packets.reflection {
            packet.lights.look_along(&reflection.lights, &chords.along);
        }
        let mut begin = [0.0; LANES];
        for i in 0..self.spots.len() {
            let (start, end) = (chords.start[i], chords.end[i]);
            if !(start < end && nearest[i] < f64::INFINITY) {
                continue;
            }
            packet.hits |= 1 << i;
            begin[i] = chords.offset[i] + start;
            let cosine: f64 = (0..3).map(|a| forward[a] * chords.along[a][i]).sum();
            // One unit less, for rounding.
            let first = (nearest[i] / cosine - begin[i]) / unit - 1.0;
            let length = (end - start) / unit;
            packet.first.0[i] = first.clamp(0.0, length) as f32;
            packet.end.0[i] = length as f32;
            for a in 0..3 {
                packet.base[a][i] = chords.origin[a][i] + chords.direction[a][i] * start;
                packet.delta[a][i] = chords.direction[a][i] * unit;
                packet.rounded_delta[a].0[i] = packet.delta[a][i] as f32;
            }
        }
        (packet, begin)
    }
}
