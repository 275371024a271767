//! Sixteen rays that wait for their next slab, or their next brick.

use fearless_simd::Simd;
use vr_kernels::vector::{LANES, Lanes, Operator, PacketLights, Shade};

use super::chunk::{Chunk, Fetch};
use super::march::{March, PacketResult};
use super::picture::Picture;
use super::state::State;
use super::tiles::{Packet, PacketScene};
use crate::fragments::Fragments;

/// Sixteen rays, and what they have gathered so far.
pub(super) struct Waiting {
    pub(super) at: Packet,
    pub(super) rays: Fragments,
    pub(super) lights: PacketLights,
    max_behind: Lanes,
    state: State,
    /// Values at the last faces: where segments begin.
    pub(super) before: Lanes,
    pub(super) done: PacketResult,
}

impl Waiting {
    /// The rays of a sample of each pixel, before their first fragment; turned where they are drawn back to front.
    pub(super) fn new<S: Simd>(simd: S, scene: &PacketScene<'_>, at: Packet, sample: u32) -> Self {
        let mut rays = Fragments::EMPTY;
        at.set_up(simd, scene, sample, &mut rays);
        let mut lights = PacketLights::default();
        if let Some(shading) = scene.shading {
            lights.look_along(&shading.lights, &rays.chords.along);
        }
        let max_behind = rays.max_behind(scene.max_radiance);
        if scene.pass.operator == Operator::Over {
            rays.turn();
        }
        Self {
            at,
            rays,
            lights,
            max_behind,
            state: State::new(scene.pass.operator),
            before: Lanes([f32::NAN; LANES]),
            done: PacketResult::default(),
        }
    }

    /// Number of the samples at these numbers, if nothing can be visible of them.
    pub(super) fn invisible<S: Simd>(&self, simd: S, scene: &PacketScene<'_>, number: &Lanes) -> Option<u64> {
        scene.pass.invisible(simd, &self.rays, &self.state, number, 1)
    }

    /// Takes up the march where it was left.
    pub(super) fn march<S: Simd>(
        &mut self,
        scene: &PacketScene<'_>,
        texture: &mut dyn Fetch<S>,
        chunk: &mut Chunk,
        draw: impl FnOnce(&mut March<'_, S>),
    ) {
        let mut march = March {
            texture,
            pass: &scene.pass,
            lit: scene.shading.map(|shading| Shade { shading, lights: &self.lights }),
            max_behind: &self.max_behind,
            chunk,
            rays: &mut self.rays,
            state: &mut self.state,
            before: self.before,
            done: self.done,
        };
        draw(&mut march);
        (self.before, self.done) = (march.before, march.done);
    }

    /// Adds what they have gathered to a picture.
    pub(super) fn finish(&self, scene: &PacketScene<'_>, picture: &mut Picture) {
        picture.add(scene, &self.at, &self.rays, &self.state, self.done);
    }
}
