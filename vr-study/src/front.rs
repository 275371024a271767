//! Front: the pairs of time and error that no other beats in both.

use serde::{Deserialize, Serialize};

/// Errors that are asked for, and their names in tables: a hundredth, what 8 bits can show, a thousandth, a ten-thousandth.
pub const THRESHOLDS: [(f64, &str); 4] = [(1e-2, "1e-2"), (1.0 / 255.0, "1/255"), (1e-3, "1e-3"), (1e-4, "1e-4")];

/// Returns the indices of the pairs (time, error) that no other pair beats or equals in both, by ascending time. Of equal pairs, the first counts;
/// those that are not finite do not.
pub fn pareto_front(pairs: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..pairs.len()).filter(|&i| pairs[i].0.is_finite() && pairs[i].1.is_finite()).collect();
    order.sort_by(|&a, &b| pairs[a].0.total_cmp(&pairs[b].0).then(pairs[a].1.total_cmp(&pairs[b].1)).then(a.cmp(&b)));
    let mut smallest = f64::INFINITY;
    order.retain(|&i| {
        let better = pairs[i].1 < smallest;
        smallest = smallest.min(pairs[i].1);
        better
    });
    order
}

/// Returns the index of the shortest time that reaches an error.
pub fn fastest_within(error: f64, pairs: &[(f64, f64)]) -> Option<usize> {
    (0..pairs.len()).filter(|&i| pairs[i].1 <= error).min_by(|&a, &b| pairs[a].0.total_cmp(&pairs[b].0))
}

/// Range of errors, and the pair that is fastest for an error within it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BestWithin {
    /// Smallest error that the pair reaches: below it, another one wins.
    pub from: f64,
    /// Error above which another pair is faster; `None` if none is.
    pub to: Option<f64>,
    /// Index of its fastest pair within the range.
    pub fastest: usize,
}

/// Returns the fastest pair for each error: the front, neighbours of one name joined, by ascending error.
pub fn best_within(pairs: &[(f64, f64)], name: impl Fn(usize) -> String) -> Vec<BestWithin> {
    let mut ranges: Vec<BestWithin> = Vec::new();
    // The slowest, and so the one with the smallest error, first.
    for &i in pareto_front(pairs).iter().rev() {
        match ranges.last_mut() {
            Some(last) if name(last.fastest) == name(i) => last.fastest = i,
            last => {
                if let Some(last) = last {
                    last.to = Some(pairs[i].1);
                }
                ranges.push(BestWithin { from: pairs[i].1, to: None, fastest: i });
            }
        }
    }
    ranges
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
        let ranges = best_within(&pairs, |i| names[i].to_owned());
        assert_eq!(
            ranges,
            [BestWithin { from: 1e-4, to: Some(1e-2), fastest: 3 }, BestWithin { from: 1e-2, to: None, fastest: 1 }]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn a_pair_off_the_front_is_beaten_by_one_on_it(
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
