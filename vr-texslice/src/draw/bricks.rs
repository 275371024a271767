//! A picture brick by brick: each takes the fragments of every ray that lie in it, through the stages of all of them, and hands rays on to the next.

use std::sync::{Mutex, PoisonError};

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, Counts, RenderError};
use vr_kernels::vector::{LANES, Lanes, Vectorized, pick, run, splat};

use super::brick_fetcher::{BrickFetcher, Middles};
use super::chunk::{Chunk, Fetcher};
use super::classify::Classifier;
use super::picture::Picture;
use super::tiles::{Packet, PacketScene, Pixel, sixteens};
use super::waiting::Waiting;
use crate::bricks::{BrickLattice, BrickSource, Pool};
use crate::fragments::Fragments;
use crate::projection::ScreenProjection;
use crate::texture::{BrickPart, InBrick, Texture, TextureVisitor};

/// A picture drawn brick by brick.
pub(crate) struct Bricked<'a> {
    pub(crate) scene: &'a PacketScene<'a>,
    pub(crate) source: BrickSource<'a>,
    pub(crate) lattice: BrickLattice,
    /// In the order in which fragments are blended.
    pub(crate) order: &'a [[usize; 3]],
    /// True if something can be visible in the bricks that lie between two of them, ends included.
    pub(crate) shows: &'a (dyn Fn([[usize; 2]; 3]) -> bool + Sync),
}

/// Number of sixteens of rays in a task.
const GROUP: usize = 64;

impl Bricked<'_> {
    /// Draws all samples of all pixels.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] if the pool does not hold the largest brick.
    pub(crate) fn draw(&self, pool: &mut Pool, control: &Control) -> Result<(Vec<Pixel>, Counts), RenderError> {
        let scene = self.scene;
        let view = scene.view;
        let screen = ScreenProjection::new(view)?;
        pool.check(self.source.bytes(&self.lattice.largest(|cells| self.source.region(cells))))?;
        let mut picture = Picture::new(view.size);
        let n = view.supersampling;
        for sample in 0..n * n {
            let places = sixteens(view.size);
            let rays = in_parallel(control, places.len() as u32, |i| {
                Mutex::new(run(scene.level, SetUp { scene, at: places[i as usize], sample }))
            })?;
            let reach = self.reach(&rays);
            for &brick in self.order {
                let cells = self.lattice.cells_of(brick);
                // The sixteens of pixels in its footprint.
                let [low, high] = screen.bounds(&self.lattice.corners(brick, scene.setup.placement));
                let touched: Vec<&Mutex<BrickRays>> =
                    rays.iter().zip(&places).filter(|(_, at)| at.overlaps(low, high)).map(|(rays, _)| rays).collect();
                if touched.is_empty() {
                    continue;
                }
                let region = self.source.region(&cells);
                let part = BrickPart::new(scene.pass.dims, &cells, region.first, self.source.key.layout.per_layer);
                let pass = PassBrick { scene, control, touched: &touched, part };
                if (self.shows)(self.lattice.bricks_around(brick, reach)) {
                    let texture = pool.brick(brick, &self.source, &region, control)?;
                    texture.with_texture(&self.source, &region, pass)?;
                } else {
                    pass.skip()?;
                }
            }
            for waiting in rays {
                waiting.into_inner().unwrap_or_else(PoisonError::into_inner).waiting.finish(scene, &mut picture);
            }
        }
        Ok(picture.mean(n * n))
    }

    /// Cells over which a segment extends along each axis, at most. A brick in which nothing is visible still matters to the segments that only begin in it, or
    /// end: it may be left out where nothing is visible so far around it.
    fn reach(&self, rays: &[Mutex<BrickRays>]) -> [usize; 3] {
        let mut reach = [0.0f32; 3];
        if !matches!(self.scene.pass.classifier, Classifier::Segments(_)) {
            return [0; 3];
        }
        for waiting in rays {
            let rays = &locked(waiting).waiting.rays;
            for i in (0..LANES).filter(|i| rays.hits >> i & 1 == 1) {
                // A ray without whole samples is one segment.
                let single = rays.begin.0[i] >= rays.end.0[i];
                for a in 0..3 {
                    let all = rays.outer[1][a].0[i] - rays.outer[0][a].0[i];
                    reach[a] = reach[a].max(if single { all } else { rays.delta[a].0[i] }.abs());
                }
            }
        }
        // Both ends may be moved.
        reach[2] += 2.0 * self.source.key.layout.largest_move() as f32;
        reach.map(|cells| cells.ceil() as usize)
    }
}

