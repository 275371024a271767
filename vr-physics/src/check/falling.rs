//! Errors that fall as steps get shorter, over scenes of every kind.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use proptest::strategy::{Strategy, ValueTree};
use vr_core::{Configurable, Control, Model, OptionError, Options, RenderError, Renderer};

use super::drawn::{ReferencePixels, SceneName, Solution, draw, solve_once};
use super::effort::Effort;
use super::outcome::CheckFailure;
use super::strategies::Kind;
use super::test_scene::TestScene;
use crate::{Metrics, Reference};

const CHECK: &str = "errors fall with the step";

/// Steps of one level, relative to its longest. One step alone may happen to meet every jump in the right place, or none of a row
/// of spikes; three that have no common multiple seldom do.
const PHASES: [f64; 3] = [1.0, 0.87, 0.76];

/// RMSE that a single scene may have by chance: one ray of thirty in one of three phases off by a fiftieth.
pub const CHANCE: f64 = 2e-3;

/// The error of all scenes of a kind together, where chance evens out, may be so many times what the order says.
const POOLED_SLACK: f64 = 2.0;

/// One scene in this many, the worst, does not count in the error of all scenes of a kind together.
const WORST_LEFT_OUT: usize = 20;

/// Refinement of a renderer, and the fall of errors that is demanded.
#[derive(Clone, Debug)]
pub struct Falling {
    /// Options held fixed.
    pub options: Options,
    /// The option that gets smaller.
    pub step: &'static str,
    /// Its first value.
    pub coarsest: f64,
    /// Factor by which it is smaller at each of the two levels below.
    pub ratio: f64,
    /// The power of the option that RMSE falls like where a transfer function jumps: ½ for steps, since the part h of all rays is
    /// wrong by all that is at stake.
    pub order: f64,
    /// RMSE below which rounding and tables decide: two right computations of a steep scene in f32 differ by 10⁻⁵ to 4·10⁻⁵.
    pub floor: f64,
    /// The error of one scene's shortest steps may be so many times that of its longer ones (and [`CHANCE`] more): three phases of
    /// some thirty rays leave chance a say where a few of them graze a jump or meet a spike. A fault that grows with the number of
    /// steps is beyond it by far.
    pub scene_slack: f64,
}

impl Falling {
    /// Eighths of a step from 1 on, order ½, a floor of 10⁻⁴, one scene's error at most twice what it was.
    pub fn new(step: &'static str) -> Self {
        Self { options: Options::new(), step, coarsest: 1.0, ratio: 8.0, order: 0.5, floor: 1e-4, scene_slack: 2.0 }
    }

    /// A renderer at every step.
    ///
    /// # Errors
    /// An option that the renderer does not have, or does not take.
    pub fn ladder(&self, renderer: &impl Configurable) -> Result<Ladder, OptionError> {
        let at = |level: i32, phase: f64| {
            let step = self.coarsest * phase / self.ratio.powi(level);
            let configured = renderer.configure(&self.options.clone().with(self.step, step));
            configured.map(|renderer| Box::new(renderer) as Box<dyn Renderer>)
        };
        let level = |level| PHASES.into_iter().map(|phase| at(level, phase)).collect::<Result<Vec<_>, _>>();
        Ok(Ladder { levels: [level(0)?, level(1)?, level(2)?], falling: self.clone() })
    }

    /// The largest error of the shortest steps, by those of the longer ones, for one scene.
    fn allowed(&self, errors: &[f64; 3], uncertainty: f64) -> f64 {
        (self.floor + uncertainty).max(self.scene_slack * errors[0].max(errors[1]) + CHANCE)
    }

    /// Largest error of the shortest steps that is allowed for all scenes of a kind together.
    fn allowed_together(&self, errors: &[f64; 3]) -> f64 {
        self.floor.max(POOLED_SLACK * self.ratio.powf(-2.0 * self.order) * errors[0])
    }
}

