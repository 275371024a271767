//! Integration rules: the points of a step at which the field is sampled, and the light that their values make.
//!
//! | rule | value along a step | samples a step | order, smooth field | at kinks of the transfer function | at its jumps |
//! |---|---|---|---|---|---|
//! | left | that in front | 1 | 1 | 1 | 1 |
//! | midpoint | that in the middle | 1 | 2 | 2 | 1 |
//! | linear | a straight line | 1, shared with the next | 2 | 2 | 2 |
//! | quadratic | a parabola | 2, one shared with the next | 4 | 4 (by a table 3.6) | 3 (by a table 2) |
//! | exact | a cubic: the field itself in a trilinear cell | 4 | no error but rounding | | |
//!
//! The last three integrate the transfer function over all values that the step goes through, instead of looking at one.

mod cubic;
mod exact;
mod profile;
mod sampling;

pub(crate) use exact::ExactIntegral;
pub(crate) use profile::{Profile, Shape};
pub(crate) use sampling::Points;

#[cfg(test)]
mod tests;
