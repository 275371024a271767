//! What the kernels look things up in: made at prepare, kept while the scene does not change.

use std::sync::Arc;

use vr_core::transfer::BakedTransfer;
use vr_core::{Real, Scene, UniformVolume};

use crate::caster::{Classification, Precision, RayCaster, Step};
use crate::classify::Classifier;
use crate::leap::Visibility;
use crate::operator::Brightest;
use crate::pace::PaceMap;
use crate::screen::Sight;
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
    /// How long steps are, where they follow the data.
    pub(crate) pace: Option<Arc<PaceMap>>,
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
        let Classifier { transfer, calibration, table } = &self.classifier;
        let visibility = Visibility::of_light(transfer, *calibration, table.as_ref().map(|(table, _)| table));
        Arc::new(move |low, high| visibility.is_visible(low, high))
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
        let last = last.filter(|(old, _)| same(old)).map(|(_, instruments)| instruments);
        let kept = last.and_then(|i| i.classifier.table.clone());
        // Steps of many lengths have no table.
        let wanted = caster.classification == Classification::Table
            && scene.compositing.integrates_light()
            && matches!(caster.step, Step::Uniform(_));
        let pace = |error: f64| {
            last.and_then(|i| i.pace.clone()).unwrap_or_else(|| {
                let (levels, voxel) = (volume.level_ranges(field), volume.placement().spacing().min_element());
                let map =
                    PaceMap::new(volume.dims(), &levels, &scene.transfer, volume.calibration(), voxel, error, true);
                Arc::new(map)
            })
        };
        let classifier = Classifier {
            transfer: Arc::clone(&scene.transfer),
            calibration: volume.calibration(),
            table: if wanted { kept.or_else(bake) } else { None },
        };
        let shader = scene
            .shading
            .as_ref()
            .map(|shading| Shader::new(Arc::clone(shading), volume.placement(), volume.calibration().slope));
        let pace = match caster.step {
            Step::Local { error } => Some(pace(error)),
            Step::Uniform(_) => None,
        };
        Self { classifier, shader, pace }
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
