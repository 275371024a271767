//! A plain marcher in f64 that can be told to make one of the classic mistakes: a check that passes it sees nothing.

use std::sync::atomic::{AtomicU32, Ordering};

use vr_core::filter::Reconstruction;
use vr_core::optics::{opacity_of_depth, source_weight};
use vr_core::transfer::Optical;
use vr_core::{
    Compositing, Configurable, Control, ConvergenceClaim, ConvergenceOrders, DeclaredOption, Documented, Feature,
    Frame, IndexRay, Model, NumberRange, OptionTable, Prepared, Rays, RenderError, RenderStats, Rendered, Renderer,
    Sampler, SamplerVisitor, Scene, TransferFunction, Unsupported, View, Voxel,
};

/// The classic mistakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// None: a right renderer.
    None,
    /// Cell-centred, though the voxels are at lattice points.
    HalfVoxelShift,
    /// α of the unit distance, whatever the step.
    NoOpacityCorrection,
    /// The last, shorter step is left out.
    DroppedLastStep,
    /// The sample at the front of each step: a rule of order 1.
    LeftSample,
    /// Missing voxels count as 0.
    MissingIsZero,
    /// A number where there is none.
    Nan,
    /// Steps of a fixed world length.
    WorldStep,
    /// x and y are mixed up.
    SwappedSpacing,
    /// Colours are clamped to 1.
    ClampedLight,
    /// Every frame is a little brighter than the last.
    Memory,
    /// The picture depends on the threads that draw it.
    CountsThreads,
    /// It panics.
    Panic,
    /// It says that it cannot draw the scene, whatever the scene is.
    RefusesEverything,
    /// Voxels are classified before they are interpolated.
    PreClassification,
    /// Rays go through the corners of pixels.
    PixelCorners,
    /// A table of optics is interpolated across the jumps of the transfer function: the shorter the steps, the more of them land
    /// between two entries, where there is neither the one side's colour nor the other's.
    BleedingJumps,
    /// Values are carried in half the digits of f32, whatever the transfer function tells apart.
    NarrowValues,
    /// The second frame and all later ones come without the depth that the first has.
    LosesDepth,
    /// An update leaves the old transfer function.
    StaleTransfer,
    /// An update leaves the old volume.
    StaleVolume,
    /// An update leaves the old filter.
    StaleFilter,
    /// An update is not asked whether it can be drawn.
    StaleSupport,
}

/// Marches along every ray, for over, without shading.
#[derive(Clone)]
pub struct Marcher {
    /// The fault.
    pub fault: Fault,
    /// Step, as a fraction of the smallest spacing.
    pub step: f64,
}

impl Marcher {
    /// Makes a marcher with a fault and steps of ⅛ of a voxel.
    pub fn new(fault: Fault) -> Self {
        Self { fault, step: 0.125 }
    }
}

impl Default for Marcher {
    fn default() -> Self {
        Self::new(Fault::None)
    }
}

impl Configurable for Marcher {
    fn options() -> OptionTable<Self> {
        let range = NumberRange::above(0.0).up_to(16.0);
        let help = "step as a fraction of the smallest spacing";
        let step = DeclaredOption::number("step", help, range, |m: &Self| m.step, |m, x| m.step = x);
        OptionTable::new("marcher", [step])
    }
}

impl Documented for Marcher {
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        let orders = ConvergenceOrders { smooth: 2.0, jumps: 1.0, grid: 2.0, pixels: 2.0 };
        vec![ConvergenceClaim::new("midpoint", self, "step", 3e-7, orders)]
    }
}

fn unsupported(feature: Feature) -> RenderError {
    Unsupported { renderer: "marcher", feature, what: feature.to_string() }.into()
}

impl Renderer for Marcher {
    fn name(&self) -> &'static str {
        "marcher"
    }

    fn supports(&self, scene: &Scene, _: Option<&View>) -> Result<(), RenderError> {
        if self.fault == Fault::RefusesEverything {
            return Err(unsupported(Feature::VolumeKind));
        }
        supports(scene)
    }

    fn prepare(&self, scene: &Scene, _: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        self.supports(scene, None)?;
        assert!(self.fault != Fault::Panic, "a bug");
        Ok(Box::new(Marching { marcher: self.clone(), scene: scene.clone(), frames: AtomicU32::new(0) }))
    }
}

