//! Numbers of any type, as f64.

use glam::DVec3;

pub(super) use crate::decode::numbers_as_f64 as numbers;

/// Three numbers each.
pub(super) fn positions(numbers: &[f64]) -> Vec<DVec3> {
    numbers.as_chunks().0.iter().map(|&p: &[f64; 3]| p.into()).collect()
}
