//! Choice of what draws moving pictures: the setting and the size of least error within the time of a frame, by trials at rest.

use super::pace::{FRAME_TIME, MIN_PIXELS, Pace, sized};

/// Settings that are tried for moving pictures beside a renderer's own draft. Those of renderers that a program lacks, or that do not draw a scene, are left out.
///
/// Settings are numbered: 0 is the renderer's own draft, and n is `QUICK[n − 1]`.
///
/// Bonsai, shaded, against the sharp picture of 512², pictures stretched as a screen does it: in 46 ms of a processor, a draft of quality 4·10⁻³ has 100² pixels and an RMSE
/// of 1.9·10⁻²; in 30 ms, local steps for 6·10⁻² have 150² and 1.4·10⁻²; in 57 ms, the shear-warp with slices a voxel apart has 0.9·10⁻² at 256². Uniform steps
/// need no map of them, which takes long to make of a large volume when its transfer function is edited.
pub(super) const QUICK: [Quick; 5] = [
    Quick { renderer: "raycast", options: &[("local-error", 0.02)] },
    Quick { renderer: "raycast", options: &[("local-error", 0.06)] },
    Quick { renderer: "raycast", options: &[("local-error", 0.2), ("termination", 0.95)] },
    Quick { renderer: "raycast", options: &[("step", 2.0), ("termination", 0.95)] },
    Quick { renderer: "shearwarp", options: &[("slice-distance", 1.0)] },
];

/// Number of the setting that draws before any trial.
const FIRST: usize = 2;
/// Number of the setting that draws all pixels first, at rest.
pub(super) const WHOLE: usize = 1;

/// A renderer and its options, by their names in scene files; other options are as usual.
pub(super) struct Quick {
    pub(super) renderer: &'static str,
    pub(super) options: &'static [(&'static str, f64)],
}

/// Weight of a new measurement in the running mean of how much slower pictures are than in their trial.
const SHARE: f64 = 0.25;
/// Largest factor by which one picture counts as slower or quicker than its trial: a single one may have to encode an axis, or be held up.
const MAX_STRAIN: f64 = 4.0;
/// Share of a picture's fixed time that its pixels may always add.
const CHEAP: f64 = 0.15;

/// Times and errors of a setting in pictures of two sizes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// Number of pixels of each, the smaller one first.
    pub(super) pixels: [f64; 2],
    /// Seconds to draw each.
    pub(super) seconds: [f64; 2],
    /// RMSE of each, stretched to the screen, against the sharp picture.
    pub(super) rmse: [f64; 2],
    /// Additional seconds of the first picture after the scene has changed.
    pub(super) renewal: f64,
}

impl Trial {
    /// Seconds of a picture of any size, and additional seconds of each pixel.
    fn costs(&self) -> [f64; 2] {
        let [few, many] = self.pixels;
        let each = ((self.seconds[1] - self.seconds[0]) / (many - few)).max(1e-10);
        [(self.seconds[0] - each * few).max(0.0), each]
    }

    fn seconds_of(&self, pixels: f64) -> f64 {
        let [fixed, each] = self.costs();
        fixed + each * pixels
    }

    /// Number of pixels that can be drawn in a time, but at least as many as add [`CHEAP`] of the fixed time.
    fn affordable(&self, seconds: f64) -> f64 {
        let [fixed, each] = self.costs();
        (seconds - fixed).max(CHEAP * fixed) / each
    }

    /// RMSE of a picture of a number of pixels: a power law through both measurements, with an exponent of at most 0.
    fn rmse_of(&self, pixels: f64) -> f64 {
        let [few, many] = self.rmse.map(|e| e.max(1e-12).ln());
        let power = ((many - few) / (self.pixels[1] / self.pixels[0]).ln()).min(0.0);
        (few + power * (pixels / self.pixels[0]).ln()).exp()
    }
}

/// Setting and size of a moving picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    /// Number of the setting.
    pub(super) setting: usize,
    pub(super) size: [u32; 2],
    /// RMSE estimated by the trials.
    pub(super) rmse: Option<f64>,
}

/// Choice of moving pictures.
#[derive(Default)]
pub(super) struct Moving {
    /// Setting that draws before any trial, and its pace.
    pace: (usize, Pace),
    /// Key of the trials.
    key: Option<String>,
    trials: Vec<Tried>,
    /// Index of the trial of the picture in progress, and the time expected by it.
    expected: Option<(usize, f64)>,
}

