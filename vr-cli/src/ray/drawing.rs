//! Drawing of the ray in the terminal: what it meets, its sum, and where the renderer leaves the reference.

use vr_core::RenderError;
use vr_core::field::Cut;
use vr_study::ray::{CHANNELS, RayAccount, RayPart, Row};

use super::figures;
use super::plot::{MARGIN, Plot, counts, scale};

/// Number of characters along the ray, and of dots.
const COLUMNS: usize = 78;
const DOTS: usize = 2 * COLUMNS;

/// Returns all curves; nothing for a ray that misses the volume.
///
/// # Errors
/// Errors of the reference, for a scene that it cannot solve.
pub fn text(account: &RayAccount<'_>) -> Result<String, RenderError> {
    let Some(extent) = account.extent() else { return Ok(String::new()) };
    let drawing = Drawing::new(account, extent)?;
    let mut text = format!("\n{}\n", drawing.legend());
    text += &drawing.values();
    if drawing.shows_light() {
        text += &drawing.opacity();
        text += &drawing.sums();
        if !account.rows.is_empty() {
            text += &drawing.error();
        }
    }
    Ok(text + &drawing.marks() + &drawing.axis())
}

struct Drawing<'a> {
    account: &'a RayAccount<'a>,
    from: f64,
    to: f64,
    /// The reference, dot by dot.
    dots: Vec<RayPart>,
}

impl<'a> Drawing<'a> {
    fn new(account: &'a RayAccount<'a>, [from, to]: [f64; 2]) -> Result<Self, RenderError> {
        Ok(Self { account, from, to, dots: account.profile([from, to], DOTS)? })
    }

    /// True if light is integrated, and there is some.
    fn shows_light(&self) -> bool {
        let drawn = |row: &Row| row.light.is_some_and(|light| light.running != [0.0; 4]);
        self.account.rows.iter().any(drawn) || self.dots.iter().any(|dot| dot.exact != [0.0; 4])
    }

    fn legend(&self) -> String {
        let RayAccount { rows, renderer, .. } = self.account;
        let mut text = "along the ray: the reference in dots".to_owned();
        if !rows.is_empty() {
            text += &format!(", × {renderer} where it is elsewhere");
        }
        if self.account.has_light() && !self.shows_light() {
            text += "\n(nothing on the way absorbs or shines)";
        } else if self.account.has_light() {
            let color = CHANNELS[self.channel()];
            text +=
                &format!("\n(opacity: of the part under a character; {color} and clear, what comes through: so far");
            if !rows.is_empty() {
                text += &format!("; error: of {} so far", CHANNELS[self.account.channel()]);
            }
            text += ")";
        }
        text
    }

    /// Returns the part of the ray under a character.
    fn character(&self, x: usize) -> [f64; 2] {
        [border(self.from, self.to, COLUMNS, x), border(self.from, self.to, COLUMNS, x + 1)]
    }

    fn values(&self) -> String {
        let curve: Vec<_> = self.dots.iter().map(|dot| dot.values).collect();
        let samples = || self.account.rows.iter().flat_map(|row| &row.step.samples);
        let marks: Vec<_> = (0..COLUMNS)
            .map(|x| {
                let [a, b] = self.character(x);
                mean(samples().filter(|s| (a..b).contains(&s.at) && !s.value.is_nan()).map(|s| s.value))
            })
            .collect();
        let scale = scale(curve.iter().flatten().flatten().copied());
        Plot { name: "value", rows: 5, scale, curve: &curve, bars: false, marks: &marks }.text()
    }

    /// Draws the opacity of the part of the ray under each character: κ as far as it can be seen.
    fn opacity(&self) -> String {
        let alpha = |dots: &[RayPart]| 1.0 - dots.iter().map(|dot| dot.transparency).product::<f64>();
        let curve: Vec<_> = self.dots.chunks(DOTS / COLUMNS).flat_map(|dots| [Some([0.0, alpha(dots)]); 2]).collect();
        let marks: Vec<_> = (0..COLUMNS)
            .map(|x| {
                let [a, b] = self.character(x);
                let depth = |row: &Row| {
                    let (begin, end) = (row.step.begin, row.step.end());
                    let part = (end.min(b) - begin.max(a)).max(0.0) / row.step.length;
                    if part > 0.0 { row.step.depth() * part } else { 0.0 }
                };
                let depth: f64 = self.account.rows.iter().map(depth).sum();
                (!self.account.rows.is_empty()).then(|| -(-depth).exp_m1())
            })
            .collect();
        let values = curve.iter().flatten().flatten().copied().chain(marks.iter().flatten().copied());
        let top = scale(values)[1];
        Plot { name: "opacity", rows: 4, scale: [0.0, top], curve: &curve, bars: true, marks: &marks }.text()
    }

