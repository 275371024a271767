//! Pictures of the light from all sides.

use std::collections::hash_map::DefaultHasher;
use std::fmt;
use std::hash::{Hash, Hasher};

use crate::error::ParameterError;
use crate::limits::MAX_LIGHT;

/// Radiance from all directions in red, green and blue, as an equirectangular picture: the top row is up (+y), the middle column is the direction −z, in
/// which a camera looks at azimuth 0, and columns to its right are on its right (+x). Each pixel has one radiance throughout.
///
/// # Examples
/// ```
/// use vr_core::scattering::EnvironmentImage;
///
/// let sky = EnvironmentImage::new([1, 2], vec![[0.5, 0.6, 1.0], [0.1, 0.1, 0.1]])?;
/// assert_eq!(sky.brightest(), [0.5, 0.6, 1.0].map(|x: f32| f64::from(x)));
/// assert!(EnvironmentImage::new([1, 1], vec![[-1.0, 0.0, 0.0]]).is_err());
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct EnvironmentImage {
    size: [u32; 2],
    pixels: Vec<[f32; 3]>,
}

impl EnvironmentImage {
    /// A picture of so many columns and rows, row by row from the top.
    ///
    /// # Errors
    /// No pixels, not as many as the size says, or radiances that are negative, not finite or above 10⁶.
    pub fn new(size: [u32; 2], pixels: Vec<[f32; 3]>) -> Result<Self, ParameterError> {
        const FIELD: &str = "scattering.environment_map";
        if pixels.is_empty() || u64::from(size[0]) * u64::from(size[1]) != pixels.len() as u64 {
            let allowed = "must have a pixel, and as many as its size says";
            return Err(ParameterError::new(FIELD, (size, pixels.len()), allowed));
        }
        let wrong = |radiance: &f32| !(0.0..=MAX_LIGHT).contains(&f64::from(*radiance));
        if let Some(i) = pixels.iter().position(|pixel| pixel.iter().any(wrong)) {
            let [column, row] = [i as u32 % size[0], i as u32 / size[0]];
            let found = format!("{:?} in column {column}, row {row}", pixels[i]);
            return Err(ParameterError {
                field: FIELD.into(),
                found,
                allowed: "radiances must be finite and not negative, 1e6 at most",
            });
        }
        Ok(Self { size, pixels })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Red, green and blue of each pixel, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Largest radiance of each of red, green and blue.
    pub fn brightest(&self) -> [f64; 3] {
        std::array::from_fn(|c| f64::from(self.pixels.iter().fold(0.0, |max: f32, pixel| max.max(pixel[c]))))
    }
}

impl fmt::Debug for EnvironmentImage {
    /// Writes the size and a hash in place of millions of numbers.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut hasher = DefaultHasher::new();
        self.pixels.iter().flatten().for_each(|radiance| radiance.to_bits().hash(&mut hasher));
        f.debug_struct("EnvironmentImage")
            .field("size", &self.size)
            .field("hash", &format_args!("{:016x}", hasher.finish()))
            .finish()
    }
}
