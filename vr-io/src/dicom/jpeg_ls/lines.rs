//! The lines of a scan: numbers predicted from their neighbours, and runs where these are alike (ITU-T T.87, A.3 and A.7).

use super::bits::Bits;
use super::contexts::Contexts;

/// Bits of the length of a run, after as many runs that went on (A.2.1, J).
const RUN_BITS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15, //
];

/// Two lines of a component, each between what stands for its neighbours beyond the edges.
pub(super) struct LinePair {
    above: Vec<i32>,
    current: Vec<i32>,
}

impl LinePair {
    /// The lines before the first, which are black.
    pub fn new(width: usize) -> Self {
        Self { above: vec![0; width + 2], current: vec![0; width + 2] }
    }

    /// Begins the next line. Beyond the left edge stands the first number above, beyond the right edge the last.
    fn advance(&mut self) {
        std::mem::swap(&mut self.above, &mut self.current);
        let width = self.above.len() - 2;
        self.above[width + 1] = self.above[width];
        self.current[0] = self.above[1];
    }

    /// The line that was decoded last.
    pub fn numbers(&self) -> &[i32] {
        &self.current[1..self.current.len() - 1]
    }

    /// Neighbours of a number: left, above, above and left, above and right.
    fn neighbours(&self, x: usize) -> [i32; 4] {
        [self.current[x], self.above[x + 1], self.above[x], self.above[x + 2]]
    }
}

/// Median of the neighbours and of the plane through them (A.4.1).
fn predicted([left, above, corner, _]: [i32; 4]) -> i32 {
    let (low, high) = (left.min(above), left.max(above));
    if corner >= high {
        low
    } else if corner <= low {
        high
    } else {
        left + above - corner
    }
}

/// Decodes a line of one component, or of several with the numbers of a pixel together; `None` where the scan ends early or is damaged.
/// `run_index` lasts from line to line.
pub(super) fn decode_line<const N: usize>(
    lines: &mut [LinePair; N],
    contexts: &mut Contexts,
    bits: &mut Bits<'_>,
    run_index: &mut usize,
) -> Option<()> {
    lines.iter_mut().for_each(LinePair::advance);
    let width = lines[0].numbers().len();
    let mut x = 0;
    while x < width {
        let neighbours: [[i32; 4]; N] = std::array::from_fn(|c| lines[c].neighbours(x));
        let indices = neighbours
            .map(|[left, above, corner, right]| contexts.index([right - above, above - corner, corner - left]));
        if indices.iter().any(|&index| index != 0) {
            for c in 0..N {
                lines[c].current[x + 1] = contexts.regular(bits, indices[c], predicted(neighbours[c]))?;
            }
            x += 1;
            continue;
        }

        // No gradient: a run of the numbers to the left, and its length.
        let start = x;
        let left = neighbours.map(|[left, ..]| left);
        while x < width && bits.number(1)? == 1 {
            let whole = 1 << RUN_BITS[*run_index];
            if whole <= width - x {
                *run_index = (*run_index + 1).min(RUN_BITS.len() - 1);
            }
            x += whole.min(width - x);
        }
        let ends_line = x == width;
        let shortened = RUN_BITS[*run_index];
        if !ends_line {
            x += bits.number(shortened)? as usize;
        }
        if x >= width && !ends_line {
            return None;
        }
        for c in 0..N {
            lines[c].current[start + 1..=x].fill(left[c]);
        }
        if ends_line {
            break;
        }

        // The number that differs.
        for c in 0..N {
            let [_, above, ..] = lines[c].neighbours(x);
            lines[c].current[x + 1] = contexts.run_end(bits, left[c], above, N == 1, shortened + 1)?;
        }
        *run_index = run_index.saturating_sub(1);
        x += 1;
    }
    Some(())
}
