//! Tables of value, red, green, blue and opacity, with their names in the first line.

use super::{TransferSource, display_points};

/// A row for each point.
pub(super) fn text(source: &TransferSource<'_>, separator: char) -> String {
    let joined = |cells: &[String]| cells.join(&separator.to_string()) + "\n";
    let mut text = joined(&["value", "red", "green", "blue", "opacity"].map(str::to_owned));
    for p in display_points(source.transfer) {
        let [r, g, b] = p.color;
        text += &joined(&[p.value, r, g, b, p.opacity].map(|x| x.to_string()));
    }
    text
}