struct SetUp<'a> {
    scene: &'a PacketScene<'a>,
    at: Packet,
    sample: u32,
}

impl Vectorized for SetUp<'_> {
    type Output = BrickRays;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> BrickRays {
        let waiting = Waiting::new(simd, self.scene, self.at, self.sample);
        let next = Lanes(waiting.rays.begin.0.map(|begin| begin - 1.0));
        BrickRays { waiting, next, middles: Middles::UNKNOWN }
    }
}

/// All rays that may meet a brick, on their way through it.
struct PassBrick<'a> {
    scene: &'a PacketScene<'a>,
    control: &'a Control,
    touched: &'a [&'a Mutex<BrickRays>],
    part: BrickPart,
}

impl PassBrick<'_> {
    /// Does something to all of them, many to a task: sixteen by sixteen would be too little work.
    fn each(&self, work: impl Fn(&[&Mutex<BrickRays>]) + Sync) -> Result<(), RenderError> {
        let groups: Vec<_> = self.touched.chunks(GROUP).collect();
        in_parallel(self.control, groups.len() as u32, |g| work(groups[g as usize]))?;
        Ok(())
    }

    /// Leaves out a brick in which nothing is visible.
    fn skip(&self) -> Result<(), RenderError> {
        self.each(|group| run(self.scene.level, Skip { part: &self.part, group }))
    }
}

impl TextureVisitor for PassBrick<'_> {
    type Output = Result<(), RenderError>;

    fn visit<X: Texture>(self, texture: X) -> Self::Output {
        let Self { scene, part, .. } = self;
        let texture = InBrick { texture, part };
        self.each(|group| run(scene.level, Group { scene, texture: &texture, part: &part, group }))
    }
}

struct Skip<'a> {
    part: &'a BrickPart,
    group: &'a [&'a Mutex<BrickRays>],
}

impl Vectorized for Skip<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.group.iter().for_each(|rays| locked(rays).skip(simd, self.part));
    }
}

/// Some sixteens of rays.
struct Group<'a, X> {
    scene: &'a PacketScene<'a>,
    texture: &'a X,
    part: &'a BrickPart,
    group: &'a [&'a Mutex<BrickRays>],
}

impl<X: Texture> Vectorized for Group<'_, X> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut chunk = Chunk::EMPTY;
        let mut fetcher = Fetcher::new(self.texture);
        for rays in self.group {
            locked(rays).draw(simd, self.scene, &mut fetcher, self.part, &mut chunk);
        }
    }
}

/// Sixteen rays, between bricks.
struct BrickRays {
    waiting: Waiting,
    /// The next sample of each ray: the first is numbered one less than the whole ones, the last one more.
    next: Lanes,
    /// Gradient in the middle of each ray's next segment, as far as it has been met.
    middles: Middles,
}

impl BrickRays {
    /// Takes the samples that lie in a brick.
    fn draw<S: Simd, X: Texture>(
        &mut self,
        simd: S,
        scene: &PacketScene<'_>,
        fetcher: &mut Fetcher<'_, X>,
        part: &BrickPart,
        chunk: &mut Chunk,
    ) {
        let here = samples_here(simd, &self.waiting.rays, &self.next, part);
        let mut texture = BrickFetcher { fetcher, part, middles: &mut self.middles };
        if here.any() {
            self.waiting.march(scene, &mut texture, chunk, |march| {
                march.enter(simd, here.first);
                let (from, to) = here.whole();
                march.stretch(simd, from, &to);
                march.leave(simd, here.last);
            });
            texture.middles.forget(&self.next, &here.next);
            self.next = here.next;
        }
        if matches!(scene.pass.classifier, Classifier::Segments(_)) && scene.looks_at_gradients() {
            texture.meet_middles(simd, &self.waiting.rays, &self.next);
        }
    }

