//! The adaptive model: Golomb codes of prediction errors, with statistics for each context (ITU-T T.87, annex A).

use super::bits::Bits;

/// Parameters of a scan (T.87, A.2.1 and C.2.4.1.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parameters {
    /// Largest number of the picture.
    pub max: i32,
    /// Largest error of a number: 0 without loss.
    pub near: i32,
    /// Thresholds of gradients.
    pub thresholds: [i32; 3],
    /// Numbers after which statistics are halved.
    pub reset: u32,
}

impl Parameters {
    /// Thresholds that hold where a file names none (C.2.4.1.1.1).
    pub fn default_thresholds(max: i32, near: i32) -> [i32; 3] {
        let mut lowest = near + 1;
        [(3, 2, 3), (7, 3, 5), (21, 4, 7)].map(|(basic, least, step)| {
            let wanted = if max >= 128 {
                (max.min(4095) + 128) / 256 * (basic - least) + least + step * near
            } else {
                least.max(basic / (256 / (max + 1)) + step * near)
            };
            // The next one is no smaller.
            lowest = if (lowest..=max).contains(&wanted) { wanted } else { lowest };
            lowest
        })
    }
}

/// Sums over the errors of one context.
#[derive(Clone, Copy)]
struct Statistics {
    /// Sum of magnitudes: A.
    magnitude: u32,
    /// Number of errors: N.
    count: u32,
    /// Sum of errors less what the correction took out, B; number of negative ones, Nn, where runs end.
    bias: i32,
    /// Correction of predictions: C.
    correction: i32,
}

impl Statistics {
    /// Bits below the unary part: the least k for which `count` · 2ᵏ reaches the sum.
    fn bits_below(&self, sum: u32) -> u32 {
        if self.count >= sum {
            return 0;
        }
        let k = self.count.leading_zeros() - sum.leading_zeros();
        k + u32::from(u64::from(self.count) << k < u64::from(sum))
    }
}

/// Model of a scan, shared by its components.
pub(super) struct Contexts {
    pub parameters: Parameters,
    /// Numbers of an error: RANGE.
    range: i32,
    /// Bits of an error that is not coded in unary.
    error_bits: u32,
    /// Longest code.
    limit: u32,
    /// Contexts by their gradients; the first one is for a component that is flat where another one is not.
    regular: [Statistics; 365],
    /// Ends of runs: at an edge, and where left and above are alike.
    run_end: [Statistics; 2],
}

impl Contexts {
    pub fn new(parameters: Parameters) -> Self {
        let Parameters { max, near, .. } = parameters;
        let range = (max + 2 * near) / (2 * near + 1) + 1;
        // Bits of n numbers.
        let bits = |n: i32| n.cast_unsigned().next_power_of_two().ilog2();
        let number_bits = bits(max + 1).max(2);
        let magnitude = ((range + 32) / 64).max(2).cast_unsigned();
        let start = Statistics { magnitude, count: 1, bias: 0, correction: 0 };
        Self {
            parameters,
            range,
            error_bits: bits(range),
            limit: 2 * (number_bits + number_bits.max(8)),
            regular: [start; 365],
            run_end: [start; 2],
        }
    }

    /// Context of three gradients: none is 0, and opposite ones differ in sign alone (A.3.3, A.3.4).
    pub fn index(&self, gradients: [i32; 3]) -> i32 {
        let Parameters { near, thresholds: [t1, t2, t3], .. } = self.parameters;
        let level = |d: i32| {
            let size = d.abs();
            d.signum()
                * (i32::from(size > near) + i32::from(size >= t1) + i32::from(size >= t2) + i32::from(size >= t3))
        };
        81 * level(gradients[0]) + 9 * level(gradients[1]) + level(gradients[2])
    }

