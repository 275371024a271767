//! Causes of a pixel's error: the steps that make it wrong, and the events in them.

use vr_study::ray::{CHANNELS, RayAccount, Row};

use super::figures;
use crate::number;

/// Largest number of steps that are named.
const NAMED: usize = 3;
/// Error below which there is nothing to explain: the rounding of an f32.
const ROUNDING: f64 = 1e-6;

/// Returns the causes of the pixel's error, in a few lines; none where there is no error, or where the renderer cannot list its steps.
pub fn lines(account: &RayAccount<'_>) -> Vec<String> {
    let changes: Vec<(&Row, f64)> =
        account.rows.iter().filter_map(|row| row.light.map(|light| (row, light.change))).collect();
    let all: f64 = changes.iter().map(|(_, change)| change.abs()).sum::<f64>() + account.left_out().abs();
    if all < ROUNDING {
        return Vec::new();
    }
    let share = |of: &dyn Fn(&Row) -> bool| {
        let (mut count, mut sum, mut size) = (0, 0.0, 0.0);
        for (_, change) in changes.iter().filter(|(row, _)| of(row)) {
            count += 1;
            sum += change;
            size += change.abs();
        }
        (count, sum, size)
    };
    let knotted = |row: &Row| !row.knots.is_empty();
    let kinds = [
        ("with a knot of the transfer function that the value crosses", share(&knotted)),
        ("with vacuum in a part of the step", share(&|row| !knotted(row) && row.meets_vacuum)),
        ("between knots", share(&|row| !knotted(row) && !row.meets_vacuum)),
    ];
    let mut lines = vec![format!(
        "error of {}, the component with the largest error, as it grows from step to step:",
        CHANNELS[account.channel()]
    )];
    for (what, (count, sum, size)) in kinds {
        if count > 0 && size > 0.0 {
            let percent = 100.0 * size / all;
            let steps = if count == 1 { "step" } else { "steps" };
            lines.push(format!("{percent:3.0} % in {count} {steps} {what} (together {})", figures::signed(sum)));
        }
    }
    if account.left_out() != 0.0 {
        let percent = 100.0 * account.left_out().abs() / all;
        lines.push(format!("{percent:3.0} % behind the last step ({})", figures::signed(account.left_out())));
    }
    let mut largest = changes.clone();
    largest.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    for (row, change) in largest.into_iter().take(NAMED).filter(|(_, change)| change.abs() > 0.02 * all) {
        let [from, to] = [row.step.begin, row.step.end()].map(number::value);
        let mut words = format!("step {}, s = {from} to {to}: {}", row.number, figures::signed(change));
        if knotted(row) {
            words += &format!(", knots {}", figures::knots(&row.knots));
        }
        if row.meets_vacuum {
            words += ", vacuum";
        }
        lines.push(words);
    }
    lines
}
