//! Errors of a picture against the reference, in the numbers that every table of this project uses.
//!
//! An error is frame − reference, for every component of every pixel that counts (premultiplied linear light), divided by
//! max(1, largest magnitude of the reference): absolute for ordinary pictures, relative for those brighter than 1.

use glam::{DVec2, DVec3};
use vr_core::{ParameterError, View, Volume};

/// Pixels this close to a projected edge of the box are left out of comparisons with other programs, which place the box
/// and its outermost half voxels differently.
pub const OUTLINE_REACH: f64 = 2.0;

/// The components of a pixel that are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// Red, green, blue and opacity.
    #[default]
    Rgba,
    /// Red, green and blue alone: other programs seldom hand over opacity.
    Rgb,
}

impl Channels {
    fn count(self) -> usize {
        match self {
            Self::Rgba => 4,
            Self::Rgb => 3,
        }
    }
}

/// The error of a frame against a reference; see the [module](self) for what an error is.
///
/// A component that is NaN or infinite has an infinite error. No pixel at all has no error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Largest |e|.
    pub max: f64,
    /// Root of the mean of e².
    pub rmse: f64,
    /// Mean of e with its sign: above 0 where the frame is too bright. Infinite (whatever the signs) as soon as one e is.
    pub bias: f64,
    /// 99th percentile of |e|: the smallest |e| that at least 99 % of all do not exceed.
    pub p99: f64,
    /// Peak signal-to-noise ratio in dB with a peak of 1: −20 log₁₀ RMSE; +∞ for an exact picture.
    pub psnr: f64,
    /// Largest magnitude of a component of the whole reference, R, G, B and A, whatever is compared.
    pub peak_reference: f64,
    /// Pixels compared.
    pub pixels: usize,
}

impl Metrics {
    /// Compares all components of all pixels.
    ///
    /// # Panics
    /// Panics if there are not as many pixels on both sides.
    pub fn of(reference: &[[f64; 4]], frame: &[[f32; 4]]) -> Self {
        Self::of_selected(reference, frame, Channels::Rgba, |_| true)
    }

    /// Compares some components of those pixels whose index is selected. The peak is that of the whole reference, so that numbers of
    /// different selections can be compared.
    ///
    /// # Panics
    /// Panics if there are not as many pixels on both sides.
    pub fn of_selected(
        reference: &[[f64; 4]],
        frame: &[[f32; 4]],
        channels: Channels,
        selected: impl Fn(usize) -> bool,
    ) -> Self {
        assert_eq!(reference.len(), frame.len(), "as many pixels in the reference as in the frame");
        let peak = reference.iter().flatten().fold(0.0, |peak: f64, c| peak.max(c.abs()));
        let scale = peak.max(1.0);
        let mut errors = Vec::new();
        let (mut sum, mut squares) = (CompensatedSum::default(), CompensatedSum::default());
        let mut pixels = 0;
        for (_, (r, f)) in reference.iter().zip(frame).enumerate().filter(|(i, _)| selected(*i)) {
            pixels += 1;
            for c in 0..channels.count() {
                let e = (f64::from(f[c]) - r[c]) / scale;
                let e = if e.is_finite() { e } else { f64::INFINITY };
                sum.add(e);
                squares.add(e * e);
                errors.push(e.abs());
            }
        }
        if errors.is_empty() {
            return Self {
                max: 0.0,
                rmse: 0.0,
                bias: 0.0,
                p99: 0.0,
                psnr: f64::INFINITY,
                peak_reference: peak,
                pixels,
            };
        }
        let n = errors.len() as f64;
        errors.sort_unstable_by(f64::total_cmp);
        let rmse = (squares.total() / n).sqrt();
        Self {
            max: errors[errors.len() - 1],
            rmse,
            bias: sum.total() / n,
            // The nearest rank, counted from 1.
            p99: errors[(0.99 * n).ceil() as usize - 1],
            psnr: -20.0 * libm::log10(rmse),
            peak_reference: peak,
            pixels,
        }
    }

