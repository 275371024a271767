//! `vr physics`.

use serde::Serialize;
use vr_core::Control;
use vr_light::{Ladder, LightModel, SceneFacts};

use crate::args::PhysicsArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::model_costs::{self, MeasuredCost};
use crate::number::{small, value};
use crate::progress::under_bar;
use crate::scene_setup::Setup;
use crate::table::Table;

/// Prints how light goes through a scene, which model of it the scene needs, and what each simpler one would cost.
///
/// # Errors
/// Any fault of the command line, the volume, or the scene.
pub fn run(args: &PhysicsArgs, console: Console, control: &Control) -> Result<(), Failure> {
    let setup = Setup::new(&args.scene, console)?;
    let ladder = Ladder::of(&setup.scene, &setup.view.clip, args.allowed).map_err(|e| setup.render_failure(e))?;
    let measured = match (args.measure, &setup.scene.scattering) {
        (true, Some(_)) => {
            let measure = |control: &Control| model_costs::measure((&setup.scene, &setup.view), control);
            under_bar(console, control, "measuring", measure).map_err(|e| setup.render_failure(e))?
        }
        (true, None) => {
            console.note("--measure: nothing scatters, and emission and absorption are exact");
            Vec::new()
        }
        (false, _) => Vec::new(),
    };
    let json = Json {
        facts: FactsJson::of(ladder.facts()),
        models: LightModel::ALL.map(|model| ModelJson {
            model: model.to_string(),
            bound: finite(ladder.cost(model)),
            measured: of_model(&measured, model),
        }),
        chosen: ladder.chosen().to_string(),
        notes: &setup.notes,
    };
    console.result(&text(&setup.title, &ladder, &measured, args.allowed), &json)
}

/// Returns the measured cost of a model, where there is one.
fn of_model(measured: &[MeasuredCost], model: LightModel) -> Option<MeasuredCost> {
    measured.iter().copied().find(|cost| cost.model == model)
}

/// Formats the facts of a scene and the cost of each model as text.
fn text(title: &str, ladder: &Ladder, measured: &[MeasuredCost], allowed: f64) -> String {
    let facts = ladder.facts();
    let mut lines = vec![format!("scene              {title}")];
    let mut line = |name: &str, words: String| lines.push(format!("{name:<17}  {words}"));
    line("extinction", format!("up to {} per world unit", value(facts.extinction)));
    line(
        "mean free path",
        match 1.0 / facts.extinction {
            path if path.is_finite() => {
                format!("{} world units or more; the longest way through is {}", value(path), value(facts.length))
            }
            _ => "light is never stopped".to_owned(),
        },
    );
    let thickness = |tau: f64| if tau.is_finite() { value(tau) } else { "infinite".to_owned() };
    line(
        "optical thickness",
        format!(
            "{} along an axis through the middle, at most {} anywhere",
            thickness(facts.thickness),
            thickness(facts.thickness_bound)
        ),
    );
    line(
        "albedo",
        if facts.albedo == 0.0 {
            "0: nothing is scattered".to_owned()
        } else {
            format!("up to {}", value(facts.albedo))
        },
    );
    line("effects", effects(facts));

    let header = ["model", "leaves out", "largest error of a pixel", "RMS error, measured (97.5 %)"];
    let columns = if measured.is_empty() { 3 } else { 4 };
    let mut table = Table::of_words(&header[..columns]);
    for model in LightModel::ALL {
        let cost = ladder.cost(model);
        let words = match cost {
            0.0 => "exact".to_owned(),
            _ if cost.is_finite() => format!("at most {}", small(cost)),
            _ => "no bound is known".to_owned(),
        };
        let found = of_model(measured, model);
        let found =
            found.map_or_else(String::new, |cost| format!("{}, at most {}", small(cost.rms), small(cost.at_most)));
        table.row([model.to_string(), model.leaves_out().to_owned(), words, found].into_iter().take(columns));
    }
    let reason = if allowed > 0.0 {
        format!("the simplest within {}", small(allowed))
    } else {
        "the simplest that is exact".to_owned()
    };
    format!("{}\n\n{table}\nneeded             {}, {reason}", lines.join("\n"), ladder.chosen())
}

/// The effects that exist, in words.
fn effects(facts: &SceneFacts) -> String {
    let all = [
        (facts.extinction * (1.0 - facts.albedo) > 0.0, "absorption"),
        (facts.emission > 0.0, "emission"),
        (facts.extinction * facts.albedo > 0.0, "scattering"),
        (facts.lit > 0.0, "light from outside"),
        (facts.has_surfaces, "light of surfaces"),
    ];
    let there: Vec<&str> = all.into_iter().filter(|(there, _)| *there).map(|(_, name)| name).collect();
    if there.is_empty() { "none: vacuum".to_owned() } else { there.join(", ") }
}

/// A number for JSON, which has no infinity.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

#[derive(Serialize)]
struct Json<'a> {
    facts: FactsJson,
    models: [ModelJson; 6],
    chosen: String,
    notes: &'a [String],
}

/// Facts; `null` is infinite.
#[derive(Serialize)]
struct FactsJson {
    extinction: Option<f64>,
    mean_free_path: Option<f64>,
    thickness: Option<f64>,
    thickness_bound: Option<f64>,
    albedo: f64,
    emission: Option<f64>,
}

impl FactsJson {
    fn of(facts: &SceneFacts) -> Self {
        Self {
            extinction: finite(facts.extinction),
            mean_free_path: finite(1.0 / facts.extinction),
            thickness: finite(facts.thickness),
            thickness_bound: finite(facts.thickness_bound),
            albedo: facts.albedo,
            emission: finite(facts.emission),
        }
    }
}

/// A model, and the bound of its error; `null` where none is known.
#[derive(Serialize)]
struct ModelJson {
    model: String,
    bound: Option<f64>,
    /// Error of pixels of this view, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<MeasuredCost>,
}
