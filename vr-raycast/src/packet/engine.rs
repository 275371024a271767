//! The vector engine behind the seam that both engines stand behind.

use std::sync::Arc;

use fearless_simd::{Level, Simd};
use vr_core::image_order::Spot;
use vr_core::transfer::BakedTransfer;
use vr_core::{Compositing, Counts, Filter, Rays, Scene, UniformVolume, View, with_grid};

use super::field::{Field, Pairs, Stage};
use super::lanes::{LANES, Lanes};
use super::leap::Distances;
use super::level::{self, Vectorized};
use super::march::{Medium, march, step_number};
use super::setup::{FrameSetup, Packet};
use super::table::Rows;
use crate::caster::{Classification, Order, Precision, RayCaster, Rule};
use crate::operator::Brightest;
use crate::ray_value::RayValue;
use crate::table_range::{resolves, table_range};

/// Draws rays.
pub(crate) trait Tracer: Sync {
    /// Traces the rays through `spots` (any, but neighbours in blocks of 4×4 run fastest); `starts[i]`, where given, is the first
    /// lattice step of ray i that can be visible. One value per spot.
    fn trace(&self, spots: &[Spot], starts: Option<&[u32]>, values: &mut Vec<Traced>, counts: &mut Counts);
}

/// What a ray became.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Traced {
    pub(crate) rgba: [f32; 4],
    /// World distance; +∞: nothing.
    pub(crate) depth: f32,
    /// Lattice step of the first sample with α > 0; `u32::MAX`: none.
    pub(crate) first: u32,
}

impl Traced {
    const NOTHING: Self = Self { rgba: [0.0; 4], depth: f32::INFINITY, first: u32::MAX };
}

/// What the vector engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PacketEngine {
    pub(crate) level: Level,
    /// For whole steps.
    pub(crate) table: Arc<BakedTransfer<f32>>,
    pub(crate) distances: Option<Arc<Distances>>,
    /// Length of a step in world units.
    pub(crate) step: f64,
    /// From a step's begin to its sample, as a fraction of the step.
    pub(crate) offset: f64,
    /// A ray ends when no more than this could be added to any component.
    pub(crate) negligible: f64,
    pub(crate) brightest: Brightest,
}

/// Steps of a ray that f32 still counts one by one, with room to spare.
const MOST_STEPS: f64 = (1 << 22) as f64;

/// Cells along the edge of a block that is leaped over.
pub(crate) const EDGE: usize = 8;

impl PacketEngine {
    /// What the vector engine needs to draw a scene with a caster's settings; `None` where it cannot, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, volume: &UniformVolume, level: Level) -> Option<Self> {
        let Order::FrontToBack { termination } = caster.order else { return None };
        let plain = scene.compositing == Compositing::Over
            && scene.shading.is_none()
            && caster.filter.unwrap_or(scene.filter) == Filter::Trilinear
            && caster.classification == Classification::Table
            && caster.precision == Precision::F32;
        let step = caster.step * volume.placement().spacing().min_element();
        let (low, high) = (volume.corners()[0], volume.corners()[7]);
        let few = (high - low).length() / step < MOST_STEPS;
        if !plain || !few || volume.vacuum_cells().is_some() || volume.census().range.is_none() {
            return None;
        }
        let range = table_range(volume, Filter::Trilinear, &scene.transfer);
        let integer = volume.voxel_type().is_integer();
        let table = BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, step);
        if !resolves(&table, volume, Filter::Trilinear, &scene.transfer) {
            return None;
        }
        let brightest = scene.transfer.brightest();
        Some(Self {
            level,
            distances: Self::distances(volume, &table, EDGE),
            table: Arc::new(table),
            step,
            offset: match caster.rule {
                Rule::Midpoint => 0.5,
                Rule::Left => 0.0,
            },
            negligible: 1.0 - termination,
            brightest: if scene.transfer.has_emission() {
                Brightest::Emission(brightest)
            } else {
                Brightest::Radiance(brightest)
            },
        })
    }

    /// Distances to what is visible under a table; `None` where all is.
    pub(crate) fn distances(volume: &UniformVolume, table: &BakedTransfer<f32>, edge: usize) -> Option<Arc<Distances>> {
        Distances::new(&volume.range_blocks(Filter::Trilinear, edge), table).map(Arc::new)
    }
}

/// The vector engine with a view.
pub(crate) struct PacketFrame<'a> {
    pub(crate) engine: &'a PacketEngine,
    pub(crate) volume: &'a UniformVolume,
    pub(crate) rays: &'a Rays,
    pub(crate) view: &'a View,
}

