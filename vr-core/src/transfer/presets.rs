//! Ready-made transfer functions.
//!
//! Opacities are meant for the default `unit_distance`, the mean voxel spacing, and for volumes of some 100 to 500 voxels
//! across: haze is 0.002 to 0.05, a surface 0.2 to 0.9.

use super::{ControlPoint, cool_warm, inferno, srgb_to_linear, viridis};

/// Number of points of a colour map: the straight lines between them are within 3 of 255 steps of the map itself (17 points: within 9).
const MAP_POINTS: usize = 33;

/// The scale of a 12-bit CT scanner, for which a CT preset takes a range of values that is not in Hounsfield units.
const SCANNER: (f64, f64) = (-1024.0, 3071.0);

/// A ready-made transfer function.
///
/// # Examples
/// ```
/// use vr_core::transfer::Preset;
/// use vr_core::{OpacityRule, TransferFunction};
///
/// let range = (-1024.0, 3071.0); // Hounsfield units
/// assert_eq!(Preset::suggest(range, true)[0], Preset::CtBone);
/// let bone = TransferFunction::new(Preset::CtBone.points(range), OpacityRule::Power, 1.0)?;
/// assert_eq!(bone.at(-1000.0).opacity, 0.0, "air");
/// assert!(bone.at(1500.0).opacity > 0.0);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// Black to white, opacity growing with the value.
    Grey,
    /// A radiograph: a white medium whose extinction is that of X-rays, proportional to value above air. Since it emits
    /// what it absorbs, a pixel is the part of the X-rays that is lost, 1 − e^(−τ): bone is white, as on film.
    XRay,
    /// Ivory bone; soft tissue is clear.
    CtBone,
    /// Skin, fat and muscle, translucent, around ivory bone; air is clear.
    CtSoftTissue,
    /// Brown to white, without the darkest values, which in MR are air and noise.
    MrDefault,
    /// The colour map viridis, opacity growing with the value.
    Viridis,
    /// The colour map inferno, opacity growing with the value.
    Inferno,
    /// The colour map cool-warm. For values of both signs: grey and clear at 0, equally far either way, opacity growing with the
    /// magnitude. For others: over the range, opacity growing with the value.
    CoolWarm,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Grey,
        Self::XRay,
        Self::CtBone,
        Self::CtSoftTissue,
        Self::MrDefault,
        Self::Viridis,
        Self::Inferno,
        Self::CoolWarm,
    ];

    /// Their names, in the same order.
    pub const NAMES: [&'static str; 8] =
        ["grey", "x-ray", "ct-bone", "ct-soft-tissue", "mr-default", "viridis", "inferno", "cool-warm"];

    /// Name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The preset of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// The control points for data in a range of calibrated values, by ascending value.
    ///
    /// The CT presets and `x-ray` are in Hounsfield units where the range is (see [`is_hounsfield`]); otherwise the range is
    /// taken for the scale of a 12-bit scanner, −1024 to 3071 HU. The others follow the range. One that is a single value
    /// is widened, so that the value lies in the middle.
    pub fn points(self, range: (f64, f64)) -> Vec<ControlPoint> {
        let range = widened(range);
        match self {
            Self::Grey => ramp(range, 2, |t| [t; 3], |t| 0.06 * t),
            Self::XRay => hounsfield_points(range, &X_RAY),
            Self::CtBone => hounsfield_points(range, &CT_BONE),
            Self::CtSoftTissue => hounsfield_points(range, &CT_SOFT_TISSUE),
            Self::MrDefault => points(&MR_DEFAULT, |t| range.0 + t * (range.1 - range.0)),
            Self::Viridis => ramp(range, MAP_POINTS, viridis, |t| 0.1 * t),
            Self::Inferno => ramp(range, MAP_POINTS, inferno, |t| 0.1 * t),
            Self::CoolWarm if has_both_signs(range) => {
                let reach = range.1.max(-range.0);
                ramp((-reach, reach), MAP_POINTS, cool_warm, |t| 0.1 * (2.0 * t - 1.0).abs())
            }
            Self::CoolWarm => ramp(range, MAP_POINTS, cool_warm, |t| 0.1 * t),
        }
    }

    /// The presets that are worth a try on data in a range of calibrated values, stored as integers or not; the best first.
    pub fn suggest(range: (f64, f64), integer: bool) -> Vec<Self> {
        if is_hounsfield(range) {
            vec![Self::CtBone, Self::CtSoftTissue, Self::XRay]
        } else if has_both_signs(range) {
            vec![Self::CoolWarm, Self::Viridis, Self::Inferno]
        } else if integer {
            vec![Self::Grey, Self::MrDefault, Self::CtBone, Self::XRay]
        } else {
            vec![Self::Viridis, Self::Inferno, Self::Grey]
        }
    }
}

