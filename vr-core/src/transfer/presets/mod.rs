//! Ready-made transfer functions.
//!
//! Opacities are meant for the default `unit_distance`, the mean voxel spacing, and for volumes of some 100 to 500 voxels
//! across: haze is 0.002 to 0.05, a surface 0.2 to 0.9.

mod hounsfield;
mod recipe;
mod table;

use crate::shading::Shading;

use super::ControlPoint;
use recipe::{Curve, Recipe, points, ramp};
use table::RECIPES;

pub use hounsfield::{HounsfieldScale, is_hounsfield};

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
#[non_exhaustive]
pub enum Preset {
    /// Black to white, opacity growing with the value.
    Grey,
    /// The colour map viridis, opacity growing with the value.
    Viridis,
    /// The colour map inferno, opacity growing with the value.
    Inferno,
    /// The colour map cool-warm. For values of both signs: grey and clear at 0, equally far either way, opacity growing with the
    /// magnitude. For others: over the range, opacity growing with the value.
    CoolWarm,
    /// A radiograph: a white medium whose extinction is that of X-rays, proportional to value above air. Since it emits
    /// what it absorbs, a pixel is the part of the X-rays that is lost, 1 − e^(−τ): bone is white, as on film.
    XRay,
    /// Ivory bone; soft tissue is clear.
    CtBone,
    /// Vessels with contrast agent, and bone.
    CtAngio,
    /// Lungs as haze; the body around them is clear.
    CtLung,
    /// Skin, fat and muscle, translucent, around ivory bone; air is clear.
    CtSoftTissue,
    /// Chambers of the heart and vessels with contrast agent.
    CtCardiac,
    /// Muscle and organs; skin and fat are clear.
    CtMuscle,
    /// The skin, opaque.
    CtSkin,
    /// Fat, and a trace of bone.
    CtFat,
    /// The surface of air: airways, lungs, sinuses and bowel, within a veil of skin.
    CtAir,
    /// The densest value along each ray, for [`crate::Compositing::Maximum`].
    CtMip,
    /// Brown to white, without the darkest values, which in MR are air and noise.
    MrDefault,
    /// A brain under T2 weighting: fluid through grey and white matter.
    MrT2Brain,
    /// Bright vessels alone: time of flight, or with contrast agent.
    MrAngio,
    /// Uptake of a tracer, glowing.
    PetHot,
    /// Echoes; fluid is clear.
    Ultrasound,
    /// A stain that glows, in a microscope.
    Fluorescence,
    /// Dense structures as surfaces: micro-CT, electron microscopy, bright stains.
    Microscopy,
}

/// Kind of data that a preset is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresetFamily {
    /// Any data: a colour map.
    Any,
    /// Computed tomography.
    Ct,
    /// Magnetic resonance.
    Mr,
    /// Emission tomography.
    Pet,
    /// Ultrasound.
    Ultrasound,
    /// Microscopy.
    Microscopy,
}

/// Meaning of a preset's positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PresetUnit {
    /// Hounsfield units, which are values of their own: nothing is stretched.
    Hounsfield,
    /// Fractions of the signal: from the lowest to the highest value that is not rare.
    Signal,
    /// Fractions of the whole range of values.
    Range,
}

