//! Points of a transfer function, by value alone or in rows by the gradient's magnitude.

use serde::{Deserialize, Serialize};
use vr_core::transfer::{TransferRow, srgb_to_linear};
use vr_core::{ControlPoint, OpacityRule, ParameterError, TransferFunction};

use super::sections::{ColorEncoding, TransferSection};

/// An entry of `[[transfer.rows]]`: the transfer function where the gradient has one magnitude.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransferRowSection {
    /// Magnitude of the gradient, in value per world unit.
    pub gradient: f64,
    /// The points, their colours as `transfer.colors` says.
    pub points: Vec<ControlPoint>,
}

/// Points of a transfer function that belongs to no rule and no unit distance yet.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule};
/// use vr_io::{TransferPoints, TransferRowSection};
///
/// let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
/// let by_value = TransferPoints::from(points.clone()).function(OpacityRule::Power, 1.0)?;
/// assert!(!by_value.has_rows());
/// let rows = vec![TransferRowSection { gradient: 2.0, points }];
/// assert!(TransferPoints::ByGradient(rows).function(OpacityRule::Power, 1.0)?.has_rows());
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum TransferPoints {
    /// Points of a function of the value.
    ByValue(Vec<ControlPoint>),
    /// Rows of a function of value and gradient magnitude.
    ByGradient(Vec<TransferRowSection>),
}

impl From<Vec<ControlPoint>> for TransferPoints {
    fn from(points: Vec<ControlPoint>) -> Self {
        Self::ByValue(points)
    }
}

impl From<&TransferFunction> for TransferPoints {
    fn from(transfer: &TransferFunction) -> Self {
        let row =
            |row: &TransferRow| TransferRowSection { gradient: row.gradient, points: row.transfer.points().to_vec() };
        match transfer.rows() {
            [] => Self::ByValue(transfer.points().to_vec()),
            rows => Self::ByGradient(rows.iter().map(row).collect()),
        }
    }
}

impl TransferPoints {
    /// Makes the transfer function.
    ///
    /// # Errors
    /// Those of [`TransferFunction::new`] and [`TransferFunction::of_rows`].
    pub fn function(self, rule: OpacityRule, unit_distance: f64) -> Result<TransferFunction, ParameterError> {
        match self {
            Self::ByValue(points) => TransferFunction::new(points, rule, unit_distance),
            Self::ByGradient(rows) => {
                let rows = rows.into_iter().map(|row| (row.gradient, row.points)).collect();
                TransferFunction::of_rows(rows, rule, unit_distance)
            }
        }
    }

    /// The points of a section with colours in linear light; `None` where it has neither points nor rows.
    ///
    /// # Errors
    /// A section with both.
    pub(crate) fn of_section(section: &TransferSection) -> Result<Option<Self>, ParameterError> {
        let points = match (&section.points, &section.rows) {
            (Some(_), Some(_)) => {
                let allowed = "must be absent beside points: each row has points of its own";
                return Err(ParameterError { field: "transfer.rows".into(), found: "rows".into(), allowed });
            }
            (Some(points), None) => Self::ByValue(points.clone()),
            (None, Some(rows)) => Self::ByGradient(rows.clone()),
            (None, None) => return Ok(None),
        };
        Ok(Some(match section.colors {
            ColorEncoding::Linear => points,
            ColorEncoding::Srgb => points.map(|p| ControlPoint { color: p.color.map(srgb_to_linear), ..*p }),
        }))
    }

    /// The same with every point changed.
    pub(crate) fn map(mut self, change: impl Fn(&ControlPoint) -> ControlPoint) -> Self {
        self.points_mut().for_each(|p| *p = change(p));
        self
    }

    /// All points, row after row.
    pub(crate) fn points(&self) -> impl Iterator<Item = &ControlPoint> {
        let (own, rows): (&[ControlPoint], &[TransferRowSection]) = match self {
            Self::ByValue(points) => (points, &[]),
            Self::ByGradient(rows) => (&[], rows),
        };
        own.iter().chain(rows.iter().flat_map(|row| &row.points))
    }

    fn points_mut(&mut self) -> impl Iterator<Item = &mut ControlPoint> {
        let (own, rows): (&mut [ControlPoint], &mut [TransferRowSection]) = match self {
            Self::ByValue(points) => (points, &mut []),
            Self::ByGradient(rows) => (&mut [], rows),
        };
        own.iter_mut().chain(rows.iter_mut().flat_map(|row| &mut row.points))
    }

    /// The same moved to another range of values, all rows alike. A range of one value is widened, so that the value lies in the middle.
    pub(crate) fn stretched(self, range: (f64, f64)) -> Self {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let own = self.points().fold(start, |(a, b), p| (a.min(p.value), b.max(p.value)));
        // Of no points, or of one, there is nothing to stretch.
        if self.points().count() < 2 { self } else { self.map(stretching(own, range)) }
    }
}

/// Returns the map of points from one range of values to another, which is widened if it has one value alone.
pub(crate) fn stretching((first, last): (f64, f64), range: (f64, f64)) -> impl Fn(&ControlPoint) -> ControlPoint {
    let (low, high) = if range.0 < range.1 { range } else { (range.0 - 0.5, range.0 + 0.5) };
    move |p| {
        let t = if first < last { (p.value - first) / (last - first) } else { 0.0 };
        ControlPoint { value: low + t * (high - low), ..*p }
    }
}

impl TransferSection {
    /// Describes a transfer function by its points, or its rows.
    pub(crate) fn describe(transfer: &TransferFunction) -> Self {
        let (points, rows) = match TransferPoints::from(transfer) {
            TransferPoints::ByValue(points) => (Some(points), None),
            TransferPoints::ByGradient(rows) => (None, Some(rows)),
        };
        Self {
            unit_distance: Some(transfer.unit_distance()),
            opacity_rule: transfer.rule(),
            points,
            rows,
            ..Self::default()
        }
    }
}
