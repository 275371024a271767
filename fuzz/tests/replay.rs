//! Files with bytes changed, put in, taken out and cut off, thousands of them: each is read or refused in one line, never with a panic, and never
//! with more memory than there is. The random numbers are the same on every run.

use std::cell::Cell;
use std::path::Path;
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use vr_core::memory;
use vr_fuzz::{Ground, MAX_MEMORY, MEMORY_LEFT, TARGETS};

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Longest time that a file of kilobytes may take, on a machine that does other work meanwhile.
const LONGEST: Duration = Duration::from_secs(10);

/// Damaged versions of each seed; `COUNT` makes more, in memory, of those readers alone whose names are in `TARGETS`, with commas between.
const CASES: u32 = 300;

#[derive(Clone, Debug)]
enum Damage {
    Set(prop::sample::Index, u8),
    Insert(prop::sample::Index, &'static str),
    Remove(prop::sample::Index, usize),
    Cut(prop::sample::Index),
}

/// Words that upset parsers.
const WORDS: [&str; 16] = [
    "-1",
    "0",
    "nan",
    "inf",
    "1e999",
    "18446744073709551616",
    "9223372036854775807",
    "4294967296",
    "\n",
    "\0",
    "\u{1b}[31m",
    "%d",
    "none",
    "(",
    "\u{fffd}",
    "\u{ff}\u{ff}\u{ff}\u{ff}",
];

fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let at = any::<prop::sample::Index>;
    let one = prop_oneof![
        4 => (at(), any::<u8>()).prop_map(|(i, b)| Damage::Set(i, b)),
        4 => (at(), prop::sample::select(&WORDS[..])).prop_map(|(i, w)| Damage::Insert(i, w)),
        2 => (at(), 1usize..20).prop_map(|(i, n)| Damage::Remove(i, n)),
        1 => at().prop_map(Damage::Cut),
    ];
    vec(one, 1..5)
}

fn apply(bytes: &[u8], damage: &[Damage]) -> Vec<u8> {
    let mut b = bytes.to_vec();
    for d in damage {
        let i = |index: &prop::sample::Index| index.index(b.len().max(1)).min(b.len());
        match d {
            Damage::Set(index, value) => {
                let i = i(index);
                if let Some(byte) = b.get_mut(i) {
                    *byte = *value;
                }
            }
            Damage::Insert(index, word) => {
                let i = i(index);
                b.splice(i..i, word.bytes());
            }
            Damage::Remove(index, n) => {
                let i = i(index);
                b.drain(i..(i + n).min(b.len()));
            }
            Damage::Cut(index) => {
                let i = i(index);
                b.truncate(i);
            }
        }
    }
    b
}

#[test]
fn every_reader_survives() {
    memory::set_meter(|| MEMORY_LEFT);
    let count = std::env::var("COUNT").ok().map(|count| count.parse().expect("a number"));
    let (cases, ground_of): (u32, fn(_) -> _) = match count {
        Some(count) => (count, Ground::in_memory),
        None => (CASES, Ground::new),
    };
    let asked = std::env::var("TARGETS").ok();
    let is_asked = |name: &str| asked.as_ref().is_none_or(|names| names.split(',').any(|asked| asked == name));
    let (count, slowest, most) = (Cell::new(0), Cell::new((Duration::ZERO, "")), Cell::new((0, "")));
    for target in TARGETS.iter().filter(|target| is_asked(target.name)) {
        let ground = ground_of(target);
        for seed in target.seeds() {
            ground.run(&seed).unwrap_or_else(|e| panic!("{}: a seed: {e}", target.name));
            let config = Config { cases, failure_persistence: None, ..Config::default() };
            let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
            // The last one that fails is the smallest, and stays for the debugger.
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(target.name);
            let outcome = runner.run(&damage(), |d| {
                let (damaged, start) = (apply(&seed, &d), Instant::now());
                HEAP.reset_peak_usage();
                let outcome = ground.run(&damaged);
                let (time, peak) = (start.elapsed(), HEAP.peak_usage());
                count.set(count.get() + 1);
                slowest.set(slowest.get().max((time, target.name)));
                most.set(most.get().max((peak, target.name)));
                if outcome.is_err() || time >= LONGEST || peak >= MAX_MEMORY {
                    std::fs::write(&kept, &damaged).unwrap();
                }
                prop_assert!(time < LONGEST, "took {:?}", time);
                prop_assert!(peak < MAX_MEMORY, "took {} bytes", peak);
                outcome.map_err(|e| TestCaseError::fail(format!("{e} from {:?}", String::from_utf8_lossy(&damaged))))
            });
            outcome.unwrap_or_else(|e| panic!("{}: {e}; the file is {}", target.name, kept.display()));
        }
    }
    let (slowest, most) = (slowest.get(), most.get());
    println!(
        "{} files; the slowest took {:?} ({}), the largest {} bytes ({})",
        count.get(),
        slowest.0,
        slowest.1,
        most.0,
        most.1
    );
}