impl PresetUnit {
    /// The unit in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hounsfield => "Hounsfield units",
            Self::Signal => "parts of the signal",
            Self::Range => "parts of the range",
        }
    }
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; RECIPES.len()] = [
        Self::Grey,
        Self::Viridis,
        Self::Inferno,
        Self::CoolWarm,
        Self::XRay,
        Self::CtBone,
        Self::CtAngio,
        Self::CtLung,
        Self::CtSoftTissue,
        Self::CtCardiac,
        Self::CtMuscle,
        Self::CtSkin,
        Self::CtFat,
        Self::CtAir,
        Self::CtMip,
        Self::MrDefault,
        Self::MrT2Brain,
        Self::MrAngio,
        Self::PetHot,
        Self::Ultrasound,
        Self::Fluorescence,
        Self::Microscopy,
    ];

    /// Their names, in the same order.
    pub const NAMES: [&'static str; RECIPES.len()] = {
        let mut names = [""; RECIPES.len()];
        let mut i = 0;
        while i < names.len() {
            names[i] = RECIPES[i].name;
            i += 1;
        }
        names
    };

    fn recipe(self) -> &'static Recipe {
        &RECIPES[self as usize]
    }

    /// Name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        self.recipe().name
    }

    /// The preset of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// Content of the picture, in one line.
    pub fn title(self) -> &'static str {
        self.recipe().title
    }

    /// Kind of data that it is made for.
    pub fn family(self) -> PresetFamily {
        self.recipe().family
    }

    /// Meaning of its positions.
    pub fn unit(self) -> PresetUnit {
        match self.recipe().curve {
            Curve::Hounsfield(_) => PresetUnit::Hounsfield,
            Curve::Signal(_) => PresetUnit::Signal,
            Curve::Map { .. } | Curve::Diverging { .. } => PresetUnit::Range,
        }
    }

    /// Shading, where it shows surfaces.
    pub fn shading(self) -> Option<Shading> {
        self.recipe().gloss.as_ref().map(|gloss| gloss.shading())
    }

    /// True if it is made for [`crate::Compositing::Maximum`], not for light and absorption.
    pub fn is_projection(self) -> bool {
        self.recipe().is_projection
    }

    /// The control points for data in a range of calibrated values, by ascending value: the range of the signal where
    /// [`Self::unit`] is [`PresetUnit::Signal`], all values otherwise.
    ///
    /// Presets in Hounsfield units are placed by [`HounsfieldScale::of_range`]. The others follow the range. One that is a single
    /// value is widened, so that the value lies in the middle.
    pub fn points(self, range: (f64, f64)) -> Vec<ControlPoint> {
        let (low, high) = widened(range);
        self.points_at((low, high), |place| low + place * (high - low))
    }

    /// The control points of [`Self::points`], with the signal's places spread by a function from 0..1 to ascending values.
    pub fn points_at(self, range: (f64, f64), signal: impl Fn(f64) -> f64) -> Vec<ControlPoint> {
        let range = widened(range);
        match self.recipe().curve {
            Curve::Hounsfield(rows) => {
                let scale = HounsfieldScale::of_range(range);
                points(rows, |hounsfield| scale.value(hounsfield))
            }
            Curve::Signal(rows) => points(rows, signal),
            Curve::Diverging { color, points, opacity } if has_both_signs(range) => {
                let reach = range.1.max(-range.0);
                ramp((-reach, reach), points, color, |t| opacity * (2.0 * t - 1.0).abs())
            }
            Curve::Map { color, points, opacity } | Curve::Diverging { color, points, opacity } => {
                ramp(range, points, color, |t| opacity * t)
            }
        }
    }

    /// The presets that are worth a try on data in a range of calibrated values, stored as integers or not; the best first.
    pub fn suggest(range: (f64, f64), integer: bool) -> Vec<Self> {
        if is_hounsfield(range) {
            vec![Self::CtBone, Self::CtSoftTissue, Self::CtSkin, Self::CtAngio, Self::XRay]
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

fn has_both_signs((low, high): (f64, f64)) -> bool {
    low < 0.0 && high > 0.0
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
    use crate::transfer::{OpacityRule, TransferFunction, cool_warm, inferno, linear_to_srgb, viridis};

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
        for (preset, name) in Preset::ALL.into_iter().zip(Preset::NAMES) {
            assert_eq!(preset.name(), name);
            assert_eq!(Preset::from_name(name), Some(preset));
            let variant = format!("{preset:?}").to_lowercase();
            assert_eq!(variant, name.replace('-', ""), "the table is in the order of the variants");
            assert!(!preset.title().is_empty() && preset.title().len() < 90);
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
        // Taken for the scale of a scanner, its middle is as dense as bone.
        let bones_are_clear = [Preset::CtLung, Preset::CtAir];
        for preset in Preset::ALL.into_iter().filter(|preset| !bones_are_clear.contains(preset)) {
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
            // Air, lung, fat, muscle, contrast agent, cortical bone.
            for (preset, shows, hides) in [
                (Preset::CtAngio, &[300.0, 1200.0][..], &[-1000.0, -800.0, -100.0, 50.0][..]),
                (Preset::CtLung, &[-800.0, -600.0], &[-1000.0, -100.0, 50.0, 1200.0]),
                (Preset::CtCardiac, &[300.0], &[-1000.0, -800.0, -100.0, 50.0]),
                (Preset::CtMuscle, &[50.0, 1200.0], &[-1000.0, -800.0, -100.0]),
                (Preset::CtSkin, &[-100.0, 50.0], &[-1000.0, -800.0]),
                (Preset::CtFat, &[-100.0], &[-1000.0, -800.0, 50.0]),
                (Preset::CtAir, &[-650.0], &[-1000.0, -100.0, 50.0, 1200.0]),
            ] {
                assert!(shows.iter().all(|&hu| opacity(preset, hu) > 0.01), "{preset}");
                assert!(hides.iter().all(|&hu| opacity(preset, hu) == 0.0), "{preset}");
            }
        }
        let [r, g, b] = at(Preset::CtBone, HU, 800.0).color;
        assert!(r > g && g > b && b > 0.4 * r, "ivory: {r} {g} {b}");
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
