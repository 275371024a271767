//! Tables of the kernels: made at prepare, kept while the scene does not change.

use std::sync::Arc;

use vr_core::{Calibration, GridVolume, Placement, Real, Scene, Shading};
use vr_kernels::ranges::LevelRanges;
use vr_kernels::tables::{PreIntegrated, round_outward};

use crate::caster::{Precision, RayCaster, Rule, Step, TransferLookup, Traversal};
use crate::classify::Classifier;
use crate::leap::{Leaper, empty_space};
use crate::rule::{ExactIntegral, Profile, Shape};
use crate::shade::Shader;
use crate::step_map::{SharpValues, StepMap};
use crate::table_range::{baked, field_range, single_precision_resolves};

/// Tables in the precision that the scene needs.
pub(crate) enum TablesByPrecision {
    F32(RenderTables<f32>),
    F64(RenderTables<f64>),
}

/// Table and shading, and maps of the steps to take.
pub(crate) struct RenderTables<R> {
    pub(crate) classifier: Classifier<R>,
    pub(crate) shader: Option<Shader<R>>,
    /// Lengths of steps that follow the data.
    pub(crate) step_map: Option<Arc<StepMap>>,
    /// Regions where long steps will do.
    #[cfg(feature = "classics")]
    pub(crate) homogeneity: Option<Arc<crate::classics::Homogeneity>>,
    /// Regions where nothing is visible; `None` if everything is sampled. Found by [`TablesByPrecision::find_empty_space`].
    pub(crate) empty_space: Option<Arc<dyn Leaper>>,
}

impl TablesByPrecision {
    /// Makes the tables of a field that is no grid's: none, for everything is evaluated exactly at its place.
    pub(crate) fn of_field(scene: &Scene, placement: &Placement) -> Self {
        let shader = |shading: Arc<Shading>| Shader::new(shading, scene.lights.clone(), placement, 1.0);
        Self::F64(RenderTables {
            classifier: Classifier {
                transfer: Arc::clone(&scene.transfer),
                calibration: Calibration::default(),
                table: None,
                profile: None,
            },
            shader: scene.gradient_shading().map(shader),
            step_map: None,
            #[cfg(feature = "classics")]
            homogeneity: None,
            empty_space: None,
        })
    }

    /// Makes the tables of a scene, and takes over from `last` those that have not changed since.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, volume: &GridVolume, last: Option<(&Scene, &Self)>) -> Self {
        let single = single_precision_resolves(volume, &scene.transfer);
        let double = caster.precision == Precision::F64 || !single;
        match (double, last) {
            (true, Some((scene_then, Self::F64(last)))) => {
                Self::F64(RenderTables::new(caster, scene, volume, Some((scene_then, last))))
            }
            (false, Some((scene_then, Self::F32(last)))) => {
                Self::F32(RenderTables::new(caster, scene, volume, Some((scene_then, last))))
            }
            (true, _) => Self::F64(RenderTables::new(caster, scene, volume, None)),
            (false, _) => Self::F32(RenderTables::new(caster, scene, volume, None)),
        }
    }
}

impl TablesByPrecision {
    /// Finds the empty space, or takes it over from `last`: for the plain engine, once it is known to draw.
    pub(crate) fn find_empty_space(
        &mut self,
        caster: &RayCaster,
        scene: &Scene,
        volume: &GridVolume,
        last: Option<(&Scene, &Self)>,
    ) {
        match (self, last) {
            (Self::F32(new), Some((then, Self::F32(last)))) => {
                new.find_empty_space(caster, scene, volume, Some((then, last)));
            }
            (Self::F64(new), Some((then, Self::F64(last)))) => {
                new.find_empty_space(caster, scene, volume, Some((then, last)));
            }
            (Self::F32(new), _) => new.find_empty_space(caster, scene, volume, None),
            (Self::F64(new), _) => new.find_empty_space(caster, scene, volume, None),
        }
    }
}

/// Returns the course of the value along a step of a caster; `None` where one sample stands for steps of one length.
fn shape(caster: &RayCaster) -> Option<Shape> {
    match (caster.rule, caster.traversal) {
        (Rule::Auto | Rule::Midpoint | Rule::Left, Traversal::Samples)
            if caster.step.is_on_lattice() && !caster.ends_steps_at_faces() =>
        {
            None
        }
        (Rule::Auto | Rule::Midpoint | Rule::Left, _) => Some(Shape::Point),
        (Rule::Linear, _) => Some(Shape::Line),
        (Rule::Quadratic, _) => Some(Shape::Parabola),
        (Rule::Exact, _) => Some(Shape::Cubic),
    }
}

