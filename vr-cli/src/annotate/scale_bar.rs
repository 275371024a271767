//! Scale bar: a round length, as long as it is in the picture.

use vr_core::{Projection, View};

use super::{round, sheet::Sheet};
use crate::{number, text};

/// Metric units, each a thousand of the one before.
const METRIC: [&str; 6] = ["pm", "nm", "µm", "mm", "m", "km"];
/// Largest part of the picture's width that the bar takes.
const MAX_SHARE: f64 = 0.22;

/// Round length beside its bar.
#[derive(Debug, PartialEq)]
pub struct ScaleBar {
    /// Length in pixels.
    pixels: f32,
    label: String,
}

impl ScaleBar {
    /// Makes the bar of a view whose world has a unit of length, if it is known. Exact under an orthographic camera; under perspective it holds at the
    /// distance of the camera's target, which the label says.
    pub fn new(view: &View, unit: Option<&str>) -> Self {
        let [width, height] = view.size.map(f64::from);
        let (world_height, where_it_holds) = match view.camera.projection {
            Projection::Orthographic { height } => (height, ""),
            Projection::Perspective { fov } => {
                let distance = (view.camera.target - view.camera.eye).length();
                (2.0 * distance * (0.5 * fov.to_radians()).tan(), " at centre")
            }
        };
        let pixel = world_height / height;
        let (shift, unit) = readable(MAX_SHARE * width * pixel, unit);
        let length = round::below(MAX_SHARE * width * pixel * shift);
        let gap = if unit.is_empty() { "" } else { "\u{a0}" };
        let label = format!("{}{gap}{unit}{where_it_holds}", number::value(length));
        Self { pixels: (length / shift / pixel) as f32, label }
    }

    /// Draws the bar in the lower right corner; false where there is no room for it.
    pub fn draw(&self, sheet: &mut Sheet<'_>) -> bool {
        let ([w, h], line) = (sheet.size(), sheet.line);
        let label = text::width(&self.label, line);
        let size = [label.max(self.pixels), 1.55 * line];
        let corner = [w - sheet.margin - size[0], h - sheet.margin - size[1]];
        if !sheet.reserve(corner, size) {
            return false;
        }
        let middle = corner[0] + 0.5 * size[0];
        let mut mask = text::mask(&self.label, [middle - 0.5 * label, corner[1]], line);
        sheet.ink(&mask);
        // The ends of the bar are the outer edges of its ticks.
        let (left, right, bottom) = (middle - 0.5 * self.pixels, middle + 0.5 * self.pixels, h - sheet.margin);
        let thick = 1.5 * sheet.hairline();
        let tick = 0.45 * line;
        mask = sheet.mask([left - 1.0, bottom - tick - 1.0], [self.pixels + 2.0, tick + 2.0]);
        mask.add_rectangle([left, bottom - thick], [self.pixels, thick]);
        mask.add_rectangle([left, bottom - tick], [thick, tick - thick]);
        mask.add_rectangle([right - thick, bottom - tick], [thick, tick - thick]);
        sheet.ink(&mask);
        true
    }
}

/// Returns the factor that turns a length to a unit in which it reads well, and that unit; a unit that is not metric is kept.
fn readable(length: f64, unit: Option<&str>) -> (f64, &str) {
    let unit = unit.unwrap_or_default();
    let Some(own) = METRIC.iter().position(|m| *m == unit) else { return (1.0, unit) };
    let (mut shift, mut place) = (1.0, own);
    while length * shift < 1.0 && place > 0 {
        (shift, place) = (shift * 1000.0, place - 1);
    }
    while length * shift >= 1000.0 && place + 1 < METRIC.len() {
        (shift, place) = (shift / 1000.0, place + 1);
    }
    (shift, METRIC[place])
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::Camera;

    use super::*;

    fn bar(projection: Projection, unit: Option<&str>) -> ScaleBar {
        let camera = Camera { eye: DVec3::Z * 100.0, target: DVec3::ZERO, up: DVec3::Y, projection };
        ScaleBar::new(&View::new(camera, [1000, 500]), unit)
    }

    #[test]
    fn a_bar_is_as_long_as_it_says() {
        // A pixel is 0.4: at most 88 in 220 pixels.
        let found = bar(Projection::Orthographic { height: 200.0 }, Some("mm"));
        assert_eq!(found, ScaleBar { pixels: 125.0, label: "50\u{a0}mm".into() });
        let found = bar(Projection::Orthographic { height: 200.0 }, None);
        assert_eq!(found.label, "50");
        let fov = 2.0f64.atan2(2.0).to_degrees() * 2.0;
        let found = bar(Projection::Perspective { fov }, Some("parsec"));
        assert_eq!((found.pixels, found.label.as_str()), (125.0, "50\u{a0}parsec at centre"));
    }

    #[test]
    fn units_are_those_that_read_well() {
        let label = |height: f64, unit| bar(Projection::Orthographic { height }, Some(unit)).label;
        assert_eq!(label(0.2, "mm"), "50\u{a0}µm");
        assert_eq!(label(2e6, "µm"), "500\u{a0}mm");
        assert_eq!(label(2.0e-7, "pm"), "5e-8\u{a0}pm");
        assert_eq!(label(200.0, "cm"), "50\u{a0}cm");
    }
}
