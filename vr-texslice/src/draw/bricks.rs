//! A picture brick by brick: each takes the fragments of every ray that lie in it, and hands rays on to the next.

use std::sync::{Mutex, PoisonError};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_core::filter::Lattice;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, Counts, RenderError};
use vr_kernels::vector::{
    Field, LANES, Lanes, Operator, Pairs, Stage, Sums, Vectorized, cells, inside, pick, run, splat, step_light,
};

use super::blend::{choose, over};
use super::classify::Classifier;
use super::march::PacketResult;
use super::picture::Picture;
use super::state::State;
use super::tiles::{Packet, PacketScene, Pixel, sixteens};
use crate::bricks::{BrickLattice, Cells, Pool};
use crate::fragments::Fragments;
use crate::projection::ScreenProjection;

/// A picture drawn brick by brick.
pub(crate) struct Bricked<'a, T> {
    pub(crate) scene: &'a PacketScene<'a>,
    pub(crate) volume: Lattice<'a, T>,
    pub(crate) lattice: BrickLattice,
    /// Front to back.
    pub(crate) order: &'a [[usize; 3]],
    /// True if something can be visible in a brick.
    pub(crate) shows: &'a (dyn Fn([usize; 3]) -> bool + Sync),
}

/// Sixteen rays, between bricks.
struct Waiting {
    at: Packet,
    rays: Fragments,
    state: State,
    /// The next sample of each ray: the first is numbered one less than the whole ones, the last one more. +∞: no more.
    next: Lanes,
    done: PacketResult,
}

impl<T: Pairs> Bricked<'_, T> {
    pub(crate) fn draw(&self, pool: &mut Pool<T>, control: &Control) -> Result<(Vec<Pixel>, Counts), RenderError> {
        let scene = self.scene;
        let view = scene.view;
        let mut picture = Picture::new(view.size);
        let n = view.supersampling;
        for k in 0..n * n {
            let places = sixteens(view.size);
            let rays = set_up(scene, &places, k, control)?;
            let screen = ScreenProjection::new(view)?;
            for &brick in self.order {
                let cells = self.lattice.cells_of(brick);
                // The footprint of a brick, as a box of pixels.
                let corners = self.lattice.corners(brick, scene.setup.placement);
                let [low, high] = screen.bounds(&corners);
                let touched: Vec<&Mutex<Waiting>> = rays
                    .iter()
                    .zip(&places)
                    .filter(|(_, at)| at.overlaps(low, high))
                    .map(|(waiting, _)| waiting)
                    .collect();
                let texture = if (self.shows)(brick) { Some(pool.texture(brick, &cells, &self.volume)?) } else { None };
                // Sixteen by sixteen would be too little work a task.
                let groups: Vec<_> = touched.chunks(GROUP).collect();
                in_parallel(control, groups.len() as u32, |g| {
                    for waiting in groups[g as usize] {
                        let mut waiting = locked(waiting);
                        let through = BrickRays {
                            scene,
                            dims: self.volume.dims,
                            cells: &cells,
                            texture: texture.as_ref(),
                            waiting: &mut waiting,
                        };
                        run(scene.level, through);
                    }
                })?;
            }
            for waiting in rays {
                let Waiting { at, rays, state, done, .. } =
                    waiting.into_inner().unwrap_or_else(PoisonError::into_inner);
                picture.add(scene, &at, &rays, &state, done);
            }
        }
        Ok(picture.mean(n * n))
    }
}

/// The rays of sample `k` of every pixel, before the first brick.
fn set_up(
    scene: &PacketScene<'_>,
    places: &[Packet],
    k: u32,
    control: &Control,
) -> Result<Vec<Mutex<Waiting>>, RenderError> {
    in_parallel(control, places.len() as u32, |i| {
        let at = places[i as usize];
        let mut rays = Fragments::EMPTY;
        run(scene.level, SetUp { scene, at, sample: k, rays: &mut rays });
        let state = State::new(scene.pass.operator);
        if scene.pass.operator == Operator::Over {
            rays.turn();
        }
        let first = |i: usize| if rays.hits >> i & 1 == 1 { rays.begin.0[i] - 1.0 } else { f32::INFINITY };
        let next = Lanes(std::array::from_fn(first));
        Mutex::new(Waiting { at, rays, state, next, done: PacketResult::default() })
    })
}

/// Sixteens of rays of a task.
const GROUP: usize = 64;

struct SetUp<'a> {
    scene: &'a PacketScene<'a>,
    at: Packet,
    sample: u32,
    rays: &'a mut Fragments,
}

impl Vectorized for SetUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.at.set_up(simd, self.scene, self.sample, self.rays);
    }
}

/// Sixteen rays through one brick.
struct BrickRays<'a, T> {
    scene: &'a PacketScene<'a>,
    dims: [usize; 3],
    cells: &'a Cells,
    /// `None`: nothing is visible in it.
    texture: Option<&'a Lattice<'a, T>>,
    waiting: &'a mut Waiting,
}

