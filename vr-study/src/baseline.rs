//! What a later version must not be worse than: errors and counts of work, no times.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::study::SubjectResult;

/// Errors and samples of every contestant on every subject, by name: `hydrogen` → `raycast midpoint 0.5` → figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Baseline(pub BTreeMap<String, BTreeMap<String, Figures>>);

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// RMSE against the canonical pixels, to four digits.
    pub rmse: f64,
    /// Largest error, to four digits.
    pub max: f64,
    /// Samples of the field.
    pub samples: u64,
}

/// By how much a figure may be worse: rounding differs between processors of different kinds.
const SLACK: f64 = 0.02;
/// What RMSE and largest errors may differ by, whatever they are: rounding.
const ROUNDING: [f64; 2] = [2e-8, 3e-7];

impl Baseline {
    /// The figures of a study.
    pub fn of(results: &[SubjectResult]) -> Self {
        let figures = |r: &SubjectResult| {
            let each = r.points.iter().map(|p| {
                let samples = p.counts.get("samples").copied().unwrap_or(0);
                (p.contestant(), Figures { rmse: four_digits(p.error.rmse), max: four_digits(p.error.max), samples })
            });
            each.collect()
        };
        Self(results.iter().map(|r| (r.name.clone(), figures(r))).collect())
    }

    /// What is worse in `now`, one line each: larger errors, more samples, and what is no longer there.
    pub fn regressions(&self, now: &Self) -> Vec<String> {
        let mut worse = Vec::new();
        for (subject, contestants) in &self.0 {
            for (contestant, then) in contestants {
                let Some(now) = now.0.get(subject).and_then(|c| c.get(contestant)) else {
                    worse.push(format!("{subject}: {contestant}: is not measured any more"));
                    continue;
                };
                let compared = [("RMSE", then.rmse, now.rmse), ("largest error", then.max, now.max)];
                for ((word, then, now), rounding) in compared.into_iter().zip(ROUNDING) {
                    // A NaN is worse than any number.
                    if now.is_nan() || now > then * (1.0 + SLACK) + rounding {
                        worse.push(format!("{subject}: {contestant}: {word} {now:.3e}, was {then:.3e}"));
                    }
                }
                if now.samples as f64 > then.samples as f64 * (1.0 + SLACK) {
                    worse.push(format!("{subject}: {contestant}: {} samples, were {}", now.samples, then.samples));
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
        let contestants = figures.iter().map(|(name, f)| ((*name).to_owned(), *f)).collect();
        Baseline([("fog".to_owned(), contestants)].into())
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
