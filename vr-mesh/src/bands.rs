//! Triangles sorted by the rows of pixels that they may cover.

/// A triangle that may cover pixels, and the rows, first and end, in which they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) triangle: u32,
    pub(crate) rows: [u32; 2],
}

/// Bands of rows, each with the triangles that may be seen in it.
#[derive(Debug)]
pub(crate) struct Bands {
    /// Rows of the picture.
    rows: u32,
    /// Rows of a band; the last one may have fewer.
    height: u32,
    /// Index into `members` at which each band's triangles begin, and that at which the last one's end.
    starts: Vec<usize>,
    members: Vec<u32>,
    /// Triangles of so many bands that each looks at all of them.
    tall: Vec<Candidate>,
}

/// Smallest number of rows of a band: so many that a band is worth a task of its own.
const MIN_ROWS: u32 = 8;
/// Largest number of bands.
const MAX_BANDS: u32 = 256;
/// Triangles of more bands are kept apart, so that lists stay within a few times the number of triangles.
const TALL: u32 = 16;

impl Bands {
    /// Sorts the candidates of a picture of so many rows. (A counting sort: each list keeps their order.)
    pub(crate) fn new(rows: u32, candidates: &[Vec<Candidate>]) -> Self {
        let height = rows.div_ceil(MAX_BANDS).max(MIN_ROWS);
        let bands = |c: &Candidate| (c.rows[0] / height) as usize..c.rows[1].div_ceil(height) as usize;
        let is_tall = |c: &&Candidate| bands(c).len() > TALL as usize;
        let all = || candidates.iter().flatten();
        // Count the triangles of each band, and sum up to where its list begins.
        let mut starts = vec![0; rows.div_ceil(height) as usize + 1];
        for candidate in all().filter(|c| !is_tall(c)) {
            bands(candidate).for_each(|band| starts[band + 1] += 1);
        }
        for band in 1..starts.len() {
            starts[band] += starts[band - 1];
        }
        // Put each triangle into the list of every band that it reaches into.
        let mut members = vec![0; starts[starts.len() - 1]];
        let mut next = starts.clone();
        for candidate in all().filter(|c| !is_tall(c)) {
            for band in bands(candidate) {
                members[next[band]] = candidate.triangle;
                next[band] += 1;
            }
        }
        Self { rows, height, starts, members, tall: all().filter(is_tall).copied().collect() }
    }

    /// Number of bands.
    pub(crate) fn count(&self) -> u32 {
        self.rows.div_ceil(self.height)
    }

    /// The rows of a band, first and end.
    pub(crate) fn rows(&self, band: u32) -> [u32; 2] {
        [band * self.height, ((band + 1) * self.height).min(self.rows)]
    }

    /// The triangles that may be seen in a band.
    pub(crate) fn triangles(&self, band: u32) -> impl Iterator<Item = u32> {
        let [first, end] = self.rows(band);
        let tall = self.tall.iter().filter(move |c| c.rows[0] < end && c.rows[1] > first).map(|c| c.triangle);
        let i = band as usize;
        self.members[self.starts[i]..self.starts[i + 1]].iter().copied().chain(tall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_band_has_what_reaches_into_it() {
        let rows = [[0, 8], [7, 9], [16, 20], [0, 20], [19, 20], [8, 16]];
        let candidates: Vec<Candidate> =
            rows.iter().enumerate().map(|(i, &rows)| Candidate { triangle: i as u32, rows }).collect();
        let bands = Bands::new(20, &[candidates[..2].to_vec(), vec![], candidates[2..].to_vec()]);
        assert_eq!((bands.count(), bands.rows(0), bands.rows(2)), (3, [0, 8], [16, 20]));
        let of = |band| bands.triangles(band).collect::<Vec<_>>();
        assert_eq!([of(0), of(1), of(2)], [vec![0, 1, 3], vec![1, 3, 5], vec![2, 3, 4]]);
    }

    #[test]
    fn tall_ones_are_not_repeated() {
        let size = 1000;
        let tall = Candidate { triangle: 7, rows: [100, 900] };
        let bands = Bands::new(size, &[vec![tall]]);
        assert_eq!((bands.members.len(), bands.tall.len()), (0, 1));
        for band in 0..bands.count() {
            let [first, end] = bands.rows(band);
            assert_eq!(bands.triangles(band).count(), usize::from(first < 900 && end > 100), "{band}");
        }
    }
}
