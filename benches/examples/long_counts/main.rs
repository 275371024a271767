//! Promises of `--max-error` and `--target-rmse` held against the reference, thousands of times.
//!
//! ```sh
//! cargo run --release -p vr-benches --example long_counts -- scenes 10000        # adversarial scenes of a few voxels under bounds of the error
//! cargo run --release -p vr-benches --example long_counts -- kinds 100           # scenes of every kind of volume, look and operator
//! cargo run --release -p vr-benches --example long_counts -- volumes ../shared/data   # real volumes, seen from twelve directions
//! cargo run --release -p vr-benches --example long_counts -- targets 200         # targets of the RMSE, over the kinds of random scenes
//! ```
//!
//! Each prints its table. A scene that breaks a promise is made as small as it goes and written to `target/long_counts`. All is drawn from seeds:
//! `--seed FIRST` goes on where another run ended.

mod bounds;
mod fields;
mod kinds;
mod scenes;
mod targets;
mod volumes;

use std::path::Path;

const USAGE: &str =
    "usage: long_counts [--seed FIRST] [--grid N] scenes COUNT | kinds COUNT | volumes FOLDER | targets COUNT
--seed: the first seed of random scenes; 0 if absent
--grid: of volumes, parts along each side of a picture, of each of which a pixel is compared; 24 if absent";

type Error = Box<dyn std::error::Error>;

fn main() -> Result<(), Error> {
    let (mut first, mut grid, mut rest) = (0, 24, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--seed" => first = words.next().ok_or(USAGE)?.parse()?,
            "--grid" => grid = words.next().ok_or(USAGE)?.parse()?,
            _ => rest.push(word),
        }
    }
    let [kind, what] = rest.as_slice() else { return Err(USAGE.into()) };
    let out = Path::new("target/long_counts");
    match kind.as_str() {
        "scenes" => scenes::count(first..first + what.parse::<u64>()?, out),
        "kinds" => kinds::count(first..first + what.parse::<u64>()?),
        "volumes" => volumes::count(Path::new(what), grid),
        "targets" => targets::count(first..first + what.parse::<u64>()?, out),
        _ => Err(USAGE.into()),
    }
}
