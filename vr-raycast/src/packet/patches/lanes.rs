//! Steps that sixteen lanes work off.

use glam::DVec3;
use vr_kernels::vector::{LANES, Lanes};

use super::steps::Batch;

/// Steps that each lane has before it: a batch of its ray.
#[derive(Clone, Debug)]
pub(crate) struct LaneSteps {
    /// Place of the sample of step 0, axis by axis, in the units of the lane's patch.
    pub(crate) base: [Lanes; 3],
    /// Vector from one sample to the next.
    pub(crate) delta: [Lanes; 3],
    /// Begin of step 0, in units of length from the begin of the ray.
    pub(crate) begin: Lanes,
    /// Length of a step in these units.
    pub(crate) length: Lanes,
    /// Number of the next step.
    pub(crate) number: Lanes,
    /// Number of steps left.
    pub(crate) left: Lanes,
    /// World position of the sample of step 0, and world vector to the next, of each lane.
    pub(crate) world: [[DVec3; 2]; LANES],
}

/// Ray of a lane in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldRay {
    /// Position at distance 0.
    pub(crate) base: DVec3,
    /// Unit vector.
    pub(crate) direction: DVec3,
    /// Distance at which it begins.
    pub(crate) start: f64,
}

impl LaneSteps {
    /// Lanes with nothing to do.
    pub(crate) const NONE: Self = Self {
        base: [Lanes::ZERO; 3],
        delta: [Lanes::ZERO; 3],
        begin: Lanes::ZERO,
        length: Lanes::ZERO,
        number: Lanes::ZERO,
        left: Lanes::ZERO,
        world: [[DVec3::ZERO; 2]; LANES],
    };

    /// Gives a lane a batch of steps, whose samples are their middles: in a patch in which world positions p have the place (p − `origin`)·`rate` + `shift`.
    /// `unit` is the unit of lengths.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, ray: &WorldRay, batch: &Batch, unit: f64, place: &PatchPlace) {
        let at = ray.base + ray.direction * (batch.begin + 0.5 * batch.length);
        let by = ray.direction * batch.length;
        let (first, step) = ((at - place.origin) * place.rate + place.shift, by * place.rate);
        for a in 0..3 {
            self.base[a].0[lane] = first[a] as f32;
            self.delta[a].0[lane] = step[a] as f32;
        }
        self.begin.0[lane] = ((batch.begin - ray.start) / unit) as f32;
        self.length.0[lane] = (batch.length / unit) as f32;
        self.number.0[lane] = batch.first as f32;
        self.left.0[lane] = batch.count as f32;
        self.world[lane] = [at, by];
    }

    /// World position of a lane's sample.
    #[inline]
    pub(crate) fn world_at(&self, lane: usize, number: f32) -> DVec3 {
        let [at, by] = self.world[lane];
        at + by * f64::from(number)
    }
}

/// Units in which places in a patch are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PatchPlace {
    pub(crate) origin: DVec3,
    pub(crate) rate: DVec3,
    pub(crate) shift: f64,
}
