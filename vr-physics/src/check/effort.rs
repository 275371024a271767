//! The effort of a check, and the seeded run over random scenes.

use std::cell::{Cell, RefCell};

use proptest::strategy::{BoxedStrategy, Strategy};
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestCaseError, TestError, TestRunner};
use vr_core::{RenderError, Renderer};

use super::outcome::{CheckFailure, Report};
use super::strategies::{
    Kind, adaptive_scene, mesh_scene, rectilinear_scene, scene, scene_of, tame_adaptive_scene, tame_mesh_scene,
    tame_rectilinear_scene, tame_scene,
};
use super::test_scene::TestScene;
use crate::Reference;

/// The effort of a check. The default takes a second or so with a fast renderer.
#[derive(Clone, Debug)]
pub struct Effort {
    /// Number of random scenes.
    pub cases: u32,
    /// Seed of the random numbers: the same seed draws the same scenes.
    pub seed: u64,
    /// Largest number of attempts at making a failing scene smaller.
    pub shrink_steps: u32,
    /// The reference that pictures are compared with.
    pub reference: Reference,
    /// The kinds of scenes that checks over any scenes draw; `None`: their own.
    pub kinds: Option<Vec<Kind>>,
    /// The volumes of the scenes.
    pub volumes: Volumes,
}

/// The volumes that random scenes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Volumes {
    /// Uniform grids.
    Grids,
    /// Meshes of cells.
    Meshes,
    /// Adaptive meshes.
    AdaptiveMeshes,
    /// Rectilinear grids.
    RectilinearGrids,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            cases: 64,
            seed: 0x5eed,
            shrink_steps: 2000,
            reference: Reference::default(),
            kinds: None,
            volumes: Volumes::Grids,
        }
    }
}

impl Effort {
    /// The default with another number of random scenes.
    pub fn cases(cases: u32) -> Self {
        Self { cases, ..Self::default() }
    }

    /// The same with scenes of these kinds, in checks over any scenes: those that look at tame or smooth ones draw their own.
    #[must_use]
    pub fn of_kinds(self, kinds: &[Kind]) -> Self {
        Self { kinds: Some(kinds.to_vec()), ..self }
    }

    /// The same with scenes of other volumes, for renderers that draw them. [Kinds](Kind) of scenes are of uniform grids, and count no more of others.
    #[must_use]
    pub fn on(self, volumes: Volumes) -> Self {
        Self { volumes, ..self }
    }

    /// Any scenes: of the kinds asked for, or of all that is valid of the volumes.
    pub(super) fn any_scene(&self) -> BoxedStrategy<TestScene> {
        match (self.volumes, &self.kinds) {
            (Volumes::Grids, Some(kinds)) => scene_of(kinds).boxed(),
            (Volumes::Grids, None) => scene().boxed(),
            (Volumes::Meshes, _) => mesh_scene().boxed(),
            (Volumes::AdaptiveMeshes, _) => adaptive_scene().boxed(),
            (Volumes::RectilinearGrids, _) => rectilinear_scene().boxed(),
        }
    }

    /// Scenes whose picture depends continuously on every number.
    pub(super) fn tame_scene(&self) -> BoxedStrategy<TestScene> {
        match self.volumes {
            Volumes::Grids => tame_scene().boxed(),
            Volumes::Meshes => tame_mesh_scene().boxed(),
            Volumes::AdaptiveMeshes => tame_adaptive_scene().boxed(),
            Volumes::RectilinearGrids => tame_rectilinear_scene().boxed(),
        }
    }
}

/// The verdict on one scene.
pub(super) enum Verdict {
    /// The scene held: the measured and the allowed deviation.
    Held { measured: f64, allowed: f64 },
    /// The renderer refuses such scenes.
    Refused,
    /// The scene could not be judged.
    Skipped,
    /// The scene did not hold, for this reason.
    Broken(String),
}

impl Verdict {
    /// Returns `Held` if `measured` is at most `allowed`; `what` is called only if not.
    pub fn within(measured: f64, allowed: f64, what: impl FnOnce() -> String) -> Self {
        // Written so that NaN is broken.
        if measured <= allowed {
            Self::Held { measured, allowed }
        } else {
            Self::Broken(format!("{}: {measured:.3e}, allowed {allowed:.3e}", what()))
        }
    }
}

/// An unsupported scene is refused; any other error is a fault, for the scenes are all valid.
impl From<RenderError> for Verdict {
    fn from(e: RenderError) -> Self {
        match e {
            RenderError::Unsupported { .. } => Self::Refused,
            other => Self::Broken(format!("an error on a valid scene: {other}")),
        }
    }
}

impl Effort {
    pub(super) fn runner(&self) -> TestRunner {
        TestRunner::new(Config {
            cases: self.cases,
            max_shrink_iters: self.shrink_steps,
            failure_persistence: None,
            rng_algorithm: RngAlgorithm::ChaCha,
            rng_seed: RngSeed::Fixed(self.seed),
            ..Config::default()
        })
    }

    /// Puts every scene through `judge`; a panic in it is a failure like any other. Failing scenes are shrunk.
    pub(super) fn over(
        &self,
        check: &'static str,
        renderer: &dyn Renderer,
        scenes: impl Strategy<Value = TestScene>,
        judge: impl Fn(&TestScene) -> Result<Verdict, RenderError>,
    ) -> Result<Report, CheckFailure> {
        let report = RefCell::new(Report::new(check, renderer.name()));
        let failed = Cell::new(false);
        let result = self.runner().run(&scenes, |test| {
            let verdict = judge(&test).unwrap_or_else(Verdict::from);
            if let Verdict::Broken(reason) = verdict {
                failed.set(true);
                return Err(TestCaseError::fail(reason));
            }
            // Smaller scenes that are tried after a failure are no part of the statistics.
            if !failed.get() {
                report.borrow_mut().count(&verdict, &test);
            }
            Ok(())
        });
        let failure = |reason: String, scene| CheckFailure { check, renderer: renderer.name(), reason, scene };
        match result {
            Ok(()) => report.into_inner().demand_some_held(),
            Err(TestError::Fail(reason, scene)) => Err(failure(reason.message().to_owned(), Some(Box::new(scene)))),
            Err(TestError::Abort(reason)) => Err(failure(reason.message().to_owned(), None)),
        }
    }
}
