//! The program from end to end, as a user meets it.

mod anatomy;
mod bad_input;
mod bench;
mod commands;
mod convert;
mod diff;
mod error_bounds;
mod harness;
mod inputs;
mod look;
mod mesh;
mod points;
mod ray;
mod report;
mod unused;
