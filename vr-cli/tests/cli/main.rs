//! The program from end to end, as a user meets it.

mod bad_input;
mod bench;
mod commands;
mod diff;
mod harness;
mod mesh;
mod points;
mod ray;
mod report;
