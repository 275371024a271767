//! Comparison of two pictures, pixel by pixel.

use vr_io::Picture;
use vr_physics::metrics::{Channels, Metrics};

/// Difference below which nothing can be seen in 8 bits.
const VISIBLE: f64 = 1.0 / 255.0;

/// Two pictures of one size, made comparable.
pub struct Comparison {
    /// Width and height.
    pub size: [u32; 2],
    /// Channels that are compared: with opacity where both pictures have it.
    pub channels: Channels,
    /// The picture that alone had opacity, and so was blended with the background.
    pub blended: Option<Blended>,
    /// The error.
    pub metrics: Metrics,
    reference: Vec<[f64; 4]>,
    picture: Vec<[f32; 4]>,
}

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blended {
    /// The first.
    Reference,
    /// The second.
    Picture,
}

/// The pixel with the largest error.
pub struct Worst {
    /// Column and row, from the top left.
    pub pixel: [u32; 2],
    /// Colour of the pixel as compared, in the reference and in the picture.
    pub colors: [[f64; 4]; 2],
    /// Error of the pixel.
    pub error: f64,
}

impl Comparison {
    /// Compares two pictures of the same size; a background in linear RGB is put behind the one that alone has opacity.
    pub fn new(reference: &Picture, picture: &Picture, background: [f32; 3]) -> Self {
        let blended = match (reference.alpha, picture.alpha) {
            (true, false) => Some(Blended::Reference),
            (false, true) => Some(Blended::Picture),
            _ => None,
        };
        let pixels = |p: &Picture, side| -> Vec<[f32; 4]> {
            if blended == Some(side) {
                p.frame.over_background(background).into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
            } else {
                p.frame.pixels().to_vec()
            }
        };
        let channels = if reference.alpha && picture.alpha { Channels::Rgba } else { Channels::Rgb };
        let of_reference: Vec<[f64; 4]> =
            pixels(reference, Blended::Reference).into_iter().map(|p| p.map(f64::from)).collect();
        let of_picture = pixels(picture, Blended::Picture);
        Self {
            size: reference.frame.size(),
            channels,
            blended,
            metrics: Metrics::of_selected(&of_reference, &of_picture, channels, |_| true),
            reference: of_reference,
            picture: of_picture,
        }
    }

    /// Returns B − A of each pixel, in units of max(1, largest magnitude in A); 0 for opacity where that is not compared.
    pub fn differences(&self) -> impl Iterator<Item = [f64; 4]> {
        let scale = self.metrics.peak_reference.max(1.0);
        let count = match self.channels {
            Channels::Rgba => 4,
            Channels::Rgb => 3,
        };
        self.reference
            .iter()
            .zip(&self.picture)
            .map(move |(r, p)| std::array::from_fn(|c| if c < count { (f64::from(p[c]) - r[c]) / scale } else { 0.0 }))
    }

    /// Returns the largest error of any component of each pixel; that of NaN is infinite.
    pub fn errors(&self) -> impl Iterator<Item = f64> {
        let size = |e: f64| if e.is_finite() { e.abs() } else { f64::INFINITY };
        self.differences().map(move |e| e.map(size).into_iter().fold(0.0, f64::max))
    }

    /// Returns the first pixel with the largest error; `None` for equal pictures.
    pub fn worst(&self) -> Option<Worst> {
        let first_largest = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
        let (index, error) = self.errors().enumerate().fold((0, 0.0), first_largest);
        let place = index as u32;
        (error > 0.0).then(|| Worst {
            pixel: [place % self.size[0], place / self.size[0]],
            colors: [self.reference[index], self.picture[index].map(f64::from)],
            error,
        })
    }

    /// Returns the number of pixels that differ by more than can be hidden in 8 bits.
    pub fn visible(&self) -> usize {
        self.errors().filter(|&e| e > VISIBLE).count()
    }
}

#[cfg(test)]
mod tests {
    use vr_core::Frame;
    use vr_io::SampleKind;

    use super::*;

    fn picture(pixels: &[[f32; 4]], alpha: bool) -> Picture {
        let frame = Frame::new([pixels.len() as u32, 1], pixels.to_vec(), None);
        Picture { frame, alpha, samples: SampleKind::Float, format: "EXR", layer: None }
    }

    #[test]
    fn opacity_counts_where_both_have_it() {
        let a = picture(&[[0.0, 0.0, 0.0, 0.5], [0.25; 4]], true);
        let b = picture(&[[0.0; 4], [0.25; 4]], true);
        let comparison = Comparison::new(&a, &b, [0.0; 3]);
        assert_eq!((comparison.metrics.max, comparison.visible(), comparison.blended), (0.5, 1, None));
        assert_eq!(comparison.differences().next(), Some([0.0, 0.0, 0.0, -0.5]));
        let worst = comparison.worst().unwrap();
        assert_eq!((worst.pixel, worst.error, worst.colors[0][3]), ([0, 0], 0.5, 0.5));
    }

    #[test]
    fn the_one_with_opacity_is_blended() {
        let a = picture(&[[0.25, 0.0, 0.0, 0.5]], true);
        let b = picture(&[[0.25, 0.0, 0.5, 1.0]], false);
        let comparison = Comparison::new(&a, &b, [0.0, 0.0, 1.0]);
        assert_eq!((comparison.metrics.max, comparison.blended), (0.0, Some(Blended::Reference)));
        assert!(comparison.worst().is_none());
        let turned = Comparison::new(&b, &a, [0.0; 3]);
        assert_eq!((turned.blended, turned.metrics.max), (Some(Blended::Picture), 0.5));
        assert_eq!(turned.differences().next(), Some([0.0, 0.0, -0.5, 0.0]));
    }

    #[test]
    fn maps_agree_with_the_numbers() {
        let a = picture(&[[10.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]], false);
        let b = picture(&[[9.0, 0.0, 0.0, 1.0], [0.0, f32::NAN, 0.0, 1.0]], false);
        let comparison = Comparison::new(&a, &b, [0.0; 3]);
        assert_eq!(comparison.errors().collect::<Vec<_>>(), [0.1, f64::INFINITY]);
        assert_eq!(comparison.metrics.max, f64::INFINITY);
        assert_eq!(comparison.worst().unwrap().pixel, [1, 0]);
    }
}
