//! Random edits for minutes: memory does not grow, the last edit of each batch is shown, and pictures at rest remain those of the saved scene.
//! `cargo run --release -p vr-view --example random_edits -- MINUTES [SEED]` prints a line each minute, and fails where one of these does not hold.
//!
//! Memory is that of the process on Linux (`VmRSS`); elsewhere it is not looked at.

#[path = "../tests/view/common.rs"]
#[allow(dead_code)]
mod common;

use std::time::{Duration, Instant};

use glam::DVec3;
use vr_core::{ControlPoint, Plane};
use vr_view::session::{Edit, Export, Output, Quality, Side, Stage};

use common::{Watched, document, drawn_anew};

/// Share of the time after which memory is first looked at: structures are kept per view and scene until then.
const WARM_UP: f64 = 0.2;
/// Factor by which memory may differ from what it was then.
const MAX_GROWTH: f64 = 1.1;

/// Numbers that follow from a seed (Marsaglia 2003, *Xorshift RNGs*).
struct Numbers(u64);

impl Numbers {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    fn edit(&mut self) -> Edit {
        match self.below(18) {
            0..=3 => Edit::Orbit { right: self.between(-40.0, 40.0), up: self.between(-30.0, 30.0) },
            4 => Edit::Zoom { factor: self.between(0.8, 1.25), at: [self.between(-0.3, 0.3), 0.1] },
            5 => Edit::Pan { right: self.between(-0.05, 0.05), up: self.between(-0.05, 0.05) },
            6 => Edit::Transfer {
                points: (0..3)
                    .map(|i| {
                        let color = [self.unit(), self.unit(), self.unit()];
                        ControlPoint::new(0.5 * f64::from(i), color, self.between(0.0, 0.6))
                    })
                    .collect(),
            },
            7 => Edit::Preset { name: ["viridis", "inferno", "ct-bone"][self.below(3)].to_owned() },
            8 => Edit::Crop {
                corners: (self.unit() < 0.5)
                    .then(|| [0, 1].map(|end| [0; 3].map(|_| self.between(0.0, 0.4) + 0.5 * f64::from(end)))),
            },
            9 => {
                let normal = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), 1.0);
                let plane = Plane { normal, offset: self.between(-0.2, 0.2) };
                Edit::Planes { planes: if self.unit() < 0.5 { vec![plane] } else { Vec::new() } }
            }
            10 => Edit::Background { color: [0; 3].map(|_| self.unit() as f32) },
            11 => Edit::Renderer { name: ["raycast", "shearwarp"][self.below(2)].to_owned() },
            12 => Edit::Quality {
                quality: [Quality::Draft, Quality::Normal, Quality::Fine, Quality::Proven][self.below(4)],
            },
            13 => Edit::Size { size: [64 + self.below(100) as u32, 48 + self.below(80) as u32] },
            14 => Edit::Projection { perspective: self.unit() < 0.5 },
            15 => Edit::Side { side: [Side::Front, Side::Left, Side::Top][self.below(3)] },
            16 => Edit::Undo,
            _ => [Edit::Redo, Edit::Fit, Edit::ResetCamera][self.below(3)].clone(),
        }
    }
}

/// Megabytes of the process; `None` where the system does not tell.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<f64>().ok()? / 1e3)
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let minutes: f64 = arguments.next().map_or(1.0, |text| text.parse().expect("minutes"));
    let mut numbers = Numbers(arguments.next().map_or(20_261_127, |text| text.parse().expect("a seed")));
    let watched = Watched::of(document("blobs", 48, [120, 90]));
    let (start, length) = (Instant::now(), Duration::from_secs_f64(60.0 * minutes));
    let (mut number, mut refused, mut compared, mut told) = (0, 0, 0, 0.0);
    let mut first = None;
    while start.elapsed() < length {
        // Some edits at the pace of a hand, or faster than anything is drawn.
        let pause = Duration::from_millis([0, 0, 5, 30][numbers.below(4)]);
        for _ in 0..1 + numbers.below(20) {
            number += 1;
            refused += u32::from(watched.session.apply(1, number, &numbers.edit()).is_err());
            std::thread::sleep(pause);
        }
        // The last one is shown at rest, and as the saved scene is drawn.
        number += 1;
        watched.session.apply(1, number, &Edit::Orbit { right: 0.5, up: 0.0 }).expect("a turn is never refused");
        let proves = watched.session.state().render.max_error.is_some();
        let last = if proves { Stage::Proven } else { Stage::Sharp };
        let picture = watched.picture(last, number);
        let scene = watched.session.export(Export::Scene).expect("a scene has a text");
        let (size, pixels) = drawn_anew(std::str::from_utf8(&scene).expect("it is text"));
        assert!(
            (picture.head.size, &picture.rgba) == (size, &pixels),
            "after edit {number}:\n{}",
            String::from_utf8_lossy(&scene)
        );
        compared += 1;
        while let Ok(output) = watched.told.try_recv() {
            assert!(!matches!(output, Output::Problem(_)), "after edit {number}");
        }
        let now = start.elapsed().as_secs_f64();
        if first.is_none() && now > WARM_UP * length.as_secs_f64() {
            first = resident();
        }
        if now >= told {
            println!(
                "{:4.1} min: {number} edits, {refused} refused, {compared} pictures compared, {:.0} MB",
                now / 60.0,
                resident().unwrap_or(f64::NAN)
            );
            told += 60.0;
        }
    }
    let end = resident();
    println!(
        "{minutes} min: {number} edits, {refused} refused, {compared} pictures equal to those of their saved scenes, bit for bit; {:.0} MB, then {:.0} MB",
        first.unwrap_or(f64::NAN),
        end.unwrap_or(f64::NAN)
    );
    if let (Some(first), Some(end)) = (first, end) {
        assert!(end <= MAX_GROWTH * first, "memory grows from {first} to {end} MB");
    }
}
