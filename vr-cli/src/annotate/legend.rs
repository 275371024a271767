//! Legend: colours and opacities of the transfer function over the values that show.

use vr_core::transfer::{Optical, TransferFunction};
use vr_core::{Compositing, Scene};

use super::{axis::Axis, sheet::Sheet};
use crate::{number, text};

/// Share of the largest opacity below which a value does not show.
const FAINT: f64 = 1.0 / 255.0;

/// Colour band of a transfer function with the values beside it, and its opacity, relative to the largest one, as a curve.
pub struct Legend {
    band: Band,
    unit: String,
}

/// Values that show.
enum Band {
    /// A single value: its colour and label.
    One([f32; 3], String),
    /// A range.
    Range { axis: Axis, entries: Vec<Entry> },
}

/// Colour and relative opacity of a small part of the range.
struct Entry {
    color: [f32; 3],
    strength: f32,
}

/// Number of parts that a range is divided into.
const ENTRIES: usize = 1024;

impl Legend {
    /// Makes the legend of a scene whose values have a unit, if it is known; `None` where no value shows.
    pub fn new(scene: &Scene, unit: Option<&str>) -> Option<Self> {
        let transfer = &*scene.transfer;
        let unit = unit.unwrap_or_default().to_owned();
        let optics = Optics::new(transfer);
        let one = |value: f64| Band::One(optics.color(&transfer.at(value)), number::value(value).replace('-', "−"));
        if let Compositing::First { threshold } = scene.compositing {
            return Some(Self { band: one(threshold), unit });
        }
        let (low, high) = optics.visible(scene.volume.value_range())?;
        let band = if low < high {
            let values: Vec<f64> = transfer.points().iter().map(|p| p.value).collect();
            let axis = Axis::new(low, high, &values);
            let entry = |i: usize| {
                let at = transfer.at(axis.value((i as f64 + 0.5) / ENTRIES as f64));
                Entry { color: optics.color(&at), strength: (optics.strength(&at) / optics.max) as f32 }
            };
            Band::Range { axis, entries: (0..ENTRIES).map(entry).collect() }
        } else {
            one(low)
        };
        Some(Self { band, unit })
    }

    /// Draws the legend at the right edge; false where there is no room for it.
    pub fn draw(&self, sheet: &mut Sheet<'_>) -> bool {
        let ([w, h], line) = (sheet.size(), sheet.line);
        let (height, ticks) = match &self.band {
            Band::One(_, label) => (line.round(), vec![(0.5, label.clone())]),
            Band::Range { axis, .. } => {
                let height = (0.45 * h).round();
                let ticks = axis.ticks(((height / (2.0 * line)) as usize).min(7));
                (height, ticks.into_iter().map(|(value, label)| (axis.place(value) as f32, label)).collect())
            }
        };
        let (band, tick, gap) = (line.round(), (0.35 * line).round(), 0.2 * line);
        let curve = if matches!(self.band, Band::Range { .. }) { (1.8 * line).round() } else { 0.0 };
        let labels = ticks.iter().map(|t| text::width(&t.1, line)).fold(0.0, f32::max);
        let unit = text::width(&self.unit, line);
        let width = (curve + band + tick + gap + labels).max(curve + band + tick + gap + unit);
        // Lines of the labels at both ends reach above and below; the unit stands above.
        let above = if self.unit.is_empty() { 0.6 * line } else { 1.7 * line };
        let corner = [(w - sheet.margin - width).round(), (0.5 * (h - height)).round()];
        let place = [corner[0], corner[1] - above];
        if height < line || width > 0.5 * w || !sheet.reserve(place, [width, height + above + 0.6 * line]) {
            return false;
        }
        let left = corner[0] + curve;
        let part = Part { corner: [left, corner[1]], size: [band, height], curve };
        match &self.band {
            Band::One(color, _) => part.draw(sheet, &[Entry { color: *color, strength: 0.0 }]),
            Band::Range { entries, .. } => part.draw(sheet, entries),
        }
        // Ticks, with the values in the middle of their lines beside them.
        let right = left + band + sheet.hairline();
        for (place, label) in &ticks {
            let y = corner[1] + (1.0 - place.clamp(0.0, 1.0)) * height;
            let thin = sheet.hairline();
            let mut mask = sheet.mask([right, y - thin], [tick, 2.0 * thin]);
            mask.add_rectangle([right, y - 0.5 * thin], [tick - thin, thin]);
            sheet.ink(&mask);
            let top = y - (text::BASELINE - 0.5 * text::CAPITALS) * line;
            sheet.text(label, [right + tick + gap, top], line);
        }
        if !self.unit.is_empty() {
            sheet.text(&self.unit, [right + tick + gap, place[1] - 0.1 * line], line);
        }
        true
    }
}

/// The band and the curve of opacity to its left.
struct Part {
    corner: [f32; 2],
    size: [f32; 2],
    /// Width of the curve at its largest.
    curve: f32,
}

