//! One tile of the picture: its splats are added to sheets, and the sheets composited, sixteen pixels at a time.

mod block;
mod chords;
mod composite;
mod footprint;
mod fragments;
mod middles;
mod painter;
mod products;
mod sheets;
mod sighted;
mod sloped_mean;
mod state;
mod whole;

use fearless_simd::Simd;
use vr_kernels::vector::{Lanes, PacketLights, Vectorized};

use crate::bins::{Keyed, TILE};
use crate::splat::Splat;
use crate::splatter::Buffers;

use block::{Block, EDGE};
use footprint::Axes;

pub(crate) use block::Bounds;
pub(crate) use footprint::FootprintKernel;
pub(crate) use painter::{Classifier, Content, Drawn, Painter, SplatLight, VisibleCells};
pub(crate) use state::State;

use painter::Work;
use sighted::Sighted;

/// Blocks along the edge of a tile.
const ACROSS: u32 = TILE / EDGE;
/// Blocks of a tile: a bit of a word each.
const BLOCKS: usize = (ACROSS * ACROSS) as usize;

struct TileJob<'a> {
    painter: &'a Painter<'a>,
    column: u32,
    row: u32,
    splats: &'a [Keyed],
}

impl Vectorized for TileJob<'_> {
    type Output = Drawn;
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Drawn {
        let painter = self.painter;
        let channels = painter.channels();
        let slots = painter.slots();
        let mut tile = Tile {
            painter,
            channels,
            axes: Axes::new(painter.view),
            column: self.column,
            row: self.row,
            blocks: vec![Block::EMPTY; BLOCKS],
            states: vec![State::EMPTY; BLOCKS],
            lights: vec![PacketLights::default(); if painter.shader().is_some() { BLOCKS } else { 0 }],
            ready: 0,
            done: 0,
            sheets: vec![Lanes::ZERO; slots * BLOCKS * channels],
            touched: vec![0; slots],
            filled: vec![0; slots],
            sighted: Sighted::new(painter, slots),
            work: Work::default(),
        };
        match (&painter.content, painter.buffers) {
            (Content::Values { .. } | Content::Light(_), Buffers::Image) => tile.image_sheets(simd, self.splats),
            _ => tile.whole_splats(simd, self.splats),
        }
        let there = (0..BLOCKS as u32).filter(|b| tile.ready >> b & 1 == 1);
        let blocks = there.map(|b| (b, tile.states[b as usize])).collect();
        Drawn { column: self.column, row: self.row, blocks, work: tile.work }
    }
}

impl Painter<'_> {
    /// Sheets that a tile holds at once.
    fn slots(&self) -> usize {
        if self.buffers == Buffers::Image { self.ring as usize } else { 1 }
    }

    /// Bytes of the sheets of a tile.
    pub(crate) fn sheet_bytes(&self) -> u64 {
        (self.slots() * BLOCKS * self.channels() * size_of::<Lanes>()) as u64
    }
}

/// A tile that is being drawn.
struct Tile<'a> {
    painter: &'a Painter<'a>,
    /// Numbers that a sheet holds of a pixel.
    channels: usize,
    axes: Axes,
    column: u32,
    row: u32,
    blocks: Vec<Block>,
    states: Vec<State>,
    /// Lights as the rays of each block see them; none where nothing is shaded.
    lights: Vec<PacketLights>,
    /// Blocks whose rays are set up, a bit each.
    ready: u64,
    /// Blocks that take no more.
    done: u64,
    /// Block by block, slot by slot, channel by channel: what a splat adds to a block lies together.
    sheets: Vec<Lanes>,
    /// Blocks that anything is in, slot by slot.
    touched: Vec<u64>,
    /// Blocks on whose rays supports cover all of a sheet, slot by slot, where what is covered matters.
    filled: Vec<u64>,
    /// Rays in visible cells, where that has been looked up.
    sighted: Sighted,
    work: Work,
}

/// A rectangle of blocks.
#[derive(Clone, Copy)]
struct Covered {
    x: [u32; 2],
    y: [u32; 2],
    /// First and last column, and row, of its pixels within the tile.
    columns: [u32; 2],
    rows: [u32; 2],
}

impl Covered {
    /// The blocks of the rectangle, a bit each.
    #[inline(always)]
    fn blocks(&self) -> u64 {
        let row = ((2u64 << self.x[1]) - 1) & !((1 << self.x[0]) - 1);
        (self.y[0]..=self.y[1]).fold(0, |all, y| all | row << (y * ACROSS))
    }

    /// Number of pixels of the rectangle within the tile.
    #[inline(always)]
    fn pixels(&self) -> u32 {
        (self.columns[1] - self.columns[0] + 1) * (self.rows[1] - self.rows[0] + 1)
    }
}

impl Tile<'_> {
    /// The first channel of a slot in a block.
    #[inline(always)]
    fn place_of(&self, slot: usize, number: usize) -> usize {
        (number * self.touched.len() + slot) * self.channels
    }

    /// The blocks that a splat may reach.
    #[inline(always)]
    fn covered(&self, splat: &Splat) -> Option<Covered> {
        let [x0, x1, y0, y1] = self.painter.view.rectangle(splat.place, splat.scale)?;
        let edge = |first: u32, last: u32, start: u32| {
            let end = start + TILE - 1;
            (first <= end && last >= start).then(|| [first.max(start) - start, last.min(end) - start])
        };
        let (columns, rows) = (edge(x0, x1, self.column)?, edge(y0, y1, self.row)?);
        Some(Covered { x: columns.map(|i| i / EDGE), y: rows.map(|i| i / EDGE), columns, rows })
    }

    /// Number of the block at (x, y), for a splat to be added to it; `None` if it takes no more. Its rays are set up then.
    #[inline(always)]
    fn take(&mut self, x: u32, y: u32) -> Option<usize> {
        let number = (y * ACROSS + x) as usize;
        self.takes_more(number).then(|| {
            self.work.met += 1;
            number
        })
    }

    /// True if a block takes more. Its rays are set up then.
    #[inline(always)]
    fn takes_more(&mut self, number: usize) -> bool {
        if self.done >> number & 1 == 1 {
            return false;
        }
        if self.ready >> number & 1 == 0 {
            let [x, y] = [number as u32 % ACROSS, number as u32 / ACROSS];
            let block = &mut self.blocks[number];
            block.set_up(self.painter.view, &self.painter.bounds, self.column + x * EDGE, self.row + y * EDGE);
            self.ready |= 1 << number;
            if let Some(shader) = self.painter.shader() {
                let along = block::directions(self.painter.view, self.column + x * EDGE, self.row + y * EDGE);
                self.lights[number].look_along(&shader.packet.lights, &along);
            }
            let rays = block.rays();
            self.work.rays += u64::from(rays);
            if rays == 0 {
                self.done |= 1 << number;
                return false;
            }
        }
        true
    }
}