    /// Draws radiance and transmittance so far.
    fn sums(&self) -> String {
        let c = self.channel();
        let curve: Vec<_> = self.dots.iter().map(|dot| Some([dot.exact[c]; 2])).collect();
        let marks = self.drawn(|rgba| rgba[c]);
        let top = scale(curve.iter().flatten().flatten().copied().chain(marks.iter().flatten().copied()))[1];
        let mut text =
            Plot { name: CHANNELS[c], rows: 5, scale: [0.0, top], curve: &curve, bars: false, marks: &marks }.text();
        let curve: Vec<_> = self.dots.iter().map(|dot| Some([1.0 - dot.exact[3]; 2])).collect();
        let marks = self.drawn(|rgba| 1.0 - rgba[3]);
        text += &Plot { name: "clear", rows: 4, scale: [0.0, 1.0], curve: &curve, bars: false, marks: &marks }.text();
        text
    }

    /// Draws the renderer's sum minus the exact one: known where steps end, straight from one to the next.
    fn error(&self) -> String {
        let first = self.account.rows.first().map(|row| (row.step.begin, 0.0));
        let ends = self.account.rows.iter().filter_map(|row| Some((row.step.end(), row.light?.error)));
        let errors: Vec<(f64, f64)> = first.into_iter().chain(ends).collect();
        let curve: Vec<_> = (0..DOTS)
            .map(|i| at(&errors, border(self.from, self.to, DOTS, i + 1)).map(|e| [e.min(0.0), e.max(0.0)]))
            .collect();
        let scale = scale(curve.iter().flatten().flatten().copied());
        if curve.iter().flatten().all(|e| *e == [0.0; 2]) {
            return String::new();
        }
        Plot { name: "error", rows: 4, scale, curve: &curve, bars: false, marks: &[] }.text()
    }

    /// Draws the counts of the steps that begin, and of the faces and knots that are crossed, under each character.
    fn marks(&self) -> String {
        let along = |places: &mut dyn Iterator<Item = f64>| {
            let mut n = vec![0; COLUMNS];
            for s in places {
                let x = ((s - self.from) / (self.to - self.from) * COLUMNS as f64).floor();
                if (0.0..COLUMNS as f64).contains(&x) {
                    n[x as usize] += 1;
                }
            }
            n
        };
        let cuts = |of: fn(&Cut) -> bool| {
            let segments = self.account.segments.iter();
            along(&mut segments.flat_map(move |s| s.front.iter().filter(move |cut| of(cut)).map(|_| s.from)))
        };
        let mut text = String::new();
        if !self.account.rows.is_empty() {
            text += &counts("steps", &along(&mut self.account.rows.iter().map(|row| row.step.begin)));
        }
        text += &counts("faces", &cuts(|cut| matches!(cut, Cut::Face { .. })));
        text + &counts("knots", &cuts(|cut| matches!(cut, Cut::Knot { .. })))
    }

    fn axis(&self) -> String {
        let (from, to) = (figures::long(self.from), figures::long(self.to));
        let gap = COLUMNS.saturating_sub(from.chars().count());
        format!("{:>width$}└{}\n{:>width$} {from}{to:>gap$}\n", "", "─".repeat(COLUMNS), "s", width = MARGIN - 1)
    }

    /// Returns the colour whose sum is drawn: the one with the largest error, or the brightest.
    fn channel(&self) -> usize {
        let exact = self.account.exact.rgba;
        let brightest = (0..3).max_by(|&a, &b| exact[a].total_cmp(&exact[b])).unwrap_or(0);
        Some(self.account.channel()).filter(|&c| c < 3 && !self.account.rows.is_empty()).unwrap_or(brightest)
    }

    /// Returns the renderer's sum at the middle of each character.
    fn drawn(&self, of: impl Fn([f64; 4]) -> f64) -> Vec<Option<f64>> {
        let middle = |x: usize| self.character(x).iter().sum::<f64>() * 0.5;
        (0..COLUMNS).map(|x| self.account.running_at(middle(x)).map(&of)).collect()
    }
}

fn border(from: f64, to: f64, parts: usize, i: usize) -> f64 {
    from + (to - from) * i as f64 / parts as f64
}

/// Interpolates linearly between points; before and behind all of them, takes the nearest.
fn at(points: &[(f64, f64)], s: f64) -> Option<f64> {
    let next = points.partition_point(|point| point.0 <= s);
    let (after, before) = (points.get(next), next.checked_sub(1).map(|i| points[i]));
    match (before, after) {
        (Some(a), Some(b)) if b.0 > a.0 => Some(a.1 + (s - a.0) / (b.0 - a.0) * (b.1 - a.1)),
        (Some(a), _) => Some(a.1),
        (None, b) => b.map(|b| b.1),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_between_points_are_straight() {
        let points = [(1.0, 0.0), (2.0, 4.0), (2.0, 4.0), (3.0, 6.0)];
        for (s, want) in [(0.0, 0.0), (1.5, 2.0), (2.0, 4.0), (2.5, 5.0), (9.0, 6.0)] {
            assert_eq!(at(&points, s), Some(want), "{s}");
        }
        assert_eq!(at(&[], 1.0), None);
        assert_eq!(mean([3.0, 1.0].into_iter()), Some(2.0));
    }
}