impl<T: Pairs> Vectorized for BrickRays<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Waiting { rays, state, next, done, .. } = self.waiting;
        let field = self.texture.map(Field::new);
        let mut stage = Stage::<T>::default();
        let mut sums = Sums::load(simd, &state.sums);
        let mut number = next.load(simd);
        let (zero, one, never) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, f32::INFINITY));
        let max = self.dims.map(|n| (n - 1) as f32);
        let operator = self.scene.pass.operator;
        let level = if let Operator::Under { level } = operator { level } else { 1.0 };
        let behind = rays.max_behind(self.scene.max_radiance);
        loop {
            // The next sample of each ray: its first, a whole one, or its last.
            let (begin, end) = (rays.begin.load(simd), rays.end.load(simd));
            // Back to front, the one sample of a ray with a single slab counts as its last.
            let first = number.simd_lt(begin) & rays.has[0].load(simd).simd_gt(zero);
            let whole = !first & number.simd_lt(end);
            // The last sample is one more than the whole ones: a ray has it, or it has a first one only.
            let last = number.simd_eq(end) & rays.has[1].load(simd).simd_gt(zero) & !first;
            let live = (first & number.simd_lt(never)) | whole | last;
            let mut at = [zero; 3];
            for a in 0..3 {
                let along = rays.base[a].load(simd) + number * rays.delta[a].load(simd);
                let outer = pick(first, rays.outer[0][a].load(simd), rays.outer[1][a].load(simd));
                let p = pick(first | last, outer, along);
                // What has no sample may be anywhere, and NaN times 0 is.
                at[a] = inside(simd, pick(live, p, zero), max[a]);
            }
            // Only samples that lie in this brick count.
            let mut places = cells(simd, at, self.dims.map(|n| n as i32 - 2));
            let mut here = live;
            for a in 0..3 {
                let [low, high] = self.cells[a].map(|c| c as i32);
                let cell = places.cell[a];
                here &= within(simd, cell, low, high);
                // Those of other bricks are not fetched, but somewhere they must lie.
                places.cell[a] = (cell - low).max(i32x16::splat(simd, 0)).min(i32x16::splat(simd, high - low - 1));
            }
            if here.all_false() {
                break;
            }
            let count = u64::from(here.to_bitmask().count_ones());
            // Fetches, classifies and composites them.
            if let Some(field) = &field {
                done.drawn += count;
                field.fetch(simd, &places, &mut stage);
                let value = field.value(simd, &places, &stage);
                let ratio = pick(
                    first,
                    rays.outer_ratio[0].load(simd),
                    pick(last, rays.outer_ratio[1].load(simd), rays.ratio.load(simd)),
                );
                let defined = value.simd_eq(value);
                // Samples on faces up to the first whole one lie in the first slab.
                let at_begin = whole & number.simd_le(begin);
                let span = |which: usize| {
                    pick(first | at_begin, rays.outer_span[0][which].load(simd), rays.outer_span[1][which].load(simd))
                };
                let outer = first | last;
                let (from, length) = (pick(outer, span(0), number - 0.5), pick(outer, span(1), one));
                if operator.picks() {
                    // On faces: at the end of what lies between a sample and the one before it; nothing lies before the first.
                    let from = pick(outer | at_begin, span(0), number - one);
                    let to = pick(first, from, pick(last | at_begin, span(0) + span(1), number));
                    let passed = choose(simd, operator, here, [from, to], [value, ratio], state);
                    number = pick(passed, never, number);
                } else {
                    let light = classified(simd, &self.scene.pass.classifier, value, ratio, outer);
                    let light = [
                        pick(defined, light[0], zero),
                        pick(defined, light[1], zero),
                        pick(defined, light[2], zero),
                        pick(defined, light[3], zero),
                    ];
                    match operator {
                        Operator::Over => {
                            let [r, g, b, a] = &state.sums[0];
                            let sum = [r.load(simd), g.load(simd), b.load(simd), a.load(simd)];
                            let [r, g, b, a] = over(simd, here & defined, [from, length], light, sum, &mut state.over);
                            state.sums[0] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                        }
                        _ => {
                            let reached = sums.add_up_to(simd, level, here & defined, [from, length], light);
                            number = pick(reached, never, number);
                        }
                    }
                }
            } else {
                done.skipped += count;
            }
            // On to the next samples; pixels that are done stop.
            number = pick(here, number + one, number);
            if self.scene.pass.negligible >= 0.0 && matches!(operator, Operator::Under { .. }) {
                let hidden = (sums.clear(simd) * behind.load(simd)).simd_le(splat(simd, self.scene.pass.negligible));
                number = pick(hidden, never, number);
            }
        }
        *next = Lanes::new(number);
        if matches!(operator, Operator::Under { .. }) {
            sums.store(&mut state.sums);
        }
    }
}

/// True for lanes with low ≤ cell < high.
#[inline(always)]
fn within<S: Simd>(simd: S, cell: i32x16<S>, low: i32, high: i32) -> mask32x16<S> {
    cell.simd_ge(i32x16::splat(simd, low)) & cell.simd_lt(i32x16::splat(simd, high))
}

/// Light and opacity of values: those of outer slabs, and of all where slabs differ from ray to ray, by their own lengths.
#[inline(always)]
fn classified<S: Simd>(
    simd: S,
    with: &Classifier<'_>,
    value: f32x16<S>,
    ratio: f32x16<S>,
    outer: mask32x16<S>,
) -> [f32x16<S>; 4] {
    let zero = splat(simd, 0.0);
    match *with {
        Classifier::Table { rows, optics, even } => {
            if even && outer.all_false() {
                return rows.at(simd, value);
            }
            let own = step_light(simd, optics.rows().at(simd, value), ratio, optics.emits);
            if !even || outer.all_true() {
                return own;
            }
            let whole = rows.at(simd, value);
            [
                pick(outer, own[0], whole[0]),
                pick(outer, own[1], whole[1]),
                pick(outer, own[2], whole[2]),
                pick(outer, own[3], whole[3]),
            ]
        }
        Classifier::Exact(light) => {
            let (value, ratio) = (Lanes::new(value), Lanes::new(ratio));
            let mut found = [Lanes::ZERO; 4];
            for i in 0..LANES {
                let one = light(value.0[i], ratio.0[i]);
                (0..4).for_each(|c| found[c].0[i] = one[c]);
            }
            [found[0].load(simd), found[1].load(simd), found[2].load(simd), found[3].load(simd)]
        }
        _ => [zero; 4],
    }
}