impl Tracer for PacketFrame<'_> {
    fn trace(&self, spots: &[Spot], starts: Option<&[u32]>, values: &mut Vec<Traced>, counts: &mut Counts) {
        with_grid!(self.volume.grid(), grid => {
            let lattice = vr_core::filter::Lattice { samples: grid.samples(), dims: grid.dims() };
            self.trace_typed(&lattice, spots, starts, values, counts);
        });
    }
}

impl PacketFrame<'_> {
    fn trace_typed<T: Pairs>(
        &self,
        lattice: &vr_core::filter::Lattice<'_, T>,
        spots: &[Spot],
        starts: Option<&[u32]>,
        values: &mut Vec<Traced>,
        counts: &mut Counts,
    ) {
        let Some(field) = Field::new(lattice) else { return };
        let medium = Medium {
            field,
            dims: lattice.dims,
            rows: Rows::of(&self.engine.table),
            distances: self.engine.distances.as_deref(),
            negligible: self.engine.negligible as f32,
        };
        level::run(self.engine.level, Trace { frame: self, medium: &medium, spots, starts, values, counts });
    }

    #[inline(always)]
    fn trace_with<S: Simd, T: Pairs>(
        &self,
        simd: S,
        medium: &Medium<'_, T>,
        spots: &[Spot],
        starts: Option<&[u32]>,
        values: &mut Vec<Traced>,
        counts: &mut Counts,
    ) {
        let layer = self.view.layer.as_deref();
        let setup = FrameSetup {
            rays: self.rays,
            placement: self.volume.placement(),
            dims: medium.dims,
            clip: &self.view.clip,
            layer,
            step: self.engine.step,
            offset: self.engine.offset,
        };
        let mut packet = Packet::EMPTY;
        let mut stage = Stage::<T>::new();
        for (group, spots) in spots.chunks(LANES).enumerate() {
            setup.packet(simd, spots, &mut packet);
            packet.hits &= (1u32 << spots.len()) - 1;
            let mut traced = [Traced::NOTHING; LANES];
            if packet.hits != 0 {
                for i in spots.len()..LANES {
                    packet.end.0[i] = f32::NEG_INFINITY;
                }
                if let Some(starts) = starts {
                    for (i, &start) in starts[group * LANES..][..spots.len()].iter().enumerate() {
                        packet.first.0[i] += (start as f32).min(packet.end.0[i] - packet.first.0[i]).max(0.0);
                    }
                }
                let most = self.most(&packet);
                let marched = march(simd, medium, &packet, &most, &mut stage);
                counts.rays += u64::from(packet.hits.count_ones());
                counts.samples += u64::from(marched.samples);
                counts.terminated += u64::from(marched.terminated.count_ones());
                for i in 0..spots.len() {
                    let [step, mut share] = [marched.half[0].0[i], marched.half[1].0[i]];
                    let steps = packet.middle[i] + f64::from(step);
                    if step == packet.end.0[i] {
                        share *= packet.ratio.0[i];
                    }
                    let first = marched.first.0[i];
                    traced[i] = Traced {
                        rgba: [0, 1, 2, 3].map(|c: usize| marched.rgba[c].0[i]),
                        depth: (packet.begin[i] + (steps + f64::from(share)) * self.engine.step) as f32,
                        first: if first < f32::INFINITY { step_number(packet.middle[i], first) } else { u32::MAX },
                    };
                }
            }
            if let Some(layer) = layer {
                for (value, spot) in traced.iter_mut().zip(spots) {
                    let before = RayValue { rgba: value.rgba.map(f64::from), depth: f64::from(value.depth) };
                    let all = before.over(layer, spot.pixel);
                    (value.rgba, value.depth) = (all.rgba.map(|x| x as f32), all.depth as f32);
                }
            }
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }

    /// Per ray the largest light, or opacity, that can come from behind, by what is left clear.
    fn most(&self, packet: &Packet) -> Lanes {
        match self.engine.brightest {
            Brightest::Radiance(c) => Lanes([c.max(1.0) as f32; LANES]),
            Brightest::Emission(q) => Lanes(packet.length.map(|length| (q * length).max(1.0) as f32)),
        }
    }
}

/// A call of [`Tracer::trace`], once the voxel type is known.
struct Trace<'a, 'f, T> {
    frame: &'a PacketFrame<'f>,
    medium: &'a Medium<'a, T>,
    spots: &'a [Spot],
    starts: Option<&'a [u32]>,
    values: &'a mut Vec<Traced>,
    counts: &'a mut Counts,
}

impl<T: Pairs> Vectorized for Trace<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.frame.trace_with(simd, self.medium, self.spots, self.starts, self.values, self.counts);
    }
}

#[cfg(test)]
mod tests;
