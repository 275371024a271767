//! Parts of blocks, with the ranges of the field in them.

use super::block::AmrCentring;
use super::check::each_index;
use super::grid::AmrGrid;
use super::level::{divided, plus};
use super::marked::Marked;
use super::solid_elements::SolidElements;
use crate::cancel;
use crate::parallel::collect;

/// Largest number of cells along the edge of a brick.
pub(super) const EDGE: i64 = 8;

/// Bricks of all blocks, block after block, x fastest.
#[derive(Clone, Debug)]
pub(super) struct Bricks {
    /// Number of the first brick of each block.
    starts: Vec<usize>,
    bricks: Vec<Brick>,
    /// True for blocks whose cells are all leaves.
    leaves: Vec<bool>,
    /// True for blocks whose cells are all leaves, and none vacuum.
    solid: Vec<bool>,
    /// For each block, the block that holds all cells beside each of its six faces, lower and upper for each axis; both without vacuum, and all leaves.
    faces: Vec<[u32; 6]>,
    /// Sides of each block that no coarser leaf touches.
    complete: Vec<u32>,
    /// Bricks parts of which may be vacuum, and their elements.
    with_vacuum: Marked,
    solid_elements: Vec<SolidElements>,
}

/// Number for a face beside which no such block lies.
const NONE: u32 = u32::MAX;

/// Part of a block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Brick {
    /// Two numbers between which all values of the field in it lie.
    pub(super) range: [f32; 2],
    /// True if finer cells cover some of it.
    pub(super) has_finer: bool,
    /// True if it holds a leaf.
    pub(super) has_leaf: bool,
    /// Edge of the largest cubes of cells, aligned with the block, each of which finer cells cover all or none of.
    pub(super) grain: u8,
    /// True if parts of it may be vacuum.
    pub(super) has_vacuum: bool,
}

impl Bricks {
    pub(super) fn new(grid: &AmrGrid) -> Self {
        // Each is there twice for a moment: in its block's list, and in the list of all.
        let count = |number: usize| brick_box(grid, number)[1].iter().product::<i64>() as u64;
        let all: u64 = (0..grid.blocks.len()).map(count).sum();
        cancel::claim("the bricks of the adaptive mesh", 2 * size_of::<Brick>() as u64 * all);
        let of_block = |number: usize| {
            let [from, to] = brick_box(grid, number);
            each_index([0; 3], plus(to, from.map(|x| -x))).map(|at| brick(grid, number, at)).collect::<Vec<_>>()
        };
        let lists = collect(grid.blocks.len(), of_block);
        let mut starts = vec![0];
        starts.extend(lists.iter().scan(0, |sum, list| {
            *sum += list.len();
            Some(*sum)
        }));
        let leaves = lists.iter().map(|list| list.iter().all(|brick| !brick.has_finer)).collect();
        let solid: Vec<bool> =
            lists.iter().map(|list| list.iter().all(|brick| !brick.has_finer && !brick.has_vacuum)).collect();
        let beside = |number: usize| match solid[number] {
            true => std::array::from_fn(|face| {
                block_beside(grid, number, face).filter(|&n| solid[n]).map_or(NONE, |n| n as u32)
            }),
            false => [NONE; 6],
        };
        let faces = collect(grid.blocks.len(), beside);
        let complete = match grid.centring {
            AmrCentring::Points => collect(grid.blocks.len(), |number| complete_sides(grid, number)),
            // The samples around a place tell.
            AmrCentring::Cells => Vec::new(),
        };
        let bricks = lists.concat();
        let with_vacuum = Marked::new(bricks.iter().map(|brick| brick.has_vacuum));
        let doubtful = |number: usize| elements_with_vacuum(grid, number, &bricks[starts[number]..]);
        let solid_elements = collect(grid.blocks.len(), doubtful).into_iter().flatten().collect();
        Self { starts, bricks, leaves, solid, faces, complete, with_vacuum, solid_elements }
    }

    /// True if all cells of a block are leaves.
    pub(super) fn is_leaf(&self, number: usize) -> bool {
        self.leaves[number]
    }

    /// True if all cells of a block are leaves, and none is vacuum.
    #[inline]
    pub(super) fn is_solid(&self, number: usize) -> bool {
        self.solid[number]
    }