/// A renderer at steps of three lengths.
pub struct Ladder {
    levels: [Vec<Box<dyn Renderer>>; 3],
    falling: Falling,
}

/// The verdict of a ladder on a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Fall {
    /// Errors that fall, or stay below the floor: RMSE, the longest steps first.
    Within([f64; 3]),
    /// Errors that grow, or do not fall to what is allowed of the last.
    Beyond([f64; 3], f64),
    /// A panic, an error on a valid scene, a pixel that is not finite.
    Failed(String),
    /// The renderer does not draw such scenes.
    Refused,
    /// The reference cannot solve the scene, or is less certain than the floor.
    Unjudged,
}

impl Fall {
    /// True if something is wrong.
    pub fn falls_short(&self) -> bool {
        matches!(self, Self::Beyond(..) | Self::Failed(_))
    }
}

impl std::fmt::Display for Fall {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Within([a, b, c]) => write!(f, "RMSE {a:.2e}, {b:.2e}, {c:.2e} as steps get shorter"),
            Self::Beyond([a, b, c], allowed) => {
                write!(f, "RMSE {a:.2e}, {b:.2e}, {c:.2e} as steps get shorter; allowed of the last {allowed:.2e}")
            }
            Self::Failed(reason) => f.write_str(reason),
            Self::Refused => f.write_str("refused"),
            Self::Unjudged => f.write_str("not judged"),
        }
    }
}

impl Ladder {
    /// Draws a scene at all steps and judges it.
    pub fn judge(&self, test: &TestScene, reference: &Reference) -> Fall {
        self.judge_by(test, &|| Ok(ReferencePixels::solve(reference, test, &Model::Canonical)?.map(Arc::new)))
    }

    /// The same with the reference that `solve` gives.
    fn judge_by(&self, test: &TestScene, solve: &dyn Fn() -> Result<Solution, RenderError>) -> Fall {
        // Nothing that a panic leaves half done is used afterwards.
        match catch_unwind(AssertUnwindSafe(|| self.errors(test, solve))) {
            Ok(Ok(Some((errors, uncertainty)))) => self.weigh(errors, uncertainty),
            Ok(Ok(None)) => Fall::Unjudged,
            Ok(Err(RenderError::Unsupported { .. })) => Fall::Refused,
            // Steps that are too short or too many for this volume, and said to be so.
            Ok(Err(RenderError::Parameter(e))) if e.field.starts_with("render.") => Fall::Refused,
            Ok(Err(other)) => Fall::Failed(format!("an error on a valid scene: {other}")),
            Err(_) => Fall::Failed("panics".to_owned()),
        }
    }

    fn weigh(&self, errors: [f64; 3], uncertainty: f64) -> Fall {
        if !errors.iter().all(|e| e.is_finite()) {
            return Fall::Failed("a pixel is not finite".to_owned());
        }
        let allowed = self.falling.allowed(&errors, uncertainty);
        if errors[2] <= allowed { Fall::Within(errors) } else { Fall::Beyond(errors, allowed) }
    }

    /// The errors, and how uncertain the reference is; `None` if that is above the floor.
    fn errors(
        &self,
        test: &TestScene,
        solve: &dyn Fn() -> Result<Solution, RenderError>,
    ) -> Result<Option<([f64; 3], f64)>, RenderError> {
        let frame = |r: &dyn Renderer| draw(r, test, &Control::default());
        // Most scenes that are refused are refused by all steps: known before the reference has any work.
        let first = frame(&*self.levels[0][0])?;
        let Some(expected) = solve()? else { return Ok(None) };
        if expected.uncertainty.is_nan() || expected.uncertainty > self.falling.floor {
            return Ok(None);
        }
        let mut errors = [0.0; 3];
        for (i, level) in self.levels.iter().enumerate() {
            let mut squares = 0.0;
            for (k, renderer) in level.iter().enumerate() {
                let drawn = if (i, k) == (0, 0) { first.clone() } else { frame(&**renderer)? };
                let rmse = Metrics::of(&expected.pixels, drawn.pixels()).rmse;
                squares += rmse * rmse;
            }
            errors[i] = (squares / level.len() as f64).sqrt();
        }
        Ok(Some((errors, expected.uncertainty)))
    }
}

