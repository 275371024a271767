//! Time of a sample in adaptive meshes beside that in a uniform grid, in the plain engine and in packets: `cargo run --release -p vr-raycast --example amr_time`.
//!
//! Arguments, each of which may be left out from the end: part of the name of a mesh; `plain`, `packets` or `shaded`, or `all`; number of frames, of which the
//! fastest counts. The uniform grid is always measured, so that ratios are those of one run. Asked for is a ratio of 2 at most in packets.

mod sample_time;

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};

use sample_time::{side, value};

fn main() {
    let side = side();
    let step = 1.0 / side as f64;
    let mesh = |levels: usize, block: usize, centring| {
        let sampling = AmrSampling {
            origin: DVec3::ZERO,
            edge: (block << (levels - 1)) as f64 * step,
            blocks: [(side / block) >> (levels - 1); 3],
            block_cells: [block; 3],
            ratios: vec![[2; 3]; levels - 1],
            centring,
        };
        // Fine near the surface of a ball.
        let near = |low: DVec3, high: DVec3, _: usize| {
            let distance = (0.5 * (low + high)).distance(DVec3::splat(0.5)) - 0.3;
            distance.abs() < 0.6 * (high - low).length()
        };
        AmrGrid::refining(&sampling, value, near).expect("sizes are sound")
    };
    sample_time::print(vec![
        ("1 level, blocks of 128", mesh(1, side.min(128), AmrCentring::Cells).into()),
        ("1 level, blocks of 32", mesh(1, 32, AmrCentring::Cells).into()),
        ("3 levels, blocks of 32", mesh(3, 32, AmrCentring::Cells).into()),
        ("1 level, blocks of 16", mesh(1, 16, AmrCentring::Cells).into()),
        ("1 level, blocks of 8", mesh(1, 8, AmrCentring::Cells).into()),
        ("3 levels, blocks of 16", mesh(3, 16, AmrCentring::Cells).into()),
        ("3 levels, blocks of 8", mesh(3, 8, AmrCentring::Cells).into()),
        ("1 level, points, blocks of 16", mesh(1, 16, AmrCentring::Points).into()),
        ("3 levels, points, blocks of 16", mesh(3, 16, AmrCentring::Points).into()),
    ]);
}
