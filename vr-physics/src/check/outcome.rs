//! Results of checks.

use super::effort::Verdict;
use super::test_scene::TestScene;

/// A check that held.
#[derive(Clone, Debug)]
pub struct Report {
    /// The check.
    pub check: &'static str,
    /// The renderer.
    pub renderer: &'static str,
    /// Scenes that held.
    pub held: u32,
    /// Scenes that the renderer refused as unsupported.
    pub refused: u32,
    /// Scenes about which nothing could be said: no bound is documented, or the reference is less certain than the bound.
    pub skipped: u32,
    /// The largest deviation measured, relative to max(1, largest magnitude of the picture).
    pub worst: f64,
    /// The largest ratio of what was measured to what was allowed, at most 1.
    pub closest: f64,
    /// The scene of that ratio.
    pub closest_scene: Option<Box<TestScene>>,
}

impl Report {
    pub(super) fn new(check: &'static str, renderer: &'static str) -> Self {
        Self { check, renderer, held: 0, refused: 0, skipped: 0, worst: 0.0, closest: 0.0, closest_scene: None }
    }

    pub(super) fn count(&mut self, verdict: &Verdict, test: &TestScene) {
        match *verdict {
            Verdict::Held { measured, allowed } => {
                self.held += 1;
                self.worst = self.worst.max(measured);
                // 0 of 0 allowed is an exact match, not a close call.
                let ratio = if measured == 0.0 { 0.0 } else { measured / allowed };
                if ratio > self.closest {
                    self.closest = ratio;
                    self.closest_scene = Some(Box::new(test.clone()));
                }
            }
            Verdict::Refused => self.refused += 1,
            Verdict::Skipped | Verdict::Broken(_) => self.skipped += 1,
        }
    }

    /// A check that never looked at a picture has not held.
    pub(super) fn demand_some_held(self) -> Result<Self, CheckFailure> {
        if self.held > 0 {
            return Ok(self);
        }
        let reason = format!("not one scene was judged: {} refused, {} skipped", self.refused, self.skipped);
        Err(CheckFailure { check: self.check, renderer: self.renderer, reason, scene: None })
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { check, renderer, held, refused, skipped, worst, closest, .. } = self;
        write!(
            f,
            "{renderer} {check}: {held} scenes held, {refused} refused, {skipped} skipped; largest deviation {worst:.2e}, \
             {:.0} % of what was allowed",
            100.0 * closest
        )
    }
}

/// A check that did not hold, and the smallest scene found that shows it.
///
/// `{}` and `{:?}` both print the scene as a scene file, so that `unwrap` in a test shows it.
#[derive(Clone)]
pub struct CheckFailure {
    /// The check.
    pub check: &'static str,
    /// The renderer.
    pub renderer: &'static str,
    /// The finding, and the limit.
    pub reason: String,
    /// The scene.
    pub scene: Option<Box<TestScene>>,
}

impl std::fmt::Display for CheckFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "renderer {} fails the check '{}': {}", self.renderer, self.check, self.reason)?;
        if let Some(scene) = &self.scene {
            write!(f, "\nThe scene, for vr render --scene:\n{scene:?}")?;
        }
        Ok(())
    }
}

impl std::fmt::Debug for CheckFailure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for CheckFailure {}
