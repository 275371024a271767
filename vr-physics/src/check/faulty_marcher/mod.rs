//! A plain marcher in f64 that can be told to make one of the classic mistakes: a check that passes it sees nothing.

mod classify;
mod fault;
mod march;
mod mistaken;

use std::sync::atomic::{AtomicU32, Ordering};

use vr_core::{
    Compositing, Configurable, Control, ConvergenceClaim, ConvergenceOrders, DeclaredOption, Documented, Feature,
    Frame, Model, NumberRange, OptionTable, Prepared, Rays, RenderError, RenderStats, Rendered, Renderer, Scene,
    Unsupported, View, Volume,
};

pub use fault::Fault;
use march::light;
use mistaken::mistaken;

/// Marches along every ray, for over, without shading: through uniform grids, and through any other field by its values at places.
#[derive(Clone)]
pub struct Marcher {
    /// The fault.
    pub fault: Fault,
    /// Step, as a fraction of the smallest spacing of a grid, or of the spacing that any other field tells.
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
        let scene = mistaken(self.fault, scene);
        Ok(Box::new(Marching { marcher: self.clone(), scene, frames: AtomicU32::new(0) }))
    }
}

fn supports(scene: &Scene) -> Result<(), RenderError> {
    if matches!(scene.volume, Volume::Color(_)) {
        return Err(unsupported(Feature::VolumeKind));
    }
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
        self.scene = mistaken(fault, scene);
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
                let rgba = light(&self.marcher, &self.scene, &rays.at(x, y), &view.clip);
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