/// Returns a table for steps of all lengths, if one resolves the transfer function: a small one where the transfer function's
/// points fit into it, else a large one.
fn preintegrated<R: Real>(scene: &Scene, volume: &GridVolume) -> Option<Arc<PreIntegrated<R>>> {
    let range = round_outward(field_range(volume).unwrap_or((0.0, 0.0)));
    let table = |entries| PreIntegrated::new(&scene.transfer, volume.calibration(), range, entries);
    let small = table(PreIntegrated::<R>::ENTRIES);
    let table = if small.is_aligned() { small } else { table(4 * PreIntegrated::<R>::ENTRIES) };
    table.resolves().then(|| Arc::new(table))
}

/// Returns the sharp changes of a scene's transfer function among the values of a grid; `None` where it has no values.
pub(crate) fn sharp_values(scene: &Scene, volume: &GridVolume) -> Option<SharpValues> {
    Some(SharpValues::of(scene, volume.value_range()?, volume.placement().spacing().min_element()))
}

/// True if the same part of the field is visible in both scenes.
fn same_light(a: &Scene, b: &Scene) -> bool {
    a.volume.same(&b.volume) && a.transfer == b.transfer && a.shading.is_some() == b.shading.is_some()
}

impl<R: Real> RenderTables<R> {
    /// Makes the tables of a scene, and takes over from `last` those that have not changed since.
    fn new(caster: &RayCaster, scene: &Scene, volume: &GridVolume, last: Option<(&Scene, &Self)>) -> Self {
        #[cfg(feature = "classics")]
        let homogeneity = {
            let last_of_field = last.filter(|(old, _)| old.volume.same(&scene.volume));
            let same = |old: &Scene| {
                let looks = old.compositing == scene.compositing && old.lights == scene.lights;
                same_light(old, scene) && looks && old.shading == scene.shading
            };
            let then = last_of_field.and_then(|(old, i)| Some((i.homogeneity.as_ref()?, same(old))));
            crate::classics::homogeneity(caster, scene, volume, then)
        };
        let last = last.filter(|(old, _)| same_light(old, scene)).map(|(_, tables)| tables);
        let lights = scene.compositing.integrates_light();
        let wanted = caster.transfer_lookup != TransferLookup::Exact && lights;
        let profile = shape(caster).filter(|_| lights).map(|shape| {
            let kept = last.and_then(|i| i.classifier.profile.as_ref());
            let made = || preintegrated(scene, volume);
            Profile {
                shape,
                table: if wanted && shape != Shape::Cubic {
                    kept.and_then(|p| p.table.clone()).or_else(made)
                } else {
                    None
                },
                exact: ExactIntegral::new(Arc::clone(&scene.transfer)),
                calibration: volume.calibration(),
            }
        });
        // Made for the same steps.
        let step = caster.world_step(volume.placement());
        let bake = || Some((Arc::new(baked(scene, volume, step)?), step));
        let kept = last.and_then(|i| i.classifier.table.clone()).filter(|(_, length)| *length == step);
        // Local steps are of many lengths, none of which has a table.
        let follows = matches!(caster.step, Step::Local { .. }) && caster.traversal == Traversal::Samples;
        let step_map = |error: f64| {
            last.and_then(|i| i.step_map.clone()).unwrap_or_else(|| {
                let (levels, voxel) = (LevelRanges::of_volume(volume), volume.placement().spacing().min_element());
                // By parabolas alone: straight lines need the short steps in which a field is one.
                let integrated = (caster.rule == Rule::Quadratic).then(|| sharp_values(scene, volume)).flatten();
                let map = StepMap::new(&levels, (scene, integrated), volume.calibration(), voxel, error);
                Arc::new(map)
            })
        };
        let classifier = Classifier {
            transfer: Arc::clone(&scene.transfer),
            calibration: volume.calibration(),
            table: if wanted && profile.is_none() && !follows { kept.or_else(bake) } else { None },
            profile,
        };
        let shader = scene
            .gradient_shading()
            .map(|shading| Shader::new(shading, scene.lights.clone(), volume.placement(), volume.calibration().slope));
        let step_map = match caster.step {
            Step::Local { error } if follows => Some(step_map(error)),
            _ => None,
        };
        Self {
            classifier,
            shader,
            step_map,
            #[cfg(feature = "classics")]
            homogeneity,
            empty_space: None,
        }
    }

    /// Finds the empty space, which packets do not need, unless it is there.
    fn find_empty_space(
        &mut self,
        caster: &RayCaster,
        scene: &Scene,
        volume: &GridVolume,
        last: Option<(&Scene, &Self)>,
    ) {
        if self.empty_space.is_some() {
            return;
        }
        let kept = |same: &dyn Fn(&Scene) -> bool| {
            last.filter(|(old, _)| same(old)).and_then(|(_, tables)| tables.empty_space.as_ref())
        };
        let same = |old: &Scene| same_light(old, scene) && old.compositing == scene.compositing;
        self.empty_space = kept(&same).cloned().or_else(|| {
            let of_field = kept(&|old| old.volume.same(&scene.volume));
            empty_space(caster, scene, volume, &self.classifier, of_field)
        });
    }
}