impl Part {
    fn draw(&self, sheet: &mut Sheet<'_>, entries: &[Entry]) {
        let ([left, top], [width, height]) = (self.corner, self.size);
        let thin = sheet.hairline();
        let whole = || {
            sheet.mask([left - self.curve - thin, top - thin], [self.curve + width + 2.0 * thin, height + 2.0 * thin])
        };
        // The outline of the curve, the lowest value at the bottom.
        let entry = |row: usize| {
            let place = 1.0 - (row as f32 + 0.5) / height;
            &entries[((place * entries.len() as f32) as usize).min(entries.len() - 1)]
        };
        let rows = height as usize;
        let reach = |row: usize| left - self.curve * entry(row).strength.clamp(0.0, 1.0);
        let steps = (0..rows).map(|row| [reach(row), top + row as f32 + 0.5]);
        let ends = |y: f32, row: usize| [[left, y], [reach(row), y]];
        let mut outline: Vec<[f32; 2]> = ends(top, 0).to_vec();
        outline.extend(steps);
        outline.extend(ends(top + height, rows - 1).into_iter().rev());
        let mut rim = whole();
        rim.add_polygon(&outline);
        rim.add_rectangle([left - thin, top - thin], [width + 2.0 * thin, height + 2.0 * thin]);
        // Ink, so that dark colours end somewhere on dark pictures; the colours leave an edge of it.
        let mut edge = whole();
        for pair in outline.windows(2).filter(|_| self.curve > 0.0) {
            edge.add_line(pair[0], pair[1], thin);
        }
        edge.add_rectangle([left - thin, top - thin], [width + 2.0 * thin, height + 2.0 * thin]);
        let rows: Vec<_> = (0..rows).map(|row| (entry(row).color, reach(row), top + row as f32)).collect();
        sheet.rim(&rim);
        sheet.color(&edge, sheet.ink);
        for (color, from, y) in rows {
            let mut mask = sheet.mask([from, y], [left + width - from, 1.0]);
            mask.add_rectangle([from, y], [left - thin - from, 1.0]);
            mask.add_rectangle([left, y], [width, 1.0]);
            sheet.color(&mask, color);
        }
    }
}

/// Light and opacity of a transfer function as its legend shows them.
struct Optics<'a> {
    transfer: &'a TransferFunction,
    /// Largest emission, where it is given on its own.
    emission: f64,
    /// Largest strength.
    max: f64,
}

impl<'a> Optics<'a> {
    fn new(transfer: &'a TransferFunction) -> Self {
        let mut optics = Self { transfer, emission: transfer.brightest_emission(), max: 0.0 };
        let strongest = |s: &vr_core::transfer::Segment| optics.strength(&s.start).max(optics.strength(&s.end));
        optics.max = transfer.segments().iter().map(strongest).fold(0.0, f64::max);
        optics
    }

    /// Opacity, or emission as a part of the largest one, whichever is more.
    fn strength(&self, at: &Optical) -> f64 {
        let emission = at.emission.into_iter().fold(0.0, f64::max);
        if self.emission > 0.0 { at.opacity.max(emission / self.emission) } else { at.opacity }
    }

    /// Colour of a value at its full strength.
    fn color(&self, at: &Optical) -> [f32; 3] {
        let color = if self.transfer.has_emission() {
            let largest = at.emission.into_iter().fold(f64::MIN_POSITIVE, f64::max);
            at.emission.map(|e| e / largest)
        } else {
            at.color
        };
        color.map(|c| c as f32)
    }

    /// Smallest and largest value that shows, of those that a volume has.
    fn visible(&self, values: Option<(f64, f64)>) -> Option<(f64, f64)> {
        let points = self.transfer.points();
        let ends = (points.first()?.value, points.last()?.value);
        let (least, most) = values.unwrap_or(ends);
        let faint = FAINT * self.max;
        let mut range: Option<(f64, f64)> = None;
        for segment in self.transfer.segments() {
            let (from, to) = (segment.from.max(least), segment.to.min(most));
            if from > to {
                continue;
            }
            let strengths = [from, to].map(|value| self.strength(&segment.at(value)));
            if self.max <= 0.0 || strengths.iter().all(|s| *s <= faint) {
                continue;
            }
            // The value at which a ramp leaves what is faint.
            let cross = from + (to - from) * (faint - strengths[0]) / (strengths[1] - strengths[0]);
            let low = if strengths[0] < faint { cross } else { from };
            let high = if strengths[1] < faint { cross } else { to };
            range = Some(range.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
        }
        range
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{ControlPoint, OpacityRule};

    use super::*;

    fn visible(points: &[(f64, f64)], values: (f64, f64)) -> Option<(f64, f64)> {
        let points = points.iter().map(|&(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity)).collect();
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        Optics::new(&transfer).visible(Some(values))
    }

    #[test]
    fn the_range_is_what_shows_of_what_the_volume_has() {
        let points = [(0.0, 0.0), (100.0, 0.0), (100.0, 0.5), (200.0, 0.5), (200.0, 0.0)];
        assert_eq!(visible(&points, (-50.0, 500.0)), Some((100.0, 200.0)));
        assert_eq!(visible(&points, (120.0, 150.0)), Some((120.0, 150.0)));
        assert_eq!(visible(&points, (-50.0, 50.0)), None);
        let ramp = [(0.0, 0.0), (255.0, 1.0)];
        let (low, high) = visible(&ramp, (0.0, 1000.0)).unwrap();
        assert!((low - 1.0).abs() < 1e-9 && high == 1000.0, "{low} {high}");
        assert_eq!(visible(&[(3.0, 0.0)], (0.0, 1.0)), None);
    }
}
