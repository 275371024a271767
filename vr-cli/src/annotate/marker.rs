//! Orientation marker: the world's axes as the camera sees them.

use glam::{DMat3, DVec3};
use vr_core::{Camera, ParameterError};

use super::sheet::Sheet;
use crate::text;

/// Letters of the ends of the axes of a patient's world, which is RAS.
const PATIENT: [[&str; 2]; 3] = [["R", "L"], ["A", "P"], ["S", "I"]];
/// Letters of the ends of any other world's axes; the negative ones are not shown.
const OWN: [[&str; 2]; 3] = [["X", ""], ["Y", ""], ["Z", ""]];
/// Linear colours of the three axes.
const COLORS: [[f32; 3]; 3] = [[0.62, 0.05, 0.04], [0.05, 0.32, 0.06], [0.05, 0.19, 0.72]];

/// The world's axes, turned as the camera is.
pub struct Marker {
    ends: Vec<End>,
}

/// End of an axis.
struct End {
    letter: &'static str,
    /// Place in the picture: to the right, and down, in lengths of the axis.
    place: [f32; 2],
    /// Distance behind the middle of the marker, in lengths of the axis.
    depth: f32,
    color: [f32; 3],
}

impl Marker {
    /// Makes the marker of a camera. The axes are parallel to the world's, also under perspective.
    ///
    /// # Errors
    /// Errors of [`Camera::frame`].
    pub fn new(camera: &Camera, is_patient: bool) -> Result<Self, ParameterError> {
        let DMat3 { x_axis: right, y_axis: up, z_axis: forward } = camera.frame()?;
        let letters = if is_patient { PATIENT } else { OWN };
        let mut ends = Vec::new();
        for (axis, (letters, color)) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(letters.into_iter().zip(COLORS))
        {
            for (letter, sign, shade) in [(letters[0], 1.0, 1.0), (letters[1], -1.0, 0.45)] {
                let axis = sign * axis;
                let place = [right.dot(axis) as f32, -up.dot(axis) as f32];
                let color = color.map(|c: f32| c * shade);
                ends.push(End { letter, place, depth: forward.dot(axis) as f32, color });
            }
        }
        ends.retain(|end| !end.letter.is_empty());
        // The farthest is drawn first.
        ends.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        Ok(Self { ends })
    }

    /// Draws the marker in the lower left corner; false where there is no room for it.
    pub fn draw(&self, sheet: &mut Sheet<'_>) -> bool {
        let [w, h] = sheet.size();
        let disc = 0.6 * sheet.line;
        let side = (0.17 * w.min(h)).max(5.4 * sheet.line);
        let corner = [sheet.margin, h - sheet.margin - side];
        if side > 0.45 * w.min(h) || !sheet.reserve(corner, [side, side]) {
            return false;
        }
        let middle = corner.map(|c| c + 0.5 * side);
        let length = 0.5 * side - disc;
        let at = |end: &End| [middle[0] + length * end.place[0], middle[1] + length * end.place[1]];
        let width = 0.2 * sheet.line;
        let whole = || sheet.mask(corner, [side, side]);
        let stick = |end: &End| {
            let mut mask = whole();
            mask.add_line(middle, at(end), width);
            mask
        };
        let ball = |end: &End| {
            let mut mask = whole();
            // Nearer ends are a little larger.
            mask.add_disc(at(end), disc * (1.0 - 0.1 * end.depth) / 1.1);
            mask
        };
        let parts: Vec<_> = self.ends.iter().map(|end| (end, stick(end), ball(end))).collect();
        let mut all = whole();
        for (end, ..) in &parts {
            all.add_line(middle, at(end), width);
            all.add_disc(at(end), disc);
        }
        sheet.rim(&all);
        for (end, stick, ball) in &parts {
            sheet.color(stick, end.color);
            sheet.color(ball, end.color);
            let height = 1.05 * sheet.line;
            let [x, y] = at(end);
            let left = x - 0.5 * text::width(end.letter, height);
            // The middle of a capital stands in the middle of the disc.
            let top = y - (text::BASELINE - 0.5 * text::CAPITALS) * height;
            sheet.color(&text::mask(end.letter, [left, top], height), [1.0; 3]);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use vr_core::Projection;

    use super::*;

    #[test]
    fn a_patient_seen_from_the_front_has_the_head_up_and_the_right_side_left() {
        // RAS: the face looks towards +y.
        let camera = Camera {
            eye: DVec3::Y * 9.0,
            target: DVec3::ZERO,
            up: DVec3::Z,
            projection: Projection::Orthographic { height: 1.0 },
        };
        let marker = Marker::new(&camera, true).unwrap();
        let place = |letter: &str| marker.ends.iter().find(|end| end.letter == letter).unwrap().place;
        assert_eq!((place("S"), place("I")), ([0.0, -1.0], [0.0, 1.0]));
        assert_eq!((place("R"), place("L")), ([-1.0, 0.0], [1.0, 0.0]));
        assert_eq!((marker.ends[0].letter, marker.ends[5].letter), ("P", "A"), "far ones first");
        assert_eq!(Marker::new(&camera, false).unwrap().ends.len(), 3);
    }
}
