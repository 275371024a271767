//! March of packets along their rays.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::VacuumCells;
use vr_kernels::vector::{
    Cells, Lanes, OpticsTable, PacketLights, PacketShading, Rows, Shade, StepOptics, Sums, cells, inside, pick, splat,
    step_light,
};

use super::fields::PacketField;
use super::gaps::{outside_holes, there};
use super::leap::Leaper;
use super::listed::{ListedSteps, listed};
use super::local::{LocalSteps, local};
use super::segments::{SegmentSteps, segments};
use super::setup::Packet;
use crate::leap::ClearSpace;

/// Volume that all packets of a frame march through.
#[derive(Clone, Copy)]
pub(crate) struct Medium<'a, T> {
    pub(crate) field: T,
    /// Cells without a field; `None` if there are none.
    pub(crate) vacuum: Option<&'a VacuumCells>,
    pub(crate) dims: [usize; 3],
    pub(crate) steps: MarchSteps<'a>,
    /// Table for steps of any length.
    pub(crate) optics: &'a OpticsTable,
    /// Shading; `None` if unshaded.
    pub(crate) shading: Option<&'a PacketShading>,
    /// True if normals are followed over a step: a sample lies in its middle.
    pub(crate) follows_normals: bool,
    /// Amount at which a ray ends: no more than this could be added to any component.
    pub(crate) negligible: f32,
    /// Opacity at which rays are cut; 1 where they are not.
    pub(crate) level: f32,
}