/// A setting that was tried.
struct Tried {
    setting: usize,
    trial: Trial,
    /// Mean logarithm of the time of later pictures in units of the time expected by the trial: while something moves, the page and other programs use the machine, too. Each
    /// setting has its own, so that pictures correct a trial that was held up.
    strain: f64,
}

impl Moving {
    /// True if the trials known are not those of a key.
    pub(super) fn is_untried(&self, key: &str) -> bool {
        self.key.as_deref() != Some(key)
    }

    /// Replaces the trials by those of a key.
    pub(super) fn tried(&mut self, key: String, trials: Vec<(usize, Trial)>) {
        let fresh = |(setting, trial)| Tried { setting, trial, strain: 0.0 };
        (self.key, self.trials) = (Some(key), trials.into_iter().map(fresh).collect());
    }

    /// The last trial of a setting.
    pub(super) fn trial(&self, setting: usize) -> Option<Trial> {
        self.trials.iter().find(|tried| tried.setting == setting).map(|tried| tried.trial)
    }

    /// Forgets all trials: another renderer or volume is shown.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Chooses the setting of the next moving picture among those that `can` draw it, and its size. The picture at rest has the size `full`. `renews` is true
    /// for a setting that has to prepare the scene anew.
    pub(super) fn choose(
        &mut self,
        full: [u32; 2],
        can: impl Fn(usize) -> bool,
        renews: impl Fn(usize) -> bool,
    ) -> Choice {
        let all = full.map(f64::from).iter().product::<f64>();
        let options = self.trials.iter().enumerate().filter(|(_, tried)| can(tried.setting));
        let options = options.map(|(index, Tried { setting, trial, strain })| {
            let budget = FRAME_TIME.as_secs_f64() / strain.exp();
            let renewal = if renews(*setting) { trial.renewal } else { 0.0 };
            let pixels = trial.affordable(budget - renewal).max(MIN_PIXELS).min(all);
            let seconds = trial.seconds_of(pixels);
            let rmse = trial.rmse_of(pixels);
            // A setting that is too slow even with the fewest pixels counts as worse by the square of its delay.
            let late = ((seconds + renewal) / budget - CHEAP).max(1.0);
            (
                rmse * late * late,
                Choice { setting: *setting, size: sized(pixels, full), rmse: Some(rmse) },
                (index, seconds),
            )
        });
        if let Some((_, choice, expected)) = options.min_by(|a, b| a.0.total_cmp(&b.0)) {
            self.expected = Some(expected);
            return choice;
        }
        self.expected = None;
        let setting = if can(FIRST) { FIRST } else { 0 };
        if self.pace.0 != setting {
            self.pace = (setting, Pace::default());
        }
        Choice { setting, size: self.pace.1.size(full), rmse: None }
    }

