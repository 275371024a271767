//! Choice of what draws moving pictures: the setting and the size of least error within the time of a frame, by trials at rest.

use super::pace::{FRAME_TIME, MIN_PIXELS, Pace, sized};

/// Settings that are tried for moving pictures beside a renderer's own draft: names of renderers and options, as scene files have them. Those that a program
/// does not have, or that do not draw a scene, are left out.
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

/// Index in [`QUICK`] of what draws before anything was tried.
const FIRST: usize = 1;
/// Index in [`QUICK`] of what draws all pixels first, at rest.
pub(super) const WHOLE: usize = 0;

/// A renderer's name, and its options that are not as usual.
pub(super) struct Quick {
    pub(super) renderer: &'static str,
    pub(super) options: &'static [(&'static str, f64)],
}

/// Share of a new measurement in the running mean of how much slower pictures are than in their trial.
const SHARE: f64 = 0.25;
/// Largest factor by which one picture counts as slower or quicker than its trial: another one may encode an axis, or be held up.
const MAX_STRAIN: f64 = 4.0;
/// Part of the time that a picture takes at any size which pixels may add without being worth a thought.
const CHEAP: f64 = 0.15;

/// Times and errors of a setting in pictures of two sizes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// Pixels of the pictures, the smaller first.
    pub(super) pixels: [f64; 2],
    /// Seconds to draw each.
    pub(super) seconds: [f64; 2],
    /// RMSE of each, spread over the screen, against the sharp picture.
    pub(super) rmse: [f64; 2],
    /// Seconds more for the first picture of a changed scene.
    pub(super) renewal: f64,
}

impl Trial {
    /// Seconds of a picture whatever its size, and seconds of each pixel.
    fn costs(&self) -> [f64; 2] {
        let [few, many] = self.pixels;
        let each = ((self.seconds[1] - self.seconds[0]) / (many - few)).max(1e-10);
        [(self.seconds[0] - each * few).max(0.0), each]
    }

    fn seconds_of(&self, pixels: f64) -> f64 {
        let [fixed, each] = self.costs();
        fixed + each * pixels
    }

    /// Pixels of a picture in so many seconds, and of one that they make little slower.
    fn affordable(&self, seconds: f64) -> f64 {
        let [fixed, each] = self.costs();
        (seconds - fixed).max(CHEAP * fixed) / each
    }

    /// RMSE of a picture of so many pixels: a power of their number through both that were measured, which does not grow with it.
    fn rmse_of(&self, pixels: f64) -> f64 {
        let [few, many] = self.rmse.map(|e| e.max(1e-12).ln());
        let power = ((many - few) / (self.pixels[1] / self.pixels[0]).ln()).min(0.0);
        (few + power * (pixels / self.pixels[0]).ln()).exp()
    }
}

/// What a moving picture is drawn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    /// 0 for the renderer's own draft, else one more than the index in [`QUICK`].
    pub(super) setting: usize,
    pub(super) size: [u32; 2],
    /// Its RMSE as trials suggest it.
    pub(super) rmse: Option<f64>,
}

/// Choice of moving pictures.
#[derive(Default)]
pub(super) struct Moving {
    /// Pace of what draws as long as nothing was tried, and the setting that it is of.
    pace: (usize, Pace),
    /// Scene, renderer and size that the trials are of.
    of: Option<String>,
    trials: Vec<Tried>,
    /// Index of the trial of the picture in progress, and the time that it suggests.
    expected: Option<(usize, f64)>,
}

/// A setting that was tried.
struct Tried {
    setting: usize,
    trial: Trial,
    /// Mean logarithm of the time of pictures since over that which the trial suggests: the page, and others, use the machine while something moves. Each
    /// setting has its own, so that a trial that was held up, or was not, is set right by the pictures that follow from it.
    strain: f64,
}

impl Moving {
    /// True if nothing was tried yet for what `of` names.
    pub(super) fn is_untried(&self, of: &str) -> bool {
        self.of.as_deref() != Some(of)
    }

    /// Takes over the trials of what `of` names.
    pub(super) fn tried(&mut self, of: String, trials: Vec<(usize, Trial)>) {
        let fresh = |(setting, trial)| Tried { setting, trial, strain: 0.0 };
        (self.of, self.trials) = (Some(of), trials.into_iter().map(fresh).collect());
    }

    /// The last trial of a setting.
    pub(super) fn trial(&self, setting: usize) -> Option<Trial> {
        self.trials.iter().find(|tried| tried.setting == setting).map(|tried| tried.trial)
    }

    /// Forgets all trials: another renderer or another volume is shown.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Chooses the setting of the next moving picture among those that can draw it, and its size, where the picture at rest has the size `full`. `renews` is true
    /// if a setting has not seen the scene as it is.
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
            // What is too slow even with few pixels is as bad as it is slow.
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
        let setting = if can(FIRST + 1) { FIRST + 1 } else { 0 };
        if self.pace.0 != setting {
            self.pace = (setting, Pace::default());
        }
        Choice { setting, size: self.pace.1.size(full), rmse: None }
    }

    /// Takes note of the time of the picture that was chosen last.
    pub(super) fn measured(&mut self, pixels: u64, seconds: f64) {
        match self.expected {
            Some((index, expected)) => {
                let slower = (seconds / expected).clamp(1.0 / MAX_STRAIN, MAX_STRAIN).ln();
                if let Some(Tried { strain, .. }) = self.trials.get_mut(index) {
                    *strain += SHARE * (slower - *strain);
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
            one.measured(pixels, 2.0 * 500e-9 * pixels as f64);
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
            both.measured(pixels as u64, seconds);
            settings.push(setting);
        }
        assert!(settings[0] == 4 && settings[30..].iter().all(|&setting| setting == 1), "{settings:?}");
    }

    #[test]
    fn before_any_trial_the_pace_decides() {
        let mut none = Moving::default();
        assert!(none.is_untried("scene"));
        let first = none.choose([512, 512], |_| true, |_| false);
        assert_eq!((first.setting, first.rmse), (FIRST + 1, None));
        none.measured(96 * 96, 96.0 * 96.0 * 1e-7);
        assert!(none.choose([512, 512], |_| true, |_| false).size[0] > first.size[0]);
        assert_eq!(none.choose([512, 512], |setting| setting == 0, |_| false).setting, 0);
    }
}
