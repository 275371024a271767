//! CIELAB, in which equal distances look about equally large.

/// Matrix from linear sRGB to CIE XYZ, as IEC 61966-2-1 rounds it (and as VTK uses it).
const XYZ_OF_RGB: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
/// The exact inverse of the matrix above.
const RGB_OF_XYZ: [[f64; 3]; 3] = [
    [3.240_625_477_320_053_3, -1.537_207_972_210_318_7, -0.498_628_598_698_247_9],
    [-0.968_930_714_729_319_4, 1.875_756_060_885_241, 0.041_517_523_842_953_94],
    [0.055_710_120_445_510_61, -0.204_021_050_598_486_7, 1.056_995_942_254_388_4],
];
/// XYZ of white (D65): the row sums of the matrix, so that greys have no colour at all.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];

/// A colour in CIE 1976 L*a*b* under D65.
///
/// # Examples
/// ```
/// use vr_core::transfer::Lab;
///
/// let [black, white] = [[0.0; 3], [1.0; 3]].map(Lab::from_linear_rgb);
/// let grey = black.lerp(white, 0.5);
/// assert!((grey.l - 50.0).abs() < 0.01, "half as light to the eye");
/// assert!((grey.to_linear_rgb()[0] - 0.184).abs() < 0.001, "by a fifth of the light");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// Lightness L*, from 0 (black) to 100 (white).
    pub l: f64,
    /// a*: red where positive, green where negative.
    pub a: f64,
    /// b*: yellow where positive, blue where negative.
    pub b: f64,
}

impl Lab {
    /// The Lab coordinates of a linear-light sRGB colour.
    pub fn from_linear_rgb(rgb: [f64; 3]) -> Self {
        let [x, y, z] = product(&XYZ_OF_RGB, rgb);
        let [x, y, z] = [compress(x / WHITE[0]), compress(y / WHITE[1]), compress(z / WHITE[2])];
        Self { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }

    /// The linear-light sRGB colour, clamped to [0, 1] where sRGB cannot show it.
    pub fn to_linear_rgb(self) -> [f64; 3] {
        let y = (self.l + 16.0) / 116.0;
        let xyz = [WHITE[0] * expand(y + self.a / 500.0), WHITE[1] * expand(y), WHITE[2] * expand(y - self.b / 200.0)];
        product(&RGB_OF_XYZ, xyz).map(|c| c.clamp(0.0, 1.0))
    }

    /// The colour at a fraction t of the way to another: what ParaView's colour space `Lab` does between two points.
    pub fn lerp(self, to: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self { l: mix(self.l, to.l), a: mix(self.a, to.a), b: mix(self.b, to.b) }
    }
}

fn product(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Cube root at which CIE's f changes to its tangent, which has a finite slope at black: δ = 6/29 in CIE 15:2004.
const DELTA: f64 = 6.0 / 29.0;

/// CIE's f: the cube root, with a linear toe.
fn compress(t: f64) -> f64 {
    if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// The inverse of `compress`.
fn expand(f: f64) -> f64 {
    if f > DELTA { f * f * f } else { 3.0 * DELTA * DELTA * (f - 4.0 / 29.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::srgb_to_linear;

    #[test]
    fn known_colours() {
        // As published, with a white that is rounded a little differently (EasyRGB and others).
        let close = |rgb: [f64; 3], expected: [f64; 3]| {
            let lab = Lab::from_linear_rgb(rgb);
            let error = [lab.l - expected[0], lab.a - expected[1], lab.b - expected[2]];
            assert!(error.iter().all(|e| e.abs() < 0.02), "{rgb:?}: {lab:?}");
        };
        close([0.0; 3], [0.0, 0.0, 0.0]);
        close([1.0; 3], [100.0, 0.0, 0.0]);
        close([1.0, 0.0, 0.0], [53.233, 80.109, 67.220]);
        close([0.0, 1.0, 0.0], [87.737, -86.185, 83.181]);
        close([0.0, 0.0, 1.0], [32.303, 79.197, -107.864]);
    }

    #[test]
    fn goes_there_and_back() {
        for k in 0..1000 {
            let rgb = [k / 100, k / 10 % 10, k % 10].map(|c| srgb_to_linear(f64::from(c) / 9.0));
            let back = Lab::from_linear_rgb(rgb).to_linear_rgb();
            assert!((0..3).all(|i| (back[i] - rgb[i]).abs() < 1e-13), "{rgb:?} {back:?}");
        }
    }
}
