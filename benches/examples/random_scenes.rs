//! Thousands of random scenes of every kind, drawn by one renderer at steps that get shorter: a table of those that fell short.
//!
//! `cargo run --release -p vr-benches --example random_scenes -- raycast 10000`
//!
//! Every scene has a seed: `--kind jumps --seed 1234 raycast 1` draws that one again. Scenes that fall short are written as scene
//! files, the worst of each kind first in the table, to be drawn by `vr render --scene FILE --renderer NAME --error full`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use vr_core::{Configurable, OptionError, Options};
use vr_physics::Reference;
use vr_physics::check::faulty_marcher::{Fault, Marcher};
use vr_physics::check::strategies::Kind;
use vr_physics::check::{Fall, Falling, KindFall, Ladder, TestScene, survey_kind};
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_texslice::TextureSlicer;

const USAGE: &str =
    "usage: random_scenes [--kind KIND] [--seed FIRST] [--slack FACTOR] [--all] [--out FOLDER] RENDERER COUNT
--all: writes every scene, not only those that fall short
RENDERER: marcher (plain, in f64), raycast, raycast-steps, raycast-exact, texslice, pre-integrated, shearwarp, splat
KIND: one of those that the table names; all of them if absent, COUNT scenes together";

type Error = Box<dyn std::error::Error>;

/// Largest number of scene files written of each kind; the table counts all.
const MAX_FILES: usize = 20;

fn main() -> Result<(), Error> {
    let (mut kinds, mut first, mut out) = (Kind::ALL.to_vec(), 0, PathBuf::from("target/random_scenes"));
    let mut words = std::env::args().skip(1);
    let (mut rest, mut slack, mut all) = (Vec::new(), None, false);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(USAGE);
        match word.as_str() {
            "--kind" => kinds = vec![Kind::from_name(&value()?).ok_or(USAGE)?],
            "--seed" => first = value()?.parse()?,
            "--slack" => slack = Some(value()?.parse()?),
            "--all" => all = true,
            "--out" => out = value()?.into(),
            _ => rest.push(word),
        }
    }
    let [name, count] = rest.as_slice() else { return Err(USAGE.into()) };
    let (key, ladder) = subject(name, slack).ok_or(USAGE)?;
    survey((name, key), &ladder?, (&kinds, first, count.parse()?), (&out, all))
}

/// A renderer by name at steps of every length, and the option that is refined; one scene's error may grow by a factor of `slack`. The floors
/// are what rounding in f32 and tables of a few thousand entries leave.
fn subject(name: &str, slack: Option<f64>) -> Option<(&'static str, Result<Ladder, OptionError>)> {
    fn ladder(
        renderer: &impl Configurable,
        falling: Falling,
        slack: Option<f64>,
    ) -> (&'static str, Result<Ladder, OptionError>) {
        let scene_slack = slack.unwrap_or(falling.scene_slack);
        (falling.step, Falling { scene_slack, ..falling }.ladder(renderer))
    }
    let step = |key, coarsest| Falling { coarsest, floor: 3e-4, ..Falling::new(key) };
    Some(match name {
        "marcher" => ladder(&Marcher::new(Fault::None), Falling::new("step"), slack),
        // A local error a 32nd as large takes steps about a sixth as long.
        "raycast" => {
            let falling =
                Falling { coarsest: 3.2e-2, ratio: 32.0, order: 0.25, floor: 5e-4, ..Falling::new("local-error") };
            ladder(&RayCaster::default(), falling, slack)
        }
        "raycast-steps" => ladder(&RayCaster::uniform(1.0), step("step", 1.0), slack),
        "raycast-exact" => ladder(&RayCaster::exact(1.0), Falling::new("step"), slack),
        "texslice" => ladder(&TextureSlicer::default(), step("slice-distance", 1.0), slack),
        "pre-integrated" => {
            let options = Options::new().with("format", "pre-integrated");
            ladder(&TextureSlicer::default(), Falling { options, ..step("slice-distance", 1.0) }, slack)
        }
        // Sheets are no closer than 0.02.
        "splat" => ladder(&Splatter::default(), Falling { ratio: 6.0, ..step("slice-distance", 1.0) }, slack),
        // Slices are as far apart as texels are wide, or half of that: one option refines both.
        "shearwarp" => ladder(&ShearWarp::default(), Falling { ratio: 5.0, ..step("texel", 1.0) }, slack),
        _ => return None,
    })
}

/// A scene that fell short: its error, its seed, what was wrong, and itself.
type Failure = (f64, u64, String, TestScene);

fn survey(
    (name, key): (&str, &str),
    ladder: &Ladder,
    (kinds, first, count): (&[Kind], u64, u64),
    (out, all): (&Path, bool),
) -> Result<(), Error> {
    let reference = Reference::new(1e-6);
    let start = Instant::now();
    println!("{name}: RMSE over all scenes of a kind as {key} gets smaller, and what is allowed of the last");
    println!("{:<16}{:>6}{:>8}{:>9}{:>7}{:>7}", "kind", "drawn", "refused", "unjudged", "within", "beyond");
    // Panics are counted: their messages would hide the table.
    std::panic::set_hook(Box::new(|_| {}));
    let mut tables: Vec<KindFall> = Vec::new();
    let mut failures: BTreeMap<&str, Vec<Failure>> = BTreeMap::new();
    for (i, &kind) in kinds.iter().enumerate() {
        let share = count / kinds.len() as u64 + u64::from((i as u64) < count % kinds.len() as u64);
        let table = survey_kind(ladder, kind, first..first + share, &reference, |seed, test, fall| {
            if all || fall.falls_short() {
                let error = if let Fall::Beyond(errors, _) = fall { errors[2] } else { f64::INFINITY };
                failures.entry(kind.name()).or_default().push((error, seed, fall.to_string(), test.clone()));
            }
        });
        println!("{table}");
        tables.push(table);
    }
    let sum = |of: fn(&KindFall) -> u32| tables.iter().map(of).sum::<u32>();
    let (drawn, refused, beyond) = (sum(KindFall::drawn), sum(|t| t.refused), sum(|t| t.beyond));
    let seconds = start.elapsed().as_secs_f64();
    println!("{drawn} scenes in {seconds:.0} s: {refused} refused, {beyond} beyond what is allowed");
    std::fs::create_dir_all(out)?;
    for (kind, mut found) in failures {
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, seed, reason, test) in found.iter().take(MAX_FILES) {
            let path = out.join(format!("{name}-{kind}-{seed}.toml"));
            let mut file = std::fs::File::create(&path)?;
            writeln!(file, "# {name}, kind '{kind}', seed {seed}: {reason}")?;
            if test.scene.surfaces.is_some() {
                writeln!(
                    file,
                    "# An opaque layer, which no scene file holds, is left out: --kind {kind} --seed {seed} draws it."
                )?;
            }
            writeln!(file, "{}", test.scene_file()?)?;
        }
        println!("{kind}: {} scenes in {}, worst: {}", found.len().min(MAX_FILES), out.display(), found[0].2);
    }
    Ok(())
}
