//! `vr render --target-rmse`.

use std::time::Duration;

use serde::Serialize;
use vr_core::{Control, MIN_MAX_ERROR, Options, Rendered, StudiedRenderer};
use vr_study::candidate::candidates;
use vr_study::choose::{
    AimedPicture, BoundedRenderer, CONFIDENCE, Choice, ChoiceError, RmseEstimate, draw_aimed, draw_within,
};
use vr_study::reference::ReferenceCache;

use crate::args::RendererArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::number;
use crate::progress::under_bar;
use crate::render::Drawn;
use crate::renderers::{self, StatedRenderer};
use crate::scene_setup::Setup;

/// Choice of a renderer and its setting.
#[derive(Debug, Serialize)]
pub struct Chosen {
    target_rmse: f64,
    /// RMSE that the renderer aimed at, or the largest error of a pixel that it promised; absent after a search.
    #[serde(skip_serializing_if = "Option::is_none")]
    aim: Option<f64>,
    /// The setting's name.
    setting: String,
    /// The options that make it.
    options: Options,
    /// Number of settings that were tried on a small picture, or of aims on the whole one.
    tried: usize,
    /// Number of settings, of those tried, whose small picture was within the target.
    within: usize,
    /// Settings whose whole picture was not, though their small one was, and the bound of its RMSE.
    disappointed: Vec<(String, f64)>,
    /// The RMSE of this picture on the pixels that were compared, weighted so that it stands for all.
    rmse: f64,
    /// Bound of the RMSE of all pixels.
    rmse_at_most: f64,
    /// True if the bound is proven.
    proven: bool,
    /// One-sided confidence of a bound that is not proven.
    confidence: f64,
    /// Number of pixels that were compared.
    sample_pixels: usize,
    pixels: u64,
}

/// Draws with steps that aim at the target, and checks the picture on a sample; where the usual renderer or the named one cannot aim, or for a `search`, with the cheapest renderer and
/// setting whose RMSE is within the target; of the named renderer alone, if there is one.
///
/// # Errors
/// A target that no picture of floats can keep or that no setting reaches, an unknown renderer, or any fault of the scene.
pub fn draw(
    (target, search): (f64, bool),
    args: &RendererArgs,
    setup: &Setup,
    cache: &ReferenceCache,
    console: Console,
    control: &Control,
) -> Result<Drawn, Failure> {
    /// Smallest target: frames are f32.
    const MIN_TARGET: f64 = 1e-7;
    if !(target >= MIN_TARGET && target.is_finite()) {
        return Err(Failure::usage(format!("--target-rmse: found {target}; must be at least 1e-7: pictures are f32")));
    }
    setup.note_unused_renderer("--target-rmse chooses", console);
    let bounded = bounded(target);
    let pixels = setup.view.size.into_iter().map(u64::from).product();
    if !search {
        let usual = renderers::usual(&setup.scene);
        let renderer = renderers::named(args.renderer.as_deref().unwrap_or(usual)).map_err(Failure::usage)?;
        let aimed = draw_aimed(target, &*renderer, &bounded, (&setup.scene, &setup.view), (cache, control));
        if let Some(picture) = aimed.map_err(|e| setup.render_failure(e))? {
            let AimedPicture { renderer, aim, tried, rendered, times, error } = picture;
            let key = if error.proven { "max-error" } else { "rmse" };
            let setting = format!("{key}={}", number::small(aim));
            let chosen = Chosen::new(target, (setting, renderer.option_values()), (tried, 1), error, pixels);
            return Ok(drawn(&*renderer, rendered, times, Chosen { aim: Some(aim), ..chosen }));
        }
    }
    let only: Vec<String> = args.renderer.iter().cloned().collect();
    let candidates = candidates(&renderers::chosen(&only)?).map_err(Failure::failed)?;
    let choice = under_bar(console, control, "trying settings", |progress| {
        let progress = |share| progress.report(share);
        draw_within(target, &candidates, &bounded, (&setup.scene, &setup.view), cache, (control, &progress))
    });
    let choice = choice.map_err(|e| match e {
        ChoiceError::Render(e) => setup.render_failure(e),
        other => Failure::failed(other),
    })?;
    let Choice { candidate, rendered, times, error, trials, missed } = choice;
    let winner = &candidates[candidate];
    let within = trials.iter().filter(|r| r.error.upper <= target).count();
    let setting = (winner.setting.clone(), winner.options.clone());
    let chosen = Chosen {
        disappointed: missed.iter().map(|(i, e)| (candidates[*i].name(), e.upper)).collect(),
        ..Chosen::new(target, setting, (trials.len(), within), error, pixels)
    };
    Ok(drawn(&*winner.configured, rendered, times, chosen))
}

