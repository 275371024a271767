//! One random path.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::{Control, Ray, RenderError};

use super::direct_light::{Scatterer, competing_weight};
use crate::boundary::{SurfaceHit, SurfacePlace};
use crate::light_scene::LightScene;
use crate::medium::{Coefficients, Medium};
use crate::random::RandomStream;
use crate::spectrum::{BandGroup, LANES, Lanes};
use crate::tracking::{Flight, TransmittanceEstimator};

/// Random paths through a scene: each gives an estimate of the radiance that comes along a ray, whose expectation is the solution of the equation of
/// transfer.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Control, Ray};
/// use vr_light::{Environment, LightScene, PathSampler, RandomStream};
///
/// let empty = LightScene::new(None, 3)?.with_environment(Environment::from([0.2, 0.3, 0.5]))?;
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
/// let mut sample = [0.0; 4];
/// PathSampler::new(&empty).sample(&ray, &mut RandomStream::new(0, 0, 0), &Control::default(), &mut sample)?;
/// assert_eq!(sample, [0.2, 0.3, 0.5, 0.0]);
/// # Ok::<(), vr_core::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PathSampler<'a> {
    pub(super) scene: &'a LightScene,
    max_scatterings: Option<u32>,
}

/// Scatterings and reflections after which a path of little weight may end by chance.
const ROULETTE_FROM: u32 = 3;
/// Weight below which such a path may end. Measured on fog of albedos from 0.3 to 0.99: error · √time is at most 1 % above that of a roulette by the weight
/// itself (1 in place of 0.5), and 11 % below it at an albedo of 0.9.
const SMALL_WEIGHT: f64 = 0.5;
/// Smallest chance of a path to go on.
const MIN_SURVIVAL: f64 = 0.05;
/// Scatterings and reflections after which a path ends in any case: in a sealed white box it would never get out. What is lost by it is less than the
/// noise of so many paths.
const MAX_SCATTERINGS: u32 = 1 << 22;
/// Scatterings and reflections between two looks at the cancel flag.
const CHECK_EVERY: u32 = 4096;

/// State of a path.
pub(super) struct Path {
    pub ray: Ray,
    /// Surface that the ray starts on.
    pub from: Option<SurfacePlace>,
    pub group: BandGroup,
    /// Light that arrives here counts with this weight.
    pub weight: Lanes,
    pub radiance: Lanes,
    /// Scatterings and reflections so far.
    pub scatterings: u32,
    /// Largest weight of a band after the first scattering in the medium.
    pub first_weight: f64,
    /// Density per solid angle by which the ray was chosen, where light of its direction was also aimed at; `None` where it was not.
    pub density: Option<f64>,
    /// Direction of the primary ray.
    pub primary: DVec3,
}

impl Path {
    /// Largest weight of a band.
    fn largest_weight(&self) -> f64 {
        self.weight.iter().copied().fold(0.0, f64::max)
    }
}

/// Collision of a path with the medium.
struct Collision {
    at: DVec3,
    /// Share of the light that is scattered, by band.
    albedo: Lanes,
}

/// Reason for which a path goes on or ends.
enum Step {
    Scattered,
    Ended,
}

impl<'a> PathSampler<'a> {
    /// Paths with as many scatterings as light has.
    pub fn new(scene: &'a LightScene) -> Self {
        Self { scene, max_scatterings: None }
    }

    /// Paths with at most so many scatterings and reflections; light that has more is lost.
    #[must_use]
    pub fn with_max_scatterings(self, max: Option<u32>) -> Self {
        Self { max_scatterings: max, ..self }
    }