    /// Block that holds all cells beside a face of another one: lower and upper for each axis. None of both has vacuum, or finer cells.
    #[inline]
    pub(super) fn beside(&self, number: usize, face: usize) -> Option<usize> {
        let found = self.faces[number][face];
        (found != NONE).then_some(found as usize)
    }

    /// Numbers of the bricks of a block.
    pub(super) fn of_block(&self, number: usize) -> std::ops::Range<usize> {
        self.starts[number]..self.starts[number + 1]
    }

    /// Sides of a block that no coarser leaf touches: 27 bits, from the corner at its lowest cell on, x fastest; the bit in the middle is the block's own.
    pub(super) fn complete_sides(&self, number: usize) -> u32 {
        self.complete.get(number).copied().unwrap_or_default()
    }

    /// Number of the brick at a place among those of a block.
    #[inline]
    pub(super) fn number_at(&self, grid: &AmrGrid, number: usize, at: [i64; 3]) -> usize {
        let [_, n] = brick_box(grid, number);
        self.starts[number] + ((at[2] * n[1] + at[1]) * n[0] + at[0]) as usize
    }

    /// The brick of a number.
    #[inline]
    pub(super) fn get(&self, number: usize) -> &Brick {
        &self.bricks[number]
    }

    /// Elements that are not vacuum of a brick parts of which may be.
    #[inline]
    pub(super) fn solid_elements(&self, number: usize) -> Option<&SolidElements> {
        self.solid_elements.get(self.with_vacuum.number(number)?)
    }

    /// The brick at a place among those of a block.
    pub(super) fn at(&self, grid: &AmrGrid, number: usize, at: [i64; 3]) -> &Brick {
        self.get(self.number_at(grid, number, at))
    }
}

/// Elements that are not vacuum, of those bricks of a block parts of which may be; `bricks` begins with the block's own.
fn elements_with_vacuum(grid: &AmrGrid, block: usize, bricks: &[Brick]) -> Vec<SolidElements> {
    let [from, to] = brick_box(grid, block);
    let found = |(brick, at): (&Brick, [i64; 3])| {
        let [first, end] = cells_of_brick(grid, block, at);
        brick.has_vacuum.then(|| SolidElements::new(grid, grid.blocks[block].level, first, end))
    };
    bricks.iter().zip(each_index(from, to)).filter_map(found).collect()
}

/// First cell of a brick, and the end of its cells.
fn cells_of_brick(grid: &AmrGrid, number: usize, at: [i64; 3]) -> [[i64; 3]; 2] {
    let block = &grid.blocks[number];
    let cells = block.cells(grid.centring);
    let from: [i64; 3] = std::array::from_fn(|a| block.first[a] + at[a] * EDGE);
    [from, std::array::from_fn(|a| (from[a] + EDGE).min(block.first[a] + cells[a] as i64))]
}

/// Block that holds all cells beside a face of another one.
fn block_beside(grid: &AmrGrid, number: usize, face: usize) -> Option<usize> {
    let block = &grid.blocks[number];
    let end = plus(block.first, block.cells(grid.centring).map(|n| n as i64));
    let (axis, is_upper) = (face / 2, face % 2 == 1);
    let (mut from, mut last) = (block.first, end.map(|e| e - 1));
    let layer = if is_upper { end[axis] } else { block.first[axis] - 1 };
    (from[axis], last[axis]) = (layer, layer);
    let beyond = grid.centring.beyond();
    let near = grid.levels[block.level].index.around(from);
    near.iter().map(|&n| n as usize).find(|&n| grid.blocks[n].holds(from, last.map(|i| i + beyond)))
}

fn complete_sides(grid: &AmrGrid, number: usize) -> u32 {
    let block = &grid.blocks[number];
    let end = plus(block.first, block.cells(grid.centring).map(|n| n as i64));
    let range = |a: usize, side: i64| match side {
        0 => [block.first[a] - 1, block.first[a]],
        1 => [block.first[a], end[a]],
        _ => [end[a], end[a] + 1],
    };
    let is_complete = |side: i64| {
        let ranges = [range(0, side % 3), range(1, side / 3 % 3), range(2, side / 9)];
        let [from, to] = [0, 1].map(|i| ranges.map(|r| r[i]));
        let is_fine = |cell: [i64; 3]| {
            grid.holder_of_cell(block.level, cell).is_some() || grid.coarser_leaf(block.level, cell).is_none()
        };
        side == 13 || each_index(from, to).all(is_fine)
    };
    (0..27).filter(|&side| is_complete(side)).fold(0, |bits, side| bits | 1 << side)
}

