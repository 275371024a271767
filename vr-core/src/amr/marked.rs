//! Marks on the items of a list, and the numbers of those that are marked.

/// A mark on some items of a list, of which each is numbered among the marked ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Marked {
    /// For each 64 items: their marks, a bit each, and the number of marked ones before them.
    words: Vec<(u64, u32)>,
}

impl Marked {
    /// Marks of a list, item by item.
    pub(super) fn new(marks: impl Iterator<Item = bool>) -> Self {
        let mut words: Vec<(u64, u32)> = Vec::new();
        for (i, is_marked) in marks.enumerate() {
            if i % 64 == 0 {
                words.push((0, words.last().map_or(0, |(bits, before)| before + bits.count_ones())));
            }
            words[i / 64].0 |= u64::from(is_marked) << (i % 64);
        }
        Self { words }
    }

    /// Number of an item among the marked ones; `None` if it is not marked.
    #[inline]
    pub(super) fn number(&self, item: usize) -> Option<usize> {
        let &(bits, before) = self.words.get(item / 64)?;
        let bit = 1u64 << (item % 64);
        (bits & bit != 0).then(|| before as usize + (bits & (bit - 1)).count_ones() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::Marked;

    #[test]
    fn marked_items_are_numbered_in_their_order() {
        let is_marked = |i: usize| i.is_multiple_of(3) || (60..70).contains(&i);
        let marked = Marked::new((0..200).map(is_marked));
        let numbers: Vec<usize> = (0..200).filter_map(|i| marked.number(i)).collect();
        assert!(numbers.iter().copied().eq(0..(0..200).filter(|&i| is_marked(i)).count()));
        assert!((0..200).all(|i| marked.number(i).is_some() == is_marked(i)));
        assert_eq!((marked.number(200), Marked::default().number(0)), (None, None));
    }
}