/// All scenes of a kind together.
#[derive(Clone, Debug, PartialEq)]
pub struct KindFall {
    /// The kind.
    pub kind: Kind,
    /// Scenes within what is allowed.
    pub within: u32,
    /// Scenes beyond it, or not drawn as they should be.
    pub beyond: u32,
    /// Scenes that the renderer refuses.
    pub refused: u32,
    /// Scenes that the reference cannot solve.
    pub unjudged: u32,
    /// The largest error of the shortest steps and its scene's seed.
    pub worst: Option<(f64, u64)>,
    /// Squares of the RMSE of every scene, the longest steps first.
    squares: Vec<[f64; 3]>,
    /// The largest error of the shortest steps that is allowed of all scenes together.
    pub allowed: f64,
}

impl KindFall {
    fn new(kind: Kind) -> Self {
        Self { kind, within: 0, beyond: 0, refused: 0, unjudged: 0, worst: None, squares: Vec::new(), allowed: 0.0 }
    }

    fn count(&mut self, seed: u64, fall: &Fall) {
        match fall {
            Fall::Within(_) => self.within += 1,
            Fall::Beyond(..) | Fall::Failed(_) => self.beyond += 1,
            Fall::Refused => self.refused += 1,
            Fall::Unjudged => self.unjudged += 1,
        }
        if let Fall::Within(errors) | Fall::Beyond(errors, _) = fall {
            self.squares.push(errors.map(|e| e * e));
            if self.worst.is_none_or(|(e, _)| errors[2] > e) {
                self.worst = Some((errors[2], seed));
            }
        }
    }

    /// Scenes drawn.
    pub fn drawn(&self) -> u32 {
        self.within + self.beyond + self.refused + self.unjudged
    }

    /// The root mean square of the RMSE of all scenes, the longest steps first; zeros if none was judged.
    ///
    /// The worst twentieth of the scenes at the shortest steps is left out: a single ray that is in a wall for less than a step is
    /// wrong by all, and would decide alone. A fault of tables, of vacuum or of an operator is in more scenes than that.
    pub fn errors(&self) -> [f64; 3] {
        let mut by_last = self.squares.clone();
        by_last.sort_by(|a, b| a[2].total_cmp(&b[2]));
        let kept = by_last.len() - by_last.len() / WORST_LEFT_OUT;
        std::array::from_fn(|level| {
            let scenes = if level == 2 { &by_last[..kept] } else { &by_last[..] };
            (scenes.iter().map(|s| s[level]).sum::<f64>() / scenes.len().max(1) as f64).sqrt()
        })
    }

    /// True if the errors of all scenes together do not fall as they must.
    pub fn falls_short(&self) -> bool {
        // Written so that NaN falls short.
        let falls = self.errors()[2] <= self.allowed;
        !falls
    }
}

impl std::fmt::Display for KindFall {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.errors();
        let Self { kind, within, beyond, refused, unjudged, allowed, .. } = self;
        write!(f, "{:<16}{:>6}{refused:>8}{unjudged:>9}{within:>7}{beyond:>7}", kind.name(), self.drawn())?;
        write!(f, "  {a:.2e} {b:.2e} {c:.2e} of {allowed:.2e}{}", if self.falls_short() { " NOT" } else { "    " })?;
        self.worst.map_or(Ok(()), |(error, seed)| write!(f, "  {error:.2e} seed {seed}"))
    }
}

/// Puts the scenes that some seeds draw through a ladder, and shows each of them with its verdict.
pub fn survey_kind(
    ladder: &Ladder,
    kind: Kind,
    seeds: std::ops::Range<u64>,
    reference: &Reference,
    mut show: impl FnMut(u64, &TestScene, &Fall),
) -> KindFall {
    survey(ladder, kind, seeds, |_, test| ladder.judge(test, reference), &mut show)
}