/// Numbers of bricks of a block, from 0.
fn brick_box(grid: &AmrGrid, number: usize) -> [[i64; 3]; 2] {
    let cells = grid.blocks[number].cells(grid.centring);
    [[0; 3], cells.map(|n| (n as i64 + EDGE - 1) / EDGE)]
}

fn brick(grid: &AmrGrid, number: usize, at: [i64; 3]) -> Brick {
    let block = &grid.blocks[number];
    let [from, to] = cells_of_brick(grid, number, at);
    let is_covered = |cell: [i64; 3]| grid.is_covered(block.level, cell);
    let covered = each_index(from, to).filter(|&cell| is_covered(cell)).count();
    let cells_in = each_index(from, to).count();
    // Every cell is as the first one of its cube.
    let is_even = |grain: i64| {
        let first = |cell: [i64; 3]| std::array::from_fn(|a| from[a] + (cell[a] - from[a]) / grain * grain);
        each_index(from, to).all(|cell| is_covered(cell) == is_covered(first(cell)))
    };
    let grain =
        if covered == 0 || covered == cells_in { EDGE } else { [4, 2].into_iter().find(|&g| is_even(g)).unwrap_or(1) };
    let mut brick = Brick {
        range: [f32::INFINITY, f32::NEG_INFINITY],
        has_finer: covered > 0,
        has_leaf: covered < cells_in,
        grain: grain as u8,
        has_vacuum: false,
    };
    if brick.has_leaf {
        enclose(grid, block.level, from.map(|x| x - 1), to.map(|x| x + 1), &mut brick);
    }
    brick
}

/// Widens a brick's range by all that the field among some cells of a level, `to` excluded, is made of.
fn enclose(grid: &AmrGrid, level: usize, from: [i64; 3], to: [i64; 3], brick: &mut Brick) {
    let mut reaches_coarser = false;
    for cell in each_index(from, to) {
        if grid.holder_of_cell(level, cell).is_some() {
            continue;
        }
        let is_solid = level > 0 && {
            let mut coarser = cell;
            (0..level).rev().any(|l| {
                coarser = divided(coarser, grid.levels[l + 1].ratio);
                grid.holder_of_cell(l, coarser).is_some()
            })
        };
        reaches_coarser |= is_solid;
        brick.has_vacuum |= !is_solid && is_near_inside(grid, level, cell);
    }
    let beyond = grid.centring.beyond();
    for at in each_index(from, to.map(|x| x + beyond)) {
        let value = grid.sample(level, at) as f32;
        if value.is_nan() {
            // A cell without a value, or none.
            brick.has_vacuum |= grid.holds_sample(level, at);
        } else {
            brick.range = [brick.range[0].min(value), brick.range[1].max(value)];
        }
    }
    if reaches_coarser {
        let ratio = grid.levels[level].ratio;
        let from = divided(from, ratio).map(|x| x - 1);
        let to = divided(to.map(|x| x - 1), ratio).map(|x| x + 2);
        enclose(grid, level - 1, from, to, brick);
    }
}

/// True if a missing cell makes vacuum within the box of the values: if that reaches nearer to it than half a cell. Cells beyond the outermost
/// values do not, where those are all of one level.
fn is_near_inside(grid: &AmrGrid, level: usize, cell: [i64; 3]) -> bool {
    let elements = grid.centring.elements();
    let half = grid.spacing_of(level) * 0.5 * (elements - 1) as f64;
    let low = grid.position(level, cell.map(|x| x * elements)) - half;
    let high = grid.position(level, cell.map(|x| (x + 1) * elements)) + half;
    let slack = grid.finest_spacing() * 1e-6;
    let (inside_low, inside_high) = grid.bounds();
    (low + slack).cmplt(inside_high).all() && (high - slack).cmpgt(inside_low).all()
}
