//! Packets under operators that pick a value: the extremes of the field, its mean, and the place where it first reaches a threshold.
//!
//! A ray takes every step of its lattice ([`march`]), or of its list ([`listed`]), but in grids for those in blocks whose bounds say that nothing there can be picked: no more than the largest value so far, or
//! nothing that reaches the threshold. (So a ray that looks for a maximum leaps over most of the volume once it has met something bright.) The step in which a
//! threshold is reached is halved until f32 resolves no more; the plain engine shades the place.

mod choice;
mod engine;
mod listed;
mod look;
mod march;
mod trace;

pub(crate) use choice::Choice;
pub(crate) use engine::{PickEngine, PickFrame};
pub(crate) use look::{PickLook, PickedNumber};
pub(crate) use march::{HALVINGS, PickMedium};
pub(crate) use trace::{PickRays, PickTrace};

#[cfg(test)]
mod tests;
