//! The program from end to end, as a user meets it.

mod anatomy;
mod animation;
mod annotate;
mod bad_input;
mod bench;
mod cells;
mod colors;
mod commands;
mod convert;
mod diff;
mod error_bounds;
mod harness;
mod inputs;
mod labels;
mod look;
mod mesh;
mod points;
mod presets;
mod ray;
mod records;
mod report;
mod resample;
mod scene_files;
mod transfer_rows;
mod uneven_files;
mod unused;
