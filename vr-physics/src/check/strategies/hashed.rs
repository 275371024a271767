//! Random numbers that belong to a place: the same for a seed and an index, in whatever order they are asked for.

/// A random number of a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hashed(u64);

impl Hashed {
    /// The number of an index under a seed.
    pub fn of<const N: usize>(seed: u64, index: [i64; N]) -> Self {
        Self(index.iter().fold(mixed(seed), |hash, &i| mixed(hash ^ i as u64)))
    }

    /// A part of 1, from the upper bits.
    pub fn part(self) -> f64 {
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }

    /// True for one place in `n`, from the lower bits.
    pub fn is_one_in(self, n: u64) -> bool {
        (self.0 & 0xff_ffff).is_multiple_of(n)
    }
}

/// A step of the generator SplitMix64, by Steele, Lea and Flood 2014.
fn mixed(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