    /// Compares with a picture of another program: RGB only, the pixels of the [`outline_mask`] left out.
    ///
    /// # Errors
    /// A view that makes no sense.
    ///
    /// # Panics
    /// Panics if reference and frame do not both have one entry per pixel of the view.
    pub fn inside_outline(
        reference: &[[f64; 4]],
        frame: &[[f32; 4]],
        volume: &Volume,
        view: &View,
    ) -> Result<Self, ParameterError> {
        let mask = outline_mask(volume, view)?;
        assert_eq!(reference.len(), mask.len(), "one entry per pixel of the view");
        Ok(Self::of_selected(reference, frame, Channels::Rgb, |i| !mask[i]))
    }
}

impl std::fmt::Display for Metrics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { max, rmse, bias, p99, psnr, .. } = self;
        write!(f, "max {max:.2e}, RMSE {rmse:.2e}, bias {bias:+.2e}, p99 {p99:.2e}, PSNR {psnr:.1} dB")
    }
}

/// A sum of many terms whose error does not grow with their number (Neumaier 1974).
#[derive(Clone, Copy, Default)]
struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        let (large, small) = if self.sum.abs() >= x.abs() { (self.sum, x) } else { (x, self.sum) };
        self.lost += (large - sum) + small;
        self.sum = sum;
    }

    fn total(&self) -> f64 {
        // After an infinite term, what was lost is NaN.
        if self.sum.is_finite() { self.sum + self.lost } else { self.sum }
    }
}

/// One pixel of each part of a picture that is cut into `n` × `n` parts, row by row of the parts.
///
/// The place of a pixel in its part follows a sequence that fills the square evenly and repeats nothing (R2; Roberts 2018, "The unreasonable
/// effectiveness of quasirandom sequences"): a renderer that traces every fourth pixel and interpolates the rest is not judged
/// by every fourth pixel. A side with fewer than `n` pixels gives all of them, each once.
pub fn subgrid(n: u32, size: [u32; 2]) -> Vec<[u32; 2]> {
    let parts = size.map(|side| n.min(side));
    // Powers of the inverse of the plastic number, ρ³ = ρ + 1.
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let mut pixels = Vec::with_capacity(parts[0] as usize * parts[1] as usize);
    for y in 0..parts[1] {
        for x in 0..parts[0] {
            let k = pixels.len() as f64;
            pixels.push([0, 1].map(|a| {
                let part = u64::from([x, y][a]);
                let edge = |part: u64| part * u64::from(size[a]) / u64::from(parts[a]);
                let (low, high) = (edge(part), edge(part + 1));
                let share = (0.5 + STEP[a] * k).fract();
                (low + (share * (high - low) as f64) as u64) as u32
            }));
        }
    }
    pixels
}

/// Marks the pixels of a view, row by row: true if the centre lies within [`OUTLINE_REACH`] pixels of a projected edge of the
/// volume's box (hidden edges count, too).
///
/// # Errors
/// A view that makes no sense.
pub fn outline_mask(volume: &Volume, view: &View) -> Result<Vec<bool>, ParameterError> {
    view.validate()?;
    let corners = box_corners(volume);
    let to_eye_space = EyeSpace::new(view)?;
    let corners = corners.map(|c| to_eye_space.point(c));
    // Corners whose numbers differ in one bit share an edge.
    let edges = (0..8usize).flat_map(|c| (0..3).map(move |axis| (c, c | 1 << axis))).filter(|(a, b)| a != b);
    let segments: Vec<(DVec2, DVec2)> =
        edges.filter_map(|(a, b)| to_eye_space.project_edge(corners[a], corners[b])).collect();
    let [width, height] = view.size;
    let centres = (0..height).flat_map(|y| (0..width).map(move |x| DVec2::new(x.into(), y.into()) + 0.5));
    Ok(centres.map(|p| segments.iter().any(|&(a, b)| distance_to_segment(p, a, b) <= OUTLINE_REACH)).collect())
}

/// The corners of the box: bit a of a corner's number says which end of axis a.
fn box_corners(volume: &Volume) -> [DVec3; 8] {
    if let Some(uniform) = volume.grid() {
        return uniform.corners();
    }
    let (low, high) = volume.bounds();
    std::array::from_fn(|c| DVec3::select(glam::BVec3::new(c & 1 == 1, c & 2 == 2, c & 4 == 4), high, low))
}