fn supports(scene: &Scene) -> Result<(), RenderError> {
    match (scene.compositing, &scene.shading, &scene.surfaces) {
        (Compositing::Over, None, None) => Ok(()),
        (Compositing::Over, None, Some(_)) => Err(unsupported(Feature::Surfaces)),
        (Compositing::Over, Some(_), _) => Err(unsupported(Feature::Shading)),
        _ => Err(unsupported(Feature::Compositing)),
    }
}

struct Marching {
    marcher: Marcher,
    scene: Scene,
    frames: AtomicU32,
}

impl Prepared for Marching {
    fn update(&mut self, scene: &Scene, _: &Control) -> Result<(), RenderError> {
        let (old, fault) = (self.scene.clone(), self.marcher.fault);
        if fault != Fault::StaleSupport {
            supports(scene)?;
        }
        self.scene = scene.clone();
        match fault {
            Fault::StaleTransfer => self.scene.transfer = old.transfer,
            Fault::StaleVolume => self.scene.volume = old.volume,
            Fault::StaleFilter => {
                let stale = old.volume.filter().unwrap_or_default();
                self.scene.volume = self.scene.volume.with_filter(stale);
            }
            _ => (),
        }
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let rays = Rays::new(view)?;
        let volume = self.scene.volume.grid().expect("a uniform grid");
        let threads = control.run(rayon::current_num_threads);
        let frame_number = self.frames.fetch_add(1, Ordering::Relaxed);
        let [w, h] = view.size;
        let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(view.supersampling);
        let pixels = (0..w * h).map(|i| {
            let mut mean = [0.0; 4];
            for k in 0..view.supersampling * view.supersampling {
                let corner =
                    if self.marcher.fault == Fault::PixelCorners { 0.5 / f64::from(view.supersampling) } else { 0.0 };
                let at = |pixel: u32, k: u32| f64::from(pixel) + centre(k) - corner;
                let (x, y) = (at(i % w, k % view.supersampling), at(i / w, k / view.supersampling));
                let along = IndexRay::new(&rays.at(x, y), volume.placement(), volume.dims(), &view.clip, f64::INFINITY);
                let March { rgba, .. } = volume.with_sampler(March { marching: self, along, rgba: [0.0; 4] });
                (0..4).for_each(|c| mean[c] += rgba[c] / f64::from(view.supersampling * view.supersampling));
            }
            match self.marcher.fault {
                Fault::Memory => mean[0] += f64::from(frame_number) * 1e-6,
                Fault::CountsThreads => mean[1] += threads as f64 * 1e-6,
                Fault::Nan if mean[3] > 0.5 => mean[2] = f64::NAN,
                Fault::ClampedLight => mean = mean.map(|x| x.min(1.0)),
                _ => (),
            }
            mean.map(|x| x as f32)
        });
        let with_depth = self.marcher.fault == Fault::LosesDepth && frame_number == 0;
        let depth = with_depth.then(|| vec![f32::INFINITY; (w * h) as usize]);
        let frame = Frame::new(view.size, pixels.collect(), depth);
        Ok(Rendered { frame, stats: RenderStats::default() })
    }

    fn model(&self, _: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}

struct March<'a> {
    marching: &'a Marching,
    along: Option<IndexRay>,
    rgba: [f64; 4],
}

