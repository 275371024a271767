//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::image_order::trace_view;
use vr_core::transfer::BakedTransfer;
use vr_core::{
    Compositing, Control, Filter, Frame, Model, Prepared, Real, RenderError, RenderStats, Rendered, Scene,
    UniformVolume, View,
};

use crate::caster::{Classification, Order, Precision, RayCaster, Rule};
use crate::classify::Classifier;
use crate::operator::{Accumulate, Average, Brightest, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::pipeline::{Pipeline, Scratch};
use crate::ray_value::RayValue;
use crate::shade::Shader;
use crate::table_range::{resolves, table_range};

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    caster: RayCaster,
    scene: Scene,
    kernel: Kernel,
}

/// What depends on the precision.
enum Kernel {
    F32(Instruments<f32>),
    F64(Instruments<f64>),
}

struct Instruments<R> {
    classifier: Classifier<R>,
    shader: Option<Shader<R>>,
}

impl PreparedCaster {
    pub(crate) fn new(caster: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(filter(&caster, scene)));
        let kernel = match caster.precision {
            Precision::F32 => Kernel::F32(Instruments::new(&caster, scene, volume, None)),
            Precision::F64 => Kernel::F64(Instruments::new(&caster, scene, volume, None)),
        };
        Ok(Self { caster, scene: scene.clone(), kernel })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(filter(&self.caster, scene)));
        match &mut self.kernel {
            Kernel::F32(i) => *i = Instruments::new(&self.caster, scene, volume, Some((&self.scene, i))),
            Kernel::F64(i) => *i = Instruments::new(&self.caster, scene, volume, Some((&self.scene, i))),
        }
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        match &self.kernel {
            Kernel::F32(instruments) => self.render_with(instruments, view, control),
            Kernel::F64(instruments) => self.render_with(instruments, view, control),
        }
    }

    fn model(&self, _: &View) -> Model {
        match self.caster.filter {
            Some(filter) if filter != self.scene.filter => Model::Filtered(filter),
            _ => Model::Canonical,
        }
    }
}

fn unsupported(feature: String) -> RenderError {
    RenderError::Unsupported { renderer: RayCaster::NAME, feature }
}

/// Whether this caster can draw this scene; its volume, if so.
fn check<'s>(caster: &RayCaster, scene: &'s Scene) -> Result<&'s UniformVolume, RenderError> {
    caster.validate()?;
    scene.validate()?;
    if caster.order == Order::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(format!("compositing '{}' back to front", scene.compositing.name())));
    }
    scene.volume.uniform().ok_or_else(|| unsupported(format!("volumes of the kind '{}'", scene.volume.kind())))
}

fn filter(caster: &RayCaster, scene: &Scene) -> Filter {
    caster.filter.unwrap_or(scene.filter)
}

/// World length of a step.
fn step(caster: &RayCaster, volume: &UniformVolume) -> f64 {
    caster.step * volume.placement().spacing().min_element()
}

impl<R: Real> Instruments<R> {
    /// Makes what the scene needs, and takes over from `last` what has not changed since.
    fn new(caster: &RayCaster, scene: &Scene, volume: &UniformVolume, last: Option<(&Scene, &Self)>) -> Self {
        let field = filter(caster, scene);
        let bake = || {
            let range = table_range(volume, field, &scene.transfer);
            let integer = volume.voxel_type().is_integer();
            let step = step(caster, volume);
            let table = BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, step);
            resolves(&table, volume, field, &scene.transfer).then(|| Arc::new(table))
        };
        let same = |old: &Scene| {
            old.volume.same(&scene.volume) && old.filter == scene.filter && old.transfer == scene.transfer
        };
        let kept = last.filter(|(old, _)| same(old)).and_then(|(_, i)| i.classifier.table.clone());
        let wanted = caster.classification == Classification::Table && scene.compositing.integrates_light();
        let classifier = Classifier {
            transfer: Arc::clone(&scene.transfer),
            calibration: volume.calibration(),
            table: if wanted { kept.or_else(bake) } else { None },
        };
        let shader = scene
            .shading
            .as_ref()
            .map(|shading| Shader::new(Arc::clone(shading), volume.placement(), volume.calibration().slope));
        Self { classifier, shader }
    }

    /// How bright the medium can be.
    fn brightest(&self) -> Brightest {
        let transfer = &self.classifier.transfer;
        let brightest = transfer.brightest();
        match &self.shader {
            _ if transfer.has_emission() => Brightest::Emission(brightest),
            Some(shader) => Brightest::Radiance(shader.brightest(brightest)),
            None => Brightest::Radiance(brightest),
        }
    }
}

impl PreparedCaster {
    /// Chooses the operator: once a frame.
    fn render_with<R: Real>(
        &self,
        instruments: &Instruments<R>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        let pipeline = Pipeline {
            volume,
            filter: filter(&self.caster, &self.scene),
            step: step(&self.caster, volume),
            offset: match self.caster.rule {
                Rule::Midpoint => 0.5,
                Rule::Left => 0.0,
            },
            classifier: &instruments.classifier,
            shader: instruments.shader.as_ref(),
            view,
        };
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = volume.calibration();
        match (self.scene.compositing, self.caster.order) {
            (Compositing::Over, Order::BackToFront) => frame(&pipeline, control, OverBackToFront::default),
            (Compositing::Over, Order::FrontToBack { termination }) => {
                frame(&pipeline, control, || OverFrontToBack::new(termination, instruments.brightest()))
            }
            (Compositing::Accumulate { level }, _) => frame(&pipeline, control, || Accumulate::new(level)),
            (Compositing::First { threshold }, _) => {
                frame(&pipeline, control, || First::new(transfer(), calibration, threshold))
            }
            (Compositing::Average, _) => frame(&pipeline, control, || Average::new(transfer(), calibration)),
            (Compositing::Maximum, _) => frame(&pipeline, control, || Extreme::new(transfer(), calibration, true)),
            (Compositing::Minimum, _) => frame(&pipeline, control, || Extreme::new(transfer(), calibration, false)),
        }
    }
}

/// Draws all pixels with one operator.
fn frame<R: Real, O: Operator<R>>(
    pipeline: &Pipeline<'_, R>,
    control: &Control,
    operator: impl Fn() -> O + Sync,
) -> Result<Rendered, RenderError> {
    let mut stats = RenderStats::default();
    let (pixels, counts) = stats.time("rays", || {
        trace_view(
            pipeline.view,
            control,
            || Scratch::new(operator()),
            |scratch, ray, spot, counts| pipeline.trace(scratch, ray, spot.pixel, counts),
        )
    })?;
    stats.counts = counts;
    let rgba = pixels.iter().map(|p: &RayValue| p.rgba.map(|x| x as f32)).collect();
    let depth = pixels.iter().map(|p| p.depth as f32).collect();
    Ok(Rendered { frame: Frame::new(pipeline.view.size, rgba, Some(depth)), stats })
}
