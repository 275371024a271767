//! Gradients inside a level, where no coarser leaf is near.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::element::Element;
use super::grid::AmrGrid;
use super::level::plus;

/// Samples of four lattice points along each axis, x fastest; of those in the corners, edges beyond the two in the middle are not needed and stay 0.
type Stencil = [f64; 64];

/// Place of a point among those of a stencil.
#[inline]
fn place(x: usize, y: usize, z: usize) -> usize {
    (z * 4 + y) * 4 + x
}

/// True if a point of a stencil is one of the eight in the middle, or beside one of them along an axis.
#[inline]
fn is_needed(at: [usize; 3]) -> bool {
    at.iter().filter(|&&i| i == 0 || i == 3).count() <= 1
}

impl AmrGrid {
    /// The gradient at a world position in an element, where the samples of its level tell it: the eight around it, and those beside them. `None` where the
    /// corners of the element have to be looked at one by one.
    pub(super) fn inner_gradient(&self, element: Element, at: DVec3) -> Option<DVec3> {
        let Element { level, node } = element;
        let spacing = self.levels[level].spacing;
        let (low, shift) = match self.centring {
            AmrCentring::Cells => (node.map(|n| (n - 1) >> 1), 0.5),
            AmrCentring::Points => (node, 0.0),
        };
        let first = low.map(|i| i - 1);
        let holder = &self.blocks[self.holder_of_cell(level, node.map(|n| n.div_euclid(self.centring.elements())))?];
        let stencil = if holder.holds(first, low.map(|i| i + 2)) {
            within_block(holder, first)?
        } else {
            if self.centring == AmrCentring::Points && !self.has_neighbors(level, node) {
                return None;
            }
            self.among_blocks(level, first)
        };
        let position = (at - self.origin) / spacing - DVec3::from_array(low.map(|i| i as f64)) - shift;
        let gradient = differences(&stencil, position.clamp(DVec3::ZERO, DVec3::ONE)) / spacing;
        (!gradient.is_nan()).then_some(gradient)
    }

    fn among_blocks(&self, level: usize, first: [i64; 3]) -> Stencil {
        let mut stencil = [0.0; 64];
        for z in 0..4 {
            for y in 0..4 {
                for x in (0..4).filter(|&x| is_needed([x, y, z])) {
                    stencil[place(x, y, z)] = self.sample(level, plus(first, [x as i64, y as i64, z as i64]));
                }
            }
        }
        stencil
    }
}

/// The samples of a block from one on, which it has.
fn within_block(block: &AmrBlock, first: [i64; 3]) -> Option<Stencil> {
    let offset = block.offset(first)?;
    let (row, layer) = (block.dims[0], block.dims[0] * block.dims[1]);
    let mut stencil = [0.0; 64];
    for z in 0..4 {
        for y in 0..4 {
            let begin = offset + z * layer + y * row;
            for (x, &value) in block.values[begin..begin + 4].iter().enumerate() {
                stencil[place(x, y, z)] = f64::from(value);
            }
        }
    }
    Some(stencil)
}

/// Trilinear interpolation, between the eight points in the middle, of their central differences per step.
fn differences(stencil: &Stencil, at: DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for i in 0..8 {
        let [x, y, z] = [1 + (i & 1), 1 + (i >> 1 & 1), 1 + (i >> 2)];
        let weight = |a: usize| if i >> a & 1 == 1 { at[a] } else { 1.0 - at[a] };
        let rise = DVec3::new(
            stencil[place(x + 1, y, z)] - stencil[place(x - 1, y, z)],
            stencil[place(x, y + 1, z)] - stencil[place(x, y - 1, z)],
            stencil[place(x, y, z + 1)] - stencil[place(x, y, z - 1)],
        );
        sum += rise * (0.5 * weight(0) * weight(1) * weight(2));
    }
    sum
}
