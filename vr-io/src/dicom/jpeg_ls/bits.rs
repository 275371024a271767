//! The bits of a scan: the highest of a byte first, seven of a byte after 0xFF (ITU-T T.87, 9.1).

/// Reader of a scan, which ends at the marker after it.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    /// Bits that were taken out of the bytes, the next one on top, zeros below the last.
    held: u64,
    count: u32,
    /// True if the last byte was 0xFF: the next one is a marker, or its top bit is stuffed.
    after_ff: bool,
}

impl<'a> Bits<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, held: 0, count: 0, after_ff: false }
    }

    fn fill(&mut self) {
        while self.count <= 56 {
            let Some((&byte, rest)) = self.bytes.split_first() else { return };
            let width = if self.after_ff { 7 } else { 8 };
            if self.after_ff && byte >= 0x80 {
                self.bytes = &[];
                return;
            }
            self.held |= u64::from(byte) << (64 - width - self.count);
            self.count += width;
            self.after_ff = byte == 0xff;
            self.bytes = rest;
        }
    }

    fn skip(&mut self, n: u32) {
        // In two steps, since the highest shift is 63.
        self.held = self.held << (n - 1) << 1;
        self.count -= n;
    }

    /// The next bits as a number, 32 at most; `None` at the end.
    pub fn number(&mut self, n: u32) -> Option<u32> {
        if n == 0 {
            return Some(0);
        }
        if self.count < n {
            self.fill();
        }
        if self.count < n {
            return None;
        }
        let number = (self.held >> (64 - n)) as u32;
        self.skip(n);
        Some(number)
    }

    /// Zeros before the next one, which is taken too; `None` at the end, or where there are more than `max`.
    pub fn zeros(&mut self, max: u32) -> Option<u32> {
        let mut zeros = 0;
        loop {
            let run = self.held.leading_zeros();
            if run < self.count {
                self.skip(run + 1);
                return (zeros + run <= max).then_some(zeros + run);
            }
            zeros += self.count;
            (self.held, self.count) = (0, 0);
            self.fill();
            if self.count == 0 || zeros > max {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_is_stuffed_after_ff() {
        let mut bits = Bits::new(&[0xa5, 0xff, 0x7f, 0x01, 0xff, 0xd9]);
        assert_eq!((bits.number(4), bits.number(4), bits.number(15)), (Some(0xa), Some(5), Some(0x7fff)));
        // Seven zeros of the byte before the marker, and its one; then the last 0xFF, and nothing of the marker.
        assert_eq!((bits.zeros(7), bits.number(8), bits.number(1)), (Some(7), Some(0xff), None));
    }

    #[test]
    fn runs_of_zeros_are_bounded() {
        let long = [[0; 20].as_slice(), &[1]].concat();
        assert_eq!(Bits::new(&long).zeros(167), Some(167));
        assert_eq!(Bits::new(&long).zeros(166), None);
        assert_eq!(Bits::new(&[0; 20]).zeros(u32::MAX), None);
    }
}
