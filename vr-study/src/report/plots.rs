//! Plots of a report.

use crate::convergence::{Convergence, Refined};
use crate::front::{THRESHOLDS, pareto_front};
use crate::point::Point;
use crate::scaling::{Grown, Growth};
use crate::study::SubjectResult;

use super::chart::{Chart, Look, Series};

/// Smallest error in a plot; smaller ones are drawn here: a logarithmic axis has no zero, and frames are f32.
const MIN_ERROR: f64 = 1e-9;

/// Returns the place of a point in a plot.
pub(super) fn place(point: &Point) -> (f64, f64) {
    let (time, error) = point.pair();
    (time, error.max(MIN_ERROR))
}

/// Returns the renderers in the order in which they appear.
pub(super) fn renderers(points: &[Point]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for p in points {
        if !names.contains(&p.renderer) {
            names.push(p.renderer.clone());
        }
    }
    names
}

/// Plots time against error: every point, and each renderer's front with the numbers of its rows in the table.
pub(super) fn speed_against_error(result: &SubjectResult) -> Chart {
    let mut series = Vec::new();
    for (k, name) in renderers(&result.points).iter().enumerate() {
        let own: Vec<usize> = (0..result.points.len()).filter(|&i| result.points[i].renderer == *name).collect();
        let places: Vec<(f64, f64)> = own.iter().map(|&i| place(&result.points[i])).collect();
        let front = pareto_front(&places);
        let points: Vec<(f64, f64)> = front.iter().map(|&i| places[i]).collect();
        let rest: Vec<usize> = (0..own.len()).filter(|i| !front.contains(i)).collect();
        let labels = front.iter().map(|&i| (own[i] + 1).to_string()).collect();
        series.push(Series { name: name.clone(), points, labels, color: k, look: Look::Line });
        let points = rest.iter().map(|&i| places[i]).collect();
        series.push(Series { name: String::new(), points, labels: Vec::new(), color: k, look: Look::Points });
    }
    Chart {
        title: "Time and error of every setting",
        x: "milliseconds a frame",
        y: "RMSE",
        series,
        levels: &THRESHOLDS,
    }
}

/// Plots the errors of every claim of a renderer as one quantity is refined, beside the documented slope.
pub(super) fn orders(results: &[&Convergence], refined: Refined) -> Chart {
    let shown: Vec<&&Convergence> =
        results.iter().filter(|c| c.refined == refined && c.errors.len() > 1 && c.measured.is_some()).collect();
    let mut series = Vec::new();
    for (k, c) in shown.iter().enumerate() {
        let points: Vec<(f64, f64)> = c.sizes.iter().copied().zip(c.errors.iter().copied()).collect();
        let measured = c.measured.map_or(String::new(), |m| format!(" {m:.2}"));
        let name = format!("{}{measured} ({})", c.claim, c.expected);
        let (h, e) = points[0];
        let guide = points.iter().map(|p| (p.0, e * (p.0 / h).powf(c.expected))).collect();
        series.push(Series { name: String::new(), points: guide, labels: Vec::new(), color: k, look: Look::Guide });
        series.push(Series { name, points, labels: Vec::new(), color: k, look: Look::Line });
    }
    let x = match refined {
        Refined::Step | Refined::StepAtJumps => "step in voxels",
        Refined::StepOnLevels | Refined::StepOnUnevenAxes => "step in cells",
        Refined::Grid => "distance of samples (the volume is 2 wide)",
        Refined::Pixels => "size of a pixel in patches",
    };
    Chart { title: refined.word(), x, y: "RMSE", series, levels: &[] }
}

/// Plots times as a quantity grows.
pub(super) fn growth(results: &[Growth], grown: Grown) -> Chart {
    let series: Vec<Series> = results
        .iter()
        .filter(|g| g.grown == grown)
        .enumerate()
        .map(|(k, g)| Series {
            name: g.exponent.map_or_else(|| g.renderer.clone(), |p| format!("{}: exponent {p:.2}", g.renderer)),
            points: g.sizes.iter().copied().zip(g.ms.iter().copied()).collect(),
            labels: Vec::new(),
            color: k,
            look: Look::Line,
        })
        .collect();
    Chart { title: grown.word(), x: grown.word(), y: "milliseconds a frame", series, levels: &[] }
}
