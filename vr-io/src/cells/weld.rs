//! Vertices of several pieces, made one where pieces meet.

use std::collections::HashMap;

use glam::DVec3;

/// Vertices of all pieces so far.
#[derive(Debug, Default)]
pub(super) struct Weld {
    pub positions: Vec<DVec3>,
    /// Values of the vertices, where they have any.
    pub values: Vec<f64>,
    /// Vertices that were made one with an earlier one.
    pub merged: usize,
    /// Those among them whose values differ.
    pub differing: usize,
    /// First vertex of each position.
    first: HashMap<[u64; 3], u32>,
}

/// Vertices that are made one with an earlier one at exactly the same place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Merge {
    /// None: there is one piece.
    Nothing,
    /// Those of other pieces: seams close.
    Seams,
    /// Besides these, those of the same piece with the same value: a lattice closes around an axis.
    SeamsAndFolds,
}

impl Weld {
    /// Takes in the vertices of a piece, with their values if they have any; returns the number that each has from now on.
    pub fn add(&mut self, positions: Vec<DVec3>, values: Vec<f64>, merge: Merge) -> Vec<u32> {
        let begin = self.positions.len();
        if merge == Merge::Nothing {
            let numbers = (begin..begin + positions.len()).map(|n| n as u32).collect();
            self.positions.extend(positions);
            self.values.extend(values);
            return numbers;
        }
        let mut numbers = Vec::with_capacity(positions.len());
        for (k, &at) in positions.iter().enumerate() {
            // The sum makes one zero of both.
            let key = (at + DVec3::ZERO).to_array().map(f64::to_bits);
            let value = values.get(k).copied();
            let new = self.positions.len() as u32;
            let found = *self.first.entry(key).or_insert(new);
            let same =
                value.is_none_or(|v| self.values.get(found as usize).is_some_and(|f| f.to_bits() == v.to_bits()));
            let is_seam = (found as usize) < begin;
            if found != new && (is_seam || merge == Merge::SeamsAndFolds && same) {
                self.merged += 1;
                self.differing += usize::from(!same);
                numbers.push(found);
            } else {
                self.positions.push(at);
                self.values.extend(value);
                numbers.push(new);
            }
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_close_and_folds_with_other_values_stay_open() {
        let at = vec![DVec3::ZERO, DVec3::X, DVec3::X];
        let mut weld = Weld::default();
        assert_eq!(weld.add(at.clone(), vec![1.0, 2.0, 3.0], Merge::SeamsAndFolds), [0, 1, 2]);
        assert_eq!(
            weld.add(vec![-DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Y], vec![1.0, 5.0, 6.0, 6.0], Merge::SeamsAndFolds),
            [0, 1, 3, 3]
        );
        assert_eq!((weld.merged, weld.differing, weld.values.len()), (3, 1, 4));
        let mut plain = Weld::default();
        assert_eq!(plain.add(at.clone(), vec![], Merge::Seams), [0, 1, 2], "one piece keeps its vertices");
        assert_eq!(Weld::default().add(at, vec![], Merge::SeamsAndFolds), [0, 1, 1]);
    }
}
