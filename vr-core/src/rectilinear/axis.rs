//! One axis of a rectilinear grid.

use super::error::RectilinearError;
use crate::limits::{MAX_STEPS_AWAY, is_length};
use crate::memory;

/// Rising places along an axis, at uneven distances, and the map from coordinates to fractional indices that is linear between two of them.
///
/// # Examples
/// ```
/// use vr_core::rectilinear::{Centering, RectilinearGrid};
///
/// let axes = [vec![0.0, 1.0, 10.0], vec![0.0, 1.0], vec![0.0, 1.0]];
/// let grid = RectilinearGrid::new(axes, vec![0.0; 12], Centering::Points)?;
/// let axis = &grid.axes()[0];
/// assert_eq!((axis.cell(4.0), axis.width(1)), (1, 9.0));
/// assert_eq!(axis.to_index(5.5), 1.5);
/// assert_eq!(axis.to_world(0.25), 0.25);
/// # Ok::<(), vr_core::rectilinear::RectilinearError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    places: Vec<f64>,
    /// First cell that may hold a coordinate of each of equally long buckets, and one entry more.
    buckets: Vec<u32>,
    /// Buckets per world unit.
    scale: f64,
}

/// Largest distance of a place from an even one, in steps, at which an axis counts as even.
const EVEN: f64 = 1e-6;

impl Axis {
    /// An axis of places that rise; `number` is that of the axis, for errors.
    pub(super) fn new(places: Vec<f64>, number: usize) -> Result<Self, RectilinearError> {
        let (first, last) = (places[0], places[places.len() - 1]);
        let away = first.abs().max(last.abs());
        for (place, pair) in places.windows(2).enumerate() {
            let found = pair[1] - pair[0];
            if !is_length(found) || away > MAX_STEPS_AWAY * found {
                return Err(RectilinearError::Step { axis: number, place, found });
            }
        }
        let count = places.len() - 1;
        memory::check("the buckets of an axis of the rectilinear grid", (places.len() * size_of::<u32>()) as u64)?;
        let scale = count as f64 / (last - first);
        let holding = |x: f64| places.partition_point(|&p| p <= x).clamp(1, count) - 1;
        let buckets = (0..=count).map(|b| holding(first + b as f64 / scale) as u32).collect();
        Ok(Self { places, buckets, scale })
    }

    /// The places, rising.
    pub fn places(&self) -> &[f64] {
        &self.places
    }

    /// The first and the last place.
    pub fn ends(&self) -> [f64; 2] {
        [self.places[0], self.places[self.places.len() - 1]]
    }

    /// Number of the cell that holds a coordinate; a place belongs to the cell above it, and what is beyond an end to the cell there.
    #[inline]
    pub fn cell(&self, x: f64) -> usize {
        let last = self.buckets.len() - 2;
        // `as` saturates, and is 0 for NaN.
        let bucket = (((x - self.places[0]) * self.scale) as usize).min(last);
        // Rounding may have led into the next bucket.
        let low = (self.buckets[bucket] as usize).saturating_sub(1);
        let high = (self.buckets[bucket + 1] as usize + 2).min(self.places.len() - 1);
        (low + self.places[low..high].partition_point(|&p| p <= x)).max(1) - 1
    }

    /// Width of a cell in world units.
    #[inline]
    pub fn width(&self, cell: usize) -> f64 {
        self.places[cell + 1] - self.places[cell]
    }

    /// Fractional index of a coordinate; beyond the ends, as the last cells go on.
    #[inline]
    pub fn to_index(&self, x: f64) -> f64 {
        let cell = self.cell(x);
        cell as f64 + (x - self.places[cell]) / self.width(cell)
    }

    /// Coordinate of a fractional index; beyond the ends, as the last cells go on.
    pub fn to_world(&self, index: f64) -> f64 {
        let cell = (index as usize).min(self.places.len() - 2);
        self.places[cell] + (index - cell as f64) * self.width(cell)
    }

    /// Mean step in world units.
    pub fn mean_step(&self) -> f64 {
        let [first, last] = self.ends();
        (last - first) / (self.places.len() - 1) as f64
    }

    /// Smallest step in world units.
    pub fn smallest_step(&self) -> f64 {
        self.places.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
    }

    /// Largest step in world units.
    pub fn largest_step(&self) -> f64 {
        self.places.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }

    /// True if all steps are equal, to within a millionth of one.
    pub fn is_even(&self) -> bool {
        let (first, step) = (self.places[0], self.mean_step());
        self.places.iter().enumerate().all(|(k, &p)| (p - (first + k as f64 * step)).abs() <= EVEN * step)
    }

    /// Factors of the rises below and above a place in the slope there, per world unit: the derivative of the parabola through three places and,
    /// at the ends, that of the line through two.
    pub fn slope_factors(&self, place: usize) -> [f64; 2] {
        match place {
            0 => [0.0, 1.0 / self.width(0)],
            p if p + 1 == self.places.len() => [1.0 / self.width(p - 1), 0.0],
            p => {
                let (below, above) = (self.width(p - 1), self.width(p));
                let both = below + above;
                [above / below / both, below / above / both]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coordinate_finds_its_cell() {
        // Graded by 10¹⁰, so that nearly all places are in one bucket, and seemingly random ones.
        let graded: Vec<f64> = (0..60).map(|k| 1.5f64.powi(k)).collect();
        let mut x = 0.0;
        let random: Vec<f64> = (0..97u32)
            .map(|k| {
                x += 0.01 + f64::from(k * 7919 % 101) / 101.0;
                x
            })
            .collect();
        for places in [graded, random, vec![-1.0, 3.0]] {
            let axis = Axis::new(places.clone(), 0).unwrap();
            for (k, pair) in places.windows(2).enumerate() {
                for t in [0.0, 1e-9, 0.5, 0.999_999] {
                    let x = pair[0] + t * (pair[1] - pair[0]);
                    assert_eq!(axis.cell(x), k, "{x}");
                    assert!((axis.to_index(x) - (k as f64 + t)).abs() < 1e-6);
                    assert!((axis.to_world(axis.to_index(x)) - x).abs() <= 1e-12 * x.abs().max(1.0));
                }
            }
            let [first, last] = axis.ends();
            assert_eq!((axis.cell(first - 1.0), axis.cell(last + 1.0)), (0, places.len() - 2));
            assert_eq!((axis.cell(last), axis.cell(f64::NAN)), (places.len() - 2, 0));
        }
    }

    #[test]
    fn slopes_of_parabolas_are_exact() {
        let axis = Axis::new(vec![0.0, 0.5, 2.0, 2.25], 0).unwrap();
        let f = |x: f64| 3.0 * x * x - x;
        let at = |k: usize| f(axis.places()[k]);
        for k in 1..3 {
            let [below, above] = axis.slope_factors(k);
            let slope = below * (at(k) - at(k - 1)) + above * (at(k + 1) - at(k));
            assert!((slope - (6.0 * axis.places()[k] - 1.0)).abs() < 1e-13);
        }
    }

    #[test]
    fn even_axes_are_told() {
        let even = |shift: f64| Axis::new(vec![1.0, 3.0, 5.0 + shift, 7.0], 0).unwrap().is_even();
        assert!(even(0.0) && even(1.9e-6) && !even(2.1e-6));
    }
}