/// Puts the scenes that some seeds draw through `judge`.
fn survey(
    ladder: &Ladder,
    kind: Kind,
    seeds: std::ops::Range<u64>,
    judge: impl Fn(u64, &TestScene) -> Fall,
    show: &mut dyn FnMut(u64, &TestScene, &Fall),
) -> KindFall {
    let mut table = KindFall::new(kind);
    for seed in seeds {
        let test = kind.draw(seed);
        let fall = judge(seed, &test);
        table.count(seed, &fall);
        show(seed, &test, &fall);
    }
    table.allowed = ladder.falling.allowed_together(&table.errors());
    table
}

/// The error against the canonical pixel falls as steps get shorter, over scenes of every [kind](Kind) (or of those that `effort`
/// names): that of each scene does not grow, and that of all scenes of a kind together falls at the order for jumps, or stays
/// below the floor.
///
/// The order of smooth scenes, which is higher, is what [`converges`](super::converges) looks at. Here a scene may have anything,
/// and steps of the same length meet jumps where they happen to: so errors are means over three steps of nearly one length, and
/// one that has doubled has not grown yet. The shortest steps are much shorter than any that a picture needs: what
/// bleeds from one side of a jump to the other does so in one sample of hundreds.
///
/// # Errors
/// The first scene that shows otherwise, made smaller; or the kind, with its table and its worst scene.
pub fn errors_fall(
    renderer: &impl Configurable,
    falling: &Falling,
    effort: &Effort,
) -> Result<Vec<KindFall>, CheckFailure> {
    let failure = |reason: String, scene| CheckFailure { check: CHECK, renderer: renderer.name(), reason, scene };
    let ladder = falling.ladder(renderer).map_err(|e| failure(e.to_string(), None))?;
    let seeds = effort.seed..effort.seed + u64::from(effort.cases);
    let mut tables = Vec::new();
    for &kind in effort.kinds.as_deref().unwrap_or(&Kind::ALL) {
        let mut broken = None;
        let judge = |seed: u64, test: &TestScene| {
            ladder.judge_by(test, &|| solve_once(&effort.reference, SceneName::Drawn(kind, seed), test))
        };
        let table = survey(&ladder, kind, seeds.clone(), judge, &mut |seed, _, fall| {
            if broken.is_none() && fall.falls_short() {
                broken = Some(seed);
            }
        });
        if let Some(seed) = broken {
            let (scene, fall) = shrunk(&ladder, kind, seed, effort);
            let reason = format!("kind '{}', seed {seed}: {fall}", kind.name());
            return Err(failure(reason, Some(Box::new(scene))));
        }
        if table.falls_short() {
            let worst = table.worst.map(|(_, seed)| Box::new(kind.draw(seed)));
            return Err(failure(format!("all scenes of a kind together:\n{table}"), worst));
        }
        tables.push(table);
    }
    if tables.iter().all(|t| t.within == 0) {
        let refused: u32 = tables.iter().map(|t| t.refused).sum();
        return Err(failure(format!("not one scene was judged: {refused} refused"), None));
    }
    Ok(tables)
}

/// The smallest scene found that falls short as well.
fn shrunk(ladder: &Ladder, kind: Kind, seed: u64, effort: &Effort) -> (TestScene, Fall) {
    let mut runner = Effort { seed, ..effort.clone() }.runner();
    let mut tree = kind.scenes().new_tree(&mut runner).expect("no scene is rejected");
    let mut smallest = (tree.current(), ladder.judge(&tree.current(), &effort.reference));
    let mut goes_on = tree.simplify();
    for _ in 0..effort.shrink_steps {
        if !goes_on {
            break;
        }
        let test = tree.current();
        let fall = ladder.judge(&test, &effort.reference);
        goes_on = if fall.falls_short() {
            smallest = (test, fall);
            tree.simplify()
        } else {
            tree.complicate()
        };
    }
    smallest
}
