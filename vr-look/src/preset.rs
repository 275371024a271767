//! Presets fitted to a volume: their points at its values, and what is worth a word.

use vr_core::transfer::{HounsfieldScale, Preset, PresetFamily, PresetUnit};
use vr_core::{Compositing, ControlPoint, Shading};

use crate::kind::{Kind, kind_of};
use crate::number::short;
use crate::scale::Scale;
use crate::survey::{Hints, Survey};

/// A preset at the values of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedPreset {
    /// Control points for a unit distance of [`vr_core::Volume::mean_spacing`].
    pub points: Vec<ControlPoint>,
    /// Shading, where the preset shows surfaces and the volume has gradients.
    pub shading: Option<Shading>,
    /// The operator that it is made for, where that is not `over`.
    pub compositing: Option<Compositing>,
    /// Notes on how it was fitted, one line each.
    pub notes: Vec<String>,
}

impl Survey {
    /// Fits a preset to the volume, all values of which lie in `values`; `range` is what it is to be stretched over instead.
    ///
    /// Presets in Hounsfield units stay at their values where the volume is in them; where it is not, a note says what they are taken for.
    /// Presets for a signal are spread from the lowest to the highest value that is not rare (one in two thousand is), and over the logarithm
    /// of values with a heavy tail.
    pub fn preset(&self, preset: Preset, values: (f64, f64), range: Option<(f64, f64)>, hints: &Hints) -> FittedPreset {
        let (kind, scale) = self.kind_and_scale(hints);
        let mut notes = Vec::new();
        let points = match (preset.unit(), range) {
            (PresetUnit::Hounsfield, _) => {
                let scale = HounsfieldScale::of_range(range.unwrap_or(values));
                // A range in Hounsfield units is the user's own word on the values.
                if range.is_none() || scale != HounsfieldScale::Calibrated {
                    notes.extend(about_hounsfield(preset, scale, &kind));
                }
                preset.points(range.unwrap_or(values))
            }
            (_, Some(range)) => preset.points(range),
            (PresetUnit::Range, None) => preset.points(values),
            (PresetUnit::Signal, None) => {
                let (low, high) = (scale.value(0.0), scale.value(1.0));
                let by = if matches!(scale, Scale::Logarithmic { .. }) { ", by the logarithm" } else { "" };
                notes.push(format!("preset {preset} is spread over the signal, {} to {}{by}", short(low), short(high)));
                preset.points_at((low, high), |place| scale.value(place))
            }
        };
        FittedPreset {
            points,
            shading: preset.shading().filter(|_| self.can_shade),
            compositing: preset.is_projection().then_some(Compositing::Maximum),
            notes,
        }
    }

    /// The presets that suit the volume, those for its kind of data first. `modality` is what the file says of the scanner, as DICOM
    /// abbreviates it.
    pub fn suitable_presets(&self, values: (f64, f64), modality: Option<&str>, hints: &Hints) -> Vec<Preset> {
        use PresetFamily::{Any, Ct, Microscopy, Mr, Pet, Ultrasound};
        let kind = self.kind_and_scale(hints).0;
        let is_stored_ct = HounsfieldScale::of_range(values) == HounsfieldScale::Stored;
        let families: &[PresetFamily] = match (modality, &kind) {
            (Some("CT"), _) | (None, Kind::Hounsfield) => &[Ct, Any],
            (Some("MR"), _) => &[Mr, Any],
            (Some("PT" | "NM"), _) => &[Pet, Any],
            (Some("US"), _) => &[Ultrasound, Any],
            (Some("SM" | "GM" | "OPT" | "OCT"), _) => &[Microscopy, Any],
            // Regions have no more or less.
            (_, Kind::Labels(_) | Kind::Signed) => &[Any],
            (_, Kind::HeavyTail) => &[Pet, Microscopy, Any],
            (_, Kind::Field) => &[Microscopy, Pet, Any],
            _ if is_stored_ct => &[Ct, Mr, Any],
            _ if hints.patient => &[Mr, Pet, Ultrasound, Any],
            _ => &[Microscopy, Mr, Ultrasound, Any],
        };
        let of_families = families.iter().flat_map(|&f| Preset::ALL.into_iter().filter(move |p| p.family() == f));
        // The zero of Hounsfield units is water, which nothing is below but fat and air.
        of_families.filter(|&preset| preset != Preset::CoolWarm || families[0] != Ct).collect()
    }

    fn kind_and_scale(&self, hints: &Hints) -> (Kind, Scale) {
        kind_of(&self.lattice, &self.values, self.integer, hints.is_scan())
    }
}

