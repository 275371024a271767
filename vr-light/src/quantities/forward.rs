//! Packets of light, followed from where they are emitted.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::{Control, ParameterError, Ray, RenderError};

use super::fluence::{cosine_direction, uniform_direction};
use crate::boundary::{Environment, LightSource, SurfacePlace};
use crate::light_scene::LightScene;
use crate::medium::Coefficients;
use crate::random::RandomStream;
use crate::spectrum::BandGroup;
use crate::tracking::Flight;

/// Power of one packet by its fate.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fate {
    pub emitted: f64,
    pub absorbed: f64,
    pub absorbed_by_surfaces: f64,
    pub escaped: f64,
}

/// Source of packets.
enum Source {
    Medium,
    Surface(usize),
    Point(usize),
    /// Uniform light through the sphere around everything.
    Environment {
        centre: DVec3,
        radius: f64,
    },
}

/// A packet on its way.
struct Packet {
    ray: Ray,
    from: Option<SurfacePlace>,
    band: usize,
    power: f64,
}

/// Packets of the light that a scene emits.
pub(super) struct ForwardSampler<'a> {
    scene: &'a LightScene,
    sources: Vec<Source>,
}

/// Power, as a share of that emitted, below which a packet may end by chance, and the chance of those.
const SMALL: f64 = 1e-2;
/// Scatterings and reflections between two looks at the cancel flag.
const CHECK_EVERY: u32 = 4096;

impl<'a> ForwardSampler<'a> {
    /// The sources of a scene.
    pub fn new(scene: &'a LightScene) -> Result<Self, ParameterError> {
        let endless =
            |field: &str| Err(ParameterError::new(field, "a source without end", "must have a power that is finite"));
        let mut sources = Vec::new();
        if let Some(tracked) = scene.medium().filter(|tracked| tracked.medium().has_emission()) {
            let (low, high) = tracked.medium().bounds();
            if !(high - low).is_finite() {
                return endless("medium");
            }
            sources.push(Source::Medium);
        }
        for (i, surface) in scene.surfaces().iter().enumerate().filter(|(_, s)| !s.emission.is_black()) {
            if !surface.shape.area().is_finite() {
                return endless("surfaces");
            }
            sources.push(Source::Surface(i));
        }
        for (i, light) in scene.lights().iter().enumerate() {
            match light {
                LightSource::Point { .. } => sources.push(Source::Point(i)),
                LightSource::Directional { .. } | LightSource::Headlight { .. } => return endless("lights"),
            }
        }
        match scene.environment() {
            Environment::Uniform(radiance) if radiance.is_black() => {}
            Environment::Uniform(_) => match scene.medium().map(|tracked| tracked.medium().bounds()) {
                Some((low, high)) if (high - low).is_finite() => {
                    let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
                    sources.push(Source::Environment { centre, radius });
                }
                _ => return endless("environment"),
            },
            Environment::Map(_) => return endless("environment"),
        }
        Ok(Self { scene, sources })
    }

    /// Fate of a random packet, whose expectation is that of all light: one source, one band.
    pub fn sample(&self, random: &mut RandomStream, control: &Control) -> Result<Fate, RenderError> {
        let mut fate = Fate::default();
        let bands = self.scene.bands();
        if self.sources.is_empty() {
            return Ok(fate);
        }
        let pick =
            |count: usize, random: &mut RandomStream| ((random.uniform() * count as f64) as usize).min(count - 1);
        let source = &self.sources[pick(self.sources.len(), random)];
        let band = pick(bands, random);
        let mut packet = self.emit(source, band, random);
        packet.power *= (self.sources.len() * bands) as f64;
        fate.emitted = packet.power;
        let mut events = 0u32;
        while packet.power > 0.0 {
            self.follow(&mut packet, &mut fate, random);
            // Roulette: power that is small is dropped, or raised by as much as it is likely to be.
            if packet.power < SMALL * fate.emitted {
                packet.power = if random.uniform() < SMALL { packet.power / SMALL } else { 0.0 };
            }
            events = events.wrapping_add(1);
            if events.is_multiple_of(CHECK_EVERY) {
                control.check()?;
            }
        }
        Ok(fate)
    }

