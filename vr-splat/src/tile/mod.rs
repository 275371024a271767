//! One tile of the picture: its splats are added to sheets, and the sheets composited, sixteen pixels at a time.

mod block;
mod meeting;
mod state;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16};
use vr_core::vector::{LANES, Lanes, OpticsTable, PacketLights, Vectorized, light_of, opacity_of_depth, pick, splat};

use crate::bins::{Keyed, TILE};
use crate::projection::SplatView;
use crate::shading::Shader;
use crate::splat::Splat;
use crate::splatting::Buffers;
use crate::visible::CellBits;
use crate::voxel_optics::VoxelOptics;

use block::{Block, EDGE};
use meeting::{Axes, Crossing, Passing, whole};

pub(crate) use block::Bounds;
pub(crate) use meeting::Met;
pub(crate) use state::{Operator, State};

/// Blocks along the edge of a tile.
const ACROSS: u32 = TILE / EDGE;
/// Blocks of a tile: a bit of a word each.
const BLOCKS: usize = (ACROSS * ACROSS) as usize;

/// All that tiles share.
pub(crate) struct Painter<'a> {
    pub(crate) view: &'a SplatView,
    pub(crate) bounds: Bounds<'a>,
    pub(crate) kernel: &'a Met,
    pub(crate) operator: Operator,
    pub(crate) buffers: Buffers,
    /// Between sheets that are parallel to the image, in the view's units.
    pub(crate) distance: f32,
    /// How many of these there are.
    pub(crate) sheets: u32,
    /// How many of them are held at once: a power of two, and at least as many as one splat is in.
    pub(crate) ring: u32,
    /// Sheets of the volume's own: their axis, and the layer of each.
    pub(crate) layers: Option<(usize, &'a [u32])>,
    pub(crate) content: Content<'a>,
    /// What may still come through pixels that are left as they are.
    pub(crate) negligible: f32,
    pub(crate) level: Level,
}

/// What is added to sheets.
pub(crate) enum Content<'a> {
    /// Values, and what they are divided by; classified sheet by sheet.
    Values {
        classifier: Classifier<'a>,
        /// Whether weights are divided out (of a grid), or the length that supports cover (of points): from the first one's front to the last one's
        /// back, in each sheet.
        normalised: bool,
        /// Where something can be seen at all.
        cells: Option<(&'a CellBits, [usize; 3])>,
        /// What shades light.
        shader: Option<&'a Shader<'a>>,
    },
    /// Emission and optical depth of what is classified already.
    Light(&'a VoxelOptics),
    /// Sums of values over whole kernels alone.
    Sums,
}

/// How a sheet's values become light.
pub(crate) enum Classifier<'a> {
    /// By a table, over lengths in the view's units.
    Table(&'a OpticsTable),
    /// One by one: of a stored number and a length.
    Exact(&'a (dyn Fn(f32, f32) -> [f32; 4] + Sync)),
}

/// The work on a tile.
#[derive(Clone, Copy, Default)]
pub(crate) struct Work {
    pub(crate) rays: u64,
    /// Splats times blocks.
    pub(crate) met: u64,
    /// Splats that nothing was done for, what is before them being opaque.
    pub(crate) skipped: u64,
    pub(crate) opaque: u64,
}

/// Pixels of a tile, block by block.
pub(crate) struct Drawn {
    pub(crate) column: u32,
    pub(crate) row: u32,
    blocks: Vec<(u32, State)>,
    pub(crate) work: Work,
}

impl Drawn {
    /// Calls back with place, state and lane of every pixel that anything may be in.
    pub(crate) fn each(&self, size: [u32; 2], mut take: impl FnMut([u32; 2], &State, usize)) {
        for (number, state) in &self.blocks {
            let (x, y) = (self.column + number % ACROSS * EDGE, self.row + number / ACROSS * EDGE);
            for i in 0..LANES {
                let at = [x + i as u32 % EDGE, y + i as u32 / EDGE];
                if at[0] < size[0] && at[1] < size[1] {
                    take(at, state, i);
                }
            }
        }
    }
}

impl Painter<'_> {
    /// Draws the tile whose first pixel is (column, row).
    pub(crate) fn draw(&self, column: u32, row: u32, splats: Vec<Keyed>) -> Drawn {
        vr_core::vector::run(self.level, TileJob { painter: self, column, row, splats: &splats })
    }

    fn shader(&self) -> Option<&Shader<'_>> {
        match self.content {
            Content::Values { shader, .. } => shader,
            _ => None,
        }
    }

    fn channels(&self) -> usize {
        match self.content {
            Content::Values { normalised: true, .. } => 2,
            Content::Values { .. } => 3,
            Content::Light(_) => 4,
            Content::Sums => 0,
        }
    }
}

