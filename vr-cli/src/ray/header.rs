//! Header before the drawing: the ray, its pixel, and the causes of its error.

use vr_physics::Certainty;
use vr_study::ray::{CHANNELS, RayAccount};

use super::{causes, figures};
use crate::number;
use crate::scene_setup::Setup;

/// Returns the header: the pixel, the ray, both sums, their difference, and its causes.
pub fn text(setup: &Setup, account: &RayAccount<'_>) -> String {
    let RayAccount { renderer, view, pixel: [x, y], ray, .. } = account;
    let [w, h] = view.size;
    let mut text = String::new();
    let mut line = |name: &str, words: String| text += &format!("{name:<9}{words}\n");
    line("pixel", format!("{x}, {y} of {w}x{h}; {}; {}", setup.title, setup.scene.compositing.name()));
    let triple = |v: [f64; 3]| number::triple(v.map(number::value), ", ");
    line("ray", format!("from {} along {}", triple(ray.origin.to_array()), triple(ray.direction.to_array())));
    match account.chord() {
        None => line("", "it misses the volume, or what the clip leaves of it".to_owned()),
        Some([from, to]) => {
            let parts = account.segments.len();
            let [faces, knots] = crossed(account);
            let extent = [from, to, to - from].map(number::value);
            let [from, to, length] = extent;
            line(
                "",
                format!(
                    "in the volume from s = {from} to {to}, {length} long; {faces} faces, {knots} knots; {parts} parts"
                ),
            );
        }
    }
    let depth =
        |depth: f64| if depth.is_finite() { format!(", at s = {}", number::value(depth)) } else { String::new() };
    let drawn_depth = account.depth.map_or_else(String::new, |d| depth(f64::from(d)));
    line(renderer, components(account.rgba, number::value) + &drawn_depth);
    let certainty = match account.exact.certainty {
        Certainty::Bound(e) => format!("proven within {}", number::small(e)),
        Certainty::Estimate(e) => format!("within an estimated {}", number::small(e)),
    };
    line("exact", components(account.exact.rgba, number::value) + &depth(account.exact.depth) + "; " + &certainty);
    line("error", components(account.error(), figures::signed));
    match &account.probe {
        None => line(
            "steps",
            format!("{renderer} cannot list its steps along a ray with these options; below is the reference alone"),
        ),
        Some(probe) => {
            let samples: usize = probe.steps.iter().map(|step| step.samples.len()).sum();
            let mut words = format!("{} steps, {samples} samples", probe.steps.len());
            if let (true, Some(last)) = (probe.ended_early, probe.steps.last()) {
                words += &format!("; ended early, at s = {}", number::value(last.end()));
            }
            line("steps", words);
            if !probe.own_kernel {
                line(
                    "",
                    "listed by a plain kernel: pictures are drawn by vector code, the same to rounding (about 1e-5)"
                        .to_owned(),
                );
            }
        }
    }
    if let Some(model) = &account.model {
        line("", format!("the field is not the scene's: {renderer} integrates {model}, and the error is of both"));
    }
    if setup.view.supersampling > 1 {
        let n = setup.view.supersampling;
        line("", format!("the picture's pixel is the mean of {n}x{n} rays; this is the one through its centre"));
    }
    causes::lines(account).into_iter().enumerate().for_each(|(i, words)| line(if i == 0 { "why" } else { "" }, words));
    text
}

fn components(rgba: [f64; 4], figure: impl Fn(f64) -> String) -> String {
    CHANNELS.iter().zip(rgba).map(|(name, x)| format!("{name} {}", figure(x))).collect::<Vec<_>>().join("  ")
}

/// Counts the faces and knots on the whole ray.
fn crossed(account: &RayAccount<'_>) -> [usize; 2] {
    let cuts = || account.segments.iter().flat_map(|segment| &segment.front);
    let faces = cuts().filter(|cut| matches!(cut, vr_core::field::Cut::Face { .. })).count();
    let knots = cuts().filter(|cut| matches!(cut, vr_core::field::Cut::Knot { .. })).count();
    [faces, knots]
}