    /// A packet of one band of a source, with all of its power.
    fn emit(&self, source: &Source, band: usize, random: &mut RandomStream) -> Packet {
        let packet = |origin, direction, from, power| Packet { ray: Ray { origin, direction }, from, band, power };
        match *source {
            Source::Medium => {
                let (low, high) = self.scene.medium().map_or((DVec3::ZERO, DVec3::ZERO), |t| t.medium().bounds());
                let share = DVec3::new(random.uniform(), random.uniform(), random.uniform());
                let (at, direction) = (low + share * (high - low), uniform_direction(random));
                let emission = self.coefficients(at, direction, band).emission;
                packet(at, direction, None, 4.0 * PI * emission * (high - low).element_product())
            }
            Source::Surface(index) => {
                let surface = &self.scene.surfaces()[index];
                let at = surface.shape.sample(random.pair());
                // Both sides emit.
                let side = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
                let direction = cosine_direction(side * surface.shape.normal(at), random);
                packet(
                    at,
                    direction,
                    Some(SurfacePlace::Simple(index)),
                    2.0 * PI * surface.emission.at(band) * surface.shape.area(),
                )
            }
            Source::Point(index) => {
                let light = &self.scene.lights()[index];
                let LightSource::Point { at, color } = light else { unreachable!("sources name point lights") };
                // π L in each unit of solid angle.
                packet(*at, uniform_direction(random), None, 4.0 * PI * PI * color.at(band))
            }
            Source::Environment { centre, radius } => {
                let outward = uniform_direction(random);
                let direction = cosine_direction(-outward, random);
                let group = BandGroup { first: band, count: 1 };
                let radiance = self.scene.environment().lanes(-direction, group)[0];
                packet(centre + radius * outward, direction, None, 4.0 * PI * PI * radius * radius * radiance)
            }
        }
    }

    fn coefficients(&self, at: DVec3, direction: DVec3, band: usize) -> Coefficients {
        let mut one = [Coefficients::default()];
        if let Some(tracked) = self.scene.medium() {
            tracked.medium().coefficients(at, direction, band, &mut one);
        }
        one[0]
    }

    /// Follows a packet to its next collision, reflection or escape.
    fn follow(&self, packet: &mut Packet, fate: &mut Fate, random: &mut RandomStream) {
        let hit = self.scene.nearest(&packet.ray, packet.from);
        if self.collide(packet, hit.map_or(f64::INFINITY, |hit| hit.distance), fate, random) {
            return;
        }
        let Some(hit) = hit else {
            fate.escaped += std::mem::take(&mut packet.power);
            return;
        };
        let group = BandGroup { first: packet.band, count: 1 };
        let reflection = self.scene.reflection(&hit);
        // Kernels are reciprocal: light may be followed either way.
        let reflected = reflection.sample(hit.normal, -packet.ray.direction, group, random.pair());
        let reflected = reflected.filter(|r| hit.facet_normal.dot(r.direction) > 0.0);
        let before = packet.power;
        packet.power *= reflected.map_or(0.0, |r| r.weight[0]);
        fate.absorbed_by_surfaces += before - packet.power;
        packet.from = Some(hit.place);
        packet.ray = Ray { origin: hit.at, direction: reflected.map_or(hit.normal, |r| r.direction) };
    }

    /// Flies to a collision before the distance `far`, if there is one: a part is absorbed, the rest scattered.
    fn collide(&self, packet: &mut Packet, far: f64, fate: &mut Fate, random: &mut RandomStream) -> bool {
        let Some(tracked) = self.scene.medium() else { return false };
        let travel = packet.ray.direction;
        let mut flight = Flight::new(tracked, &packet.ray, far, random);
        while let Some((distance, _)) = flight.tentative(random) {
            let at = flight.place(distance);
            let here = self.coefficients(at, travel, packet.band);
            if !flight.collides(here.extinction(), random) {
                continue;
            }
            let before = packet.power;
            packet.power *= here.albedo();
            fate.absorbed += before - packet.power;
            if let Some(matrix) = tracked.medium().band_matrix() {
                packet.band = matrix.sample_target(packet.band, random.uniform());
            }
            packet.from = None;
            packet.ray = Ray { origin: at, direction: tracked.medium().phase().sample(travel, random.pair()) };
            return true;
        }
        false
    }
}