    /// The scene.
    pub fn scene(&self) -> &'a LightScene {
        self.scene
    }

    /// Bands of the path that begins with the band `first`.
    fn group(&self, first: usize) -> BandGroup {
        let elastic = |medium: &dyn Medium| medium.is_grey() && medium.band_matrix().is_none();
        let together = self.scene.medium().is_none_or(|tracked| elastic(tracked.medium()));
        BandGroup { first, count: if together { LANES.min(self.scene.bands() - first) } else { 1 } }
    }

    /// Fills an estimate of the radiance of each band that comes along a ray, and behind them one of the opacity, 1 − the mean transmittance of the
    /// bands. Bands of one extinction share a path; others have one each.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    ///
    /// # Panics
    /// If `out` does not have one place more than there are bands.
    pub fn sample(
        &self,
        ray: &Ray,
        random: &mut RandomStream,
        control: &Control,
        out: &mut [f64],
    ) -> Result<(), RenderError> {
        let bands = self.scene.bands();
        assert_eq!(out.len(), bands + 1, "one place for each band, and one for the opacity");
        self.sample_radiance(ray, random, control, &mut out[..bands])?;
        out[bands] = self.sample_opacity(ray, random);
        Ok(())
    }

    /// Fills an estimate of the radiance of each band that comes along a ray.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    ///
    /// # Panics
    /// If `out` does not have one place for each band.
    pub fn sample_radiance(
        &self,
        ray: &Ray,
        random: &mut RandomStream,
        control: &Control,
        out: &mut [f64],
    ) -> Result<(), RenderError> {
        assert_eq!(out.len(), self.scene.bands(), "one place for each band");
        let mut first = 0;
        while first < out.len() {
            let group = self.group(first);
            let radiance = self.radiance(ray, group, random, control)?;
            out[first..first + group.count].copy_from_slice(&radiance[..group.count]);
            first += group.count;
        }
        Ok(())
    }

    /// An estimate of the opacity along a ray: 1 − the mean transmittance of the bands.
    pub fn sample_opacity(&self, ray: &Ray, random: &mut RandomStream) -> f64 {
        let bands = self.scene.bands();
        let (mut first, mut sum) = (0, 0.0);
        while first < bands {
            let group = self.group(first);
            sum += self.opacity(ray, first, random) * group.count as f64;
            first += group.count;
        }
        sum / bands as f64
    }

    /// Opacity of a band along the primary ray: 1 if it ends on a surface.
    fn opacity(&self, ray: &Ray, band: usize, random: &mut RandomStream) -> f64 {
        if self.scene.nearest(ray, None).is_some() {
            return 1.0;
        }
        let estimator = TransmittanceEstimator::default();
        let through = |medium: &crate::TrackedMedium| medium.transmittance(ray, f64::INFINITY, band, estimator, random);
        1.0 - self.scene.medium().map_or(1.0, through)
    }

    /// Radiance of a group of bands along one path.
    fn radiance(
        &self,
        ray: &Ray,
        group: BandGroup,
        random: &mut RandomStream,
        control: &Control,
    ) -> Result<Lanes, RenderError> {
        let weight = std::array::from_fn(|i| if i < group.count { 1.0 } else { 0.0 });
        let mut path = Path {
            ray: *ray,
            from: None,
            group,
            weight,
            radiance: [0.0; LANES],
            scatterings: 0,
            first_weight: 1.0,
            density: None,
            primary: ray.direction,
        };
        loop {
            let hit = self.scene.nearest(&path.ray, path.from);
            let step = match self.collide(&mut path, hit.map_or(f64::INFINITY, |hit| hit.distance), random) {
                Some(collision) => self.scatter(&mut path, collision, random),
                None => match hit {
                    Some(hit) => self.reflect(&mut path, &hit, random),
                    None => {
                        self.escape(&mut path);
                        Step::Ended
                    }
                },
            };
            if matches!(step, Step::Ended) || !survives(&mut path, random) {
                return Ok(path.radiance);
            }
            if path.scatterings.is_multiple_of(CHECK_EVERY) {
                control.check()?;
            }
        }
    }

    /// Flies to the next collision before the distance `far`, and adds the light that the medium emits on the way.
    fn collide(&self, path: &mut Path, far: f64, random: &mut RandomStream) -> Option<Collision> {
        let tracked = self.scene.medium()?;
        let (medium, group) = (tracked.medium(), path.group);
        // Light travels against the ray.
        let travel = -path.ray.direction;
        let emits = tracked.emits();
        let mut bands = [Coefficients::default(); LANES];
        let mut flight = Flight::new(tracked, &path.ray, far, random);
        while let Some((distance, rate)) = flight.tentative(random) {
            let at = flight.place(distance);
            if emits {
                medium.coefficients(at, travel, group.first, &mut bands[..group.count]);
                // Each tentative collision stands for a length 1/μ.
                (0..group.count).for_each(|i| path.radiance[i] += path.weight[i] * bands[i].emission / rate);
                if flight.collides(bands[0].extinction(), random) {
                    return Some(Collision { at, albedo: bands.map(|band| band.albedo()) });
                }
            } else if flight.is_certain() || flight.collides(medium.extinction(at, travel, group.first), random) {
                return Some(Collision { at, albedo: albedo(medium, at, travel, group) });
            }
        }
        None
    }

    /// Scatters a path in the medium: absorption lowers its weight.
    fn scatter(&self, path: &mut Path, Collision { at, albedo }: Collision, random: &mut RandomStream) -> Step {
        let Some(tracked) = self.scene.medium() else { return Step::Ended };
        let medium = tracked.medium();
        if !self.may_scatter(path) {
            return Step::Ended;
        }
        match medium.band_matrix() {
            None => (0..path.group.count).for_each(|i| path.weight[i] *= albedo[i]),
            // Light of this band came from another: of those, one is followed.
            Some(matrix) => {
                let to = path.group.first;
                let Some((from, share)) = matrix.sample_source(to, random.uniform()) else { return Step::Ended };
                let mut both = [Coefficients::default(); 2];
                for (found, band) in both.iter_mut().zip([from, to]) {
                    medium.coefficients(at, -path.ray.direction, band, std::slice::from_mut(found));
                }
                path.weight[0] *= share * both[0].scattering / both[1].extinction();
                path.group.first = from;
            }
        }
        let largest = path.largest_weight();
        if largest == 0.0 {
            return Step::Ended;
        }
        if path.scatterings == 1 {
            path.first_weight = largest;
        }
        path.from = None;
        let phase = medium.phase();
        self.add_direct_light(path, at, &Scatterer::Phase(phase), random);
        let before = path.ray.direction;
        let direction = phase.sample(before, random.pair());
        path.density = Some(phase.value(before.dot(direction)) / (4.0 * PI));
        path.ray = Ray { origin: at, direction };
        Step::Scattered
    }

    /// Adds the emission of a surface, and reflects a path.
    fn reflect(&self, path: &mut Path, hit: &SurfaceHit, random: &mut RandomStream) -> Step {
        if let Some(surface) = self.scene.simple_surface(hit).filter(|surface| !surface.emission.is_black()) {
            let share = match path.density {
                Some(density) => competing_weight(density, self.emitter_density(hit, path.ray.direction)),
                None => 1.0,
            };
            let emission = surface.emission.lanes(path.group);
            (0..path.group.count).for_each(|i| path.radiance[i] += path.weight[i] * share * emission[i]);
        }
        if !self.may_scatter(path) {
            return Step::Ended;
        }
        let to = -path.ray.direction;
        path.from = Some(hit.place);
        let reflection = self.scene.reflection(hit);
        if reflection.is_smooth() {
            let scatterer = Scatterer::Surface { reflection: &reflection, hit, to };
            self.add_direct_light(path, hit.at, &scatterer, random);
        }
        let reflected = reflection.sample(hit.normal, to, path.group, random.pair());
        // Light below the facet, by its interpolated normal, is lost.
        let Some(reflected) = reflected.filter(|r| hit.facet_normal.dot(r.direction) > 0.0) else {
            return Step::Ended;
        };
        (0..path.group.count).for_each(|i| path.weight[i] *= reflected.weight[i]);
        path.density = reflected.density;
        path.ray = Ray { origin: hit.at, direction: reflected.direction };
        Step::Scattered
    }

    /// Adds the environment that a path escapes to.
    fn escape(&self, path: &mut Path) {
        if path.scatterings == 0 && self.scene.hides_environment() {
            return;
        }
        let environment = self.scene.environment();
        let share = match (path.density, environment.map()) {
            (Some(density), Some(map)) => competing_weight(density, map.density(path.ray.direction)),
            _ => 1.0,
        };
        let light = environment.lanes(path.ray.direction, path.group);
        (0..path.group.count).for_each(|i| path.radiance[i] += path.weight[i] * share * light[i]);
    }

    /// Counts a scattering or reflection; false if it is one too many.
    fn may_scatter(&self, path: &mut Path) -> bool {
        path.scatterings = path.scatterings.saturating_add(1);
        path.scatterings <= self.max_scatterings.unwrap_or(MAX_SCATTERINGS)
    }
}

/// Albedo of a group of bands at a place.
fn albedo(medium: &dyn Medium, at: DVec3, direction: DVec3, group: BandGroup) -> Lanes {
    let mut known = [0.0; LANES];
    for (i, known) in known[..group.count].iter_mut().enumerate() {
        let Some(albedo) = medium.albedo(group.first + i) else {
            let mut bands = [Coefficients::default(); LANES];
            medium.coefficients(at, direction, group.first, &mut bands[..group.count]);
            return bands.map(|band| band.albedo());
        };
        *known = albedo;
    }
    known
}

/// Ends long paths of little weight by chance, and makes up for it in those that go on (Russian roulette).
fn survives(path: &mut Path, random: &mut RandomStream) -> bool {
    let largest = path.largest_weight();
    if path.scatterings < ROULETTE_FROM || largest >= SMALL_WEIGHT {
        return largest > 0.0;
    }
    let chance = (largest / SMALL_WEIGHT).max(MIN_SURVIVAL);
    if random.uniform() >= chance {
        return false;
    }
    path.weight = path.weight.map(|w| w / chance);
    largest > 0.0
}
