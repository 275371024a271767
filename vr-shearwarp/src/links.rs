//! Links over the texels of a scan line that are opaque already, from each to the next that is not (Lacroute & Levoy 1994).

/// The links of one scan line. An opaque texel holds the distance to a texel behind it, all between being opaque, too; the others hold 0.
/// Behind the last texel stands one that is never opaque.
///
/// Paths are compressed as in union-find: who follows a chain of links points its members at its end.
pub(crate) struct Links<'a>(&'a mut [u16]);

impl<'a> Links<'a> {
    /// The links of a scan line of `links.len() − 1` texels.
    pub(crate) fn new(links: &'a mut [u16]) -> Self {
        Self(links)
    }

    /// The first texel at or behind `x` that is not opaque; the width where there is none.
    #[inline]
    pub(crate) fn next_open(&mut self, x: usize) -> usize {
        let mut open = x;
        while self.0[open] != 0 {
            open += usize::from(self.0[open]);
        }
        let mut at = x;
        while self.0[at] != 0 {
            let next = at + usize::from(self.0[at]);
            // Too far for a link: a long one, and the rest of the chain.
            self.0[at] = u16::try_from(open - at).unwrap_or(self.0[at]);
            at = next;
        }
        open
    }

    /// Marks a texel as opaque.
    #[inline]
    pub(crate) fn close(&mut self, x: usize) {
        self.0[x] = 1;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::with_cases(300) })]

        #[test]
        fn no_open_texel_is_skipped(width in 1usize..200, steps in prop::collection::vec((any::<bool>(), 0usize..200), 1..300)) {
            let mut memory = vec![0; width + 1];
            let mut opaque = vec![false; width];
            for (close, x) in steps {
                let x = x % width;
                let mut links = Links::new(&mut memory);
                if close && !opaque[x] {
                    links.close(x);
                    opaque[x] = true;
                } else {
                    let open = (x..width).find(|&i| !opaque[i]).unwrap_or(width);
                    prop_assert_eq!(links.next_open(x), open);
                }
            }
        }
    }

    #[test]
    fn chains_longer_than_a_link_are_followed() {
        let width = 200_000;
        let mut memory = vec![0; width + 1];
        let mut links = Links::new(&mut memory);
        (0..width).for_each(|x| links.close(x));
        for _ in 0..2 {
            assert_eq!((links.next_open(0), links.next_open(70_000)), (width, width));
        }
    }
}
