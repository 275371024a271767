//! Models of light from the simplest to the whole, and which of them a scene needs.
//!
//! Each [`LightModel`] leaves some of the equation of transfer out. What that costs is bounded from a few facts of the scene ([`SceneFacts`]) before
//! anything is drawn, and the lowest model that costs nothing, or no more than is allowed, is chosen ([`Ladder::chosen`]).
//!
//! The bounds come from the orders of scattering. Let C = 1 − e^(−τ) with τ the largest optical thickness of any straight path: no path meets more than the
//! share C of the source function j/χ around it. If light from lamps, from all sides and from the medium itself makes a source function of at
//! most S after one scattering, then after n it is at most S (ϖ C)ⁿ⁻¹, and the sum of what is left out a geometric series.

mod cost;
mod facts;
mod thickness;

pub use facts::SceneFacts;
pub use thickness::{thickness_along, thickness_bound};

use std::fmt;

use vr_core::{Clip, RenderError, Scene};

use crate::medium::SceneMedium;

/// Part of the equation of transfer that is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LightModel {
    /// Nothing is in the way of light.
    Vacuum,
    /// Light is absorbed: a shadow before the background.
    Absorption,
    /// The medium emits and is transparent.
    Emission,
    /// The medium emits and absorbs; scattering takes light away alone.
    EmissionAbsorption,
    /// Light of lamps and from all sides is scattered once on its way to the eye.
    SingleScattering,
    /// All of it.
    MultipleScattering,
}

impl LightModel {
    /// Every model, the simplest first.
    pub const ALL: [Self; 6] = [
        Self::Vacuum,
        Self::Absorption,
        Self::Emission,
        Self::EmissionAbsorption,
        Self::SingleScattering,
        Self::MultipleScattering,
    ];

    /// The effects that the model leaves out, in a few words.
    pub fn leaves_out(self) -> &'static str {
        match self {
            Self::Vacuum => "the medium",
            Self::Absorption => "emission, and light that is scattered towards the eye",
            Self::Emission => "absorption, and scattering",
            Self::EmissionAbsorption => "light that is scattered towards the eye",
            Self::SingleScattering => "light that is scattered more than once",
            Self::MultipleScattering => "nothing",
        }
    }
}

impl fmt::Display for LightModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Vacuum => "vacuum",
            Self::Absorption => "absorption",
            Self::Emission => "emission",
            Self::EmissionAbsorption => "emission-absorption",
            Self::SingleScattering => "single scattering",
            Self::MultipleScattering => "multiple scattering",
        })
    }
}

/// Models with what each would cost on a scene, and the one that it needs.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use vr_core::{Clip, phantom};
/// use vr_core::scattering::{Albedo, Scattering};
/// use vr_light::{Ladder, LightModel};
///
/// let mut scene = phantom::by_name("fog").unwrap().scene(9)?;
/// assert_eq!(Ladder::of(&scene, &Clip::default(), 0.0)?.chosen(), LightModel::EmissionAbsorption);
/// scene.scattering = Some(Arc::new(Scattering { albedo: Albedo::Constant([0.5; 3]), ..Scattering::default() }));
/// let ladder = Ladder::of(&scene, &Clip::default(), 0.0)?;
/// assert_eq!(ladder.chosen(), LightModel::MultipleScattering);
/// assert!(ladder.cost(LightModel::SingleScattering) < ladder.cost(LightModel::EmissionAbsorption));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    facts: SceneFacts,
    costs: [f64; 6],
    chosen: LightModel,
}

impl Ladder {
    /// The models of what a clip leaves of a scene. The lowest one is chosen whose pixels differ from those of the whole equation by at most `allowed`.
    ///
    /// # Errors
    /// A scene that makes no sense.
    pub fn of(scene: &Scene, clip: &Clip, allowed: f64) -> Result<Self, RenderError> {
        scene.validate()?;
        let medium = SceneMedium::new(scene, clip, scene.scattering.as_deref().unwrap_or(&cost::NO_SCATTERING))?;
        Ok(Self::of_facts(SceneFacts::of(scene, &medium), allowed))
    }

    /// The models for facts that are known.
    pub fn of_facts(facts: SceneFacts, allowed: f64) -> Self {
        let costs = LightModel::ALL.map(|model| cost::cost(model, &facts));
        let fits = |model: &&LightModel| costs[**model as usize] <= allowed;
        let chosen = *LightModel::ALL.iter().find(fits).unwrap_or(&LightModel::MultipleScattering);
        Self { facts, costs, chosen }
    }

    /// Facts of the scene that the bounds come from.
    pub fn facts(&self) -> &SceneFacts {
        &self.facts
    }

    /// Upper bound of the difference of any component of any pixel between a model and the whole equation; +∞ where none is known.
    pub fn cost(&self, model: LightModel) -> f64 {
        self.costs[model as usize]
    }

    /// The lowest model that costs no more than is allowed.
    pub fn chosen(&self) -> LightModel {
        self.chosen
    }
}