/// Coordinates (right, up, forward) from the eye, and from there to pixels.
struct EyeSpace {
    eye: DVec3,
    from_world: glam::DMat3,
    perspective: bool,
    pixels_per_unit: f64,
    middle: DVec2,
}

impl EyeSpace {
    fn new(view: &View) -> Result<Self, ParameterError> {
        let frame = view.camera.frame()?;
        let projection = view.camera.projection;
        Ok(Self {
            eye: view.camera.eye,
            from_world: frame.transpose(),
            perspective: projection.is_perspective(),
            pixels_per_unit: f64::from(view.size[1]) / projection.height(),
            middle: 0.5 * DVec2::new(view.size[0].into(), view.size[1].into()),
        })
    }

    fn point(&self, world: DVec3) -> DVec3 {
        self.from_world * (world - self.eye)
    }

    /// An edge in pixels from the top left corner; `None` where all of it is behind the eye.
    fn project_edge(&self, mut a: DVec3, mut b: DVec3) -> Option<(DVec2, DVec2)> {
        // Just before the eye: what is behind it has no place in the picture, and what is in its plane is infinitely far out.
        let near = 1e-9 * a.length().max(b.length());
        if a.z < near && b.z < near {
            return None;
        }
        if self.perspective {
            let cut = |from: DVec3, to: DVec3| from + (to - from) * ((near - from.z) / (to.z - from.z));
            if a.z < near {
                a = cut(a, b);
            } else if b.z < near {
                b = cut(b, a);
            }
        }
        let to_pixel = |p: DVec3| {
            let p = if self.perspective { p / p.z } else { p };
            self.middle + DVec2::new(p.x, -p.y) * self.pixels_per_unit
        };
        Some((to_pixel(a), to_pixel(b)))
    }
}

