//! A ray's part cut into steps of equal length, and one shorter one.

/// Steps of `length` from `start` on; the last one ends where the ray does and is as long as is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steps {
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) count: usize,
    /// Length of the last step: above 0, at most `length`.
    pub(crate) last: f64,
}

/// Of a ray's length: a last step shorter than this is rounding, not a step, and falls to the one before.
const SLIVER: f64 = 1e-12;

impl Steps {
    /// Cuts the interval, which must not be empty.
    pub(crate) fn new(start: f64, end: f64, length: f64) -> Self {
        let chord = end - start;
        let sliver = SLIVER * chord;
        let count = ((chord - sliver) / length).ceil().max(1.0);
        let rest = chord - (count - 1.0) * length;
        // Whole up to rounding: whole, so that the table's entry serves and the picture does not depend on the last bit.
        let last = if rest + sliver >= length { length } else { rest };
        Self { start, length, count: count as usize, last }
    }

    /// Where step `k` begins; `k` = count: a whole step beyond the last.
    pub(crate) fn begin(&self, k: usize) -> f64 {
        self.start + k as f64 * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_step_is_what_is_left() {
        let s = Steps::new(-1.0, 1.3, 0.5);
        assert_eq!(s.count, 5);
        assert!((s.last - 0.3).abs() < 1e-15);
        assert_eq!(Steps::new(0.0, 0.2, 0.5), Steps { start: 0.0, length: 0.5, count: 1, last: 0.2 });
    }

    #[test]
    fn whole_numbers_of_steps_survive_rounding() {
        for n in [1, 3, 7, 1000, 4096] {
            for length in [0.1, 1.0 / 3.0, 1e-20, 1e20] {
                let end = f64::from(n) * length;
                for end in [end.next_down(), end, end.next_up()] {
                    let s = Steps::new(0.0, end, length);
                    assert_eq!((s.count, s.last), (n as usize, length), "{n} of {length}");
                }
            }
        }
    }
}
