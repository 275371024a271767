//! The tree of a grid: nodes of 32³ children of 128³ voxels, of 16³ leaves, of 8³ voxels.

use crate::error::FileErrorKind;

use super::bytes::{Bits, Bytes};
use super::map::Map;
use super::values::{Compression, ValueReader};

/// A grid's values where they are not the background's.
#[derive(Debug)]
pub(super) struct Tree {
    pub background: f32,
    /// Cubes of one value.
    pub tiles: Vec<Tile>,
    pub leaves: Vec<Leaf>,
    pub map: Map,
}

/// A cube of one value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub origin: [i32; 3],
    /// Voxels along an edge.
    pub edge: i32,
    pub value: f32,
    pub is_active: bool,
}

/// A cube of 8³ voxels, of which z runs fastest.
#[derive(Debug)]
pub(super) struct Leaf {
    pub origin: [i32; 3],
    pub active: Bits,
    pub values: Vec<f32>,
}

/// Voxels along the edge of a leaf.
pub(super) const LEAF: i32 = 8;
/// Edges of the tiles that are the values of the two kinds of inner nodes, and their children along an edge as powers of two.
const LEVELS: [(i32, u32); 2] = [(128, 5), (8, 4)];
/// Edge of a tile of the root.
const ROOT_TILE: i32 = 4096;
/// Most tiles of a tree: nodes of a few bytes may claim thousands.
const MAX_TILES: usize = 1 << 24;
/// Origins that are far from overflow.
const MAX_ORIGIN: i32 = 1 << 30;

impl Tree {
    /// Reads the topology and, elsewhere in the file and in the same order, the values of the leaves.
    pub fn read(
        mut bytes: Bytes<'_>,
        mut buffers: Bytes<'_>,
        compression: Compression,
        is_half: bool,
        map: Map,
    ) -> Result<Self, FileErrorKind> {
        let count = bytes.u32()?;
        if count != 1 {
            return Err(FileErrorKind::field("buffers of the tree", count, "must be 1"));
        }
        let background = bytes.f32()?;
        let values = ValueReader { compression, is_half, background };
        let mut tree = Self { background, tiles: Vec::new(), leaves: Vec::new(), map };
        let (tiles, children) = (bytes.u32()?, bytes.u32()?);
        for _ in 0..tiles {
            let (origin, value, is_active) = (checked(bytes.index()?)?, bytes.f32()?, bytes.array::<1>()? != [0]);
            tree.add_tile(Tile { origin, edge: ROOT_TILE, value, is_active })?;
        }
        for _ in 0..children {
            let origin = checked(bytes.index()?)?;
            tree.node(&mut bytes, &values, origin, 0)?;
        }
        for leaf in &mut tree.leaves {
            // The mask is there a second time.
            leaf.active = buffers.bits(512)?;
            leaf.values = values.read(&mut buffers, &leaf.active, 512)?;
        }
        Ok(tree)
    }

    fn add_tile(&mut self, tile: Tile) -> Result<(), FileErrorKind> {
        if tile.is_active || tile.value != self.background {
            if self.tiles.len() >= MAX_TILES {
                return Err(FileErrorKind::field("tiles", "too many", format!("must be at most {MAX_TILES}")));
            }
            self.tiles.push(tile);
        }
        Ok(())
    }

    /// Reads an inner node: which children it has, the values of the others, and the children.
    fn node(
        &mut self,
        bytes: &mut Bytes<'_>,
        reader: &ValueReader,
        origin: [i32; 3],
        level: usize,
    ) -> Result<(), FileErrorKind> {
        let (edge, log) = LEVELS[level];
        let count = 1usize << (3 * log);
        let (children, active) = (bytes.bits(count)?, bytes.bits(count)?);
        let values = reader.read(bytes, &active, count)?;
        let place = |i: usize| {
            let along = |shift: u32| (i >> shift & ((1 << log) - 1)) as i32 * edge;
            [origin[0] + along(2 * log), origin[1] + along(log), origin[2] + along(0)]
        };
        for i in (0..count).filter(|&i| !children.is_on(i)) {
            self.add_tile(Tile { origin: place(i), edge, value: values[i], is_active: active.is_on(i) })?;
        }
        for i in children.on() {
            if level + 1 < LEVELS.len() {
                self.node(bytes, reader, place(i), level + 1)?;
            } else {
                let active = bytes.bits(512)?;
                self.leaves.push(Leaf { origin: place(i), active, values: Vec::new() });
            }
        }
        Ok(())
    }
}

fn checked(origin: [i32; 3]) -> Result<[i32; 3], FileErrorKind> {
    if origin.iter().any(|o| !(-MAX_ORIGIN..=MAX_ORIGIN).contains(o)) {
        return Err(FileErrorKind::field("origin of a node", format!("{origin:?}"), "must be within ±2³⁰"));
    }
    Ok(origin)
}
