//! Pictures by random paths.

use std::sync::Mutex;
use std::time::Duration;

use vr_core::clock::Instant;
use vr_core::parallel::{locked, try_each};
use vr_core::{Control, ParameterError, Rays, RenderError, View};

use super::film::add_sample;
use super::{Film, PathSampler};
use crate::light_scene::LightScene;
use crate::random::RandomStream;

/// End of a run: the first of these that is reached. Without any, a run ends when it is cancelled.
///
/// # Examples
/// ```
/// use vr_light::Until;
///
/// let until = Until { error: Some(0.01), ..Until::samples(4096) };
/// assert_eq!((until.samples, until.time), (Some(4096), None));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Until {
    /// Samples of each pixel, those of earlier runs included.
    pub samples: Option<u64>,
    /// Root mean square of the standard errors of all pixels and bands. It is looked at after each pass, of all pixels alike: a pixel that ended on
    /// its own at a lucky moment would be darker than it should be.
    pub error: Option<f64>,
    /// Time of this run.
    pub time: Option<Duration>,
}

impl Until {
    /// A number of samples of each pixel.
    pub fn samples(samples: u64) -> Self {
        Self { samples: Some(samples), ..Self::default() }
    }
}

/// Path tracer: the mean over random paths for each pixel.
///
/// The samples of a pixel are a function of the scene, the view, the seed and their numbers, and are added in the order of these: a film is the same bits
/// on any number of threads, in one run or in several.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use vr_core::scattering::PhaseFunction;
/// use vr_core::{Camera, Control, View};
/// use vr_light::{Coefficients, Environment, Film, Homogeneous, LightScene, PathTracer, Until};
///
/// // A conservative medium in uniform light is invisible.
/// let cloud = Coefficients { scattering: 5.0, ..Coefficients::default() };
/// let cube = Homogeneous::new((DVec3::NEG_ONE, DVec3::ONE), vec![cloud], PhaseFunction::Isotropic)?;
/// let scene = LightScene::new(Some(Arc::new(cube)), 1)?.with_environment(Environment::from([0.5]))?;
/// let view = View::new(Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 30.0, 20.0, None), [4, 4]);
/// let mut film = Film::new(view.size, 1)?;
/// PathTracer::new(&scene, 7).run(&view, &mut film, &Until::samples(8), &Control::default(), &mut |_| {})?;
/// assert!((film.mean(5, 0) - 0.5).abs() < 1e-12);
/// # Ok::<(), vr_core::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PathTracer<'a> {
    paths: PathSampler<'a>,
    seed: u64,
}

/// Largest number of samples of each pixel in one pass.
const MAX_PASS: u64 = 64;
/// Pixels that a thread takes at once.
const PART: usize = 64;

/// True if a sample of this number is one of the opacity, too: that costs as much as a third of a path, and has a fraction of its noise. The first two
/// are, so that an error can be told.
fn has_opacity(number: u64) -> bool {
    number < 2 || number.is_multiple_of(4)
}

impl<'a> PathTracer<'a> {
    /// A tracer of a scene with a seed of its random numbers.
    pub fn new(scene: &'a LightScene, seed: u64) -> Self {
        Self { paths: PathSampler::new(scene), seed }
    }

    /// A tracer of paths with at most so many scatterings and reflections; light that has more is lost.
    #[must_use]
    pub fn with_max_scatterings(self, max: Option<u32>) -> Self {
        Self { paths: self.paths.with_max_scatterings(max), ..self }
    }

    /// Adds samples to the film of a view until the end of the run, and hands it out after each pass: the picture so far. Passes grow, from 1 sample
    /// of each pixel to 64.
    ///
    /// # Errors
    /// A view that is out of range, a film of another size or other bands, [`RenderError::Cancelled`]: the film then has the samples made so far, by which
    /// the run can be resumed.
    pub fn run(
        &self,
        view: &View,
        film: &mut Film,
        until: &Until,
        control: &Control,
        progress: &mut dyn FnMut(&Film),
    ) -> Result<(), RenderError> {
        if film.size() != view.size || film.bands() != self.paths.scene().bands() {
            let found = (film.size(), film.bands());
            return Err(ParameterError::new(
                "film",
                found,
                "must have the size of the view and the bands of the scene",
            )
            .into());
        }
        let width = view.size[0] as usize;
        self.run_at(view, &|pixel| [pixel % width, pixel / width], film, until, control, progress)
    }

