//! What the kernels look things up in: made at prepare, kept while the scene does not change.

use std::sync::Arc;

use vr_core::transfer::BakedTransfer;
use vr_core::{Real, Scene, UniformVolume};

use crate::caster::{Classification, Leaping, Precision, RayCaster, Step};
use crate::classify::Classifier;
use crate::leap::EmptySpace;
use crate::operator::Brightest;
use crate::pace::PaceMap;
use crate::shade::Shader;
use crate::table_range::{resolves, single_precision_resolves, table_range};

/// The instruments, in the precision that the scene needs.
pub(crate) enum Kernel {
    F32(Instruments<f32>),
    F64(Instruments<f64>),
}

/// Table, shading, and what is known of the steps to take.
pub(crate) struct Instruments<R> {
    pub(crate) classifier: Classifier<R>,
    pub(crate) shader: Option<Shader<R>>,
    /// How long steps are, where they follow the data.
    pub(crate) pace: Option<Arc<PaceMap>>,
    /// Where nothing is visible; `None`: everything is sampled.
    pub(crate) empty_space: Option<EmptySpace>,
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

impl<R: Real> Instruments<R> {
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
        let same_field = |old: &Scene| old.volume.same(&scene.volume) && old.filter == scene.filter;
        let of_field = last.filter(|(old, _)| same_field(old)).and_then(|(_, i)| i.empty_space.as_ref());
        let of_scene = last.filter(|(old, _)| same(old) && old.compositing == scene.compositing);
        let last = last.filter(|(old, _)| same(old)).map(|(_, instruments)| instruments);
        let kept = last.and_then(|i| i.classifier.table.clone());
        // Steps of many lengths have no table.
        let wanted = caster.classification == Classification::Table
            && scene.compositing.integrates_light()
            && !matches!(caster.step, Step::Local { .. });
        let leaping = caster.leaping != Leaping::None;
        let pace = |error: f64| {
            last.and_then(|i| i.pace.clone()).unwrap_or_else(|| {
                let (levels, voxel) = (volume.level_ranges(field), volume.placement().spacing().min_element());
                let map =
                    PaceMap::new(volume.dims(), &levels, &scene.transfer, volume.calibration(), voxel, error, leaping);
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
            Step::Uniform(_) | Step::Vicinity { .. } => None,
        };
        let empty_space = match of_scene {
            Some((_, last)) => last.empty_space.clone(),
            None => EmptySpace::new(caster, scene, volume, &classifier, of_field),
        };
        Self { classifier, shader, pace, empty_space }
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
