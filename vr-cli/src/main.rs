//! The program `vr`: pictures of volumes, and how far they are from the correct ones.
//!
//! It parses, wires and prints. What it prints is found out elsewhere: `vr-io` reads and writes, the renderers draw, and
//! `vr-physics` solves the reference.

mod animation;
mod annotate;
mod args;
mod bench;
mod bench_report;
mod blank;
#[cfg(feature = "view")]
mod browser;
mod camera_flags;
mod canvas;
mod compare;
mod console;
mod contact_sheet;
mod convert;
mod diff;
mod error_bound;
mod error_map;
mod error_scale;
mod exact_cache;
mod failure;
mod heap;
mod heat_map;
mod help;
mod histogram_drawing;
mod info;
mod inputs;
mod interrupt;
mod joint_histogram;
mod mask;
mod memory_limit;
mod model_costs;
mod number;
mod output_file;
mod overrides;
mod physics;
mod picture_record;
mod preset_sheet;
mod presets;
mod process;
mod progress;
mod ranking;
mod ray;
mod render;
mod renderers;
mod report;
mod report_summary;
mod rerun;
mod resampled;
mod scene_file;
mod scene_setup;
mod sheet_record;
mod show;
mod table;
mod target;
mod text;
mod tf;
mod tf_picture;
mod tf_plane;
mod threads;
mod transfer_box;
mod verify;
#[cfg(feature = "view")]
mod view;
mod volume_setup;
mod wrapping;

use std::process::ExitCode;

use clap::CommandFactory;

use crate::args::{Cli, Command};
use crate::console::Console;
use crate::failure::Failure;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            Console::error(&failure);
            failure.exit_code()
        }
    }
}

fn run() -> Result<(), Failure> {
    let Cli { global, command } = Cli::from_command_line()?;
    let console = Console { quiet: global.quiet, json: global.json };
    let control = threads::control(global.threads, console)?;
    interrupt::cancels(&control);
    memory_limit::enforce(global.memory);
    #[cfg(feature = "view")]
    let mut page = None;
    // Reading and sampling volumes is parallel, too: all of a command runs on the control's threads.
    let done = control.cancellable(|| match &command {
        Command::Render(args) => render::run(args, console, &control),
        Command::Compare(args) => compare::run(args, console, &control),
        Command::Bench(args) => bench::run(args, console, &control),
        Command::Report(args) => report::run(args, console, &control),
        Command::Verify(args) => verify::run(args, console, &control),
        Command::Diff(args) => diff::run(args, console),
        Command::Info(args) => info::run(args, console),
        Command::Convert(args) => convert::run(args, console, &control),
        Command::Scene(args) => scene_file::run(args, console, &control),
        Command::Rerun(args) => rerun::run(args, console, &control),
        Command::Turntable(args) => animation::turntable(args, console, &control),
        Command::Animate(args) => animation::animate(args, console, &control),
        Command::Presets(args) => presets::run(args, console, &control),
        Command::Tf(args) => tf::run(args, console),
        Command::Ray(args) => ray::run(args, console, &control),
        Command::Physics(args) => physics::run(args, console, &control),
        #[cfg(feature = "view")]
        Command::View(args) => view::open(args, console).map(|opened| page = Some(opened)),
        Command::Help(args) => help::run(args, Cli::command()),
    });
    let done = done.unwrap_or_else(|stopped| Err(Failure::failed(stopped)));
    // The page's server waits here: on the pool it would hold one of the threads that draw.
    #[cfg(feature = "view")]
    let done = done.and_then(|()| page.map_or(Ok(()), |page| page.serve(&control)));
    done.map_err(|failure| if control.is_cancelled() { failure.cancelled() } else { failure })
}
