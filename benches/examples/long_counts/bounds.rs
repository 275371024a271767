//! Pictures under a bound of their error, beside the reference.

use vr_core::{Control, Model, RenderError, Renderer, Scene, View};
use vr_physics::{Certainty, Reference, Solution};
use vr_raycast::RayCaster;

/// Bounds that are asked for: those of `--max-error`.
pub const BOUNDS: [f64; 3] = [0.02, 0.004, 0.001];

/// Tolerance of the reference, a fiftieth of the smallest bound.
const TOLERANCE: f64 = 2e-5;

/// Share of a bound up to which the reference must be certain of a pixel for it to be judged.
const KNOWN: f64 = 0.1;

/// Pixels of a view, solved in f64.
pub struct Solved {
    pixels: Vec<[u32; 2]>,
    solution: Solution,
    /// max(1, largest magnitude): errors are in units of it.
    scale: f64,
}

impl Solved {
    /// Solves pixels of a view.
    pub fn new(scene: &Scene, view: &View, pixels: Vec<[u32; 2]>, control: &Control) -> Result<Self, RenderError> {
        let solution = Reference::new(TOLERANCE).solve_pixels(scene, view, &Model::Canonical, &pixels, control)?;
        let scale = solution.pixels.iter().flat_map(|p| p.rgba).fold(1.0, |m: f64, x| m.max(x.abs()));
        Ok(Self { pixels, solution, scale })
    }

    /// Draws the view under a bound, and compares; `None` where the ray caster has no bound for such scenes.
    pub fn judge(
        &self,
        bound: f64,
        scene: &Scene,
        view: &View,
        control: &Control,
    ) -> Result<Option<Judged>, RenderError> {
        let caster = RayCaster::default().with_max_error(bound).expect("a ray caster promises");
        let mut prepared = match caster?.prepare(scene, control) {
            Err(RenderError::Unsupported { .. }) => return Ok(None),
            prepared => prepared?,
        };
        let rendered = match prepared.render(view, control) {
            Err(RenderError::Unsupported { .. }) => return Ok(None),
            rendered => rendered?,
        };
        let mut judged = Judged { unbounded: rendered.stats.counts.unbounded, ..Judged::default() };
        let width = view.size[0] as usize;
        for (&[x, y], want) in self.pixels.iter().zip(&self.solution.pixels) {
            let uncertain = match want.certainty {
                Certainty::Bound(error) => error / self.scale,
                Certainty::Estimate(_) => f64::INFINITY,
            };
            if uncertain > KNOWN * bound {
                judged.unknown += 1;
                continue;
            }
            let got = rendered.frame.pixels()[y as usize * width + x as usize];
            // NaN is beyond every bound.
            let off = (0..4).map(|c| (f64::from(got[c]) - want.rgba[c]).abs() / self.scale);
            let off = off.fold(0.0, |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(x) });
            judged.pixels += 1;
            // The uncertainty of the reference does not count against the picture.
            let ratio = (off - uncertain).max(0.0) / bound;
            judged.beyond += u64::from(ratio > 1.0);
            judged.worst = judged.worst.max(ratio);
        }
        Ok(Some(judged))
    }
}

/// Comparison of a picture with the correct one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Judged {
    /// Pixels judged.
    pixels: u64,
    /// Pixels that the reference does not know well enough.
    unknown: u64,
    /// Pixels further off than asked for.
    beyond: u64,
    /// Pixels of the whole picture that the caster itself says it has no bound for.
    unbounded: u64,
    /// Largest error, in units of the bound.
    worst: f64,
}

impl Judged {
    /// True if more pixels are further off than the picture says.
    pub fn breaks_its_promise(&self) -> bool {
        self.beyond > self.unbounded
    }
}

/// Sums over pictures under one bound.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    refused: u64,
    pixels: u64,
    unknown: u64,
    unbounded: u64,
    broken: u64,
    /// Largest error of each picture without unbounded pixels, in units of the bound.
    worst: Vec<f64>,
}

impl Tally {
    /// Heading of [`row`](Self::row).
    pub const HEADING: &'static str =
        "pictures | refused | pixels | unknown | unbounded | median | 90 % | 99 % | largest | broken";

    /// Adds a picture; `None` is one that was refused.
    pub fn add(&mut self, judged: Option<Judged>) {
        let Some(judged) = judged else {
            self.refused += 1;
            return;
        };
        self.pixels += judged.pixels;
        self.unknown += judged.unknown;
        self.unbounded += judged.unbounded;
        self.broken += u64::from(judged.breaks_its_promise());
        self.worst.push(if judged.unbounded == 0 { judged.worst } else { 0.0 });
    }

    /// Adds the pictures of another.
    pub fn join(&mut self, other: &Self) {
        self.refused += other.refused;
        self.pixels += other.pixels;
        self.unknown += other.unknown;
        self.unbounded += other.unbounded;
        self.broken += other.broken;
        self.worst.extend_from_slice(&other.worst);
    }

    /// Returns a row of a table.
    pub fn row(&self) -> String {
        let mut sorted = self.worst.clone();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = sorted.len().checked_sub(1)?;
            Some(sorted[(share * last as f64).round() as usize])
        };
        let shown = |share: f64| at(share).map_or("-".to_owned(), |ratio| format!("{ratio:.3}"));
        format!(
            "{} | {} | {} | {} | {} | {} | {} | {} | {} | {}",
            sorted.len(),
            self.refused,
            self.pixels,
            self.unknown,
            self.unbounded,
            shown(0.5),
            shown(0.9),
            shown(0.99),
            shown(1.0),
            self.broken
        )
    }

    /// Returns the share of pictures whose largest error is in each tenth of the bound, and beyond it, in percent.
    pub fn distribution(&self) -> String {
        let mut counts = [0u64; 11];
        self.worst.iter().for_each(|&ratio| counts[((10.0 * ratio) as usize).min(10)] += 1);
        let all = self.worst.len().max(1) as f64;
        counts.map(|count| format!("{:.2}", 100.0 * count as f64 / all)).join(" | ")
    }
}
