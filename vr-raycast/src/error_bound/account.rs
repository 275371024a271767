//! Light that a ray has gathered, and the bound of its error.

use super::step::Step;

/// Share of the error asked for that a step may always have. Shares leave a tenth, in which as many steps as a ray may take have room.
const NEGLIGIBLE: f64 = 1e-6;

/// Share of the error asked for that what the field is off by may cost.
const RESOLUTION_SHARE: f64 = 0.02;

/// Limits of a ray's error and light, the same for all rays of a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest error, relative to max(1, the ray's own radiance).
    pub(super) error: f64,
    /// Share of the error that steps may use. Their error decides how much of an emission is in doubt around the cut.
    pub(super) of_steps: f64,
    /// Opacity at which the ray is cut; 1 if it never is.
    pub(super) level: f64,
    /// Largest component of the source. `emits` is true if the source is emission given on its own.
    pub(super) brightest: f64,
    pub(super) emits: bool,
}

/// Sum of a ray, from the eye into the depth, and its bound.
///
/// The sum is a telescope: each step in turn takes the place of the true medium, the steps in front of it being those computed and the medium
/// behind it the true one. So the pixel is off by at most Σ T̂ₖ (eₖ + aₖ M): what step k is off by, dimmed by the transmittance *computed*
/// in front of it, M being the largest radiance that can come from behind.
#[derive(Clone, Debug)]
pub(super) struct Account {
    limits: Limits,
    start: f64,
    end: f64,
    /// The largest component of what stands behind the volume.
    backdrop: f64,
    pub(super) transmittance: f64,
    pub(super) light: [f64; 3],
    pub(super) error: f64,
    /// Largest contribution of the part of the ray that was not looked at.
    unseen: f64,
    /// True if the computed opacity has reached the level, behind which no light counts.
    is_cut: bool,
    /// Light of an emission that may be in front of the cut or behind it.
    doubtful: f64,
    /// Distance at which opacity reached ½.
    pub(super) half_way: f64,
    pub(super) steps: u64,
    /// True if nothing that follows matters.
    pub(super) ended: bool,
    /// Step that may hold the beginning of a wall, until the steps behind it tell.
    pending: Option<PendingWall>,
}

/// Short step that may hold the beginning of a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingWall {
    pub(super) step: Step,
    /// Largest contribution before a wall begins.
    pub(super) before: f64,
    /// Largest difference of two of its values.
    pub(super) spread: f64,
    /// Largest difference that reflection makes between two of its places.
    pub(super) turn: f64,
}

impl Account {
    pub(super) fn new(limits: Limits, start: f64, end: f64, backdrop: f64) -> Self {
        Self {
            limits,
            start,
            end,
            backdrop,
            transmittance: 1.0,
            light: [0.0; 3],
            error: 0.0,
            unseen: 0.0,
            is_cut: false,
            doubtful: 0.0,
            half_way: f64::INFINITY,
            steps: 0,
            ended: false,
            pending: None,
        }
    }

    /// Returns the largest radiance, or opacity, that can come from behind a distance.
    fn max_light(&self, s: f64) -> f64 {
        let medium = if self.limits.emits {
            self.limits.brightest * (self.end - s).max(0.0) + self.backdrop
        } else {
            self.limits.brightest.max(self.backdrop)
        };
        medium.max(1.0)
    }

    /// Returns the error that may be spent altogether: the picture's largest magnitude is at least that of this ray's true radiance, and what was not looked
    /// at can only add to that.
    fn budget(&self) -> f64 {
        let light = self.light.into_iter().fold(0.0, f64::max);
        self.limits.error * (light - self.error).max(1.0)
    }

    /// Returns the error that may have been spent when the ray is at `s` with the transmittance `left`: half of it in proportion to the distance,
    /// half to the opacity.
    fn share(&self, s: f64, left: f64) -> f64 {
        let length = (s - self.start) / (self.end - self.start);
        self.budget() * self.limits.of_steps * (0.45 * length + 0.45 * (1.0 - left))
    }

    /// Returns the error that a step at `s` may have, before it is dimmed: a hint for choosing the step.
    pub(super) fn enough(&self, s: f64) -> f64 {
        let left = self.share(s, self.transmittance) - self.error;
        (0.25 * left / self.transmittance.max(1e-300)).max(0.0)
    }

    /// Returns the error of the field, all along the ray, that steps hardly notice, given the slopes of extinction and source by the field's value. Steps count it five times.
    pub(super) fn resolution(&self, [rate, source]: [f64; 2]) -> f64 {
        let length = self.end - self.start;
        let emitted = if self.limits.emits { length } else { 1.0 };
        RESOLUTION_SHARE * self.limits.of_steps * self.limits.error
            / (rate * self.max_light(self.start) * length + source * emitted)
    }

    /// True if a step from `s` on is good enough.
    pub(super) fn fits(&self, step: &Step, s: f64) -> bool {
        let left = self.transmittance * (1.0 - step.opacity);
        let cost = self.transmittance * (step.light_error + step.opacity_error * self.max_light(s) + self.cut(step));
        // Half of a part in which nothing is known costs half as much, and has half the share: halving alone would never end.
        cost <= NEGLIGIBLE * self.budget() || self.error + cost <= self.share(s + step.length, left)
    }

