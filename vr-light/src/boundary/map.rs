//! Environment maps.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::ParameterError;
use vr_core::scattering::EnvironmentImage;

use crate::spectrum::{BandGroup, Lanes};

/// Radiance from all directions, as an equirectangular picture: the top row is up (+y), the middle column is the direction −z, in which a camera looks
/// at azimuth 0, and columns to its right are on its right (+x). Each pixel has one radiance throughout.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_light::EnvironmentMap;
///
/// // A bright upper half of one band.
/// let map = EnvironmentMap::new([1, 2], 1, vec![1.0, 0.0])?;
/// assert_eq!(map.radiance(DVec3::Y, 0), 1.0);
/// assert_eq!(map.radiance(DVec3::NEG_Y, 0), 0.0);
/// let (direction, density) = map.sample([0.3, 0.4]).expect("it is not dark");
/// assert!(direction.y > 0.0 && (density - 0.5 / std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    size: [usize; 2],
    bands: usize,
    /// Radiances, band by band of each pixel, row by row.
    radiance: Vec<f32>,
    /// Sums of radiance · solid angle of the rows up to each, and of the pixels of each row up to each.
    rows: Vec<f64>,
    pixels: Vec<f64>,
}

impl EnvironmentMap {
    /// A map of so many columns and rows, with a radiance for each band of each pixel.
    ///
    /// # Errors
    /// A size of 0, radiances that are not as many as there are pixels and bands, or that are negative or not finite.
    pub fn new(size: [usize; 2], bands: usize, radiance: Vec<f32>) -> Result<Self, ParameterError> {
        let expected = size[0].checked_mul(size[1]).and_then(|n| n.checked_mul(bands));
        if radiance.is_empty() || expected != Some(radiance.len()) {
            let allowed = "must have a radiance for each band of each pixel, and a pixel";
            return Err(ParameterError::new("environment", (size, bands, radiance.len()), allowed));
        }
        if let Some(wrong) = radiance.iter().find(|r| !(0.0..=f32::MAX).contains(*r)) {
            return Err(ParameterError::new("environment", wrong, "must be finite and not negative"));
        }
        let mut map = Self { size, bands, radiance, rows: Vec::new(), pixels: Vec::new() };
        let mut total = 0.0;
        for row in 0..size[1] {
            let angle = map.solid_angle(row);
            let mut sum = 0.0;
            for column in 0..size[0] {
                sum += angle * map.pixel(column, row).iter().map(|&r| f64::from(r)).sum::<f64>();
                map.pixels.push(sum);
            }
            total += sum;
            map.rows.push(total);
        }
        Ok(map)
    }

    /// Map in red, green and blue of a picture, with a uniform radiance added to every pixel.
    ///
    /// # Errors
    /// Same as for [`Self::new`].
    pub fn of_image(image: &EnvironmentImage, uniform: [f64; 3]) -> Result<Self, ParameterError> {
        let sum = |pixel: &[f32; 3]| -> [f32; 3] { std::array::from_fn(|c| pixel[c] + uniform[c] as f32) };
        Self::new(image.size().map(|n| n as usize), 3, image.pixels().iter().flat_map(sum).collect())
    }

    /// Number of bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// Radiance of a band that is seen in a direction.
    pub fn radiance(&self, direction: DVec3, band: usize) -> f64 {
        let [column, row] = self.place(direction);
        self.pixel(column, row)[band].into()
    }

    pub(crate) fn lanes(&self, direction: DVec3, group: BandGroup) -> Lanes {
        let [column, row] = self.place(direction);
        let pixel = self.pixel(column, row);
        std::array::from_fn(|i| if i < group.count { pixel[group.first + i].into() } else { 0.0 })
    }

    /// Density per solid angle with which [`Self::sample`] gives a direction: in proportion to the sum of the bands.
    pub fn density(&self, direction: DVec3) -> f64 {
        let total = self.rows[self.rows.len() - 1];
        let [column, row] = self.place(direction);
        let light: f64 = self.pixel(column, row).iter().map(|&r| f64::from(r)).sum();
        if total > 0.0 { light / total } else { 0.0 }
    }

    /// A random direction of two numbers uniform in [0, 1), and its density; `None` if the map is dark.
    pub fn sample(&self, uniform: [f64; 2]) -> Option<(DVec3, f64)> {
        let total = self.rows[self.rows.len() - 1];
        if total <= 0.0 {
            return None;
        }
        let (row, down) = pick(&self.rows, uniform[0]);
        let (column, right) = pick(&self.pixels[row * self.size[0]..][..self.size[0]], uniform[1]);
        let [width, height] = self.size.map(|n| n as f64);
        // Uniform over the solid angle: the height is (Archimedes).
        let [top, bottom] = [row, row + 1].map(|row| libm::cos(PI * row as f64 / height));
        let y = top + down * (bottom - top);
        let azimuth = 2.0 * PI * ((column as f64 + right) / width - 0.5);
        let ring = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = libm::sincos(azimuth);
        let direction = DVec3::new(ring * sin, y, -ring * cos);
        let light: f64 = self.pixel(column, row).iter().map(|&r| f64::from(r)).sum();
        Some((direction, light / total))
    }

    /// Column and row of a direction.
    fn place(&self, direction: DVec3) -> [usize; 2] {
        let [width, height] = self.size.map(|n| n as f64);
        let right = 0.5 + libm::atan2(direction.x, -direction.z) / (2.0 * PI);
        let down = libm::acos(direction.y.clamp(-1.0, 1.0)) / PI;
        [((right * width) as usize).min(self.size[0] - 1), ((down * height) as usize).min(self.size[1] - 1)]
    }

    fn pixel(&self, column: usize, row: usize) -> &[f32] {
        &self.radiance[(row * self.size[0] + column) * self.bands..][..self.bands]
    }

    /// Solid angle of a pixel of a row.
    fn solid_angle(&self, row: usize) -> f64 {
        let [top, bottom] = [row, row + 1].map(|row| libm::cos(PI * row as f64 / self.size[1] as f64));
        2.0 * PI * (top - bottom) / self.size[0] as f64
    }
}

/// Index of the entry that a uniform number chooses of running sums, and the number's place within that entry, uniform in [0, 1).
fn pick(sums: &[f64], uniform: f64) -> (usize, f64) {
    let target = uniform * sums[sums.len() - 1];
    let index = sums.partition_point(|&sum| sum <= target).min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    let width = sums[index] - before;
    (index, if width > 0.0 { ((target - before) / width).clamp(0.0, 1.0) } else { 0.5 })
}