    /// Returns samples of some pixels of a view, (x, y), as the row of a film: the same ones as in a film of the whole view.
    ///
    /// # Errors
    /// A view that is out of range, pixels that it does not have, none, or [`RenderError::Cancelled`].
    pub fn trace_pixels(
        &self,
        view: &View,
        pixels: &[[u32; 2]],
        samples: u64,
        control: &Control,
    ) -> Result<Film, RenderError> {
        if let Some(pixel) = pixels.iter().find(|pixel| pixel[0] >= view.size[0] || pixel[1] >= view.size[1]) {
            return Err(ParameterError::new("pixels", pixel, "must lie within the view").into());
        }
        let count = u32::try_from(pixels.len());
        let count = count.map_err(|_| ParameterError::new("pixels", pixels.len(), "must be fewer than 2^32"))?;
        let mut film = Film::new([count, 1], self.paths.scene().bands())?;
        let place = |pixel: usize| pixels[pixel].map(|x| x as usize);
        self.run_at(view, &place, &mut film, &Until::samples(samples), control, &mut |_| {})?;
        Ok(film)
    }

    /// Adds samples to a film, whose pixels lie at these places of the view, until the end of the run.
    fn run_at(
        &self,
        view: &View,
        place: &(dyn Fn(usize) -> [usize; 2] + Sync),
        film: &mut Film,
        until: &Until,
        control: &Control,
        progress: &mut dyn FnMut(&Film),
    ) -> Result<(), RenderError> {
        let rays = Rays::new(view)?;
        let (started, first) = (Instant::now(), film.count(0));
        loop {
            let made = (0..film.size()[0] as usize * film.size()[1] as usize).map(|p| film.count(p)).min().unwrap_or(0);
            if until.samples.is_some_and(|samples| made >= samples)
                || until.time.is_some_and(|time| started.elapsed() >= time)
                || until.error.is_some_and(|error| film.rms_error() <= error)
            {
                return Ok(());
            }
            let pass = (made - first.min(made)).clamp(1, MAX_PASS);
            let target = made + until.samples.map_or(pass, |samples| pass.min(samples - made));
            self.pass((&rays, view), place, film, target, control)?;
            progress(film);
            if let Some(samples) = until.samples {
                control.report(target as f64 / samples as f64);
            }
        }
    }

    /// Adds samples to each pixel until it has `target` of them.
    fn pass(
        &self,
        (rays, view): (&Rays, &View),
        place: &(dyn Fn(usize) -> [usize; 2] + Sync),
        film: &mut Film,
        target: u64,
        control: &Control,
    ) -> Result<(), RenderError> {
        let (width, channels) = (view.size[0] as usize, film.channels());
        let parts: Vec<_> = film.parts(PART).map(Mutex::new).collect();
        let work = |part: usize| {
            let mut pixels = locked(&parts[part]);
            let (counts, sums) = &mut *pixels;
            let mut sample = vec![0.0; channels];
            for (i, (count, sums)) in counts.iter_mut().zip(sums.chunks_mut(channels)).enumerate() {
                let [x, y] = place(part * PART + i);
                while count[0] < target {
                    control.check()?;
                    let number = count[0];
                    let ray = subpixel_ray(rays, [x, y], number, view.supersampling);
                    let mut random = RandomStream::new(self.seed, (y * width + x) as u32, number);
                    let bands = channels - 1;
                    self.paths.sample_radiance(&ray, &mut random, control, &mut sample[..bands])?;
                    let sampled = if has_opacity(number) {
                        sample[bands] = self.paths.sample_opacity(&ray, &mut random);
                        channels
                    } else {
                        bands
                    };
                    add_sample(count, sums, &sample[..sampled]);
                }
            }
            Ok(())
        };
        control.run(|| try_each(parts.len(), &work))
    }
}

/// Ray of a sample: through the centre of the pixel, or through those of its subpixels in turns.
fn subpixel_ray(rays: &Rays, [x, y]: [usize; 2], number: u64, supersampling: u32) -> vr_core::Ray {
    let edge = u64::from(supersampling);
    let subpixel = number % (edge * edge);
    let at = |pixel: usize, index: u64| pixel as f64 + (index as f64 + 0.5) / edge as f64;
    rays.at(at(x, subpixel % edge), at(y, subpixel / edge))
}