/// A note on values that are not plainly in Hounsfield units.
fn about_hounsfield(preset: Preset, scale: HounsfieldScale, kind: &Kind) -> Option<String> {
    match (scale, kind) {
        (HounsfieldScale::Calibrated, Kind::Hounsfield) => None,
        (HounsfieldScale::Calibrated, _) => {
            let why = "their range could be, but nothing among them is air around a patient";
            Some(format!("preset {preset} is in Hounsfield units, and the values may not be: {why}"))
        }
        (HounsfieldScale::Stored, _) => Some(format!(
            "preset {preset} is in Hounsfield units: the values are taken for a scanner's numbers, 1024 above them; --range -1024,3071 takes \
             them as they are"
        )),
        (HounsfieldScale::Stretched { low, high }, _) => Some(format!(
            "preset {preset} is in Hounsfield units, which the values are not: {} to {} is taken for the scale of a scanner, -1024 to 3071, and \
             what is shown need not be what the preset is named after; --range -1024,3071 takes the values as they are",
            short(low),
            short(high)
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, OpacityRule, Placement, TransferFunction, UniformGrid, Volume};

    const SIDE: usize = 24;

    /// A ball of one value in another.
    fn ball(inside: i16, outside: i16) -> (Volume, (f64, f64)) {
        let place = |i: usize| (i as f64 + 0.5) / SIDE as f64 * 2.0 - 1.0;
        let value = |i: usize| {
            let [x, y, z] = [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(place);
            let r = (x * x + y * y + z * z).sqrt();
            // Noise of a few steps, so that these are no labels.
            let noise = (i * 7919 % 13) as i16;
            if r < 0.6 { inside + noise } else { outside + noise }
        };
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let samples: Vec<i16> = (0..SIDE * SIDE * SIDE).map(value).collect();
        let grid = UniformGrid::new([SIDE; 3], samples, placement, Calibration::default()).unwrap();
        let volume = Volume::from(grid);
        let range = volume.value_range().unwrap();
        (volume, range)
    }

    #[test]
    fn hounsfield_units_are_taken_and_others_are_said() {
        let hints = Hints { patient: true, ..Hints::default() };
        let fitted = |inside, outside, range| {
            let (volume, values) = ball(inside, outside);
            Survey::of(&volume).preset(Preset::CtBone, values, range, &hints)
        };
        let head = fitted(900, -1000, None);
        assert!(head.notes.is_empty() && head.shading.is_some(), "{:?}", head.notes);
        assert_eq!(head.points, Preset::CtBone.points((-1024.0, 3071.0)));
        let mr = fitted(30_000, -600, None);
        assert!(mr.notes[0].contains("may not be"), "{:?}", mr.notes);
        let stored = fitted(2000, 0, None);
        assert!(stored.notes[0].contains("1024 above"), "{:?}", stored.notes);
        assert_eq!(stored.points[0].value, head.points[0].value + 1024.0);
        let bytes = fitted(200, 3, None);
        assert!(bytes.notes[0].contains("which the values are not"), "{:?}", bytes.notes);
        // A range that the user gives is what counts.
        let told = fitted(200, 3, Some((-1024.0, 3071.0)));
        assert!(told.points == head.points && told.notes.is_empty(), "{:?}", told.notes);
    }

    #[test]
    fn signals_ignore_what_is_rare() {
        let (volume, values) = ball(1000, 10);
        let survey = Survey::of(&volume);
        let fitted = survey.preset(Preset::MrAngio, values, None, &Hints::default());
        let transfer = TransferFunction::new(fitted.points, OpacityRule::Power, 1.0).unwrap();
        assert_eq!(transfer.at(20.0).opacity, 0.0);
        assert!(transfer.at(1000.0).opacity > 0.5);
        assert!(fitted.notes[0].contains("over the signal"), "{:?}", fitted.notes);
        let mip = survey.preset(Preset::CtMip, values, None, &Hints::default());
        assert_eq!((mip.compositing, mip.shading), (Some(Compositing::Maximum), None));
    }

    #[test]
    fn presets_suit_the_kind_of_data() {
        let (volume, values) = ball(900, -1000);
        let survey = Survey::of(&volume);
        let hints = Hints { patient: true, ..Hints::default() };
        let of = |modality| survey.suitable_presets(values, modality, &hints);
        assert!(of(None).contains(&Preset::CtLung) && !of(None).contains(&Preset::PetHot));
        assert_eq!(of(Some("PT"))[0], Preset::PetHot);
        assert!(of(Some("MR")).contains(&Preset::MrAngio) && !of(Some("MR")).contains(&Preset::CtBone));
        assert!(of(Some("MR")).contains(&Preset::Grey));
    }
}