/// Returns the picture that was chosen, with all that is told of it.
fn drawn(
    renderer: &dyn StudiedRenderer,
    rendered: Rendered,
    [prepare, render]: [Duration; 2],
    chosen: Chosen,
) -> Drawn {
    Drawn {
        renderer: renderer.name().to_owned(),
        counts: rendered.stats.counts,
        frame: rendered.frame,
        prepare,
        render,
        error_bound: None,
        stated: StatedRenderer::of(renderer, None),
        chosen: Some(chosen),
    }
}

impl Chosen {
    /// Returns what is known of a picture of so many pixels by a setting, its name and its options.
    fn new(
        target_rmse: f64,
        (setting, options): (String, Options),
        (tried, within): (usize, usize),
        error: RmseEstimate,
        pixels: u64,
    ) -> Self {
        Self {
            target_rmse,
            aim: None,
            setting,
            options,
            tried,
            within,
            disappointed: Vec::new(),
            rmse: error.rmse,
            rmse_at_most: error.upper,
            proven: error.proven,
            confidence: CONFIDENCE,
            sample_pixels: error.pixels,
            pixels,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let Self { setting, tried, within, rmse, rmse_at_most, sample_pixels, pixels, target_rmse, .. } = self;
        let target = number::small(*target_rmse);
        let mut text = match self.aim {
            Some(_) if self.proven => {
                format!(
                    "chosen   {setting}: every pixel is within it, as no aim was seen to keep an RMSE of {target}\n"
                )
            }
            Some(_) => format!("chosen   {setting}: steps and rays that aim at this RMSE, for at most {target}\n"),
            None => format!(
                "chosen   {setting}: expected to be the cheapest of the {within} settings that were within RMSE {target} on a small picture, \
                 of {tried} tried\n"
            ),
        };
        for (name, rmse) in &self.disappointed {
            text += &format!("         not {name}: the RMSE of its whole picture may be {}\n", number::small(*rmse));
        }
        if self.aim.is_some() && self.proven {
            // A promise tells no RMSE of its own.
            return text
                + &format!("target   RMSE at most {} on all {pixels} pixels, proven\n", number::small(*rmse_at_most));
        }
        let certainty = if self.proven {
            "proven".to_owned()
        } else {
            format!(
                "with a confidence of {:.0} %, if no pixel is further off than the worst of those",
                100.0 * self.confidence
            )
        };
        text + &format!(
            "target   RMSE {} on {sample_pixels} of {pixels} pixels; at most {} for all, {certainty}\n",
            number::small(*rmse),
            number::small(*rmse_at_most),
        )
    }
}

/// Returns the renderers that can prove a picture to be well within a target, by which others are judged.
fn bounded(target: f64) -> Vec<BoundedRenderer> {
    // An eighth is little beside the target, and costs little more than the target itself would. Pictures of floats keep no smaller bound.
    let max_error = (target / 8.0).max(MIN_MAX_ERROR);
    // A renderer that bounds its error by default draws as slowly as exact pixels are solved: it is no help.
    let quick = renderers::all().into_iter().filter(|renderer| renderer.max_error().is_none());
    let promising = |renderer: Box<dyn StudiedRenderer>| renderer.with_max_error(max_error)?.ok();
    quick.filter_map(promising).map(|renderer| BoundedRenderer { renderer, max_error }).collect()
}