/// Steps of the rays.
#[derive(Clone, Copy)]
pub(crate) enum MarchSteps<'a> {
    /// Steps of one length.
    Lattice(LatticeSteps<'a>),
    /// Steps of the length that each place asks for.
    Local(LocalSteps<'a>),
    /// Steps of one length along which the value changes.
    Segments(SegmentSteps<'a>),
    /// Steps listed for each ray, of fields that jump.
    Listed(ListedSteps<'a>),
}

/// Steps of one length.
#[derive(Clone, Copy)]
pub(crate) struct LatticeSteps<'a> {
    /// Table for whole steps.
    pub(crate) rows: Rows<'a>,
    /// Space that is leaped over, if there is any.
    pub(crate) clear: Option<&'a ClearSpace>,
}

/// Results of a packet's rays.
pub(crate) struct PacketResult {
    pub(crate) rgba: [Lanes; 4],
    /// Position where opacity reaches a half, in steps from the middle one's begin; +∞ if it does not.
    pub(crate) half: Lanes,
    pub(crate) samples: u32,
    /// Mask of the rays that ended before their last step.
    pub(crate) terminated: u32,
}

/// Takes the packet's rays to their ends. `max_light` is the largest light or opacity that can come from behind, per transmittance left.
///
/// # Panics
/// Panics at steps in which fields of the type are not marched: a bug in the caller.
///
/// Its own function, called once a packet: stages that the optimizer can see made are stages that it tries to keep in registers, in vain
/// and for twice the time.
#[inline(never)]
pub(crate) fn march<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    packet: &Packet,
    max_light: &Lanes,
    lights: &PacketLights,
    stages: &mut [T::Stage; 2],
) -> PacketResult {
    match medium.steps {
        MarchSteps::Lattice(steps) if T::STEPS.has_lattice => simd.vectorize(
            #[inline(always)]
            || lattice(simd, medium, steps, packet, max_light, lights, stages),
        ),
        MarchSteps::Local(steps) if T::STEPS.has_grid_steps => simd.vectorize(
            #[inline(always)]
            || local(simd, medium, steps, packet, max_light, lights, stages),
        ),
        MarchSteps::Segments(steps) if T::STEPS.has_grid_steps => simd.vectorize(
            #[inline(always)]
            || segments(simd, medium, steps, packet, max_light, lights, stages),
        ),
        MarchSteps::Listed(steps) if T::STEPS.has_lists => simd.vectorize(
            #[inline(always)]
            || listed(simd, medium, steps, packet, max_light, lights, stages),
        ),
        _ => unreachable!("fields are marched in the steps of their type"),
    }
}

/// Number of pairs of steps between two looks for clear space: a look costs a third of a sample.
const STRIDE: u32 = 2;

/// Steps of one length.
#[inline(always)]
fn lattice<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    LatticeSteps { rows, clear }: LatticeSteps<'_>,
    packet: &Packet,
    max_light: &Lanes,
    lights: &PacketLights,
    stages: &mut [T::Stage; 2],
) -> PacketResult {
    let ray = Path::new(simd, medium.dims, packet);
    let never = splat(simd, f32::NEG_INFINITY);
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd);
    let leaper = Leaper::over(simd, clear, packet, medium.dims);
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    let mut until_look = 0;
    // The last steps of all rays are taken at once, at the end: shorter ones, whose light must be converted.
    let mut ending = false;
    loop {
        // A ray that has gone past its last whole step waits for the others.
        let mut live = if ending { end.simd_gt(never) } else { at.simd_lt(end) };
        // Move rays in clear space on, until at least half of those that go on are in visible cells. Last steps in clear space are left out.
        if let Some((clear, leaper)) = &leaper {
            if until_look == 0 {
                until_look = STRIDE;
                loop {
                    let (position, cells) = ray.cells(simd, at);
                    let code = clear.at(simd, &cells);
                    let invisible = live & (code.simd_gt(0) | code.simd_eq(ClearSpace::CLEAR_CELL));
                    if invisible.all_false() {
                        until_look += leaper.visible_steps(simd, live, code) / 2;
                        break;
                    }
                    let visible = live & !invisible;
                    if ending {
                        live = visible;
                        break;
                    }
                    at = pick(invisible, at + leaper.steps(simd, position, &cells, code), at);
                    live = at.simd_lt(end);
                    // Rays whose cells have been seen to be visible outnumber those that have come to unknown ones.
                    let (known, all) = (visible.to_bitmask().count_ones(), live.to_bitmask().count_ones());
                    if known * 2 >= all {
                        break;
                    }
                }
            }
            until_look -= 1;
        }
        // When no ray has a whole step left, begin the last steps; when they are done, too, stop.
        let bits = live.to_bitmask();
        if bits == 0 {
            if ending {
                break;
            }
            ending = true;
            at = packet.last.load(simd);
            until_look = 0;
            continue;
        }
        samples += bits.count_ones();
        let [now, next] = stages;
        let (_, cells) = ray.cells(simd, at);
        medium.field.fetch(simd, &cells, now);
        // The last steps: each as a fraction of a whole one.
        if ending {
            let value = medium.field.value(simd, &cells, now);
            let ratio = packet.ratio.load(simd);
            let live = there(simd, medium.vacuum, &cells, live);
            let light = step_light(simd, medium.optics.rows().at(simd, value), ratio, medium.optics.emits);
            let light = shaded(simd, medium, lights, live, &ray, (&cells, ratio), light, now);
            let light = medium.field.outside_vacuum(simd, light, now);
            sums.add_up_to(simd, medium.level, live, [end, ratio], light);
            break;
        }
        // Two steps at once: while the first waits for its samples, those of the second are fetched.
        let one = splat(simd, 1.0);
        let then = at + one;
        let (_, cells_then) = ray.cells(simd, then);
        medium.field.fetch(simd, &cells_then, next);
        let value = medium.field.value(simd, &cells, now);
        let value_then = medium.field.value(simd, &cells_then, next);
        let light = shaded(simd, medium, lights, live, &ray, (&cells, one), rows.at(simd, value), now);
        let light_then = rows.at(simd, value_then);
        let light_then = shaded(simd, medium, lights, live, &ray, (&cells_then, one), light_then, next);
        let light = medium.field.outside_vacuum(simd, light, now);
        let light_then = medium.field.outside_vacuum(simd, light_then, next);
        // One branch for both: two take 0.7 % more instructions.
        let (mut light, mut light_then) = (light, light_then);
        if medium.vacuum.is_some() {
            light = outside_holes(simd, medium.vacuum, &cells, live, light);
            light_then = outside_holes(simd, medium.vacuum, &cells_then, live, light_then);
        }
        end = pick(sums.add_up_to(simd, medium.level, live, [at, one], light), never, end);
        end = pick((sums.clear(simd) * max_light).simd_le(negligible), never, end);
        live = then.simd_lt(end);
        samples += live.to_bitmask().count_ones();
        end = pick(sums.add_up_to(simd, medium.level, live, [then, one], light_then), never, end);
        end = pick((sums.clear(simd) * max_light).simd_le(negligible), never, end);
        at = then + one;
    }
    finish(simd, &sums, packet, end.simd_le(never), samples)
}