    /// Returns the error, before it is dimmed, that is due to the cut of the ray and that shorter steps would lessen.
    pub(super) fn cut(&self, step: &Step) -> f64 {
        let level = self.limits.level;
        if level >= 1.0 {
            return 0.0;
        }
        let [before, behind] = [1.0, 1.0 - step.opacity].map(|clear| 1.0 - self.transmittance * clear);
        if !self.limits.emits {
            return if behind >= level { step.opacity * step.variation } else { 0.0 };
        }
        // Light is in doubt from the first place where the ray may be cut to the first where it surely is: all of it, in a step that holds either place.
        let holds = |off: f64| before + off < level && behind + off >= level;
        if holds(self.error) || holds(-self.error) { step.brightest() } else { 0.0 }
    }

    /// True if shorter steps would do no better: most of the error is rounding.
    pub(super) fn is_rounding(&self, step: &Step, s: f64) -> bool {
        let max_light = self.max_light(s);
        let rounding = step.rounding[1] + step.rounding[0] * max_light;
        step.light_error + step.opacity_error * max_light + self.cut(step) <= 2.0 * rounding
    }

    /// Takes a step from `s` on.
    pub(super) fn take(&mut self, step: &Step, s: f64) {
        self.settle(s);
        self.add(step, s);
    }

    fn add(&mut self, step: &Step, s: f64) {
        self.steps += 1;
        let (front, level) = (self.transmittance, self.limits.level);
        let behind = front * (1.0 - step.opacity);
        self.error += front * (step.light_error + step.opacity_error * self.max_light(s));
        let reaches = level < 1.0 && 1.0 - behind >= level;
        // Of a step that is cut, light goes with opacity.
        let share = match (self.is_cut, reaches) {
            (true, _) => 0.0,
            (_, true) => ((front - (1.0 - level)) / (front * step.opacity)).clamp(0.0, 1.0),
            _ => 1.0,
        };
        for (sum, light) in self.light.iter_mut().zip(step.light) {
            *sum += front * share * light;
        }
        if self.half_way == f64::INFINITY && behind <= 0.5 {
            let part = libm::log(2.0 * front) / -libm::log1p(-step.opacity);
            self.half_way = s + step.length * if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
        }
        self.transmittance = behind;
        self.is_cut |= reaches;
        if level < 1.0 && self.limits.emits {
            if 1.0 - behind + self.error >= level {
                self.doubtful += front * (step.brightest() + step.light_error);
            }
            if 1.0 - behind - self.error >= level {
                self.ended = true;
                return;
            }
        } else if reaches {
            self.error += front * step.opacity * step.variation;
            self.ended = true;
            return;
        }
        let rest = behind * self.max_light(s + step.length);
        if self.error + self.doubtful + rest <= 0.99 * self.budget() {
            self.unseen = rest;
            self.ended = true;
        }
    }

    /// Takes a step, ending at `s`, that may hold the beginning of a wall: that is unknown until what follows is seen. Doubts that follow each
    /// other are one.
    pub(super) fn doubt(&mut self, pending: PendingWall) {
        // A step, too: where all of a ray is in doubt, it must end all the same.
        self.steps += 1;
        let Some(last) = &mut self.pending else {
            self.pending = Some(pending);
            return;
        };
        let (a, b) = (&mut last.step, &pending.step);
        let brightest = b.brightest();
        a.length += b.length;
        (a.opacity, a.opacity_error) = (0.5, 0.5);
        a.light_error += b.light_error + brightest;
        a.variation = a.variation.max(b.variation);
        last.before += pending.before;
        last.spread += pending.spread;
        last.turn += pending.turn;
    }

    /// Settles a place in doubt as no wall, or one that a ray only touches: it costs what it can cost.
    fn settle(&mut self, s: f64) {
        if let Some(pending) = self.pending.take() {
            self.add(&pending.step, s - pending.step.length);
        }
    }

    /// Takes a wall that begins at `s`: its light, the error of that, and how fast it changes with the value. The place in doubt before it, if
    /// any, is part of it.
    pub(super) fn wall(&mut self, light: [f64; 3], error: f64, steepness: f64, s: f64) {
        let doubt = self.pending.take().map_or(0.0, |d| d.before + steepness * d.spread + d.turn);
        let step = Step { opacity: 1.0, light, light_error: error + doubt, ..Step::default() };
        self.add(&step, s);
        self.ended = true;
    }

    /// Adds the cost of a medium that may begin or end a little elsewhere than where it is taken to, by bounds of the opacity and the light in between.
    pub(super) fn misplace(&mut self, opacity: f64, light: f64) {
        self.error += self.transmittance * (light + opacity * self.max_light(self.start));
    }

    /// True if some light is in doubt; smaller errors of the steps leave less of it.
    pub(super) fn is_doubtful(&self) -> bool {
        self.doubtful > 0.0
    }

    /// Returns the proven bound.
    fn bound(&self) -> f64 {
        self.error + self.doubtful + self.unseen
    }

    /// True if the proven bound exceeds the one asked for.
    pub(super) fn is_over(&self) -> bool {
        let error = self.bound();
        error > self.budget() || error.is_nan()
    }

    /// Returns the proven bound as a multiple of the one asked for: above 1 where that one is not kept, NaN where nothing is known.
    pub(super) fn overrun(&self) -> f64 {
        self.bound() / self.budget()
    }

    /// Settles a pending wall at the end of the ray.
    pub(super) fn finish(&mut self) {
        self.settle(self.end);
        // A few additions and products a step.
        let light = self.light.into_iter().fold(1.0, f64::max);
        self.error += 4.0 * f64::EPSILON * self.steps as f64 * light;
    }

    /// Returns the opacity of the ray.
    pub(super) fn opacity(&self) -> f64 {
        if self.is_cut { self.limits.level } else { 1.0 - self.transmittance }
    }
}
