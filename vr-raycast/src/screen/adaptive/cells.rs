//! Cells of the picture that are refined.

use crate::screen::blocks::in_blocks;

/// Set of cells between the points of a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cells {
    across: usize,
    down: usize,
    /// Marks of the cells, row by row.
    chosen: Vec<bool>,
}

impl Cells {
    /// Returns all cells between so many points across and down.
    pub(super) fn all(points: [usize; 2]) -> Self {
        let [across, down] = points.map(|n| n - 1);
        Self { across, down, chosen: vec![true; across * down] }
    }

    /// Returns those of these cells that are listed.
    pub(super) fn among(&self, list: &[[usize; 2]]) -> Self {
        let mut found = Self { chosen: vec![false; self.chosen.len()], ..*self };
        found.include(list, self);
        found
    }

    /// Returns the cells that have a corner among the marked points, which are listed row by row.
    pub(super) fn within(&self, marked: &[Vec<bool>]) -> Self {
        let mut found = self.clone();
        for (y, row) in found.rows_mut() {
            let (above, below) = (&marked[y], &marked[y + 1]);
            for (x, chosen) in row.iter_mut().enumerate() {
                *chosen &= above[x] | above[x + 1] | below[x] | below[x + 1];
            }
        }
        found
    }

    /// Marks the corners of the cells in a row of points.
    pub(super) fn corners_in_row(&self, y: usize) -> Vec<bool> {
        let mut corners = vec![false; self.across + 1];
        for row in [y.checked_sub(1), (y < self.down).then_some(y)].into_iter().flatten().map(|y| self.row(y)) {
            for (x, &chosen) in row.iter().enumerate() {
                corners[x] |= chosen;
                corners[x + 1] |= chosen;
            }
        }
        corners
    }

    /// Adds the cells of a list that are among others.
    pub(super) fn include(&mut self, list: &[[usize; 2]], among: &Self) {
        for &[x, y] in list.iter().filter(|[x, y]| *x < self.across && *y < self.down) {
            let i = y * self.across + x;
            self.chosen[i] |= among.chosen[i];
        }
    }

    /// Adds all cells of a set.
    pub(super) fn add(&mut self, others: &Self) {
        self.chosen.iter_mut().zip(&others.chosen).for_each(|(chosen, &other)| *chosen |= other);
    }

    /// Returns those that are not among others.
    pub(super) fn without(mut self, others: &Self) -> Self {
        self.chosen.iter_mut().zip(&others.chosen).for_each(|(chosen, &other)| *chosen &= !other);
        self
    }

    /// True if there are none.
    pub(super) fn is_empty(&self) -> bool {
        !self.chosen.contains(&true)
    }

    /// Returns these cells and all that touch them, as far as they are among others.
    pub(super) fn grown(&self, among: &Self) -> Self {
        let mut wide = self.clone();
        for (y, row) in wide.rows_mut() {
            let from = self.row(y);
            for x in 0..from.len() {
                let beside = (x > 0 && from[x - 1]) | from.get(x + 1).copied().unwrap_or(false);
                row[x] |= beside;
            }
        }
        let mut grown = wide.clone();
        for (y, row) in grown.rows_mut() {
            let neighbours = [y.checked_sub(1), (y + 1 < self.down).then_some(y + 1)];
            for from in neighbours.into_iter().flatten().map(|y| wide.row(y)) {
                row.iter_mut().zip(from).for_each(|(to, &from)| *to |= from);
            }
            row.iter_mut().zip(among.row(y)).for_each(|(to, &among)| *to &= among);
        }
        grown
    }

    /// Divides each cell into four.
    pub(super) fn quartered(&self) -> Self {
        let (across, down) = (2 * self.across, 2 * self.down);
        let mut quarters = Self { across, down, chosen: vec![false; across * down] };
        for (y, row) in quarters.rows_mut() {
            for (pair, &chosen) in row.chunks_exact_mut(2).zip(self.row(y / 2)) {
                pair.fill(chosen);
            }
        }
        quarters
    }