    /// A number, from its prediction; `None` where the scan is damaged (A.4 to A.6).
    pub fn regular(&mut self, bits: &mut Bits<'_>, context: i32, predicted: i32) -> Option<i32> {
        let Parameters { max, near, reset, .. } = self.parameters;
        let statistics = &mut self.regular[context.unsigned_abs() as usize];
        let sign = if context < 0 { -1 } else { 1 };
        let predicted = (predicted + sign * statistics.correction).clamp(0, max);
        let k = statistics.bits_below(statistics.magnitude);
        let code = golomb(bits, k, self.limit, self.error_bits)?;
        // Even codes are errors of 0 and above, unless the bias says that negative ones are more.
        let turned = near == 0 && k == 0 && 2 * statistics.bias <= -statistics.count.cast_signed();
        let half = code >> 1;
        let error = if (code & 1 == 0) != turned { half } else { -half - 1 };

        let step = 2 * near + 1;
        statistics.bias += error * step;
        statistics.magnitude += error.unsigned_abs();
        if statistics.count == reset {
            statistics.magnitude >>= 1;
            statistics.bias >>= 1;
            statistics.count >>= 1;
        }
        statistics.count += 1;
        let count = statistics.count.cast_signed();
        if statistics.bias <= -count {
            statistics.correction = (statistics.correction - 1).max(-128);
            statistics.bias = (statistics.bias + count).max(1 - count);
        } else if statistics.bias > 0 {
            statistics.correction = (statistics.correction + 1).min(127);
            statistics.bias = (statistics.bias - count).min(0);
        }
        Some(self.rebuilt(predicted, sign * error))
    }

    /// The number that ends a run, between the one to the left and the one above; `shortened` is what the run took of the longest code.
    /// Pixels of several numbers have one kind of end (A.7.2).
    pub fn run_end(&mut self, bits: &mut Bits<'_>, left: i32, above: i32, single: bool, shortened: u32) -> Option<i32> {
        let alike = single && (left - above).abs() <= self.parameters.near;
        let statistics = &mut self.run_end[usize::from(alike)];
        let kind = i32::from(alike);
        let sum = statistics.magnitude + if alike { statistics.count >> 1 } else { 0 };
        let k = statistics.bits_below(sum);
        let code = golomb(bits, k, self.limit - shortened, self.error_bits)?;
        // The rarer sign has the odd codes.
        let odd = (code + kind) & 1;
        let size = (code + kind + odd) / 2;
        let odd_is_negative = k != 0 || 2 * statistics.bias >= statistics.count.cast_signed();
        let error = if odd_is_negative == (odd == 1) { -size } else { size };

        if error < 0 {
            statistics.bias += 1;
        }
        statistics.magnitude += ((code + 1 - kind) >> 1).cast_unsigned();
        if statistics.count == self.parameters.reset {
            statistics.magnitude >>= 1;
            statistics.bias >>= 1;
            statistics.count >>= 1;
        }
        statistics.count += 1;
        let (predicted, sign) = match (alike, left > above) {
            (true, _) => (left, 1),
            (false, true) => (above, -1),
            (false, false) => (above, 1),
        };
        Some(self.rebuilt(predicted, sign * error))
    }

    /// A prediction with its error, modulo the range (A.4.5 undone).
    fn rebuilt(&self, predicted: i32, error: i32) -> i32 {
        let Parameters { max, near, .. } = self.parameters;
        let step = 2 * near + 1;
        let value = predicted + error * step;
        let value = if value < -near {
            value + self.range * step
        } else if value > max + near {
            value - self.range * step
        } else {
            value
        };
        value.clamp(0, max)
    }
}

/// A code of limited length (A.5.3): below 2¹⁷, which every error of 16 bits is; `None` where the scan is damaged.
fn golomb(bits: &mut Bits<'_>, k: u32, limit: u32, error_bits: u32) -> Option<i32> {
    let longest = limit - error_bits - 1;
    let zeros = bits.zeros(longest)?;
    let code = if zeros < longest {
        u64::from(zeros) << k | u64::from(bits.number(k)?)
    } else {
        u64::from(bits.number(error_bits)?) + 1
    };
    i32::try_from(code).ok().filter(|&code| code < 1 << 17)
}