    /// Records the time of the picture that was chosen last, and the time to prepare its scene before it, if the scene had changed.
    pub(super) fn measured(&mut self, pixels: u64, seconds: f64, renewal: Option<f64>) {
        match self.expected {
            Some((index, expected)) => {
                let slower = (seconds / expected).clamp(1.0 / MAX_STRAIN, MAX_STRAIN).ln();
                if let Some(Tried { strain, trial, .. }) = self.trials.get_mut(index) {
                    *strain += SHARE * (slower - *strain);
                    // The trial has prepared the scene from nothing, or has found it prepared: neither is what an edit costs.
                    if let Some(renewal) = renewal {
                        trial.renewal += SHARE * (renewal - trial.renewal);
                    }
                }
            }
            None => self.pace.1.measured(pixels, std::time::Duration::from_secs_f64(seconds)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A setting of so many microseconds whatever the size, and nanoseconds a pixel, with an error that falls with the side.
    fn trial(fixed: f64, each: f64, rmse: [f64; 2]) -> Trial {
        let pixels = [128.0 * 128.0, 256.0 * 256.0];
        Trial { pixels, seconds: pixels.map(|n| 1e-6 * fixed + 1e-9 * each * n), rmse, renewal: 0.0 }
    }

    fn moving(trials: Vec<(usize, Trial)>) -> Moving {
        let mut moving = Moving::default();
        moving.tried("scene".to_owned(), trials);
        moving
    }

    #[test]
    fn the_least_error_within_the_time_is_chosen() {
        // Rays that cost a microsecond each; and a picture that takes most of the time at any size.
        let (rays, slices) = (trial(0.0, 1000.0, [2e-2, 1e-2]), trial(20_000.0, 20.0, [1.1e-2, 0.9e-2]));
        let mut both = moving(vec![(1, rays), (4, slices)]);
        let choice = both.choose([512, 512], |_| true, |_| false);
        assert!(choice.setting == 4 && choice.size[0] > 256, "{choice:?}");
        assert_eq!(both.choose([512, 512], |setting| setting != 4, |_| false).setting, 1);
        // A scene that is new to the slices alone.
        let costly = Trial { renewal: 0.1, ..slices };
        let mut both = moving(vec![(1, rays), (4, costly)]);
        assert_eq!(both.choose([512, 512], |_| true, |setting| setting == 4).setting, 1);
        assert_eq!(both.choose([512, 512], |_| true, |_| false).setting, 4);
    }

    #[test]
    fn a_strained_machine_is_asked_for_less() {
        let mut one = moving(vec![(1, trial(0.0, 500.0, [2e-2, 1e-2]))]);
        let before = one.choose([512, 512], |_| true, |_| false);
        for _ in 0..60 {
            let choice = one.choose([512, 512], |_| true, |_| false);
            let pixels = u64::from(choice.size[0]) * u64::from(choice.size[1]);
            one.measured(pixels, 2.0 * 500e-9 * pixels as f64, None);
        }
        let after = one.choose([512, 512], |_| true, |_| false);
        let share = f64::from(after.size[0] * after.size[1]) / f64::from(before.size[0] * before.size[1]);
        assert!((share - 0.5).abs() < 0.02, "{share}");
    }

    #[test]
    fn a_trial_that_was_wrong_is_set_right() {
        // The slices look quick, and are four times as slow.
        let (rays, slices) = (trial(0.0, 1000.0, [2e-2, 1e-2]), trial(20_000.0, 20.0, [1.1e-2, 0.9e-2]));
        let mut both = moving(vec![(1, rays), (4, slices)]);
        let mut settings = Vec::new();
        for _ in 0..60 {
            let Choice { setting, size, .. } = both.choose([512, 512], |_| true, |_| false);
            let pixels = f64::from(size[0] * size[1]);
            let seconds = if setting == 4 { 4.0 * (20e-3 + 20e-9 * pixels) } else { 1e-6 * pixels };
            both.measured(pixels as u64, seconds, None);
            settings.push(setting);
        }
        assert!(settings[0] == 4 && settings[30..].iter().all(|&setting| setting == 1), "{settings:?}");
    }

    #[test]
    fn what_an_edit_costs_is_learned_from_edits() {
        let mut one = moving(vec![(1, trial(0.0, 500.0, [2e-2, 1e-2]))]);
        let (mut pixels, mut before) = (0, 0);
        for edit in 0..40 {
            let [w, h] = one.choose([512, 512], |_| true, |_| true).size;
            pixels = u64::from(w) * u64::from(h);
            if edit == 0 {
                before = pixels;
            }
            // Half the time of a frame is spent on the scene.
            one.measured(pixels, 500e-9 * pixels as f64, Some(0.5 * FRAME_TIME.as_secs_f64()));
        }
        let share = pixels as f64 / before as f64;
        assert!((share - 0.5).abs() < 0.02, "{share}");
        // Moves cost what they did.
        let [w, h] = one.choose([512, 512], |_| true, |_| false).size;
        assert_eq!(u64::from(w) * u64::from(h), before);
    }

    #[test]
    fn before_any_trial_the_pace_decides() {
        let mut none = Moving::default();
        assert!(none.is_untried("scene"));
        let first = none.choose([512, 512], |_| true, |_| false);
        assert_eq!((first.setting, first.rmse), (FIRST, None));
        none.measured(96 * 96, 96.0 * 96.0 * 1e-7, None);
        assert!(none.choose([512, 512], |_| true, |_| false).size[0] > first.size[0]);
        assert_eq!(none.choose([512, 512], |setting| setting == 0, |_| false).setting, 0);
    }
}