struct TileJob<'a> {
    painter: &'a Painter<'a>,
    column: u32,
    row: u32,
    splats: &'a [Keyed],
}

impl Vectorized for TileJob<'_> {
    type Output = Drawn;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Drawn {
        let painter = self.painter;
        let slots = if painter.buffers == Buffers::Image { painter.ring as usize } else { 1 };
        let mut tile = Tile {
            painter,
            axes: Axes::new(painter.view),
            column: self.column,
            row: self.row,
            blocks: vec![Block::EMPTY; BLOCKS],
            states: vec![State::EMPTY; BLOCKS],
            lights: vec![PacketLights::default(); if painter.shader().is_some() { BLOCKS } else { 0 }],
            ready: 0,
            done: 0,
            sheets: vec![Lanes::ZERO; slots * BLOCKS * painter.channels()],
            touched: vec![0; slots],
            work: Work::default(),
        };
        match (&painter.content, painter.buffers) {
            (Content::Sums, _) => tile.sums(simd, self.splats),
            (_, Buffers::Image) => tile.image_sheets(simd, self.splats),
            (_, Buffers::Axis) => tile.own_sheets(simd, self.splats),
            (_, Buffers::Samples) => tile.samples(simd, self.splats),
        }
        let there = (0..BLOCKS as u32).filter(|b| tile.ready >> b & 1 == 1);
        let blocks = there.map(|b| (b, tile.states[b as usize])).collect();
        Drawn { column: self.column, row: self.row, blocks, work: tile.work }
    }
}

/// A tile that is being drawn.
struct Tile<'a> {
    painter: &'a Painter<'a>,
    axes: Axes,
    column: u32,
    row: u32,
    blocks: Vec<Block>,
    states: Vec<State>,
    /// As each block's rays see them; none where nothing is shaded.
    lights: Vec<PacketLights>,
    /// Blocks whose rays are set up, a bit each.
    ready: u64,
    /// Blocks that take no more.
    done: u64,
    /// Slot by slot, block by block, channel by channel.
    sheets: Vec<Lanes>,
    /// Blocks that anything is in, slot by slot.
    touched: Vec<u64>,
    work: Work,
}

/// A rectangle of blocks.
#[derive(Clone, Copy)]
struct Covered {
    x: [u32; 2],
    y: [u32; 2],
}

