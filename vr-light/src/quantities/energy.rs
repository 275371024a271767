//! The balance of energy: what is emitted is absorbed or escapes.

use vr_core::parallel::try_collect;
use vr_core::{Control, RenderError};

use super::Estimate;
use super::forward::{Fate, ForwardSampler};
use crate::light_scene::LightScene;
use crate::random::RandomStream;

/// Power by its fate, summed over all bands, of light that is followed from where it is emitted.
///
/// Counted is the light that the medium and the surfaces emit, that of point lights, and that of a uniform environment which comes in through the sphere
/// around everything.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use vr_core::Control;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::quantities::EnergyBalance;
/// use vr_light::{Coefficients, Homogeneous, LightScene};
///
/// let glow = Coefficients { absorption: 0.5, scattering: 1.0, emission: 2.0 };
/// let cube = Homogeneous::new((DVec3::ZERO, DVec3::ONE), vec![glow], PhaseFunction::Isotropic)?;
/// let scene = LightScene::new(Some(Arc::new(cube)), 1)?;
/// let balance = EnergyBalance::new(&scene, 2000, 1, &Control::default())?;
/// // 4π q V.
/// assert!(balance.emitted.is_within(8.0 * std::f64::consts::PI, 3.0));
/// assert!(balance.is_closed(3.0));
/// # Ok::<(), vr_core::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBalance {
    /// Power of all sources.
    pub emitted: Estimate,
    /// Power absorbed in the medium.
    pub absorbed: Estimate,
    /// Power absorbed by surfaces.
    pub absorbed_by_surfaces: Estimate,
    /// Power that leaves everything behind.
    pub escaped: Estimate,
    /// Emitted less absorbed and escaped: 0 within its standard error.
    pub residual: Estimate,
}

impl EnergyBalance {
    /// The balance of a scene over random packets of light.
    ///
    /// # Errors
    /// Sources that have no end: planes that emit, a medium without end that emits, directional lights and headlights, and maps, whose power through
    /// a scene is not counted; [`RenderError::Cancelled`].
    pub fn new(scene: &LightScene, packets: u64, seed: u64, control: &Control) -> Result<Self, RenderError> {
        let sampler = ForwardSampler::new(scene)?;
        let one = |number: usize| {
            control.check()?;
            sampler.sample(&mut RandomStream::new(seed, 0, number as u64), control)
        };
        let fates: Vec<Fate> = control.run(|| try_collect(packets as usize, one))?;
        let mean = |of: fn(&Fate) -> f64| fates.iter().map(of).collect::<Estimate>();
        Ok(Self {
            emitted: mean(|f| f.emitted),
            absorbed: mean(|f| f.absorbed),
            absorbed_by_surfaces: mean(|f| f.absorbed_by_surfaces),
            escaped: mean(|f| f.escaped),
            residual: mean(|f| f.emitted - f.absorbed - f.absorbed_by_surfaces - f.escaped),
        })
    }

    /// True if emission is absorption and escape within so many standard errors.
    pub fn is_closed(&self, errors: f64) -> bool {
        let rounding = 1e-10 * self.emitted.mean.abs();
        self.residual.mean.abs() <= errors * self.residual.standard_error + rounding
    }
}
