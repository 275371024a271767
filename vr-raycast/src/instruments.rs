//! What the kernels look things up in: made at prepare, kept while the scene does not change.

use std::sync::Arc;

use vr_core::transfer::BakedTransfer;
use vr_core::{Real, Scene, UniformVolume};

use crate::caster::{Classification, Precision, RayCaster};
use crate::classify::Classifier;
use crate::operator::Brightest;
use crate::screen::{Sight, VisibleRanges};
use crate::shade::Shader;
use crate::table_range::{resolves, single_precision_resolves, table_range};

/// The instruments, in the precision that the scene needs.
pub(crate) enum Kernel {
    F32(Instruments<f32>),
    F64(Instruments<f64>),
}

/// Table and shading.
pub(crate) struct Instruments<R> {
    pub(crate) classifier: Classifier<R>,
    pub(crate) shader: Option<Shader<R>>,
}

impl Kernel {
    /// Makes what the scene needs, and takes over from `last` what has not changed since.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        volume: &UniformVolume,
        last: Option<(&Scene, &Self)>,
    ) -> Self {
        let double = caster.precision == Precision::F64 || !single_precision_resolves(volume, &scene.transfer);
        match (double, last) {
            (true, Some((scene_then, Self::F64(last)))) => {
                Self::F64(Instruments::new(caster, scene, volume, Some((scene_then, last))))
            }
            (false, Some((scene_then, Self::F32(last)))) => {
                Self::F32(Instruments::new(caster, scene, volume, Some((scene_then, last))))
            }
            (true, _) => Self::F64(Instruments::new(caster, scene, volume, None)),
            (false, _) => Self::F32(Instruments::new(caster, scene, volume, None)),
        }
    }
}

impl Kernel {
    /// What can be seen of a field.
    pub(crate) fn sight(&self) -> Sight {
        match self {
            Self::F32(instruments) => instruments.sight(),
            Self::F64(instruments) => instruments.sight(),
        }
    }
}

impl<R: Real> Instruments<R> {
    fn sight(&self) -> Sight {
        let classifier = &self.classifier;
        let slack = classifier.table.as_ref().map_or(0.0, |(table, _)| table.spacing());
        let ranges = VisibleRanges::new(&classifier.transfer, classifier.calibration, slack);
        Arc::new(move |low, high| ranges.meet(low, high))
    }

    /// Makes what the scene needs, and takes over from `last` what has not changed since.
    fn new(caster: &RayCaster, scene: &Scene, volume: &UniformVolume, last: Option<(&Scene, &Self)>) -> Self {
        let field = caster.filter_of(scene);
        let bake = || {
            let range = table_range(volume, field, &scene.transfer);
            let integer = volume.voxel_type().is_integer();
            let step = caster.world_step(volume);
            let table = BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, step);
            resolves(&table, volume, field, &scene.transfer).then(|| (Arc::new(table), step))
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
    pub(crate) fn brightest(&self) -> Brightest {
        let transfer = &self.classifier.transfer;
        let brightest = transfer.brightest();
        match &self.shader {
            _ if transfer.has_emission() => Brightest::Emission(brightest),
            Some(shader) => Brightest::Radiance(shader.brightest(brightest)),
            None => Brightest::Radiance(brightest),
        }
    }
}
