//! `vr turntable` and `vr animate`.

mod film;
mod frame_store;
mod keyed;
mod places;
mod shot;
mod stage;
mod summary;
mod time_series;
mod turn;

use vr_core::Control;

use crate::args::{AnimateArgs, TurntableArgs};
use crate::console::Console;
use crate::failure::Failure;

use film::Film;
use places::Places;
use stage::Stage;

/// Frames of a turn where neither flags nor a time series give their number: five degrees each.
const TURN_FRAMES: usize = 72;

/// Draws a volume that turns, and writes the animation.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the files to be written.
pub fn turntable(args: &TurntableArgs, console: Console, control: &Control) -> Result<(), Failure> {
    let animation = args.animation.before(args.scene.image.background);
    let places = Places::new(&animation)?;
    let (setup, volumes) = time_series::set_up(&args.scene, &args.renderer, &animation, console)?;
    let usual = if animation.time_series { volumes.pictures() } else { TURN_FRAMES };
    let count = animation.frames.map_or(usual, |frames| frames as usize);
    let stage = Stage::new(&args.scene.camera, &setup);
    let shots = turn::shots(args.turn, &stage, count);
    Film { args: &animation, renderer: &args.renderer, setup, shots, places }.make(volumes, console, control)
}

/// Draws what happens between key frames, and writes the animation.
///
/// # Errors
/// Errors of [`turntable`], and a fault of the keys.
pub fn animate(args: &AnimateArgs, console: Console, control: &Control) -> Result<(), Failure> {
    let keys = vr_io::read_keys(&args.keys).map_err(Failure::failed)?;
    let animation = args.animation.before(args.scene.image.background);
    let places = Places::new(&animation)?;
    let (mut setup, volumes) = time_series::set_up(&args.scene, &args.renderer, &animation, console)?;
    setup.inputs.push(args.keys.clone());
    let times = keyed::times(&keys, animation.frames, animation.fps)?;
    let stage = Stage::new(&args.scene.camera, &setup);
    let wrong = |e| Failure::failed(format!("{}: {e}", args.keys.display()));
    let shots = keyed::shots(&keys, &times, &stage).map_err(wrong)?;
    Film { args: &animation, renderer: &args.renderer, setup, shots, places }.make(volumes, console, control)
}
