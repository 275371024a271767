//! Baseline: errors and counts of work, without times, than which a later version must not be worse.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::study::SubjectResult;

/// Errors and samples of every candidate on every subject, by name: `hydrogen` → `raycast midpoint 0.5` → figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Baseline(pub BTreeMap<String, BTreeMap<String, Figures>>);

/// Figures that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// RMSE against the reference, to four digits.
    pub rmse: f64,
    /// Largest error, to four digits.
    pub max: f64,
    /// Samples of the field.
    pub samples: u64,
}

/// Relative amount by which a figure may be worse: rounding differs between processors of different kinds.
const SLACK: f64 = 0.02;
/// Difference that RMSE and largest error may have at any size: rounding.
const ROUNDING: [f64; 2] = [2e-8, 3e-7];

impl Baseline {
    /// Returns the figures of a study.
    pub fn of(results: &[SubjectResult]) -> Self {
        let figures = |r: &SubjectResult| {
            let each = r.points.iter().map(|p| {
                let samples = p.counts.get("samples").copied().unwrap_or(0);
                (p.candidate(), Figures { rmse: four_digits(p.error.rmse), max: four_digits(p.error.max), samples })
            });
            each.collect()
        };
        Self(results.iter().map(|r| (r.name.clone(), figures(r))).collect())
    }

    /// Lists the figures that are worse in `now`, one line each: larger errors, more samples, and candidates that are no longer measured.
    pub fn regressions(&self, now: &Self) -> Vec<String> {
        let mut worse = Vec::new();
        for (subject, candidates) in &self.0 {
            for (candidate, then) in candidates {
                let Some(now) = now.0.get(subject).and_then(|c| c.get(candidate)) else {
                    worse.push(format!("{subject}: {candidate}: is not measured any more"));
                    continue;
                };
                let compared = [("RMSE", then.rmse, now.rmse), ("largest error", then.max, now.max)];
                for ((word, then, now), rounding) in compared.into_iter().zip(ROUNDING) {
                    // A NaN is worse than any number.
                    if now.is_nan() || now > then * (1.0 + SLACK) + rounding {
                        worse.push(format!("{subject}: {candidate}: {word} {now:.3e}, was {then:.3e}"));
                    }
                }
                if now.samples as f64 > then.samples as f64 * (1.0 + SLACK) {
                    worse.push(format!("{subject}: {candidate}: {} samples, were {}", now.samples, then.samples));
                }
            }
        }
        worse
    }
}

fn four_digits(x: f64) -> f64 {
    // JSON has no infinity.
    format!("{x:.3e}").parse().unwrap_or(x).min(f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(figures: &[(&str, Figures)]) -> Baseline {
        let candidates = figures.iter().map(|(name, f)| ((*name).to_owned(), *f)).collect();
        Baseline([("fog".to_owned(), candidates)].into())
    }

    #[test]
    fn what_is_worse_is_named_and_what_is_better_is_not() {
        let own = Figures { rmse: 1e-3, max: 1e-2, samples: 1000 };
        let then = of(&[("a", own)]);
        let complaints = |now: Figures| then.regressions(&of(&[("a", now)]));
        assert!(complaints(own).is_empty());
        assert!(complaints(Figures { rmse: 1e-4, max: 1e-3, samples: 10 }).is_empty());
        assert!(complaints(Figures { rmse: 1.01e-3, ..own }).is_empty(), "rounding of another processor");
        for (now, word) in [
            (Figures { rmse: 1.1e-3, ..own }, "RMSE"),
            (Figures { max: f64::NAN, ..own }, "largest error"),
            (Figures { samples: 1100, ..own }, "samples"),
        ] {
            let [line] = &complaints(now)[..] else { panic!("one complaint") };
            assert!(line.contains(word) && line.contains("fog: a"), "{line}");
        }
        assert_eq!(then.regressions(&of(&[("b", own)])).len(), 1);
        assert_eq!(four_digits(0.123_456), 0.1235);
    }
}