impl SamplerVisitor for March<'_> {
    type Output = Self;

    fn visit<T: Voxel, F: Reconstruction>(mut self, sampler: Sampler<'_, T, F>) -> Self {
        let Some(ray) = self.along else { return self };
        let Marching { marcher, scene, .. } = self.marching;
        let volume = scene.volume.grid().expect("a uniform grid");
        let fault = marcher.fault;
        let spacing = volume.placement().spacing();
        let step = marcher.step
            * match fault {
                // With an end to it in a huge world.
                Fault::WorldStep => (1e-2 * ray.length()).max(1.0),
                Fault::SwappedSpacing => spacing.x,
                _ => spacing.min_element(),
            };
        let mut transmittance = 1.0;
        let mut start = ray.start;
        while start < ray.end {
            let end = (start + step).min(ray.end);
            let length = end - start;
            if fault == Fault::DroppedLastStep && length < step * (1.0 - 1e-9) {
                break;
            }
            let at = if fault == Fault::LeftSample { start } else { 0.5 * (start + end) };
            let mut p = ray.at(at).to_array();
            if fault == Fault::HalfVoxelShift {
                p = std::array::from_fn(|a| (p[a] - 0.5).max(0.0));
            }
            start = end;
            let value = sampler.value(p);
            let value = if fault == Fault::MissingIsZero && f64::is_nan(value) { 0.0 } else { value };
            if f64::is_nan(value) {
                continue;
            }
            let value = volume.calibration().value(value);
            let optical = match fault {
                Fault::PreClassification => {
                    classified_before(&sampler, p, |stored| scene.transfer.at(volume.calibration().value(stored)))
                }
                Fault::BleedingJumps => bled(&scene.transfer, value),
                Fault::NarrowValues => scene.transfer.at(narrow(value)),
                _ => scene.transfer.at(value),
            };
            let length = if fault == Fault::NoOpacityCorrection { scene.transfer.unit_distance() } else { length };
            let tau = scene.transfer.extinction(optical.opacity) * length;
            let alpha = opacity_of_depth(tau);
            for c in 0..3 {
                let light = if scene.transfer.has_emission() {
                    optical.emission[c] * length * source_weight(tau)
                } else {
                    optical.color[c] * alpha
                };
                self.rgba[c] += transmittance * light;
            }
            transmittance *= 1.0 - alpha;
        }
        self.rgba[3] = 1.0 - transmittance;
        self
    }
}

/// A number of 12 binary digits.
fn narrow(value: f64) -> f64 {
    let scale = libm::exp2(libm::floor(libm::log2(value.abs().max(f64::MIN_POSITIVE))) - 11.0);
    (value / scale).round() * scale
}

/// Linear between the entries of a table of 64, whatever lies between them.
fn bled(transfer: &TransferFunction, value: f64) -> Optical {
    const ENTRIES: f64 = 64.0;
    let points = transfer.points();
    let (low, high) = (points[0].value, points[points.len() - 1].value);
    let width = 1.2 * (high - low).max(1e-3 * low.abs()).max(f64::MIN_POSITIVE) / ENTRIES;
    let place = (value - low) / width;
    let below = place.floor();
    let (a, b) = (transfer.at(low + below * width), transfer.at(low + (below + 1.0) * width));
    let t = place - below;
    let mix = |a: f64, b: f64| a + t * (b - a);
    // Opacity as an extinction of 1 is: any share of an opaque entry is opaque, in whatever colour.
    let opacity = if a.opacity == 1.0 || b.opacity == 1.0 { 1.0 } else { mix(a.opacity, b.opacity) };
    Optical {
        opacity,
        color: std::array::from_fn(|c| mix(a.color[c], b.color[c])),
        emission: std::array::from_fn(|c| mix(a.emission[c], b.emission[c])),
    }
}

/// The mean of what the corners of a cell are classified as, each weighted as trilinear interpolation weights its value.
fn classified_before<T: Voxel, F: Reconstruction>(
    sampler: &Sampler<'_, T, F>,
    p: [f64; 3],
    classify: impl Fn(f64) -> Optical,
) -> Optical {
    let dims = sampler.lattice().dims;
    let mut mean = Optical::default();
    for corner in 0..8 {
        let (mut at, mut weight) = ([0.0; 3], 1.0);
        for axis in 0..3 {
            let low = p[axis].floor().clamp(0.0, (dims[axis] - 2) as f64);
            let t = p[axis] - low;
            (at[axis], weight) =
                if corner >> axis & 1 == 1 { (low + 1.0, weight * t) } else { (low, weight * (1.0 - t)) };
        }
        let optical = classify(sampler.value(at));
        mean.opacity += weight * optical.opacity;
        for c in 0..3 {
            mean.color[c] += weight * optical.color[c];
            mean.emission[c] += weight * optical.emission[c];
        }
    }
    mean
}
