//! Named suites of measurements.

use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use vr_core::{Camera, Control, Model, Options, Renderer, StudiedRenderer, View};

use crate::candidate::{Candidate, candidates};
use crate::convergence::{Convergence, OrderCheck, Outcome};
use crate::error::StudyError;
use crate::journal::Journal;
use crate::machine::Machine;
use crate::memory::MemoryMeter;
use crate::reference::{ReferenceCache, fingerprint};
use crate::scaling::{Grown, Growth, grow};
use crate::stability::{CaseResult, candidates_with_bounds, survey};
use crate::study::{Study, SubjectResult};
use crate::subject::{Subject, lit_fog, phantom_subjects};
use crate::timing::Timing;

/// Set of measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Suite {
    /// Speed against error in small pictures, and the orders of convergence: less than a minute on two cores.
    Quick,
    /// Everything: larger volumes and pictures, three views of each, one in which light is scattered, stability, scaling.
    Full,
    /// Every renderer on every hard case.
    Hard,
    /// Growth of times with threads, volumes and pictures.
    Scaling,
}

impl Suite {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Full => "full",
            Self::Hard => "hard",
            Self::Scaling => "scaling",
        }
    }

    fn has(self, part: Part) -> bool {
        match part {
            Part::Fronts | Part::Orders => matches!(self, Self::Quick | Self::Full),
            Part::Stability => matches!(self, Self::Hard | Self::Full),
            Part::Growth => matches!(self, Self::Scaling | Self::Full),
        }
    }

    /// Returns the number of voxels along each side of phantoms, and of pixels along each side of their pictures.
    fn sizes(self) -> (usize, u32) {
        if self == Self::Quick { (64, 96) } else { (128, 256) }
    }

    /// Returns the time for the rounds of one of so many subjects: half a minute in all for the quick suite, however many renderers there are.
    fn timing(self, subjects: usize) -> Timing {
        let quick = Duration::from_secs(33) / subjects.max(1) as u32;
        let patience = if self == Self::Quick { quick } else { Duration::from_secs(20) };
        let min_rounds = if self == Self::Quick { 1 } else { 3 };
        Timing { min_rounds, max_rounds: 9, patience }
    }
}

#[derive(Clone, Copy)]
enum Part {
    Fronts,
    Orders,
    Stability,
    Growth,
}

/// Results of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The suite.
    pub suite: Suite,
    /// The machine that it was measured on.
    pub machine: Machine,
    /// Command that made the report, if there is one.
    #[serde(default)]
    pub command: Option<String>,
    /// Seconds that it took, without what had been done before.
    pub seconds: f64,
    /// Speed against error.
    pub subjects: Vec<SubjectResult>,
    /// Orders of convergence.
    pub orders: Vec<Convergence>,
    /// Hard cases.
    pub stability: Vec<CaseResult>,
    /// Growth of times.
    pub growth: Vec<Growth>,
}

impl Report {
    /// Returns the number of pictures of hard cases that failed without an explanation by the renderer.
    pub fn failed_cases(&self) -> usize {
        self.stability.iter().filter(|r| r.verdict.is_failure()).count()
    }

    /// Returns the number of orders that are not as documented.
    pub fn failing_orders(&self) -> usize {
        self.orders.iter().filter(|c| c.outcome() == Outcome::Fails).count()
    }
}

/// Settings of a run of a suite.
pub struct Run<'a> {
    /// Renderers that take part.
    pub renderers: &'a [Box<dyn StudiedRenderer>],
    /// Subject that is measured in place of the phantoms.
    pub own: Option<Subject>,
    /// True if nothing is timed: errors and counts alone.
    pub untimed: bool,
    /// Reference pixels that were solved before.
    pub cache: &'a ReferenceCache,
    /// Meter of memory; `None` if memory is not measured.
    pub meter: Option<&'a dyn MemoryMeter>,
    /// Command that makes the report, if there is one.
    pub command: Option<String>,
    /// File in which finished parts are noted, so that a run can be resumed; `None` if they are not.
    pub journal: Option<&'a Path>,
}

/// Named piece of work; its weight is its share of the progress.
struct Piece<'a> {
    name: String,
    weight: f64,
    work: Work<'a>,
}

