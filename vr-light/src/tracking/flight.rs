//! The free flight of light: delta tracking.

use glam::DVec3;
use vr_core::Ray;

use super::TrackedMedium;
use super::walk::{Stretch, Walk};
use crate::random::RandomStream;

/// End of a free flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlightEnd {
    /// A collision with the medium.
    Collision {
        /// World distance from the origin of the ray.
        distance: f64,
        /// World position.
        at: DVec3,
    },
    /// None: the ray gets to where it was to end.
    Passed,
}

/// A free flight along a ray, by tentative collisions at the rates of the cells.
///
/// Each tentative collision is handed out with its rate μ; the caller knows χ there, and says by [`Flight::collides`] whether it is one. In the share
/// that belongs to the least extinction of the cell it is one wherever it lies ([`Flight::is_certain`]; Kutz, Habel, Li & Novák, "Spectral and
/// decomposition tracking for rendering heterogeneous volumes", 2017). The light of what a medium emits is q/μ for each of them, those with
/// nothing among them: its expectation is ∫ T q ds.
#[derive(Debug)]
pub struct Flight<'a> {
    walk: Walk<'a>,
    stretch: Option<Stretch>,
    at: f64,
    ray: Ray,
    /// Optical depth of the majorants to the next tentative collision.
    depth: f64,
    /// Part of the rate that the last tentative collision fell into: one with the medium if its extinction is above.
    part: f64,
    is_certain: bool,
}

impl<'a> Flight<'a> {
    /// A flight along a ray up to the world distance `far`.
    pub fn new(medium: &'a TrackedMedium, ray: &Ray, far: f64, random: &mut RandomStream) -> Self {
        let mut walk = Walk::new(medium.grid(), ray, far);
        let stretch = walk.next();
        let at = stretch.map_or(0.0, |s| s.start);
        Self { walk, stretch, at, ray: *ray, depth: random.exponential(), part: 0.0, is_certain: false }
    }

    /// The next tentative collision: its world distance and the rate μ there; `None` where the ray ends before.
    #[inline]
    pub fn tentative(&mut self, random: &mut RandomStream) -> Option<(f64, f64)> {
        while let Some(stretch) = self.stretch {
            let rate = stretch.cell.rate;
            // 0·∞ of a vacuum without end is a depth of nothing.
            let depth = if rate == 0.0 { 0.0 } else { rate * (stretch.end - self.at) };
            if self.depth < depth {
                self.at += self.depth / rate;
                self.part = random.uniform() * rate;
                self.is_certain = self.part < stretch.cell.min;
                return Some((self.at, rate));
            }
            self.depth -= depth;
            self.at = stretch.end;
            self.stretch = self.walk.next();
        }
        None
    }

    /// True if the tentative collision is one with the medium, whatever its extinction is there.
    #[inline]
    pub fn is_certain(&self) -> bool {
        self.is_certain
    }

    /// True if the tentative collision is one with the medium, whose extinction there is given. Else the flight goes on.
    #[inline]
    pub fn collides(&mut self, extinction: f64, random: &mut RandomStream) -> bool {
        if self.part < extinction {
            return true;
        }
        self.depth = random.exponential();
        false
    }

    /// World position of a distance.
    #[inline]
    pub fn place(&self, distance: f64) -> DVec3 {
        self.ray.origin + self.ray.direction * distance
    }
}

impl TrackedMedium {
    /// A random free flight of light of one band along a ray, up to the world distance `far`. Light travels against the ray.
    pub fn fly(&self, ray: &Ray, far: f64, band: usize, random: &mut RandomStream) -> FlightEnd {
        let mut flight = Flight::new(self, ray, far, random);
        while let Some((distance, _)) = flight.tentative(random) {
            let at = flight.place(distance);
            if flight.is_certain() || flight.collides(self.medium().extinction(at, -ray.direction, band), random) {
                return FlightEnd::Collision { distance, at };
            }
        }
        FlightEnd::Passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Coefficients, FunctionMedium};
    use std::sync::Arc;
    use vr_core::scattering::PhaseFunction;

    /// A cube without end of constant extinction, under a bound of three times that.
    fn constant(extinction: f64) -> TrackedMedium {
        let bounds = (DVec3::NEG_INFINITY, DVec3::INFINITY);
        let all = Coefficients { absorption: 0.25 * extinction, scattering: 0.75 * extinction, emission: 0.0 };
        let range = [0.0, 3.0 * extinction];
        let medium = FunctionMedium::new(bounds, 1, PhaseFunction::Isotropic, range, move |_, _, _| all);
        TrackedMedium::new(Arc::new(medium.unwrap()))
    }

    #[test]
    fn mean_path_is_the_mean_free_path() {
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::new(0.6, 0.0, 0.8) };
        for (i, extinction) in [1e-12, 1e-3, 1.0, 7.0, 1e12].into_iter().enumerate() {
            let (medium, count) = (constant(extinction), 20_000);
            let mut sum = 0.0;
            for sample in 0..count {
                let mut random = RandomStream::new(11, i as u32, sample);
                let FlightEnd::Collision { distance, .. } = medium.fly(&ray, f64::INFINITY, 0, &mut random) else {
                    panic!("nothing gets through a medium without end")
                };
                sum += distance;
            }
            // Paths are distributed exponentially: their standard deviation is their mean.
            let (mean, error) = (sum / count as f64, 1.0 / (extinction * (count as f64).sqrt()));
            let z = (mean - 1.0 / extinction) / error;
            assert!(z.abs() < 4.0, "{extinction}: {z} standard errors");
        }
    }
}
