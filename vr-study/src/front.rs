//! What nothing else beats in both time and error.

use serde::{Deserialize, Serialize};

/// Errors that people ask for, and how tables write them: a hundredth, what 8 bits can show, a thousandth, a ten-thousandth.
pub const THRESHOLDS: [(f64, &str); 4] = [(1e-2, "1e-2"), (1.0 / 255.0, "1/255"), (1e-3, "1e-3"), (1e-4, "1e-4")];

/// Indices of the pairs (time, error) that no other pair beats or equals in both, by ascending time. Of equal pairs, the first counts;
/// those that are not finite do not.
pub fn pareto_front(pairs: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..pairs.len()).filter(|&i| pairs[i].0.is_finite() && pairs[i].1.is_finite()).collect();
    order.sort_by(|&a, &b| pairs[a].0.total_cmp(&pairs[b].0).then(pairs[a].1.total_cmp(&pairs[b].1)).then(a.cmp(&b)));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = pairs[i].1 < least;
        least = least.min(pairs[i].1);
        better
    });
    order
}

/// The index of the least time that reaches an error.
pub fn fastest_within(error: f64, pairs: &[(f64, f64)]) -> Option<usize> {
    (0..pairs.len()).filter(|&i| pairs[i].1 <= error).min_by(|&a, &b| pairs[a].0.total_cmp(&pairs[b].0))
}

/// A range of errors, and who is fastest for an error that is asked for within it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reign {
    /// The smallest error that it reaches: asked for less, somebody else wins.
    pub from: f64,
    /// The error above which somebody else is faster; `None`: nobody is.
    pub to: Option<f64>,
    /// Index of its fastest pair within the range.
    pub fastest: usize,
}

/// Who wins for which error: the front, neighbours of one name joined, by ascending error.
pub fn reigns(pairs: &[(f64, f64)], name: impl Fn(usize) -> String) -> Vec<Reign> {
    let mut reigns: Vec<Reign> = Vec::new();
    // Slowest, and so most exact, first.
    for &i in pareto_front(pairs).iter().rev() {
        match reigns.last_mut() {
            Some(last) if name(last.fastest) == name(i) => last.fastest = i,
            last => {
                if let Some(last) = last {
                    last.to = Some(pairs[i].1);
                }
                reigns.push(Reign { from: pairs[i].1, to: None, fastest: i });
            }
        }
    }
    reigns
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        let pairs = [(4.0, 1e-4), (1.0, 1e-2), (2.0, 2e-2), (2.0, 1e-3), (2.0, 1e-3), (f64::NAN, 0.0), (9.0, 1e-4)];
        assert_eq!(pareto_front(&pairs), [1, 3, 0]);
        assert_eq!(fastest_within(5e-3, &pairs), Some(3));
        assert_eq!(fastest_within(1e-9, &pairs[..5]), None);
        let names = ["a", "b", "b", "a", "a", "c", "c"];
        let reigns = reigns(&pairs, |i| names[i].to_owned());
        assert_eq!(
            reigns,
            [Reign { from: 1e-4, to: Some(1e-2), fastest: 3 }, Reign { from: 1e-2, to: None, fastest: 1 }]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn whoever_is_not_on_the_front_is_beaten_by_somebody_who_is(
            pairs in prop::collection::vec((0u8..12, 0u8..12), 1..40)
        ) {
            let pairs: Vec<(f64, f64)> = pairs.into_iter().map(|(a, b)| (a.into(), b.into())).collect();
            let front = pareto_front(&pairs);
            let beats = |a: usize, b: usize| pairs[a].0 <= pairs[b].0 && pairs[a].1 <= pairs[b].1;
            for i in 0..pairs.len() {
                let beaten = front.iter().any(|&f| f != i && beats(f, i));
                prop_assert_eq!(beaten, !front.contains(&i), "{} of {:?}", i, pairs);
            }
            prop_assert!(front.windows(2).all(|w| pairs[w[0]].0 < pairs[w[1]].0 && pairs[w[0]].1 > pairs[w[1]].1));
        }
    }
}
