//! Integrals of radiance over directions.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::parallel::try_collect;
use vr_core::{Control, ParameterError, Ray, RenderError};

use super::Estimate;
use crate::boundary::Shape;
use crate::light_scene::LightScene;
use crate::paths::PathSampler;
use crate::random::RandomStream;

/// Fluence rate at a point, ∫ I dω over all directions, in each band: 4π times the mean radiance. Divided by the speed of light it is the density of
/// radiant energy. The light of headlights is left out, for there is no eye; so is that of other lights without size in mirrors, which no path finds.
///
/// # Errors
/// [`RenderError::Cancelled`].
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Control;
/// use vr_light::quantities::fluence;
/// use vr_light::{Environment, LightScene};
///
/// let empty = LightScene::new(None, 1)?.with_environment(Environment::from([0.5]))?;
/// let found = fluence(&empty, DVec3::ZERO, 16, 1, &Control::default())?;
/// assert!(found[0].is_within(2.0 * std::f64::consts::PI, 3.0));
/// # Ok::<(), vr_core::RenderError>(())
/// ```
pub fn fluence(
    scene: &LightScene,
    at: DVec3,
    samples: u64,
    seed: u64,
    control: &Control,
) -> Result<Vec<Estimate>, RenderError> {
    let ray = |random: &mut RandomStream| (Ray { origin: at, direction: uniform_direction(random) }, None);
    mean_radiance(scene, samples, seed, control, 4.0 * PI, ray)
}

/// Flux through a face in each band: ∫∫ I cos θ dω dA of the light that goes through it to the side of its normal, `against` it if that is asked.
/// Net flux is the difference of both. Lights without size count as for [`fluence`].
///
/// # Errors
/// A shape without area or without end; [`RenderError::Cancelled`].
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Control;
/// use vr_light::quantities::flux;
/// use vr_light::{Environment, LightScene, Shape};
///
/// let empty = LightScene::new(None, 1)?.with_environment(Environment::from([0.5]))?;
/// let face = Shape::Parallelogram { corner: DVec3::ZERO, edges: [2.0 * DVec3::X, DVec3::Y] };
/// let found = flux(&empty, &face, false, 16, 1, &Control::default())?;
/// assert!(found[0].is_within(std::f64::consts::PI, 3.0), "π·I·A");
/// # Ok::<(), vr_core::RenderError>(())
/// ```
pub fn flux(
    scene: &LightScene,
    face: &Shape,
    against: bool,
    samples: u64,
    seed: u64,
    control: &Control,
) -> Result<Vec<Estimate>, RenderError> {
    face.validate("face")?;
    let area = face.area();
    if !area.is_finite() {
        return Err(ParameterError::new("face", face, "must have an end").into());
    }
    let ray = |random: &mut RandomStream| {
        let origin = face.sample(random.pair());
        let normal = face.normal(origin) * if against { -1.0 } else { 1.0 };
        // Light that goes along the normal comes from behind.
        (Ray { origin, direction: cosine_direction(-normal, random) }, Some(-normal))
    };
    mean_radiance(scene, samples, seed, control, PI * area, ray)
}

/// Mean radiance over random rays, times a factor, in each band, and the light of lights without size. Rays come with the normal of the face that they
/// were chosen for by the cosine, or none of rays from all sides.
fn mean_radiance(
    scene: &LightScene,
    samples: u64,
    seed: u64,
    control: &Control,
    factor: f64,
    ray: impl Fn(&mut RandomStream) -> (Ray, Option<DVec3>) + Sync,
) -> Result<Vec<Estimate>, RenderError> {
    let (paths, bands) = (PathSampler::new(scene), scene.bands());
    let one = |number: usize| {
        control.check()?;
        let mut random = RandomStream::new(seed, 0, number as u64);
        let mut sample = vec![0.0; bands];
        let (ray, normal) = ray(&mut random);
        paths.sample_radiance(&ray, &mut random, control, &mut sample)?;
        // The factor is the integral of the weight over directions (and the face): 4π, or π for each unit of area.
        let (facing, whole): (&dyn Fn(DVec3) -> f64, f64) = match normal {
            Some(normal) => (&move |towards| normal.dot(towards), PI),
            None => (&|_| 1.0, 4.0 * PI),
        };
        for (band, sample) in sample.iter_mut().enumerate() {
            *sample += paths.unscattered_light(ray.origin, band, facing, &mut random) / whole;
        }
        Ok::<_, RenderError>(sample)
    };
    let all = control.run(|| try_collect(samples as usize, one))?;
    Ok((0..bands).map(|band| all.iter().map(|sample| sample[band]).collect::<Estimate>().scaled(factor)).collect())
}

/// A direction, uniform over the sphere.
pub(super) fn uniform_direction(random: &mut RandomStream) -> DVec3 {
    Shape::Sphere { centre: DVec3::ZERO, radius: 1.0 }.sample(random.pair()).normalize()
}

/// A direction on the side of a unit normal, with the density cos θ / π.
pub(super) fn cosine_direction(normal: DVec3, random: &mut RandomStream) -> DVec3 {
    // A point of the unit sphere about the tip of the normal.
    (normal + uniform_direction(random)).try_normalize().unwrap_or(normal)
}
