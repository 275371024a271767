//! Sums of the samples of a picture.

use vr_core::ParameterError;

/// Sums of the samples of each pixel and their squares, from which mean and standard error follow at any time: of each band, and of the opacity
/// behind them. A run that is given the film of an earlier one goes on where that ended.
///
/// # Examples
/// ```
/// use vr_light::Film;
///
/// let mut film = Film::new([2, 1], 1)?;
/// film.add(1, &[1.0, 0.5]);
/// film.add(1, &[3.0, 0.5]);
/// assert_eq!((film.count(1), film.mean(1, 0), film.mean(1, 1)), (2, 2.0, 0.5));
/// assert_eq!(film.standard_error(1, 0), 1.0);
/// assert!(film.standard_error(0, 0).is_infinite(), "nothing is known of a pixel without samples");
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    size: [u32; 2],
    bands: usize,
    /// Samples of the radiance of each pixel, and of its opacity.
    counts: Vec<[u64; 2]>,
    /// Sum and sum of squares of each channel of each pixel.
    sums: Vec<[f64; 2]>,
}

/// Largest number of sums of a film, 16 bytes each.
const MAX_SUMS: u64 = 1 << 33;

impl Film {
    /// A film without samples, of so many columns, rows and bands.
    ///
    /// # Errors
    /// A size of 0, no bands, or more than 2³³ sums.
    pub fn new(size: [u32; 2], bands: usize) -> Result<Self, ParameterError> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let sums = pixels.checked_mul(bands as u64 + 1).filter(|&n| pixels > 0 && bands > 0 && n <= MAX_SUMS);
        let Some(sums) = sums else {
            let allowed = "must have pixels and bands, and at most 2^33 sums";
            return Err(ParameterError::new("image.size", (size, bands), allowed));
        };
        Ok(Self { size, bands, counts: vec![[0; 2]; pixels as usize], sums: vec![[0.0; 2]; sums as usize] })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Number of bands; the opacity is the channel behind them.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.bands + 1
    }

    /// Number of samples of a pixel's radiance. Pixels are counted row by row from the top left.
    pub fn count(&self, pixel: usize) -> u64 {
        self.counts[pixel][0]
    }

    /// Number of samples of a pixel in a channel: of the opacity, there may be fewer.
    pub fn count_of(&self, pixel: usize, channel: usize) -> u64 {
        self.counts[pixel][usize::from(channel == self.bands)]
    }

    /// Adds a sample to a pixel: of all channels, or of the bands alone.
    ///
    /// # Panics
    /// If the sample has neither one number for each channel nor one for each band.
    pub fn add(&mut self, pixel: usize, sample: &[f64]) {
        let channels = self.channels();
        assert!(
            sample.len() == channels || sample.len() == self.bands,
            "one number for each channel, or for each band"
        );
        add_sample(&mut self.counts[pixel], &mut self.sums[pixel * channels..][..channels], sample);
    }

    /// Mean of the samples of a pixel in a channel; 0 without samples.
    pub fn mean(&self, pixel: usize, channel: usize) -> f64 {
        let [sum, _] = self.sums[pixel * self.channels() + channel];
        match self.count_of(pixel, channel) {
            0 => 0.0,
            count => sum / count as f64,
        }
    }

    /// Standard error of that mean; +∞ of less than two samples.
    pub fn standard_error(&self, pixel: usize, channel: usize) -> f64 {
        let count = self.count_of(pixel, channel) as f64;
        if count < 2.0 {
            return f64::INFINITY;
        }
        let [sum, squares] = self.sums[pixel * self.channels() + channel];
        let variance = ((squares - sum * (sum / count)) / (count - 1.0)).max(0.0);
        (variance / count).sqrt()
    }

    /// Root mean square of the standard errors of all pixels and bands; +∞ if a pixel has less than two samples.
    pub fn rms_error(&self) -> f64 {
        let errors = (0..self.counts.len()).flat_map(|p| (0..self.bands).map(move |c| (p, c)));
        let sum: f64 = errors.map(|(pixel, band)| self.standard_error(pixel, band).powi(2)).sum();
        (sum / (self.counts.len() * self.bands) as f64).sqrt()
    }

    /// Counts and sums of each part of so many pixels, to add samples to.
    pub(super) fn parts(&mut self, pixels: usize) -> impl Iterator<Item = (&mut [[u64; 2]], &mut [[f64; 2]])> {
        let channels = self.channels();
        self.counts.chunks_mut(pixels).zip(self.sums.chunks_mut(pixels * channels))
    }
}

/// Adds a sample to the sums of one pixel: of all channels, or of all but the last.
pub(super) fn add_sample(counts: &mut [u64; 2], sums: &mut [[f64; 2]], sample: &[f64]) {
    counts[0] += 1;
    counts[1] += u64::from(sample.len() == sums.len());
    for ([sum, squares], &value) in sums.iter_mut().zip(sample) {
        *sum += value;
        *squares += value * value;
    }
}
