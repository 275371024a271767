//! Random scenes whose transfer function has rows by the gradient.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{Compositing, ControlPoint, GradientMethod, Scene, Shading, TransferFunction, Volume};

use super::looks::filter;
use super::scenes::scene;
use crate::check::TestScene;

/// Row made of a transfer function without rows.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// Share of its opacity.
    share: f64,
    /// Channels by which its colours are turned.
    turn: usize,
    /// Way to the magnitude of the next row, as a share of the steepest slope there may be.
    gap: f64,
}

/// A scene whose transfer function has two to four rows, some of them clear: under every filter, lit by gradients of either kind or not, light gathered.
pub fn gradient_row_scene() -> impl Strategy<Value = TestScene> {
    let share = prop_oneof![1 => Just(0.0), 2 => 0.0..1.0];
    let rows = vec((share, 0..3usize, 0.005..0.5).prop_map(|(share, turn, gap)| Row { share, turn, gap }), 2..=4);
    let gradient = prop::sample::select(vec![GradientMethod::Analytic, GradientMethod::CentralDifferences]);
    let parts = (scene(), filter(), rows, prop::option::of(gradient), any::<bool>());
    parts.prop_filter_map("values too far apart for a slope", |(test, filter, rows, gradient, from_flat)| {
        let transfer = with_rows(&test.scene, &rows, from_flat)?;
        let shading = gradient.map(|gradient| Arc::new(Shading { gradient, ..Shading::default() }));
        let compositing = match test.scene.compositing {
            accumulate @ Compositing::Accumulate { .. } => accumulate,
            _ => Compositing::Over,
        };
        let TestScene { scene, view } = test;
        let scene = Scene { transfer: Arc::new(transfer), shading, compositing, ..scene.with_filter(filter) };
        Some(TestScene { scene, view })
    })
}

fn with_rows(scene: &Scene, rows: &[Row], from_flat: bool) -> Option<TransferFunction> {
    let Volume::Grid(grid) = &scene.volume else { return None };
    let (low, high) = grid.value_stats().range.unwrap_or_default();
    let spacing = grid.placement().spacing().min_element();
    let steepest = (f64::from(high) - f64::from(low)).max(1.0) * grid.calibration().slope.abs() / spacing;
    let mut magnitude = if from_flat { 0.0 } else { 0.1 * steepest };
    let rows = rows.iter().map(|row| {
        let points = scene.transfer.points().iter().map(|p| {
            let color = std::array::from_fn(|c| p.color[(c + row.turn) % 3]);
            // A row is no wall.
            ControlPoint { opacity: (p.opacity * row.share).min(0.999), color, ..*p }
        });
        let made = (magnitude, points.collect());
        magnitude += row.gap * steepest;
        made
    });
    TransferFunction::of_rows(rows.collect(), scene.transfer.rule(), scene.transfer.unit_distance()).ok()
}
