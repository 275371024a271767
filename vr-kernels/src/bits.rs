//! Rows of bits in words of 64: sets of places along a row, and runs of them.

/// Number of bits of a word.
pub const WORD: usize = 64;

/// Runs of ones of a row of bits: index of the first one, and their number.
pub struct Ones<'a> {
    words: &'a [u64],
    bit: usize,
}

/// Returns the runs of ones of a row, from its beginning.
pub fn ones(words: &[u64]) -> Ones<'_> {
    Ones { words, bit: 0 }
}

impl Ones<'_> {
    /// The first bit from `self.bit` on that is set once `flip` is applied.
    fn next_bit(&self, flip: u64) -> Option<usize> {
        let mut w = self.bit / WORD;
        let mut word = (self.words.get(w)? ^ flip) & (!0 << (self.bit % WORD));
        while word == 0 {
            w += 1;
            word = self.words.get(w)? ^ flip;
        }
        Some(w * WORD + word.trailing_zeros() as usize)
    }
}

impl Iterator for Ones<'_> {
    type Item = (usize, usize);

    #[inline]
    fn next(&mut self) -> Option<(usize, usize)> {
        let start = self.next_bit(0)?;
        self.bit = start;
        self.bit = self.next_bit(!0).unwrap_or(self.words.len() * WORD);
        Some((start, self.bit - start))
    }
}

/// Number of runs of ones in a row.
pub fn count_runs(words: &[u64]) -> usize {
    let mut before = 0;
    let mut runs = 0;
    for &word in words {
        runs += (word & !(word << 1 | before)).count_ones() as usize;
        before = word >> (WORD - 1);
    }
    runs
}

/// Number of ones in a row.
pub fn count_ones(words: &[u64]) -> usize {
    words.iter().map(|w| w.count_ones() as usize).sum()
}

/// Clears the bits from `len` on.
pub fn clip(words: &mut [u64], len: usize) {
    for (i, word) in words.iter_mut().enumerate() {
        let left = len.saturating_sub(i * WORD);
        if left < WORD {
            *word &= (1 << left) - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cross_words_and_end_with_the_row() {
        for (words, runs) in [
            (&[][..], &[][..]),
            (&[0, 0], &[]),
            (&[!0, !0], &[(0, 128)]),
            (&[1 << 63, 1], &[(63, 2)]),
            (&[0b1011, 0, 1 << 63], &[(0, 2), (3, 1), (191, 1)]),
            (&[0, !0, 0], &[(64, 64)]),
        ] {
            assert_eq!(ones(words).collect::<Vec<_>>(), runs);
            assert_eq!(count_runs(words), runs.len());
            assert_eq!(count_ones(words), runs.iter().map(|r| r.1).sum::<usize>());
        }
    }

    #[test]
    fn clipping_keeps_what_is_before() {
        let mut words = [!0u64; 3];
        clip(&mut words, 65);
        assert_eq!(words, [!0, 1, 0]);
        clip(&mut words, 64);
        assert_eq!(words, [!0, 0, 0]);
    }
}
