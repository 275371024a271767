//! Numbers of any type, as f64.

use glam::DVec3;

use crate::decode::{Scalar, with_scalar};
use crate::scalar::{Endian, ScalarType};

/// The numbers that whole groups of bytes stand for. Integers beyond 2⁵³ are rounded.
#[allow(clippy::unnecessary_cast, reason = "one of the ten types is f64")]
pub(super) fn numbers(bytes: &[u8], scalar: ScalarType, endian: Endian) -> Vec<f64> {
    with_scalar!(scalar, S => {
        let mut stored: Vec<S> = Vec::with_capacity(bytes.len() / size_of::<S>());
        S::append(bytes, endian, &mut stored);
        stored.into_iter().map(|x| x as f64).collect()
    })
}

/// Three numbers each.
pub(super) fn positions(numbers: &[f64]) -> Vec<DVec3> {
    numbers.as_chunks().0.iter().map(|&p: &[f64; 3]| p.into()).collect()
}