impl Tile<'_> {
    /// The blocks that a splat may reach.
    #[inline(always)]
    fn covered(&self, splat: &Splat) -> Option<Covered> {
        let [x0, x1, y0, y1] = self.painter.view.rectangle(splat.place, splat.scale)?;
        let edge = |first: u32, last: u32, start: u32| {
            let end = start + TILE - 1;
            (first <= end && last >= start).then(|| [(first.max(start) - start) / EDGE, (last.min(end) - start) / EDGE])
        };
        Some(Covered { x: edge(x0, x1, self.column)?, y: edge(y0, y1, self.row)? })
    }

    /// The next block, from (x, y) on, that takes more; its rays are ready then.
    #[inline(always)]
    fn take(&mut self, x: u32, y: u32) -> Option<usize> {
        let number = (y * ACROSS + x) as usize;
        if self.done >> number & 1 == 1 {
            return None;
        }
        if self.ready >> number & 1 == 0 {
            let block = &mut self.blocks[number];
            block.set_up(self.painter.view, &self.painter.bounds, self.column + x * EDGE, self.row + y * EDGE);
            self.ready |= 1 << number;
            if let Some(shader) = self.painter.shader() {
                let along = block::directions(self.painter.view, self.column + x * EDGE, self.row + y * EDGE);
                self.lights[number].look_along(&shader.shading.shading, &along);
            }
            let rays = block.rays();
            self.work.rays += u64::from(rays);
            if rays == 0 {
                self.done |= 1 << number;
                return None;
            }
        }
        self.work.met += 1;
        Some(number)
    }

    /// Sheets parallel to the image: a ring of those that splats are still added to.
    #[inline(always)]
    fn image_sheets<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let painter = self.painter;
        let half = painter.view.half_depth() as f32;
        // Sheets from `next` to `open` may hold something.
        let (mut next, mut open) = (0, 0);
        for (i, Keyed { key, splat }) in splats.iter().enumerate() {
            while next < *key && next < open {
                self.finish_image(simd, next);
                next += 1;
            }
            next = *key;
            if self.done == u64::MAX {
                self.work.skipped += (splats.len() - i) as u64;
                return;
            }
            let Some(covered) = self.covered(splat) else { continue };
            let back = (splat.place[2] + half / splat.scale) / painter.distance;
            // `as` saturates; rounding must not take more sheets than the ring has.
            let last = (back as u32).clamp(*key, key + painter.ring - 1).min(painter.sheets - 1);
            open = open.max(last + 1);
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    if let Some(number) = self.take(x, y) {
                        self.add_sections(simd, number, splat, *key, last);
                    }
                }
            }
        }
        for sheet in next..open {
            self.finish_image(simd, sheet);
        }
    }

    /// Adds what lies in each of some sheets of a splat.
    #[inline(always)]
    fn add_sections<S: Simd>(&mut self, simd: S, number: usize, splat_: &Splat, first: u32, last: u32) {
        let painter = self.painter;
        let block = &self.blocks[number];
        let (near, far) = (block.near.load(simd), block.far.load(simd));
        let optics = match painter.content {
            Content::Light(optics) => optics.at(splat_.value),
            _ => [0.0; 4],
        };
        let channels = painter.channels();
        let bit = 1u64 << number;
        match painter.kernel {
            Met::Radial(table) => {
                let Some(passing) = Passing::new(simd, &self.axes, block, splat_) else { return };
                let factor = block.stretch.load(simd) * splat_.weight / passing.speed;
                let [enter, leave] = passing.chord(simd);
                let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
                let mut before = passing.up_to(simd, table, start);
                for sheet in first..=last {
                    let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
                    let after = passing.up_to(simd, table, end);
                    // Radial kernels are nowhere negative; tables and rounding might be.
                    let section = (after - before).max(splat(simd, 0.0)) * factor;
                    before = after;
                    let slot = (sheet & (painter.ring - 1)) as usize;
                    let at = (slot * BLOCKS + number) * channels;
                    let sheet = &mut self.sheets[at..at + channels];
                    add(simd, sheet, section, splat_.value, optics);
                    if let [_, to_back, to_front] = sheet {
                        cover(simd, to_back, to_front, [start, end], [enter, leave]);
                    }
                    start = end;
                    self.touched[slot] |= bit;
                }
            }
            kernel => {
                let crossing = Crossing::new(simd, &self.axes, block, splat_);
                let factor = block.stretch.load(simd) * splat_.weight;
                let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
                for sheet in first..=last {
                    let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
                    let middle = (start + end) * 0.5;
                    let weight = match kernel {
                        Met::Bilinear => crossing.bilinear(simd, middle),
                        Met::Sinc(table) => crossing.sinc(simd, table, middle),
                        _ => crossing.b_spline(simd, middle),
                    };
                    // Values are divided by weights: lengths, which may be 0, must not be in both.
                    let section = if channels == 2 { weight } else { weight * factor * (end - start) };
                    start = end;
                    let slot = (sheet & (painter.ring - 1)) as usize;
                    let at = (slot * BLOCKS + number) * channels;
                    add(simd, &mut self.sheets[at..at + channels], section, splat_.value, optics);
                    self.touched[slot] |= bit;
                }
            }
        }
    }

    /// Composites a sheet parallel to the image, and clears it.
    #[inline(always)]
    fn finish_image<S: Simd>(&mut self, simd: S, sheet: u32) {
        let painter = self.painter;
        let slot = (sheet & (painter.ring - 1)) as usize;
        let mut touched = std::mem::take(&mut self.touched[slot]);
        let channels = painter.channels();
        let [a, b] = [sheet, sheet + 1].map(|k| k as f32 * painter.distance);
        while touched != 0 {
            let number = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            let at = (slot * BLOCKS + number) * channels;
            let block = &self.blocks[number];
            let (near, far) = (block.near.load(simd), block.far.load(simd));
            let from = splat(simd, a).max(near).min(far);
            let to = splat(simd, b).max(near).min(far);
            let length = (to - from) * block.stretch.load(simd);
            self.composite(simd, number, at, length, (from + to) * 0.5);
            self.sheets[at..at + channels].fill(Lanes::ZERO);
        }
    }

    /// The volume's own sheets, one after another.
    #[inline(always)]
    fn own_sheets<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let mut i = 0;
        while i < splats.len() {
            if self.done == u64::MAX {
                self.work.skipped += (splats.len() - i) as u64;
                return;
            }
            let sheet = splats[i].key;
            while i < splats.len() && splats[i].key == sheet {
                self.add_whole(simd, &splats[i].splat);
                i += 1;
            }
            self.finish_own(simd, sheet);
        }
    }

    /// Adds a splat's whole kernel to the only sheet.
    #[inline(always)]
    fn add_whole<S: Simd>(&mut self, simd: S, splat: &Splat) {
        let Some(covered) = self.covered(splat) else { return };
        let channels = self.painter.channels();
        let optics = match self.painter.content {
            Content::Light(optics) => optics.at(splat.value),
            _ => [0.0; 4],
        };
        for y in covered.y[0]..=covered.y[1] {
            for x in covered.x[0]..=covered.x[1] {
                let Some(number) = self.take(x, y) else { continue };
                let Some(weight) = self.weight(simd, number, splat) else { continue };
                let at = number * channels;
                add(simd, &mut self.sheets[at..at + channels], weight, splat.value, optics);
                self.touched[0] |= 1 << number;
            }
        }
    }

    /// ∫ of a splat's kernel along the rays of a block, in world units; `None` if none meets it.
    #[inline(always)]
    fn weight<S: Simd>(&self, simd: S, number: usize, splat: &Splat) -> Option<f32x16<S>> {
        let block = &self.blocks[number];
        let ends = [block.near.load(simd), block.far.load(simd)];
        let sum = whole(simd, self.painter.kernel, &self.axes, block, splat, ends)?;
        Some(sum * block.stretch.load(simd) * splat.weight)
    }

    /// Composites one of the volume's own sheets, and clears it.
    #[inline(always)]
    fn finish_own<S: Simd>(&mut self, simd: S, sheet: u32) {
        let channels = self.painter.channels();
        let mut touched = std::mem::take(&mut self.touched[0]);
        while touched != 0 {
            let number = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            let at = number * channels;
            let mut depth = splat(simd, 0.0);
            if let Some((axis, layers)) = self.painter.layers {
                let [from, step] = self.blocks[number].index.map(|v| v[axis].load(simd));
                let flat = step.abs().simd_lt(splat(simd, 1e-12));
                depth = (splat(simd, layers[sheet as usize] as f32) - from) / pick(flat, splat(simd, 1e-12), step);
            }
            // Weights of a sheet sum to its length along the ray.
            let length = if channels == 2 { self.sheets[at + 1].load(simd) } else { splat(simd, 1.0) };
            self.composite(simd, number, at, length, depth);
            self.sheets[at..at + channels].fill(Lanes::ZERO);
        }
    }

    /// Classifies what a sheet holds in a block, and takes it in.
    #[inline(always)]
    fn composite<S: Simd>(&mut self, simd: S, number: usize, at: usize, length: f32x16<S>, depth: f32x16<S>) {
        let painter = self.painter;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let operator = painter.operator;
        match &painter.content {
            Content::Values { classifier, normalised, cells, shader } => {
                let (sum, weight) = (self.sheets[at].load(simd), self.sheets[at + 1].load(simd));
                let (length, divisor) = if *normalised {
                    (length, weight)
                } else {
                    // From the first front to the back of the sheet, and from its front to the last back: what they have in common.
                    let both = weight + self.sheets[at + 2].load(simd);
                    let covered = (both * self.blocks[number].stretch.load(simd) - length).max(zero);
                    (covered, covered)
                };
                let mut there = divisor.simd_gt(zero) & length.simd_gt(zero);
                if !there.any_true() {
                    return;
                }
                let value = sum / pick(there, divisor, one);
                if let Some((cells, dims)) = cells {
                    let visible = self.in_visible_cells(simd, number, depth, cells, *dims);
                    there &= Lanes(visible).load(simd).simd_gt(zero);
                    if !there.any_true() {
                        return;
                    }
                }
                if !matches!(operator, Operator::Under { .. } | Operator::Over) {
                    self.states[number].choose(simd, operator, value, length, there);
                    return;
                }
                let length = pick(there, length, zero);
                let light = match classifier {
                    Classifier::Table(optics) => {
                        let unit = 1.0 / painter.view.unit as f32;
                        light_of(simd, optics.rows().at(simd, value), length * unit, optics.emits)
                    }
                    Classifier::Exact(step) => {
                        let (value, length) = (value.to_array(), length.to_array());
                        let mut light = [Lanes::ZERO; 4];
                        for i in 0..LANES {
                            let one = step(value[i], length[i]);
                            for c in 0..4 {
                                light[c].0[i] = one[c];
                            }
                        }
                        [light[0].load(simd), light[1].load(simd), light[2].load(simd), light[3].load(simd)]
                    }
                };
                let light = match shader {
                    Some(shader) if light[3].simd_gt(zero).any_true() => {
                        let mut lanes = light.map(Lanes::of);
                        let place = self.place(simd, number, depth);
                        shader.shade(simd, &self.lights[number], place, &mut lanes);
                        [lanes[0].load(simd), lanes[1].load(simd), lanes[2].load(simd), lanes[3].load(simd)]
                    }
                    _ => light,
                };
                self.states[number].blend(simd, operator, light);
            }
            Content::Light(_) => {
                let tau = self.sheets[at + 3].load(simd);
                let alpha = opacity_of_depth(simd, tau.max(zero));
                // A sinc's sides may outweigh its middle: less than nothing sends nothing.
                let share = pick(tau.simd_lt(zero), zero, share(simd, tau, alpha));
                let [r, g, b] = [0, 1, 2].map(|c| self.sheets[at + c].0);
                let light =
                    [Lanes(r).load(simd) * share, Lanes(g).load(simd) * share, Lanes(b).load(simd) * share, alpha];
                self.states[number].blend(simd, operator, light);
            }
            Content::Sums => {}
        }
        self.retire(simd, number);
    }

    /// Of a block that is opaque: takes no more.
    #[inline(always)]
    fn retire<S: Simd>(&mut self, simd: S, number: usize) {
        if let Operator::Under { level } = self.painter.operator {
            let block = &self.blocks[number];
            let clear = self.states[number].clear.load(simd);
            let least = splat(simd, self.painter.negligible.max(1.0 - level));
            let open = clear.simd_gt(least) & block.near.load(simd).simd_lt(block.far.load(simd));
            if !open.any_true() {
                self.done |= 1 << number;
                self.work.opaque += 1;
            }
        }
    }

    /// 1 for rays that are in a cell in which something can be seen at a depth.
    #[inline(always)]
    fn in_visible_cells<S: Simd>(
        &self,
        simd: S,
        number: usize,
        depth: f32x16<S>,
        cells: &CellBits,
        dims: [usize; 3],
    ) -> [f32; LANES] {
        let index = self.place(simd, number, depth);
        let mut visible = [0.0; LANES];
        for i in 0..LANES {
            // `as` saturates at 0.
            let cell = |a: usize| (index[a].0[i] as usize).min(dims[a] - 2);
            visible[i] = if cells.is_visible(cell(0), cell(1), cell(2)) { 1.0 } else { 0.0 };
        }
        visible
    }

    /// Where a block's rays are in a grid at some depths.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, number: usize, depth: f32x16<S>) -> [Lanes; 3] {
        let [from, step] = &self.blocks[number].index;
        let mut place = [Lanes::ZERO; 3];
        for a in 0..3 {
            place[a] = Lanes::of(from[a].load(simd) + step[a].load(simd) * depth);
        }
        place
    }

    /// Every splat on its own, nearest first.
    #[inline(always)]
    fn samples<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let Content::Light(optics) = self.painter.content else { return };
        for (i, Keyed { splat: at, .. }) in splats.iter().enumerate() {
            if self.done == u64::MAX {
                self.work.skipped += (splats.len() - i) as u64;
                return;
            }
            let Some(covered) = self.covered(at) else { continue };
            let [r, g, b, kappa] = optics.at(at.value);
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    let Some(number) = self.take(x, y) else { continue };
                    let Some(weight) = self.weight(simd, number, at) else { continue };
                    let zero = splat(simd, 0.0);
                    let tau = weight * kappa;
                    let alpha = opacity_of_depth(simd, tau.max(zero));
                    let share = pick(tau.simd_lt(zero), zero, share(simd, tau, alpha)) * weight;
                    self.states[number].blend(simd, self.painter.operator, [share * r, share * g, share * b, alpha]);
                    self.retire(simd, number);
                }
            }
        }
    }

    /// Sums of values over whole kernels.
    #[inline(always)]
    fn sums<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        for Keyed { splat: at, .. } in splats {
            let Some(covered) = self.covered(at) else { continue };
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    let Some(number) = self.take(x, y) else { continue };
                    let Some(weight) = self.weight(simd, number, at) else { continue };
                    let state = &mut self.states[number];
                    state.value = Lanes::of(state.value.load(simd) + weight * at.value);
                    state.length = Lanes::of(state.length.load(simd) + weight);
                }
            }
        }
    }
}

