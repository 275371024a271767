//! Light in a slab.

/// Depths and directions at which light is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Probes {
    /// Optical depths below the top, 0 to the slab's thickness.
    pub depths: Vec<f64>,
    /// Cosines of directions to the normal, 10⁻⁶ to 1, for which radiance up and down is told.
    pub cosines: Vec<f64>,
}

/// A number and an estimate of its error: by how much it changed when the number of directions was doubled for the last time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimated {
    /// The number.
    pub value: f64,
    /// Estimate of its error.
    pub error: f64,
}

/// Light at one depth, from outside and from the slab's own sources together.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Optical depth below the top.
    pub depth: f64,
    /// Flux down of light that was not scattered on its way from outside.
    pub direct: Estimated,
    /// All other flux down.
    pub down: Estimated,
    /// Flux up.
    pub up: Estimated,
    /// Radiance integrated over all directions, with the direct light.
    pub fluence: Estimated,
    /// Radiance down at each cosine asked for, averaged over azimuth; without the beam, with what is left of diffuse illumination.
    pub radiance_down: Vec<Estimated>,
    /// Radiance up at each cosine asked for, averaged over azimuth.
    pub radiance_up: Vec<Estimated>,
}

/// Light in a slab. Fluxes are in the units of the illumination's and the sources' radiance times steradian.
#[derive(Clone, Debug, PartialEq)]
pub struct SlabSolution {
    /// Flux that comes in from above.
    pub incident: f64,
    /// Light at the top: what leaves the slab goes up here.
    pub top: Level,
    /// Light at the bottom, above the ground.
    pub bottom: Level,
    /// Light at the depths asked for.
    pub levels: Vec<Level>,
    /// Flux from outside that the medium absorbs. It is solved on its own, from what the medium would emit, not as the rest of the balance.
    pub absorbed: Estimated,
    /// Flux of the slab's and the ground's own light that leaves at the top.
    pub emitted_up: Estimated,
    /// Flux of the slab's own light, and of the ground's that the slab sends back, that reaches the ground.
    pub emitted_down: Estimated,
    /// Number of directions in each hemisphere.
    pub points: usize,
}

impl SlabSolution {
    /// Flux of light from outside that leaves at the top: of an incident flux of 1, the plane albedo (beam) or the spherical albedo (diffuse).
    pub fn reflected(&self) -> Estimated {
        let (up, own) = (self.top.up, self.emitted_up);
        Estimated { value: up.value - own.value, error: up.error + own.error }
    }

    /// Flux of light from outside that reaches the ground, unscattered and scattered together.
    pub fn transmitted(&self) -> Estimated {
        let (direct, diffuse, own) = (self.bottom.direct, self.bottom.down, self.emitted_down);
        Estimated { value: direct.value + diffuse.value - own.value, error: direct.error + diffuse.error + own.error }
    }
}
