//! Random numbers that are a function of a counter, so that pictures repeat bit for bit, in any order and on any number of threads.

/// Random numbers of one path: Philox 4×32 (Salmon, Moraes, Dror & Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011) with seven rounds, the
/// fewest that pass all of the authors' tests.
///
/// The n-th number is a function of seed, pixel, sample and n alone. A run that is resumed goes on with the next sample.
///
/// # Examples
/// ```
/// use vr_light::RandomStream;
///
/// let numbers = |sample| {
///     let mut random = RandomStream::new(7, 42, sample);
///     [random.uniform(), random.uniform(), random.uniform()]
/// };
/// assert_eq!(numbers(0), numbers(0));
/// assert_ne!(numbers(0), numbers(1));
/// assert!(numbers(0).iter().all(|u| (0.0..1.0).contains(u)));
/// ```
#[derive(Clone, Debug)]
pub struct RandomStream {
    key: [u32; 2],
    counter: [u32; 4],
    /// A number that is made and not given out yet.
    spare: Option<u64>,
}

impl RandomStream {
    /// The numbers of a sample of a pixel.
    pub fn new(seed: u64, pixel: u32, sample: u64) -> Self {
        let key = [seed as u32, (seed >> 32) as u32];
        Self { key, counter: [0, pixel, sample as u32, (sample >> 32) as u32], spare: None }
    }

    /// The next 64 random bits. A path of 2³³ numbers would begin anew; none is as long.
    fn bits(&mut self) -> u64 {
        if let Some(bits) = self.spare.take() {
            return bits;
        }
        let [a, b, c, d] = philox(self.counter, self.key);
        self.counter[0] = self.counter[0].wrapping_add(1);
        self.spare = Some(u64::from(c) << 32 | u64::from(d));
        u64::from(a) << 32 | u64::from(b)
    }

    /// The next number, uniform in [0, 1): a multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// The next two numbers, uniform in [0, 1), for directions and places: multiples of 2⁻³².
    pub fn pair(&mut self) -> [f64; 2] {
        let bits = self.bits();
        [bits >> 32, bits & 0xFFFF_FFFF].map(|half| half as f64 * (1.0 / (1u64 << 32) as f64))
    }

    /// The next number of the exponential distribution of mean 1; 0 at least, 36.8 at most.
    pub fn exponential(&mut self) -> f64 {
        // 1 − u is never 0.
        -logarithm(1.0 - self.uniform())
    }
}

/// ln x of a normal number above 0, to 10⁻¹³ of its size or of 1: 2 artanh((m − 1)/(m + 1)) of the mantissa, whose series ends at the 15th power.
#[inline]
fn logarithm(x: f64) -> f64 {
    // Mantissa between √½ and √2.
    const ROOT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
    let bits = x.to_bits();
    let exponent = (bits.wrapping_sub(ROOT_HALF) as i64) >> 52;
    let mantissa = f64::from_bits(bits.wrapping_sub((exponent as u64) << 52));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let low = (1.0 / 3.0 + z * (1.0 / 5.0)) + z * z * (1.0 / 7.0 + z * (1.0 / 9.0));
    let high = (1.0 / 11.0 + z * (1.0 / 13.0)) + z * z * (1.0 / 15.0);
    let fourth = (z * z) * (z * z);
    exponent as f64 * std::f64::consts::LN_2 + 2.0 * (s + s * z * (low + fourth * high))
}

/// Seven rounds of Philox 4×32.
#[inline]
fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    let product = |a: u32, b: u32| {
        let wide = u64::from(a) * u64::from(b);
        ((wide >> 32) as u32, wide as u32)
    };
    for _ in 0..7 {
        let (high0, low0) = product(0xD251_1F53, counter[0]);
        let (high1, low1) = product(0xCD9E_8D57, counter[2]);
        counter = [high1 ^ counter[1] ^ key[0], low1, high0 ^ counter[3] ^ key[1], low0];
        // Weyl sequences: the golden ratio, and √3 − 1.
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_the_published_numbers() {
        // The known answers of the authors' Random123 (kat_vectors), `philox4x32 7`.
        assert_eq!(philox([0; 4], [0; 2]), [0x5f6f_b709, 0x0d89_3f64, 0x4f12_1f81, 0x4f73_0a48]);
        assert_eq!(philox([u32::MAX; 4], [u32::MAX; 2]), [0x5207_ddc2, 0x4516_5e59, 0x4d8e_e751, 0x8c52_f662]);
        let counter = [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344];
        let expected = [0x4dfc_caba, 0x190a_87f0, 0xc473_62ba, 0xb6b5_242a];
        assert_eq!(philox(counter, [0xa409_3822, 0x299f_31d0]), expected);
    }

    #[test]
    fn logarithms_are_those_of_the_library() {
        for k in 1..20_000u64 {
            let x = (k as f64 / 20_000.0).powi(1 + (k % 7) as i32);
            let (found, wanted) = (logarithm(x), libm::log(x));
            assert!((found - wanted).abs() <= 1e-13 * wanted.abs().max(1.0), "{x}: {found} for {wanted}");
        }
        assert_eq!(logarithm(1.0), 0.0);
        assert!((logarithm(f64::EPSILON / 2.0) / libm::log(f64::EPSILON / 2.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn numbers_are_uniform_and_streams_differ() {
        let count = 100_000;
        let mut bins = [0u32; 64];
        for sample in 0..count / 4 {
            let mut random = RandomStream::new(3, 5, sample);
            for _ in 0..4 {
                bins[(random.uniform() * 64.0) as usize] += 1;
            }
        }
        let expected = count as f64 / 64.0;
        let chi: f64 = bins.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
        // Chi-squared of 63 degrees of freedom: mean 63, standard deviation √126 = 11.2.
        assert!((chi - 63.0).abs() < 4.0 * 11.2, "{chi}");
        let first = |seed, pixel, sample| RandomStream::new(seed, pixel, sample).bits();
        assert!(
            first(0, 0, 0) != first(1, 0, 0)
                && first(0, 0, 0) != first(0, 1, 0)
                && first(0, 0, 1) != first(0, 0, 1 << 32)
        );
    }
}
