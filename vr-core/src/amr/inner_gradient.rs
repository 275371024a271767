//! Gradients inside a level, where no coarser leaf is near.

use glam::DVec3;

use super::block::AmrCentring;
use super::element::Element;
use super::grid::AmrGrid;

impl AmrGrid {
    /// The gradient at a world position in an element, where the samples of its level tell it: the eight around it, and those beside them. `None` where the
    /// corners of the element have to be looked at one by one.
    pub(super) fn inner_gradient(&self, element: Element, at: DVec3) -> Option<DVec3> {
        let position = (at - self.origin) * self.levels[element.level].rate;
        self.gradient_within_level(element, position - DVec3::from_array(element.node.map(|n| n as f64)))
    }

    /// The same at a place in the element, 0 to 1.
    pub(super) fn gradient_within_level(&self, Element { level, node }: Element, place: DVec3) -> Option<DVec3> {
        let elements = self.centring.elements();
        let number = self.holder_of_cell(level, node.map(|n| n.div_euclid(elements)))?;
        // The eight samples around it, and the place between them.
        let (low, place) = match self.centring {
            AmrCentring::Cells => {
                let low = node.map(|n| (n - 1) >> 1);
                let half = DVec3::from_array(std::array::from_fn(|a| (node[a] - 2 * low[a] - 1) as f64));
                (low, (half + place) * 0.5)
            }
            AmrCentring::Points => (node, place),
        };
        let first = self.blocks[number].first;
        let stencil = self.samples().exact_stencil(number, std::array::from_fn(|a| (low[a] - first[a]) as i32))?;
        let gradient = differences(&stencil, place.clamp(DVec3::ZERO, DVec3::ONE)) / self.levels[level].spacing;
        (!gradient.is_nan()).then_some(gradient)
    }
}

/// Trilinear interpolation, between the eight samples in the middle, of their central differences per step.
fn differences(stencil: &[f64; 32], at: DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for i in 0..8 {
        let weight = |a: usize| if i >> a & 1 == 1 { at[a] } else { 1.0 - at[a] };
        let along = |a: usize| {
            let [t, u] = [[1, 2], [0, 2], [0, 1]][a].map(|other| i >> other & 1);
            let (bit, beyond) = (1 << a, 8 + 8 * a + t + 2 * u);
            if i & bit == 0 { stencil[i | bit] - stencil[beyond] } else { stencil[beyond + 4] - stencil[i & !bit] }
        };
        let rise = DVec3::new(along(0), along(1), along(2));
        sum += rise * (0.5 * weight(0) * weight(1) * weight(2));
    }
    sum
}