/// Returns the results of the rays; those in `ended` ended early.
#[inline(always)]
pub(crate) fn finish<S: Simd>(
    simd: S,
    sums: &Sums<S>,
    packet: &Packet,
    ended: mask32x16<S>,
    samples: u32,
) -> PacketResult {
    let [r, g, b, a] = sums.rgba();
    PacketResult {
        rgba: [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)],
        half: sums.half(simd),
        samples,
        terminated: packet.hits & ended.to_bitmask() as u32,
    }
}

/// Returns the light after shading, where something is shaded or has a colour of its own, of staged samples at places and of steps of a length; `stage` is used up.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
pub(crate) fn shaded<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    lights: &PacketLights,
    live: mask32x16<S>,
    ray: &Path<S>,
    (at, length): (&Cells<S>, f32x16<S>),
    light: [f32x16<S>; 4],
    stage: &mut T::Stage,
) -> [f32x16<S>; 4] {
    let has_colors = medium.field.has_colors();
    if medium.shading.is_none() && !has_colors {
        return light;
    }
    let [r, g, b, alpha] = light;
    let zero = splat(simd, 0.0);
    let mut shows = alpha.simd_gt(zero);
    let mut has_rows = false;
    let mut follows_gradients = false;
    if let Some(shading) = medium.shading {
        has_rows = shading.rows.is_some();
        follows_gradients = shading.follows_gradients();
    }
    if has_colors || has_rows {
        // What shines without absorbing has a colour, too, and a row.
        shows |= r.max(g).max(b).simd_gt(zero);
    }
    if (live & shows).all_false() {
        return light;
    }
    let place = in_lanes(at);
    let step = ray.extent(medium, length);
    let mut lanes = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(alpha)];
    let mut shade = None;
    if let Some(shading) = medium.shading {
        shade = Some(Shade { shading, lights });
    }
    if follows_gradients {
        // Found anew: a value that was kept for this would take a register from every scene.
        let value = medium.field.value(simd, at, stage);
        let [r, g, b, kappa] = medium.optics.rows().at(simd, value);
        let row = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(kappa)];
        let (value, length) = (Lanes::new(value), Lanes::new(length));
        let optics = StepOptics { value, row, length, emits: medium.optics.emits };
        medium.field.look(simd, shade, &place, &step, Some(&optics), &mut lanes, stage);
    } else {
        medium.field.look(simd, shade, &place, &step, None, &mut lanes, stage);
    }
    [lanes[0].load(simd), lanes[1].load(simd), lanes[2].load(simd), lanes[3].load(simd)]
}

/// Returns cells, as numbers, and fractions in them.
#[inline(always)]
pub(crate) fn in_lanes<S: Simd>(at: &Cells<S>) -> [[Lanes; 3]; 2] {
    let [x, y, z] = at.cell;
    let cell = [Lanes::new(x.to_float()), Lanes::new(y.to_float()), Lanes::new(z.to_float())];
    let [x, y, z] = at.fraction;
    [cell, [Lanes::new(x), Lanes::new(y), Lanes::new(z)]]
}

/// Positions along the rays of a packet.
pub(crate) struct Path<S: Simd> {
    base: [f32x16<S>; 3],
    delta: [f32x16<S>; 3],
    max_index: [f32; 3],
    last_cell: [i32; 3],
}

impl<S: Simd> Path<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, dims: [usize; 3], packet: &Packet) -> Self {
        Self {
            base: [packet.base[0].load(simd), packet.base[1].load(simd), packet.base[2].load(simd)],
            delta: [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)],
            max_index: dims.map(|n| (n - 1) as f32),
            last_cell: dims.map(|n| n as i32 - 2),
        }
    }

    /// Returns the extents, in index space, over which normals are followed in steps of a length; zero where they are not.
    #[inline(always)]
    pub(crate) fn extent<T>(&self, medium: &Medium<'_, T>, length: f32x16<S>) -> [Lanes; 3] {
        if !medium.follows_normals {
            return [Lanes::ZERO; 3];
        }
        [Lanes::new(self.delta[0] * length), Lanes::new(self.delta[1] * length), Lanes::new(self.delta[2] * length)]
    }

    /// Returns the positions that are so many steps from the middle ones, and their cells.
    #[inline(always)]
    pub(crate) fn cells(&self, simd: S, at: f32x16<S>) -> ([f32x16<S>; 3], Cells<S>) {
        let position = [
            inside(simd, self.base[0] + at * self.delta[0], self.max_index[0]),
            inside(simd, self.base[1] + at * self.delta[1], self.max_index[1]),
            inside(simd, self.base[2] + at * self.delta[2], self.max_index[2]),
        ];
        (position, cells(simd, position, self.last_cell))
    }
}