impl std::fmt::Display for Preset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// True if values in a range look like Hounsfield units (air −1000, water 0): they begin below −500, which MR and 8-bit data
/// do not, and fit into the 16 bits that scanners store.
pub fn is_hounsfield((low, high): (f64, f64)) -> bool {
    (-32768.0..-500.0).contains(&low) && (0.0..32768.0).contains(&high)
}

fn has_both_signs((low, high): (f64, f64)) -> bool {
    low < 0.0 && high > 0.0
}

/// Value, sRGB colour and opacity of a control point.
type Row = (f64, [f64; 3], f64);

/// μ = μ_water·(1 + HU/1000), so extinction is linear from air upwards; 0.2 % per voxel of water lets two thirds through
/// 200 voxels of a body. So small an opacity is as good as proportional to extinction.
const X_RAY: [Row; 2] = [(-1000.0, [1.0; 3], 0.0), (3071.0, [1.0; 3], 0.002 * 4.071)];

/// After 3D Slicer's CT-Bone, whose ramp begins at −16 HU and veils bone in soft tissue; here it begins at the upper end of
/// blood and muscle. Cancellous bone is at 200 to 500 HU, cortical bone above.
const CT_BONE: [Row; 5] = [
    (150.0, [0.73, 0.25, 0.30], 0.0),
    (250.0, [0.85, 0.58, 0.42], 0.05),
    (450.0, [0.91, 0.82, 0.62], 0.40),
    (1000.0, [0.98, 0.94, 0.84], 0.80),
    (3071.0, [1.00, 1.00, 1.00], 0.90),
];

/// Fat is at about −100 HU, muscle and organs at 20 to 70, contrast agent and bone above 150.
const CT_SOFT_TISSUE: [Row; 7] = [
    (-300.0, [0.55, 0.25, 0.15], 0.0),
    (-120.0, [0.88, 0.66, 0.45], 0.03),
    (-30.0, [0.85, 0.50, 0.38], 0.04),
    (40.0, [0.72, 0.22, 0.18], 0.10),
    (100.0, [0.80, 0.32, 0.25], 0.12),
    (250.0, [0.95, 0.85, 0.70], 0.25),
    (1000.0, [1.00, 0.98, 0.92], 0.60),
];

/// Colours of 3D Slicer's MR-Default; values as fractions of the range, opacities a third of Slicer's, which are for shaded
/// surfaces.
const MR_DEFAULT: [Row; 6] = [
    (0.00, [0.0, 0.0, 0.0], 0.0),
    (0.10, [0.168627, 0.0, 0.0], 0.0),
    (0.20, [0.403922, 0.145098, 0.0784314], 0.03),
    (0.45, [0.780392, 0.607843, 0.380392], 0.10),
    (0.75, [0.847059, 0.835294, 0.788235], 0.15),
    (1.00, [1.0, 1.0, 1.0], 0.20),
];

fn points(rows: &[Row], value: impl Fn(f64) -> f64) -> Vec<ControlPoint> {
    rows.iter()
        .map(|&(position, srgb, opacity)| ControlPoint::new(value(position), srgb.map(srgb_to_linear), opacity))
        .collect()
}

fn hounsfield_points(range: (f64, f64), rows: &[Row]) -> Vec<ControlPoint> {
    if is_hounsfield(range) {
        return points(rows, |hu| hu);
    }
    let scale = (range.1 - range.0) / (SCANNER.1 - SCANNER.0);
    points(rows, |hu| range.0 + scale * (hu - SCANNER.0))
}

/// `count` points, evenly spaced over a range.
fn ramp(
    (low, high): (f64, f64),
    count: usize,
    color: impl Fn(f64) -> [f64; 3],
    opacity: impl Fn(f64) -> f64,
) -> Vec<ControlPoint> {
    let fractions = (0..count).map(|k| k as f64 / (count - 1) as f64);
    fractions.map(|t| ControlPoint::new(low + t * (high - low), color(t), opacity(t))).collect()
}

