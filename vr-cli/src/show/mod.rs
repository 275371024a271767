//! Pictures in the terminal.

mod blocks;
mod inline;
mod sixel;
mod terminal;

use std::io::{self, ErrorKind, Write};

use vr_core::Frame;
use vr_io::PngOptions;

use crate::args::{Protocol, ShowArgs};
use crate::canvas::Canvas;
use crate::console::Console;
use crate::failure::Failure;
use terminal::Terminal;

/// Refuses to show a picture where stdout holds JSON.
///
/// # Errors
/// [`Failure::Usage`] for `--show` with `--json`.
pub fn check(args: ShowArgs, console: Console) -> Result<(), Failure> {
    match args.show {
        Some(_) if console.json => {
            Err(Failure::usage("--show: stdout holds the result as JSON; leave --show or --json out"))
        }
        _ => Ok(()),
    }
}

/// Shows a frame, as a PNG of these options would be, on stdout.
///
/// # Errors
/// A stdout that cannot be written to. A reader that went away is no failure.
pub fn print(protocol: Protocol, frame: &Frame, png: &PngOptions) -> Result<(), Failure> {
    let text = text(protocol, frame, png, &Terminal::of_stdout());
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(format!("stdout: {e}"))),
        _ => Ok(()),
    }
}

/// Returns what a terminal is sent to show a frame.
fn text(protocol: Protocol, frame: &Frame, png: &PngOptions, terminal: &Terminal) -> String {
    let protocol = if protocol == Protocol::Auto { terminal.protocol() } else { protocol };
    match protocol {
        Protocol::Kitty => inline::kitty(&vr_io::encode_png(frame, png), terminal.columns_for(frame.size())),
        Protocol::Iterm => inline::iterm(&vr_io::encode_png(frame, png), terminal.columns_for(frame.size())),
        Protocol::Sixel => {
            let size = terminal.pixels_for(frame.size());
            sixel::text(size, &shown(&shrunk(frame, size), png))
        }
        Protocol::Blocks | Protocol::Auto => {
            let size = terminal.dots_for(frame.size());
            blocks::text(size, &shown(&shrunk(frame, size), png), terminal.true_color)
        }
    }
}

/// Returns the bytes of each pixel as a PNG of these options has them, opacity last.
fn shown(frame: &Frame, png: &PngOptions) -> Vec<[u8; 4]> {
    Canvas::over(frame, (!png.alpha).then_some(png.background), png.encode).shown()
}

/// Returns a frame made smaller, each pixel the mean of what it takes the place of; no side is made larger.
fn shrunk(frame: &Frame, size: [u32; 2]) -> Frame {
    let [w, h] = frame.size();
    let [new_w, new_h] = [size[0].min(w), size[1].min(h)];
    if [new_w, new_h] == [w, h] {
        return frame.clone();
    }
    // The part of each old pixel in a row or a column that lies in the new one.
    let parts = |new: u32, count: u32, old: u32| -> Vec<(u32, f32)> {
        let ends = [new, new + 1].map(|k| f64::from(k) * f64::from(old) / f64::from(count));
        let last = (ends[1].ceil() as u32).min(old);
        let overlap = |k: u32| (f64::from(k + 1).min(ends[1]) - f64::from(k).max(ends[0])) as f32;
        (ends[0] as u32..last).map(|k| (k, overlap(k))).filter(|part| part.1 > 0.0).collect()
    };
    let columns: Vec<_> = (0..new_w).map(|x| parts(x, new_w, w)).collect();
    let mut pixels = Vec::with_capacity(new_w as usize * new_h as usize);
    for y in 0..new_h {
        let rows = parts(y, new_h, h);
        for column in &columns {
            let (mut sum, mut weight) = ([0.0f32; 4], 0.0);
            for &(old_y, part_y) in &rows {
                for &(old_x, part_x) in column {
                    let pixel = frame.pixel(old_x, old_y).map(|c| if c.is_nan() { 0.0 } else { c });
                    let share = part_x * part_y;
                    sum = std::array::from_fn(|c| sum[c] + share * pixel[c]);
                    weight += share;
                }
            }
            pixels.push(sum.map(|c| c / weight));
        }
    }
    Frame::new([new_w, new_h], pixels, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_pictures_keep_the_mean() {
        let pixels: Vec<[f32; 4]> = (0..35).map(|i| [i as f32, 1.0, 0.0, 0.5]).collect();
        let small = shrunk(&Frame::new([7, 5], pixels, None), [3, 2]);
        assert_eq!(small.size(), [3, 2]);
        let mean = small.pixels().iter().map(|p| p[0]).sum::<f32>() / 6.0;
        assert!((mean - 17.0).abs() < 1e-4, "{mean}");
        assert!(small.pixels().iter().all(|p| (p[1] - 1.0).abs() < 1e-6 && (p[3] - 0.5).abs() < 1e-6));
        assert_eq!(shrunk(&small, [9, 9]), small);
    }

    #[test]
    fn every_protocol_says_something_and_ends_its_line() {
        let frame = Frame::new([200, 100], vec![[0.2, 0.1, 0.0, 0.5]; 20_000], None);
        for (protocol, start) in [
            (Protocol::Kitty, "\u{1b}_G"),
            (Protocol::Iterm, "\u{1b}]1337;File="),
            (Protocol::Sixel, "\u{1b}P"),
            (Protocol::Blocks, "\u{1b}["),
        ] {
            for alpha in [false, true] {
                let png = PngOptions { alpha, ..PngOptions::default() };
                let text = text(protocol, &frame, &png, &Terminal::none());
                assert!(text.starts_with(start) && text.ends_with('\n'), "{protocol:?}");
            }
        }
    }
}