    /// Leaves out the samples that lie in a brick.
    fn skip<S: Simd>(&mut self, simd: S, part: &BrickPart) {
        let here = samples_here(simd, &self.waiting.rays, &self.next, part);
        self.waiting.done.skipped += here.count();
        for i in (0..LANES).filter(|&i| self.next.0[i] != here.next.0[i]) {
            // The segment from its last sample here is one in which nothing is visible.
            self.waiting.before.0[i] = f32::NAN;
        }
        self.middles.forget(&self.next, &here.next);
        self.next = here.next;
    }
}

/// The samples of sixteen rays that lie in a brick.
struct SamplesHere {
    /// Bit i: the first of ray i, and the last one.
    first: u32,
    last: u32,
    /// Numbers of the whole ones, from the first to behind the last.
    whole: [Lanes; 2],
    /// The next sample, behind this brick.
    next: Lanes,
}

impl SamplesHere {
    fn any(&self) -> bool {
        let [from, to] = &self.whole;
        self.first | self.last != 0 || from.0 != to.0
    }

    /// Number of samples.
    fn count(&self) -> u64 {
        let [from, to] = &self.whole;
        let whole: f32 = (0..LANES).map(|i| to.0[i] - from.0[i]).sum();
        whole as u64 + u64::from(self.first.count_ones() + self.last.count_ones())
    }

    /// Numbers of the whole ones, as a march takes them: of rays without any the end is −∞.
    fn whole(&self) -> (Lanes, Lanes) {
        let [from, to] = &self.whole;
        let has = |i: usize| from.0[i] < to.0[i];
        let end = |i: usize| if has(i) { to.0[i] } else { f32::NEG_INFINITY };
        let begin = |i: usize| if has(i) { from.0[i] } else { 0.0 };
        (Lanes(std::array::from_fn(begin)), Lanes(std::array::from_fn(end)))
    }
}

/// Finds the samples, from each ray's next one on, that lie in a brick: positions are those that they are fetched at.
#[inline(never)]
fn samples_here<S: Simd>(simd: S, rays: &Fragments, next: &Lanes, part: &BrickPart) -> SamplesHere {
    simd.vectorize(
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let (begin, end) = (rays.begin.load(simd), rays.end.load(simd));
            let number = next.load(simd);
            let heading = [rays.delta[0].load(simd), rays.delta[1].load(simd), rays.delta[2].load(simd)];
            // Back to front, the one sample of a ray with a single slab is its last.
            let waits = number.simd_lt(begin) & rays.has[0].load(simd).simd_gt(zero);
            let [x, y, z] = &rays.outer[0];
            let first = waits & part.holds_ahead(simd, [x.load(simd), y.load(simd), z.load(simd)], heading);
            let under_way = !waits | first;
            let from = pick(first, number + one, number);
            // Whole ones, as far as they are here.
            let mut to = from;
            loop {
                let position = [
                    rays.base[0].load(simd) + to * heading[0],
                    rays.base[1].load(simd) + to * heading[1],
                    rays.base[2].load(simd) + to * heading[2],
                ];
                let here = under_way & to.simd_lt(end) & part.holds_ahead(simd, position, heading);
                if here.all_false() {
                    break;
                }
                to = pick(here, to + one, to);
            }
            let [x, y, z] = &rays.outer[1];
            let at_last = under_way & to.simd_eq(end) & rays.has[1].load(simd).simd_gt(zero);
            let last = at_last & part.holds_ahead(simd, [x.load(simd), y.load(simd), z.load(simd)], heading);
            SamplesHere {
                first: first.to_bitmask() as u32,
                last: last.to_bitmask() as u32,
                whole: [Lanes::new(from), Lanes::new(to)],
                next: Lanes::new(pick(last, to + one, to)),
            }
        },
    )
}
