//! ImageJ's colour tables: 256 reds, greens and blues.

use vr_core::TransferFunction;

use super::display_color;

/// The colours at 256 values from the first point to the last.
pub(super) fn bytes(transfer: &TransferFunction) -> Vec<u8> {
    let points = transfer.points();
    let (low, high) = (points[0].value, points[points.len() - 1].value);
    let colors: Vec<[u8; 3]> = (0..256)
        .map(|k| display_color(transfer, low + (high - low) * f64::from(k) / 255.0))
        .map(|color| color.map(|c| (255.0 * c).round() as u8))
        .collect();
    (0..3).flat_map(|c| colors.iter().map(move |color| color[c])).collect()
}
