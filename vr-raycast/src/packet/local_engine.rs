//! The vector engine for local steps.

use std::sync::Arc;

use fearless_simd::{Level, Simd};
use vr_core::filter::Lattice;
use vr_core::image_order::Spot;
use vr_core::transfer::BakedTransfer;
use vr_core::{Counts, Filter, Rays, Scene, UniformVolume, View, with_grid};

use super::field::{Field, Pairs, Stage};
use super::lanes::{LANES, Lanes};
use super::level::{self, Vectorized};
use super::local_march::{LocalMedium, THIN, local_march};
use super::setup::{FrameSetup, Packet};
use super::table::Rows;
use crate::caster::{Order, RayCaster};
use crate::operator::Brightest;
use crate::pace::PaceMap;
use crate::table_range::{resolves, table_range};
use crate::tracer::{Traced, Tracer};

/// What it keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct LocalEngine {
    level: Level,
    /// For steps of [`THIN`] of a voxel.
    table: Arc<BakedTransfer<f32>>,
    map: Arc<PaceMap>,
    /// Voxels of the step that each byte of the map asks for.
    lengths: [f32; 256],
    /// World length of the smallest voxel edge.
    voxel: f64,
    /// A ray ends when no more than this could be added to any component.
    negligible: f32,
    brightest: Brightest,
}

impl LocalEngine {
    /// What it needs for a scene that the vector engine [`super::supports`]; `None` where no table tells apart what the transfer function
    /// does.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        volume: &UniformVolume,
        map: Arc<PaceMap>,
        brightest: Brightest,
        level: Level,
    ) -> Option<Self> {
        let Order::FrontToBack { termination } = caster.order else { return None };
        let voxel = volume.placement().spacing().min_element();
        let range = table_range(volume, Filter::Trilinear, &scene.transfer);
        let integer = volume.voxel_type().is_integer();
        let table = BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, THIN * voxel);
        if !resolves(&table, volume, Filter::Trilinear, &scene.transfer) {
            return None;
        }
        let mut lengths = [0.0; 256];
        for (length, &step) in lengths.iter_mut().zip(map.steps()) {
            *length = (f64::from(step) / voxel) as f32;
        }
        let negligible = (1.0 - termination) as f32;
        Some(Self { level, table: Arc::new(table), map, lengths, voxel, negligible, brightest })
    }
}

/// The engine with a view.
pub(crate) struct LocalFrame<'a> {
    pub(crate) engine: &'a LocalEngine,
    pub(crate) volume: &'a UniformVolume,
    pub(crate) rays: Rays,
    pub(crate) view: &'a View,
}

impl Tracer for LocalFrame<'_> {
    /// Steps have no lattice, and so no starts are needed: the map leaps over what is clear.
    fn trace(&self, spots: &[Spot], _: Option<&[u32]>, values: &mut Vec<Traced>, counts: &mut Counts) {
        with_grid!(self.volume.grid(), grid => {
            self.trace_typed(&Lattice { samples: grid.samples(), dims: grid.dims() }, spots, values, counts);
        });
    }
}

impl LocalFrame<'_> {
    fn trace_typed<T: Pairs>(
        &self,
        lattice: &Lattice<'_, T>,
        spots: &[Spot],
        values: &mut Vec<Traced>,
        counts: &mut Counts,
    ) {
        let engine = self.engine;
        let Some(field) = Field::new(lattice) else { return };
        let medium = LocalMedium {
            field,
            dims: lattice.dims,
            rows: Rows::of(&engine.table),
            map: &engine.map,
            lengths: &engine.lengths,
            negligible: engine.negligible,
        };
        level::run(engine.level, Trace { frame: self, medium: &medium, spots, values, counts });
    }

    #[inline(always)]
    fn trace_with<S: Simd, T: Pairs>(
        &self,
        simd: S,
        medium: &LocalMedium<'_, T>,
        spots: &[Spot],
        values: &mut Vec<Traced>,
        counts: &mut Counts,
    ) {
        let layer = self.view.layer.as_deref();
        let setup = FrameSetup {
            rays: &self.rays,
            placement: self.volume.placement(),
            dims: medium.dims,
            clip: &self.view.clip,
            layer,
            step: self.engine.voxel,
            offset: 0.0,
        };
        let mut packet = Packet::EMPTY;
        let mut stage = Stage::<T>::new();
        for spots in spots.chunks(LANES) {
            setup.packet(simd, spots, &mut packet);
            packet.hits &= (1u32 << spots.len()) - 1;
            let mut traced = [Traced::NOTHING; LANES];
            if packet.hits != 0 {
                packet.end.0[spots.len()..].fill(f32::NEG_INFINITY);
                let marched = local_march(simd, medium, &packet, &self.most(&packet), &mut stage);
                counts.rays += u64::from(packet.hits.count_ones());
                counts.samples += u64::from(marched.samples);
                counts.terminated += u64::from(marched.terminated.count_ones());
                for i in 0..spots.len() {
                    let voxels = packet.middle[i] + f64::from(marched.half[0].0[i]);
                    traced[i] = Traced {
                        rgba: [0, 1, 2, 3].map(|c: usize| marched.rgba[c].0[i]),
                        depth: (packet.begin[i] + voxels * self.engine.voxel) as f32,
                    };
                }
            }
            if let Some(layer) = layer {
                for (value, spot) in traced.iter_mut().zip(spots) {
                    *value = value.over(layer, spot.pixel);
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
    frame: &'a LocalFrame<'f>,
    medium: &'a LocalMedium<'a, T>,
    spots: &'a [Spot],
    values: &'a mut Vec<Traced>,
    counts: &'a mut Counts,
}

impl<T: Pairs> Vectorized for Trace<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.frame.trace_with(simd, self.medium, self.spots, self.values, self.counts);
    }
}