/// (1 − e^(−τ)) / τ: what of a homogeneous sheet's light comes out at its front.
#[inline(always)]
fn share<S: Simd>(simd: S, tau: f32x16<S>, alpha: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let clear = tau.simd_le(zero);
    pick(clear, one, alpha / pick(clear, one, tau))
}

/// Takes note of what a support covers of a sheet: how far its front is from the sheet's back, and its back from the sheet's front.
#[inline(always)]
fn cover<S: Simd>(
    simd: S,
    to_back: &mut Lanes,
    to_front: &mut Lanes,
    [start, end]: [f32x16<S>; 2],
    [enter, leave]: [f32x16<S>; 2],
) {
    let zero = splat(simd, 0.0);
    let (front, back) = (enter.max(start), leave.min(end));
    let covered = front.simd_lt(back);
    *to_back = Lanes::of(to_back.load(simd).max(pick(covered, end - front, zero)));
    *to_front = Lanes::of(to_front.load(simd).max(pick(covered, back - start, zero)));
}

/// Adds a section of a kernel to a sheet: a value, and its weight where that is divided out, or emission and optical depth.
#[inline(always)]
fn add<S: Simd>(simd: S, sheet: &mut [Lanes], section: f32x16<S>, value: f32, optics: [f32; 4]) {
    if let [sum, weight] = sheet {
        *sum = Lanes::of(sum.load(simd) + section * value);
        *weight = Lanes::of(weight.load(simd) + section);
    } else if let [sum, _, _] = sheet {
        *sum = Lanes::of(sum.load(simd) + section * value);
    } else if let [r, g, b, tau] = sheet {
        *r = Lanes::of(r.load(simd) + section * optics[0]);
        *g = Lanes::of(g.load(simd) + section * optics[1]);
        *b = Lanes::of(b.load(simd) + section * optics[2]);
        *tau = Lanes::of(tau.load(simd) + section * optics[3]);
    }
}
