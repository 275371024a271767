//! `vr verify`.

use serde::Serialize;
use vr_core::{Control, StudiedRenderer};
use vr_study::StudyError;
use vr_study::convergence::{Convergence, OrderCheck, Outcome};

use crate::args::VerifyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::progress::under_bar;
use crate::scene_setup::{Setup, named_scene};
use crate::table::Table;
use crate::{exact_cache, renderers};

/// Puts every documented order of convergence to the test.
///
/// # Errors
/// Any fault of the command line, the volume, or the scene; an order that is not as documented.
pub fn run(args: &VerifyArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    // Choose the renderers that document an order.
    let chosen = renderers::chosen(&args.renderers)?;
    let chosen: Vec<Box<dyn StudiedRenderer>> = chosen.into_iter().filter(|r| !r.convergence().is_empty()).collect();
    if chosen.is_empty() {
        return Err(Failure::usage(format!(
            "--renderer: found {}; must name one that documents an order of convergence",
            args.renderers.join(", ")
        )));
    }
    let setup = named_scene(&args.scene, console)?;
    if let Some(setup) = &setup {
        setup.note_unused_renderer("orders are measured under settings of their own", console);
    }
    // Verify on scenes made for each renderer, or on the scene that flags name.
    let cache = exact_cache::open(&args.cache, console);
    let proven = under_bar(console, control, "verifying", |progress| {
        let check = OrderCheck { cache: &cache, control };
        let mut results = Vec::new();
        for (i, renderer) in chosen.iter().enumerate() {
            let share = |s: f64| progress.report((i as f64 + s) / chosen.len() as f64);
            match &setup {
                None => results.extend(check.check_claims(&**renderer, &share)?),
                Some(setup) => {
                    let Setup { title, scene, view, .. } = setup;
                    results.extend(check.step_on(&**renderer, (title, scene, view), &|s| share(0.8 * s))?);
                    match check.grid_of(&**renderer, (title, scene))? {
                        Some(grid) => results.push(grid),
                        None => console.note("the grid is not refined: no whole, unshaded trilinear field"),
                    }
                }
            }
        }
        Ok(results)
    });
    let results = proven.map_err(|e: StudyError| match (e, &setup) {
        (StudyError::Render(e), Some(setup)) => setup.render_failure(e),
        (other, _) => Failure::failed(other),
    })?;
    let failing = results.iter().filter(|c| c.outcome() == Outcome::Fails).count();
    let held = results.iter().filter(|c| c.outcome().is_held()).count();
    console.result(&text(&results), &json(&results))?;
    match failing {
        0 if held == 0 => Err(Failure::failed("no order could be verified on this scene")),
        0 => Ok(()),
        n => Err(Failure::failed(format!("{n} of {} orders are not as documented", results.len()))),
    }
}

fn text(results: &[Convergence]) -> String {
    let mut table =
        Table::new(&["renderer, claim", "refined", "documented", "measured", "verdict", "errors, coarse to fine"]);
    for c in results {
        let errors: Vec<String> = c.errors.iter().map(|e| format!("{e:.1e}")).collect();
        table.row([
            format!("{} {}", c.renderer, c.claim),
            c.refined.word().to_owned(),
            format!("{} ± {}{}", c.expected, c.tolerance, if c.at_least { ", or more" } else { "" }),
            c.measured.map_or_else(|| "-".to_owned(), |m| format!("{m:.2}")),
            c.trouble.clone().unwrap_or_else(|| c.outcome().word().to_owned()),
            errors.join(" "),
        ]);
    }
    let scene = results.first().map_or("", |c| c.scene.as_str());
    let held = results.iter().filter(|c| c.outcome().is_held()).count();
    format!("on {scene}\n\n{table}\n{held} of {} orders are as documented\n", results.len())
}

#[derive(Serialize)]
struct Json<'a> {
    orders: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    #[serde(flatten)]
    convergence: &'a Convergence,
    outcome: Outcome,
}

fn json(results: &[Convergence]) -> Json<'_> {
    let entry = |convergence| Entry { convergence, outcome: Convergence::outcome(convergence) };
    Json { orders: results.iter().map(entry).collect() }
}
