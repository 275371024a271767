//! Pieces of the transfer function over the values of a projected mesh, for vectors.

use vr_core::{OpacityRule, TransferFunction};

use super::projected::Projected;

/// A transfer function over values between 0 and 1.
pub(crate) struct Segments {
    pub(crate) pieces: Vec<Piece>,
    /// Colour and opacity at the lower end of each piece, and what is added up to the upper one.
    pub(crate) rows: Vec<[[f32; 4]; 2]>,
    /// Depths of an extinction of 1 (rule of extinction), or of a natural logarithm of 1 (power rule), for each unit of depth.
    pub(crate) dense: f32,
    pub(crate) rule: OpacityRule,
}

/// The piece between two values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Parts of the piece for each unit of value; 0 where it is constant.
    pub(crate) per_value: f64,
    pub(crate) is_clear: bool,
    /// Largest extinction for each unit of depth; infinite where it is a wall.
    pub(crate) steepest: f32,
    /// True if the logarithm of the power rule bends too much for the whole piece to be one stretch.
    pub(crate) bends: bool,
}

/// Largest change of opacity, as part of what is left of 1, over which the rule follows the logarithm: to 4·10⁻⁶ of its depth.
const BEND: f32 = 0.35;

/// True if the logarithm bends too much between two opacities.
#[inline(always)]
pub(crate) fn bends(a: f32, b: f32) -> bool {
    (b - a).abs() > BEND * (1.0 - a.max(b))
}

impl Segments {
    pub(crate) fn new(transfer: &TransferFunction, mesh: &Projected) -> Self {
        let ([low, range], [_, half]) = (mesh.value, mesh.depth);
        let on_range = |value: f64| (value - low) / range;
        let rule = transfer.rule();
        let segments = transfer.segments();
        let pieces = segments.iter().map(|s| {
            let [a, b] = [s.start.opacity, s.end.opacity];
            let finite = s.from.is_finite() && s.to.is_finite();
            Piece {
                from: on_range(s.from),
                to: on_range(s.to),
                per_value: if finite { range / (s.to - s.from) } else { 0.0 },
                is_clear: s.is_clear(),
                steepest: (transfer.extinction(a.max(b)) * half) as f32,
                bends: rule == OpacityRule::Power && finite && bends(a as f32, b as f32),
            }
        });
        let rows = segments.iter().map(|s| {
            let row = |o: &vr_core::transfer::Optical| {
                let [r, g, b] = o.color;
                [r, g, b, o.opacity]
            };
            let (start, end) = (row(&s.start), row(&s.end));
            let constant = !(s.from.is_finite() && s.to.is_finite());
            let grown = std::array::from_fn(|c| if constant { 0.0 } else { (end[c] - start[c]) as f32 });
            [start.map(|x| x as f32), grown]
        });
        let dense = match rule {
            OpacityRule::Extinction => transfer.extinction(1.0) * half,
            OpacityRule::Power => transfer.extinction(0.5) * half / std::f64::consts::LN_2,
        };
        Self { pieces: pieces.collect(), rows: rows.collect(), dense: dense as f32, rule }
    }

    /// Opacity at a fraction of a piece.
    #[inline(always)]
    pub(crate) fn opacity(&self, piece: usize, t: f32) -> f32 {
        let [start, grown] = &self.rows[piece];
        start[3] + grown[3] * t
    }

    /// No less than the extinction of an opacity, without its logarithm: −ln(1 − α) ≤ α/(1 − α).
    #[inline(always)]
    pub(crate) fn extinction_at_most(&self, opacity: f32) -> f32 {
        match self.rule {
            OpacityRule::Extinction => opacity * self.dense,
            OpacityRule::Power => opacity / (1.0 - opacity) * self.dense,
        }
    }

    /// Extinction of an opacity for each unit of depth.
    pub(crate) fn extinction(&self, opacity: f32) -> f32 {
        match self.rule {
            OpacityRule::Extinction => opacity * self.dense,
            OpacityRule::Power => -(-opacity).ln_1p() * self.dense,
        }
    }
}
