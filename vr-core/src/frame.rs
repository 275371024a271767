//! A finished picture.

use crate::uncertainty::Uncertainty;

/// A picture in premultiplied linear RGBA without the background, f32; row 0 is the top. Optionally with a depth per pixel.
///
/// # Examples
/// ```
/// use vr_core::Frame;
///
/// // Half covered by white, before blue.
/// let frame = Frame::new([1, 1], vec![[0.5, 0.5, 0.5, 0.5]], None);
/// assert_eq!(frame.pixel(0, 0)[3], 0.5);
/// assert_eq!(frame.over_background([0.0, 0.0, 1.0]), [[0.5, 0.5, 1.0]]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    size: [u32; 2],
    pixels: Vec<[f32; 4]>,
    depth: Option<Vec<f32>>,
    uncertainty: Option<Uncertainty>,
}

impl Frame {
    /// A picture from its pixels, row by row from the top.
    ///
    /// # Panics
    /// Panics if there is not one entry per pixel.
    pub fn new(size: [u32; 2], pixels: Vec<[f32; 4]>, depth: Option<Vec<f32>>) -> Self {
        let n = size[0] as usize * size[1] as usize;
        assert!(pixels.len() == n && depth.as_ref().is_none_or(|d| d.len() == n), "one entry per pixel");
        Self { size, pixels, depth, uncertainty: None }
    }

    /// The same picture with what its renderer knows of its errors.
    ///
    /// # Panics
    /// Panics if there is not one entry per pixel.
    #[must_use]
    pub fn with_uncertainty(self, uncertainty: Uncertainty) -> Self {
        assert!(uncertainty.components().len() == self.pixels.len(), "one entry per pixel");
        Self { uncertainty: Some(uncertainty), ..self }
    }

    /// Errors of the pixels, where the renderer knows them.
    pub fn uncertainty(&self) -> Option<&Uncertainty> {
        self.uncertainty.as_ref()
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// One pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// World distance along each pixel's ray to what is seen (for over: to α = 0.5); +∞ where there is nothing.
    pub fn depth(&self) -> Option<&[f32]> {
        self.depth.as_deref()
    }

    /// The pixels before a background: rgb + (1 − α)·background.
    pub fn over_background(&self, background: [f32; 3]) -> Vec<[f32; 3]> {
        let blend = |p: &[f32; 4]| std::array::from_fn(|c| p[c] + (1.0 - p[3]) * background[c]);
        self.pixels.iter().map(blend).collect()
    }
}