/// A range that is not a single value.
fn widened((low, high): (f64, f64)) -> (f64, f64) {
    if low < high {
        return (low, high);
    }
    let half = f64::max(0.5, 1e-6 * low.abs());
    (low - half, low + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{OpacityRule, TransferFunction, linear_to_srgb};

    const HU: (f64, f64) = (-1024.0, 3071.0);

    fn at(preset: Preset, range: (f64, f64), value: f64) -> ControlPoint {
        let points = preset.points(range);
        let after = points.iter().position(|p| p.value > value).unwrap_or(points.len());
        let (a, b) = (points[after.saturating_sub(1)], points[after.min(points.len() - 1)]);
        let t = if a.value < b.value { (value - a.value) / (b.value - a.value) } else { 0.0 };
        let mix = |a: f64, b: f64| a + t * (b - a);
        ControlPoint::new(value, std::array::from_fn(|i| mix(a.color[i], b.color[i])), mix(a.opacity, b.opacity))
    }

    #[test]
    fn names_are_found_again() {
        for preset in Preset::ALL {
            assert_eq!(Preset::from_name(preset.name()), Some(preset));
        }
        assert_eq!(Preset::from_name("rainbow"), None);
    }

    #[test]
    fn every_preset_is_a_transfer_function_over_any_range() {
        for range in [HU, (0.0, 255.0), (0.0, 1.0), (-1.0, 1e-3), (7.0, 7.0), (0.0, 0.0), (1e20, 1e20), (-1e9, 1e9)] {
            for preset in Preset::ALL {
                let made = TransferFunction::new(preset.points(range), OpacityRule::Power, 1.0);
                assert!(made.is_ok(), "{preset} over {range:?}: {made:?}");
            }
        }
    }

    #[test]
    fn a_constant_volume_is_visible() {
        for preset in Preset::ALL {
            assert!(at(preset, (7.0, 7.0), 7.0).opacity > 0.0, "{preset}");
        }
    }

    #[test]
    fn ct_presets_show_what_they_are_named_after() {
        // In Hounsfield units, and on the same scan stored without its calibration.
        for (range, stored) in [(HU, 0.0), ((0.0, 4095.0), 1024.0)] {
            let opacity = |preset, hu: f64| at(preset, range, hu + stored).opacity;
            assert_eq!(opacity(Preset::CtBone, 60.0), 0.0, "muscle is clear");
            assert!(opacity(Preset::CtBone, 700.0) > 0.5, "bone is not");
            assert_eq!(opacity(Preset::CtSoftTissue, -900.0), 0.0, "air is clear");
            assert!((0.05..0.2).contains(&opacity(Preset::CtSoftTissue, 40.0)), "muscle is translucent");
            assert!((opacity(Preset::XRay, 1000.0) / opacity(Preset::XRay, 0.0) - 2.0).abs() < 1e-9, "μ is linear");
        }
        let [r, g, b] = at(Preset::CtBone, HU, 800.0).color;
        assert!(r > g && g > b && b > 0.4 * r, "ivory: {r} {g} {b}");
    }

    #[test]
    fn hounsfield_is_told_from_other_data() {
        assert!(is_hounsfield((-1024.0, 1800.0)) && is_hounsfield((-3024.0, 3071.0)));
        assert!(!is_hounsfield((0.0, 4095.0)) && !is_hounsfield((-1.0, 1.0)) && !is_hounsfield((-1e6, 1e6)));
    }

    #[test]
    fn suggestions_fit_the_data() {
        assert_eq!(Preset::suggest(HU, true)[0], Preset::CtBone);
        assert_eq!(Preset::suggest((-1.0, 1.0), false)[0], Preset::CoolWarm);
        assert_eq!(Preset::suggest((0.0, 1.0), false)[0], Preset::Viridis);
        assert!(Preset::suggest((0.0, 255.0), true).contains(&Preset::MrDefault));
    }

    #[test]
    fn colour_maps_have_points_enough() {
        for (preset, map) in [
            (Preset::Viridis, viridis as fn(f64) -> [f64; 3]),
            (Preset::Inferno, inferno),
            (Preset::CoolWarm, cool_warm),
        ] {
            let mut worst = 0.0f64;
            for k in 0..=1000 {
                let t = f64::from(k) / 1000.0;
                let encoded = |rgb: [f64; 3]| rgb.map(|c| 255.0 * linear_to_srgb(c));
                let (found, expected) = (encoded(at(preset, (0.0, 1.0), t).color), encoded(map(t)));
                worst = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(worst, f64::max);
            }
            assert!(worst < 3.0, "{preset}: {worst} steps of 8 bits");
        }
    }
}