fn distance_to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = if along == DVec2::ZERO { 0.0 } else { (p - a).dot(along) / along.length_squared() };
    p.distance(a + along * t.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Camera, Placement, Projection, UniformGrid};

    #[test]
    fn one_hand_computed_picture() {
        // Errors, undivided: 0, 0.1, −0.3, 0 and 0, 0, 0, 0.2; the reference's peak is 0.5, so the divisor is 1.
        let reference = [[0.0, 0.4, 0.5, 0.0], [0.25; 4]];
        let frame = [[0.0, 0.5, 0.2, 0.0], [0.25, 0.25, 0.25, 0.45]];
        let m = Metrics::of(&reference, &frame);
        assert!((m.max - 0.3).abs() < 1e-7 && m.p99 == m.max, "{m:?}");
        assert!((m.rmse - (0.14f64 / 8.0).sqrt()).abs() < 1e-7);
        assert!(m.bias.abs() < 1e-7, "0.1 − 0.3 + 0.2 = 0");
        assert!((m.psnr - 17.569_62).abs() < 1e-4, "−10 log₁₀ 0.0175");
        assert_eq!((m.peak_reference, m.pixels), (0.5, 2));
        let rgb = Metrics::of_selected(&reference, &frame, Channels::Rgb, |i| i == 0);
        assert!((rgb.bias - -0.2 / 3.0).abs() < 1e-7 && rgb.pixels == 1);
        assert_eq!(Metrics::of(&[[0.5; 4]], &[[0.5; 4]]).psnr, f64::INFINITY);
    }

    #[test]
    fn bright_pictures_are_judged_by_their_peak() {
        let m = Metrics::of(&[[100.0, 0.0, 0.0, 1.0]], &[[101.0, 0.0, 0.0, 1.0]]);
        assert_eq!((m.max, m.bias, m.peak_reference), (0.01, 0.0025, 100.0));
        // The peak is that of the whole picture, also for a part of it.
        let part = Metrics::of_selected(&[[100.0; 4], [0.0; 4]], &[[100.0; 4], [1.0; 4]], Channels::Rgba, |i| i == 1);
        assert_eq!(part.max, 0.01);
    }

    #[test]
    fn what_is_no_number_is_infinitely_wrong() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let m = Metrics::of(&[[0.0; 4]], &[[0.0, bad, 0.0, 0.0]]);
            assert_eq!(
                [m.max, m.rmse, m.bias, m.p99, m.psnr],
                [f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY]
            );
        }
    }

    #[test]
    fn percentile_is_the_nearest_rank() {
        // 100 pixels, 400 components: 4 of them wrong by 1 are the hundredth part, 5 are more.
        let frame = |wrong: usize| (0..100).map(move |i| if i < wrong { [1.0, 0.0, 0.0, 0.0] } else { [0.0; 4] });
        let p99 = |wrong| Metrics::of(&[[0.0; 4]; 100], &frame(wrong).collect::<Vec<_>>()).p99;
        assert_eq!((p99(4), p99(5)), (0.0, 1.0));
    }

    #[test]
    fn sums_do_not_drown_small_terms() {
        let mut sum = CompensatedSum::default();
        for x in [1.0, 1e100, 1.0, -1e100] {
            sum.add(x);
        }
        assert_eq!(sum.total(), 2.0);
    }

    #[test]
    fn subgrid_takes_one_pixel_of_each_part() {
        for (n, size) in [(64, [512, 512]), (3, [10, 1]), (5, [2, 2]), (u32::MAX, [7, 4]), (10, [101, 33])] {
            let pixels = subgrid(n, size);
            let parts = size.map(|side: u32| n.min(side));
            assert_eq!(pixels.len() as u32, parts[0] * parts[1]);
            for (k, pixel) in (0..).zip(&pixels) {
                for (a, part) in [k % parts[0], k / parts[0]].into_iter().enumerate() {
                    let edge = |part: u32| (u64::from(part) * u64::from(size[a]) / u64::from(parts[a])) as u32;
                    assert!((edge(part)..edge(part + 1)).contains(&pixel[a]), "{pixel:?} of {n}, {size:?}");
                }
            }
        }
    }

    #[test]
    fn subgrid_follows_no_pattern() {
        // Every place in a part of 8×8 is taken about as often as any other: 64 times.
        let mut taken = [0; 64];
        for [x, y] in subgrid(64, [512, 512]) {
            taken[(y % 8 * 8 + x % 8) as usize] += 1;
        }
        assert!(taken.iter().all(|n| (58..=70).contains(n)), "{taken:?}");
    }

    fn cube(edge: f64) -> Volume {
        let placement = Placement::new(DVec3::splat(-0.5 * edge), glam::DMat3::from_diagonal(DVec3::splat(edge)));
        UniformGrid::new([2; 3], vec![0u8; 8], placement.unwrap(), Calibration::default()).unwrap().into()
    }

    #[test]
    fn outline_of_a_cube_seen_from_the_front() {
        let camera = Camera {
            eye: DVec3::Z * 50.0,
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 32.0 },
        };
        // One pixel a unit: the outline is the square from 6 to 26.
        let mask = outline_mask(&cube(20.0), &View::new(camera, [32, 32])).unwrap();
        for (i, near) in mask.into_iter().enumerate() {
            let p = DVec2::new((i % 32) as f64 + 0.5, (i / 32) as f64 + 0.5) - 16.0;
            let beyond = (p.abs() - 10.0).max(DVec2::ZERO).length();
            let within = 10.0 - p.abs().max_element();
            assert_eq!(near, beyond <= 2.0 && within <= 2.0, "pixel {i}");
        }
    }

    #[test]
    fn edges_behind_a_perspective_eye_leave_no_mark() {
        let camera = Camera {
            eye: DVec3::ZERO,
            target: DVec3::NEG_Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov: 90.0 },
        };
        // From the centre of a cube, a field of view of 90° sees exactly one face: its edges are the picture's edges, and
        // the four that run towards the eye end in its corners.
        let mask = outline_mask(&cube(2.0), &View::new(camera, [32, 32])).unwrap();
        for (i, near) in mask.into_iter().enumerate() {
            let (x, y) = (i % 32, i / 32);
            let border = x.min(31 - x).min(y.min(31 - y));
            assert_eq!(near, border < 2, "pixel {i}");
        }
    }
}