enum Work<'a> {
    Subject(Box<Subject>),
    Orders(&'a dyn StudiedRenderer),
    Stability(String, &'a dyn StudiedRenderer),
    Growth(&'a dyn Renderer, Grown),
}

impl Run<'_> {
    /// Runs a suite. `progress` is called with the share that is done, 0 to 1.
    ///
    /// # Errors
    /// A renderer that fails, a journal that cannot be written, or cancellation.
    pub fn run(&self, suite: Suite, (control, progress): (&Control, &dyn Fn(f64))) -> Result<Report, StudyError> {
        let start = Instant::now();
        let settings = candidates(self.renderers)?;
        let pieces = self.pieces(suite, &settings)?;
        let machine = Machine::here(control.threads());
        let mut journal =
            self.journal.map(|path| Journal::open(path, &self.signature(suite, &machine, &settings))).transpose()?;
        let subjects = pieces.iter().filter(|p| matches!(p.work, Work::Subject(_))).count();
        let study = Study {
            candidates: &settings,
            timing: (!self.untimed).then(|| suite.timing(subjects)),
            // Every pixel of the small pictures of the quick suite.
            subgrid: 96,
            own_subgrid: 16,
            cache: self.cache,
            meter: self.meter,
        };
        let check = OrderCheck { cache: self.cache, control };
        let mut report = Report {
            suite,
            machine,
            command: self.command.clone(),
            seconds: 0.0,
            subjects: Vec::new(),
            orders: Vec::new(),
            stability: Vec::new(),
            growth: Vec::new(),
        };
        // Measure piece by piece, or take what the journal has.
        let total: f64 = pieces.iter().map(|p| p.weight).sum();
        let mut done = 0.0;
        for Piece { name, weight, work } in &pieces {
            let progress = |share: f64| progress((done + weight * share) / total);
            control.check()?;
            match work {
                Work::Subject(subject) => {
                    let result = noted(&mut journal, name, || Ok(study.measure(subject, (control, &progress))?))?;
                    report.subjects.push(result);
                }
                Work::Orders(renderer) => {
                    report.orders.extend(noted(&mut journal, name, || check.check_claims(*renderer, &progress))?);
                }
                Work::Stability(candidate, renderer) => {
                    let survey = || Ok(survey((candidate, *renderer), self.cache, control)?);
                    report.stability.extend(noted(&mut journal, name, survey)?);
                }
                Work::Growth(renderer, grown) => {
                    let grow = || grow(*renderer, "blobs", *grown, (control, &progress));
                    report.growth.extend(noted(&mut journal, name, grow)?);
                }
            }
            done += weight;
        }
        report.seconds = start.elapsed().as_secs_f64();
        if let Some(journal) = journal {
            journal.finish()?;
        }
        Ok(report)
    }

    /// Returns the text that two runs must share so that one can resume the other: the program, the machine, the settings, and all of the scene.
    fn signature(&self, suite: Suite, machine: &Machine, settings: &[Candidate]) -> String {
        let program = std::env::current_exe().and_then(std::fs::metadata).ok();
        let program = program.map(|file| (file.len(), file.modified().ok()));
        let own = self.own.as_ref().map(|s| {
            let scene = fingerprint((&s.scene, &s.view), &Model::Canonical, &[], 0.0);
            (&s.name, scene, s.scene.volume.filter(), s.scene.background)
        });
        let who: Vec<(String, &Options)> = settings.iter().map(|c| (c.name(), &c.options)).collect();
        format!("{} {program:?} {machine:?} {who:?} {own:?} {}", suite.name(), self.untimed)
    }

    fn pieces<'a>(&'a self, suite: Suite, settings: &'a [Candidate]) -> Result<Vec<Piece<'a>>, StudyError> {
        let mut pieces = Vec::new();
        if suite.has(Part::Fronts) {
            let (samples, pixels) = suite.sizes();
            let subjects = match &self.own {
                Some(own) => vec![own.clone()],
                None => {
                    let lit = (suite == Suite::Full).then(|| lit_fog(samples, [pixels; 2])).transpose()?;
                    phantom_subjects(samples, [pixels; 2])?.into_iter().chain(lit).collect()
                }
            };
            for subject in subjects {
                let all = if suite == Suite::Full { three_views(&subject) } else { vec![subject] };
                let piece = |s: Subject| Piece {
                    name: format!("subject {}", s.name),
                    weight: 8.0,
                    work: Work::Subject(Box::new(s)),
                };
                pieces.extend(all.into_iter().map(piece));
            }
        }
        if suite.has(Part::Orders) {
            let claiming = self.renderers.iter().filter(|r| !r.convergence().is_empty());
            pieces.extend(claiming.map(|r| Piece {
                name: format!("orders {}", r.name()),
                weight: 8.0,
                work: Work::Orders(&**r),
            }));
        }
        if suite.has(Part::Stability) {
            pieces.extend(candidates_with_bounds(self.renderers, settings).into_iter().map(|(name, r)| Piece {
                name: format!("stability {name}"),
                weight: 1.0,
                work: Work::Stability(name, r),
            }));
        }
        if suite.has(Part::Growth) {
            for renderer in self.renderers {
                pieces.extend(Grown::ALL.into_iter().map(|grown| Piece {
                    name: format!("growth {} {}", renderer.name(), grown.word()),
                    weight: 6.0,
                    work: Work::Growth(&**renderer, grown),
                }));
            }
        }
        Ok(pieces)
    }
}

/// Returns the result of a part: the noted one, or one that is made now and noted.
fn noted<T: Serialize + serde::de::DeserializeOwned>(
    journal: &mut Option<Journal>,
    name: &str,
    make: impl FnOnce() -> Result<T, StudyError>,
) -> Result<T, StudyError> {
    match journal {
        Some(journal) => journal.part(name, make),
        None => make(),
    }
}

/// Returns three views: the subject's own; in perspective from the other side; and along an axis, so that rays run in cell faces.
fn three_views(subject: &Subject) -> Vec<Subject> {
    let bounds = subject.scene.volume.bounds();
    let seen = |word: &str, azimuth: f64, elevation: f64, fov: Option<f64>| {
        let camera = Camera::framing(bounds, azimuth, elevation, fov);
        subject.seen(word, View { camera, ..subject.view.clone() })
    };
    vec![subject.clone(), seen("perspective", 210.0, -15.0, Some(35.0)), seen("along z", 0.0, 0.0, None)]
}
