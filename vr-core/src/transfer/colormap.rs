//! Colour maps from a fraction t in [0, 1] to linear-light RGB. Fractions outside take the end's colour.

use colorous::Gradient;

use super::msh::diverging;
use super::srgb::srgb_to_linear;

/// Viridis: dark violet over green to yellow, of even perceptual steps (van der Walt & Smith, matplotlib 1.5, 2015).
pub fn viridis(t: f64) -> [f64; 3] {
    of_gradient(colorous::VIRIDIS, t)
}

/// Inferno: black over purple and orange to pale yellow, of even perceptual steps (van der Walt & Smith, matplotlib 1.5, 2015).
pub fn inferno(t: f64) -> [f64; 3] {
    of_gradient(colorous::INFERNO, t)
}

/// Cool to warm: blue over light grey to red, for values with a meaningful middle (Moreland, "Diverging color maps for
/// scientific visualization", 2009); ParaView's default.
pub fn cool_warm(t: f64) -> [f64; 3] {
    diverging(of_bytes([59, 76, 192]), of_bytes([180, 4, 38]), t.clamp(0.0, 1.0))
}

/// A colour map by name.
///
/// # Examples
/// ```
/// use vr_core::transfer::{ColorMap, viridis};
///
/// let map = ColorMap::from_name("viridis").expect("one of them");
/// assert_eq!(map.at(0.25), viridis(0.25));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ColorMap {
    /// [`viridis`].
    #[default]
    Viridis,
    /// [`inferno`].
    Inferno,
    /// [`cool_warm`].
    CoolWarm,
}

impl ColorMap {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Viridis, Self::Inferno, Self::CoolWarm];

    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Inferno => "inferno",
            Self::CoolWarm => "cool-warm",
        }
    }

    /// The colour map of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|map| map.name() == name)
    }

    /// The linear light of a fraction.
    pub fn at(self, t: f64) -> [f64; 3] {
        match self {
            Self::Viridis => viridis(t),
            Self::Inferno => inferno(t),
            Self::CoolWarm => cool_warm(t),
        }
    }
}

fn of_gradient(gradient: Gradient, t: f64) -> [f64; 3] {
    of_bytes(gradient.eval_continuous(t).into_array())
}

/// The linear light of 8-bit sRGB.
fn of_bytes(rgb: [u8; 3]) -> [f64; 3] {
    rgb.map(|c| srgb_to_linear(f64::from(c) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::linear_to_srgb;

    fn bytes(rgb: [f64; 3]) -> [i32; 3] {
        rgb.map(|c| (255.0 * linear_to_srgb(c)).round() as i32)
    }

    fn assert_close(found: [f64; 3], expected: [i32; 3]) {
        let found = bytes(found);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() <= 1), "{found:?} {expected:?}");
    }

    #[test]
    fn cool_warm_is_the_published_one() {
        // Every fourth row of Moreland's CoolWarmUChar33.csv.
        let table = [
            [59, 76, 192],
            [98, 130, 234],
            [141, 176, 254],
            [184, 208, 249],
            [221, 221, 221],
            [245, 196, 173],
            [244, 154, 123],
            [222, 96, 77],
            [180, 4, 38],
        ];
        for (k, expected) in table.into_iter().enumerate() {
            assert_close(cool_warm(k as f64 / 8.0), expected);
        }
    }

    #[test]
    fn viridis_and_inferno_have_the_published_ends() {
        assert_close(viridis(0.0), [68, 1, 84]);
        assert_close(viridis(1.0), [253, 231, 37]);
        assert_close(viridis(0.5), [33, 145, 140]);
        assert_close(inferno(0.0), [0, 0, 4]);
        assert_close(inferno(1.0), [252, 255, 164]);
    }

    #[test]
    fn fractions_outside_take_the_end() {
        for map in [viridis, inferno, cool_warm] {
            assert_eq!(map(-1.0), map(0.0));
            assert_eq!(map(7.0), map(1.0));
        }
    }
}