    /// Returns the cells on whose sides, or in which, a point of a grid so many times as fine is marked.
    pub(super) fn touching(&self, marked: &[Vec<bool>], times: usize) -> Self {
        let mut found = self.clone();
        for (y, row) in found.rows_mut() {
            let rows = &marked[y * times..=(y + 1) * times];
            for (x, chosen) in row.iter_mut().enumerate() {
                *chosen &= rows.iter().any(|row| row[x * times..=(x + 1) * times].contains(&true));
            }
        }
        found
    }

    /// Returns the number of these cells that are among others, too.
    pub(super) fn common(&self, others: &Self) -> usize {
        self.chosen.iter().zip(&others.chosen).filter(|(a, b)| **a && **b).count()
    }

    /// Returns the points of a grid so many times as fine, in these cells and on their sides, that `claim` accepts, cell by cell.
    pub(super) fn points(&self, times: u32, mut claim: impl FnMut([u32; 2]) -> bool) -> Vec<[u32; 2]> {
        let mut points = Vec::new();
        in_blocks([0; 2], [self.across as u32, self.down as u32], |[x, y]| {
            if self.chosen[y as usize * self.across + x as usize] {
                let inside = (0..=times).flat_map(|j| (0..=times).map(move |i| [times * x + i, times * y + j]));
                points.extend(inside.filter(|&point| claim(point)));
            }
        });
        points
    }

    /// Returns the corners of these cells that `claim` accepts; neighbours stay together.
    pub(super) fn corners(&self, mut claim: impl FnMut([u32; 2]) -> bool) -> Vec<[u32; 2]> {
        let mut points = Vec::new();
        in_blocks([0; 2], [self.across as u32, self.down as u32], |[x, y]| {
            if self.chosen[y as usize * self.across + x as usize] {
                points.extend((0..4).map(|k| [x + k % 2, y + k / 2]).filter(|&point| claim(point)));
            }
        });
        points
    }

    fn row(&self, y: usize) -> &[bool] {
        &self.chosen[y * self.across..][..self.across]
    }

    fn rows_mut(&mut self) -> impl Iterator<Item = (usize, &mut [bool])> {
        self.chosen.chunks_exact_mut(self.across).enumerate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(picture: &[&str]) -> Cells {
        let chosen = picture.iter().flat_map(|row| row.bytes().map(|b| b == b'#')).collect();
        Cells { across: picture[0].len(), down: picture.len(), chosen }
    }

    #[test]
    fn growth_stays_among_the_given_cells() {
        let seed = cells(&["....", ".#..", "....", "...."]);
        let among = cells(&["####", "##.#", "####", "####"]);
        assert_eq!(seed.grown(&among), cells(&["###.", "##..", "###.", "...."]));
    }

    #[test]
    fn corners_mark_the_cells_around_them() {
        let mut marked = vec![vec![false; 4]; 3];
        marked[1][1] = true;
        assert_eq!(Cells::all([4, 3]).within(&marked), cells(&["##.", "##."]));
    }

    #[test]
    fn corners_are_those_of_the_cells() {
        let one = cells(&["...", ".#."]);
        assert_eq!(one.corners_in_row(0), [false; 4]);
        for y in [1, 2] {
            assert_eq!(one.corners_in_row(y), [false, true, true, false]);
        }
    }

    #[test]
    fn sets_are_joined_and_taken_away() {
        let mut joined = cells(&["#..", "..."]);
        joined.add(&cells(&["..#", ".#."]));
        assert_eq!(joined, cells(&["#.#", ".#."]));
        let rest = joined.without(&cells(&["#.#", "..."]));
        assert_eq!(rest, cells(&["...", ".#."]));
        assert_eq!((rest.is_empty(), rest.clone().without(&rest).is_empty()), (false, true));
        assert_eq!(rest.corners(|_| true), [[1, 1], [2, 1], [1, 2], [2, 2]]);
    }

    #[test]
    fn quarters_and_their_points() {
        let one = cells(&[".#"]);
        assert_eq!(one.quartered(), cells(&["..##", "..##"]));
        let mut points = one.points(2, |_| true);
        points.sort_unstable_by_key(|&[x, y]| (y, x));
        assert_eq!(points, [[2, 0], [3, 0], [4, 0], [2, 1], [3, 1], [4, 1], [2, 2], [3, 2], [4, 2]]);
    }
}
