//! Random scenes by what is hard about them: small, so that thousands of them are drawn in a minute.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use vr_core::{
    Calibration, Compositing, Control, Filter, Layer, Light, Rays, RenderError, Shading, Surfaces, View, Volume,
    VoxelType,
};

use super::adaptive::adaptive_mesh;
use super::assembly::{Look, Picture, assemble};
use super::cameras::{Cuts, Viewpoint, cuts, far, generic, inside};
use super::grids::{self, Data};
use super::looks::{Lit, filter, lit, modulation, scheme};
use super::meshes::cell_mesh;
use super::rectilinear::rectilinear_grid;
use super::transfers::{self as transfers, Recipe, value_range};
use crate::check::{Effort, TestScene};

/// One thing that is hard about a scene; the rest of it is plain, so that the kind of a scene that fails says why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Nothing: continuous data, no jumps.
    Plain,
    /// Jumps of the transfer function, to 1, 0.999 or anything, with the same colour on both sides, black or another.
    Jumps,
    /// Triangles of the transfer function much narrower than what values do within a cell.
    Spikes,
    /// A ramp up to a plateau of opacity 1.
    Opaque,
    /// Voxels that are missing in blocks and spheres.
    Masks,
    /// Voxels that are missing here and there.
    Holes,
    /// Constant data, constant blocks in other data.
    Constants,
    /// A few numbers of parts, nearest or trilinear, jumps between them.
    Labels,
    /// The same with triangles of the transfer function whose tips, of opacity 1 or less, are at the numbers of the parts.
    Peaks,
    /// Calibrations of a negative slope.
    NegativeSlopes,
    /// Values around 10³ to 10⁷, in the calibration or in the voxels themselves.
    Offsets,
    /// Values near either end of what f32 holds.
    Extremes,
    /// Opacity that follows the gradient, with shading.
    GradientOpacity,
    /// Emission that is given on its own, with absorption and without; half of it beside gradient opacity or shading.
    Emission,
    /// Shading by lights of all colours.
    Lights,
    /// An opaque layer in the volume.
    Layers,
    /// The first point that reaches a value.
    First,
    /// The mean along a ray.
    Average,
    /// The largest or the smallest value.
    Extrema,
    /// Light up to a level of opacity.
    Accumulate,
    /// Every filter but the trilinear one.
    Filters,
    /// Cameras up to a million diagonals away.
    Far,
    /// Cameras in the volume.
    Inside,
    /// Everything above at once, with crops, planes and several rays a pixel.
    Mixed,
    /// Meshes of cells.
    Cells,
    /// Adaptive meshes.
    Adaptive,
    /// Rectilinear grids.
    Rectilinear,
}

impl Kind {
    /// Those of other volumes than uniform grids, which not every renderer draws.
    pub const OF_OTHER_VOLUMES: [Self; 3] = [Self::Cells, Self::Adaptive, Self::Rectilinear];

    /// All of uniform grids.
    pub const ALL: [Self; 24] = [
        Self::Plain,
        Self::Jumps,
        Self::Spikes,
        Self::Opaque,
        Self::Masks,
        Self::Holes,
        Self::Constants,
        Self::Labels,
        Self::Peaks,
        Self::NegativeSlopes,
        Self::Offsets,
        Self::Extremes,
        Self::GradientOpacity,
        Self::Emission,
        Self::Lights,
        Self::Layers,
        Self::First,
        Self::Average,
        Self::Extrema,
        Self::Accumulate,
        Self::Filters,
        Self::Far,
        Self::Inside,
        Self::Mixed,
    ];

    /// Its name, in kebab case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Jumps => "jumps",
            Self::Spikes => "spikes",
            Self::Opaque => "opaque",
            Self::Masks => "masks",
            Self::Holes => "holes",
            Self::Constants => "constants",
            Self::Labels => "labels",
            Self::Peaks => "peaks",
            Self::NegativeSlopes => "negative-slopes",
            Self::Offsets => "offsets",
            Self::Extremes => "extremes",
            Self::GradientOpacity => "gradient-opacity",
            Self::Emission => "emission",
            Self::Lights => "lights",
            Self::Layers => "layers",
            Self::First => "first",
            Self::Average => "average",
            Self::Extrema => "extrema",
            Self::Accumulate => "accumulate",
            Self::Filters => "filters",
            Self::Far => "far",
            Self::Inside => "inside",
            Self::Mixed => "mixed",
            Self::Cells => "cells",
            Self::Adaptive => "adaptive",
            Self::Rectilinear => "rectilinear",
        }
    }

    /// The kind of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().chain(Self::OF_OTHER_VOLUMES).find(|k| k.name() == name)
    }

    /// Random scenes of this kind.
    pub fn scenes(self) -> BoxedStrategy<TestScene> {
        let plain = Parts::plain();
        let over_jumps = || prop_oneof![1 => transfers::tame_recipe(), 1 => transfers::jumping_recipe()].boxed();
        let picks = |compositing: BoxedStrategy<Compositing>| Parts {
            recipe: over_jumps(),
            volume: volume(prop_oneof![2 => grids::varied(), 1 => grids::masked(), 1 => grids::flat()].boxed()),
            compositing,
            ..Parts::plain()
        };
        let of_volume = |volume| Parts { volume, recipe: over_jumps(), ..any_operator(Parts::plain()) };
        let parts = match self {
            Self::Plain => plain,
            Self::Jumps => Parts { recipe: transfers::jumping_recipe().boxed(), ..plain },
            Self::Spikes => Parts { recipe: transfers::spiked_recipe().boxed(), ..plain },
            Self::Opaque => Parts { recipe: transfers::opaque_recipe().boxed(), ..plain },
            Self::Masks => Parts { volume: float_volume(grids::masked().boxed()), recipe: over_jumps(), ..plain },
            Self::Holes => Parts { volume: float_volume(grids::with_holes().boxed()), recipe: over_jumps(), ..plain },
            Self::Constants => Parts { volume: volume(grids::flat().boxed()), recipe: over_jumps(), ..plain },
            Self::Labels => Parts {
                volume: volume(grids::labels().boxed()),
                recipe: transfers::label_recipe(usize::from(grids::LABELS)).boxed(),
                filter: label_filter(),
                ..plain
            },
            Self::Peaks => Parts {
                volume: volume(grids::labels().boxed()),
                recipe: transfers::peak_recipe(usize::from(grids::LABELS)).boxed(),
                filter: label_filter(),
                ..plain
            },
            Self::NegativeSlopes => Parts { volume: falling(), recipe: over_jumps(), ..any_operator(plain) },
            Self::Offsets => Parts { volume: offset(), recipe: over_jumps(), ..plain },
            Self::Extremes => Parts { volume: extreme(), recipe: over_jumps(), ..plain },
            Self::GradientOpacity => Parts {
                shading: shaded(prop_oneof![1 => Just(Vec::new()).boxed(), 4 => modulation().boxed()].boxed()),
                recipe: prop_oneof![3 => transfers::reflecting_recipe(), 1 => transfers::opaque_recipe()].boxed(),
                ..plain
            },
            Self::Emission => Parts {
                recipe: transfers::emitting_recipe().boxed(),
                shading: prop_oneof![1 => Just(None).boxed(), 1 => shaded(modulation().boxed())].boxed(),
                ..plain
            },
            Self::Lights => Parts {
                recipe: transfers::reflecting_recipe().boxed(),
                shading: shaded(Just(Vec::new()).boxed()),
                ..plain
            },
            Self::Layers => {
                Parts { layer: layer().prop_map(Some).boxed(), recipe: over_jumps(), ..any_operator(plain) }
            }
            Self::First => picks((0.05..0.95).prop_map(|threshold| Compositing::First { threshold }).boxed()),
            Self::Average => picks(Just(Compositing::Average).boxed()),
            Self::Extrema => picks(prop_oneof![Just(Compositing::Maximum), Just(Compositing::Minimum)].boxed()),
            Self::Accumulate => picks((0.05..=1.0).prop_map(|level| Compositing::Accumulate { level }).boxed()),
            Self::Filters => Parts {
                filter: prop::sample::select(Filter::ALL.to_vec()).boxed(),
                volume: volume(prop_oneof![2 => grids::varied(), 1 => grids::flat()].boxed()),
                recipe: over_jumps(),
                ..plain
            },
            Self::Far => Parts { viewpoint: far().boxed(), recipe: over_jumps(), ..plain },
            Self::Inside => Parts { viewpoint: inside().boxed(), recipe: over_jumps(), ..plain },
            Self::Mixed => Parts::mixed(),
            Self::Cells => of_volume(cell_mesh().prop_map(Volume::from).boxed()),
            Self::Adaptive => of_volume(adaptive_mesh().prop_map(Volume::from).boxed()),
            Self::Rectilinear => of_volume(rectilinear_grid().prop_map(Volume::from).boxed()),
        };
        parts.scenes()
    }

    /// The scene of this kind that a seed draws.
    pub fn draw(self, seed: u64) -> TestScene {
        let mut runner = Effort { seed, ..Effort::default() }.runner();
        self.scenes().new_tree(&mut runner).expect("no scene is rejected").current()
    }
}

/// Random scenes of any of these kinds, all alike often.
///
/// # Panics
/// Panics if the list is empty.
pub fn scene_of(kinds: &[Kind]) -> impl Strategy<Value = TestScene> + use<> {
    prop::sample::select(kinds.to_vec()).prop_flat_map(Kind::scenes)
}

/// Strategies for the parts of a scene.
struct Parts {
    volume: BoxedStrategy<Volume>,
    recipe: BoxedStrategy<Recipe>,
    viewpoint: BoxedStrategy<Viewpoint>,
    cuts: BoxedStrategy<Option<Cuts>>,
    filter: BoxedStrategy<Filter>,
    /// Magnitudes of the shading's gradients are fractions of the steepest.
    shading: BoxedStrategy<Option<Lit>>,
    /// The threshold of `first` is a fraction of the range of values.
    compositing: BoxedStrategy<Compositing>,
    layer: BoxedStrategy<Option<LayerPlane>>,
    supersampling: BoxedStrategy<u32>,
}

impl Parts {
    fn plain() -> Self {
        Self {
            volume: volume(grids::varied().boxed()),
            recipe: transfers::tame_recipe().boxed(),
            viewpoint: generic().boxed(),
            cuts: Just(None).boxed(),
            filter: Just(Filter::Trilinear).boxed(),
            shading: Just(None).boxed(),
            compositing: Just(Compositing::Over).boxed(),
            layer: Just(None).boxed(),
            supersampling: Just(1).boxed(),
        }
    }

    fn mixed() -> Self {
        let data = prop_oneof![
            3 => grids::varied().boxed(),
            1 => grids::flat().boxed(),
            1 => grids::masked().boxed(),
            1 => grids::with_holes().boxed(),
            1 => grids::labels().boxed(),
        ];
        let volumes = prop_oneof![4 => volume(data.boxed()), 1 => falling(), 1 => offset(), 1 => extreme()];
        let recipe = prop_oneof![
            2 => transfers::tame_recipe().boxed(),
            2 => transfers::jumping_recipe().boxed(),
            1 => transfers::spiked_recipe().boxed(),
            1 => transfers::opaque_recipe().boxed(),
            1 => transfers::emitting_recipe().boxed(),
            1 => transfers::label_recipe(usize::from(grids::LABELS)).boxed(),
        ];
        let modulations = prop_oneof![2 => Just(Vec::new()).boxed(), 1 => modulation().boxed()];
        Self {
            volume: volumes.boxed(),
            recipe: recipe.boxed(),
            viewpoint: prop_oneof![3 => generic().boxed(), 1 => far().boxed(), 1 => inside().boxed()].boxed(),
            cuts: proptest::option::weighted(0.3, cuts()).boxed(),
            // Mostly what every renderer draws, so that few refuse.
            filter: prop_oneof![3 => Just(Filter::Trilinear), 1 => filter()].boxed(),
            shading: prop_oneof![2 => Just(None).boxed(), 1 => shaded(modulations.boxed())].boxed(),
            compositing: scheme().boxed(),
            layer: proptest::option::weighted(0.2, layer()).boxed(),
            supersampling: prop_oneof![6 => Just(1u32), 1 => Just(2)].boxed(),
        }
    }

    fn scenes(self) -> BoxedStrategy<TestScene> {
        let look = (self.filter, self.shading, self.compositing, self.layer, self.supersampling);
        (self.volume, self.recipe, self.viewpoint, [4u32..=6, 4u32..=6], self.cuts, look)
            .prop_map(
                |(volume, recipe, viewpoint, size, cuts, (filter, shading, compositing, layer, supersampling))| {
                    let surfaces = layer.map(|plane| Arc::new(plane.of(&volume)) as Arc<dyn Surfaces>);
                    let (low, high) = value_range(&volume);
                    let steepest = (high - low) / volume.mean_spacing();
                    let shading = shading.map(|(shading, lights)| (with_slopes(shading, steepest), lights));
                    let look = Look { filter, ..Look::plain(compositing, shading) };
                    let picture = Picture { viewpoint, size, supersampling, cuts };
                    let mut test = assemble(volume, &recipe, &picture, look);
                    test.scene.surfaces = surfaces;
                    test
                },
            )
            .boxed()
    }
}

/// Returns the shading with magnitudes that are fractions of the steepest slope.
pub(super) fn with_slopes(mut shading: Shading, steepest: f64) -> Shading {
    // Slopes that cannot be told apart are none: constant data, or values next to nothing.
    if !(steepest > 1e-300 && steepest < 1e300) {
        shading.gradient_opacity.clear();
    }
    shading.gradient_opacity.iter_mut().for_each(|(magnitude, _)| *magnitude *= steepest);
    shading
}

fn label_filter() -> BoxedStrategy<Filter> {
    prop_oneof![1 => Just(Filter::Nearest), 1 => Just(Filter::Trilinear)].boxed()
}

fn any_operator(parts: Parts) -> Parts {
    Parts { compositing: scheme().boxed(), ..parts }
}

fn shaded(modulation: BoxedStrategy<Vec<(f64, f64)>>) -> BoxedStrategy<Option<Lit>> {
    (lit(), modulation)
        .prop_map(|((shading, lights), gradient_opacity)| Some((Shading { gradient_opacity, ..shading }, lights)))
        .boxed()
}

/// Some data in any voxel type; floats alone if the data have missing voxels, which integers cannot tell.
fn volume(data: BoxedStrategy<Data>) -> BoxedStrategy<Volume> {
    (grids::voxel_type(), data)
        .prop_flat_map(|(voxel, data)| {
            let voxel = if data.has_missing() { VoxelType::F32 } else { voxel };
            calibrated((0.0, 1.0), voxel, Just(data).boxed(), Just(Calibration::default()).boxed())
        })
        .boxed()
}

fn float_volume(data: BoxedStrategy<Data>) -> BoxedStrategy<Volume> {
    calibrated((0.0, 1.0), VoxelType::F32, data, Just(Calibration::default()).boxed())
}

fn calibrated(
    stored: (f64, f64),
    voxel: VoxelType,
    data: BoxedStrategy<Data>,
    calibration: BoxedStrategy<Calibration>,
) -> BoxedStrategy<Volume> {
    (grids::dims(2), data, grids::placement(grids::any_spacing()), calibration)
        .prop_map(move |(dims, data, placement, calibration)| {
            grids::build_in(stored, voxel, dims, &data, placement, calibration)
        })
        .boxed()
}

fn falling() -> BoxedStrategy<Volume> {
    let calibration = (prop_oneof![Just(-1.0), -1000.0..-0.001], -1000.0..1000.0)
        .prop_map(|(slope, intercept)| Calibration { slope, intercept });
    let data = prop_oneof![3 => grids::varied(), 1 => grids::masked()].boxed();
    (grids::voxel_type(), Just(data), Just(calibration.boxed()))
        .prop_flat_map(|(voxel, data, calibration)| {
            let data =
                data.prop_filter("a type that can miss samples", move |d| voxel == VoxelType::F32 || !d.has_missing());
            calibrated((0.0, 1.0), voxel, data.boxed(), calibration)
        })
        .boxed()
}

/// An offset of 10³ to 10⁷ under values that differ by 1 to 1000, given by the calibration or in the voxels.
fn offset() -> BoxedStrategy<Volume> {
    (3.0..=7.0, any::<bool>(), 0.0..3.0, any::<bool>())
        .prop_flat_map(|(decades, negative, extent, stored)| {
            let offset = libm::pow(10.0, decades) * if negative { -1.0 } else { 1.0 };
            let extent = libm::pow(10.0, extent);
            let (samples, calibration) = if stored {
                ((offset, offset + extent), Calibration::default())
            } else {
                ((0.0, 1.0), Calibration { slope: extent, intercept: offset })
            };
            calibrated(samples, VoxelType::F32, grids::varied().boxed(), Just(calibration).boxed())
        })
        .boxed()
}

fn extreme() -> BoxedStrategy<Volume> {
    let ends = prop_oneof![
        Just((0.0, 1e-40)),
        Just((-1e-40, 1e-42)),
        Just((0.0, 1e-37)),
        Just((0.0, 3e38)),
        Just((-3e38, 3e38)),
        Just((1e38, 3e38)),
        Just((-1e30, 1e36)),
    ];
    ends.prop_flat_map(|ends| {
        calibrated(ends, VoxelType::F32, grids::varied().boxed(), Just(Calibration::default()).boxed())
    })
    .boxed()
}

/// An opaque picture: a plane through the volume, seen in some pixels alone.
#[derive(Clone, Copy, Debug)]
struct LayerPlane {
    color: [f32; 3],
    /// Depth behind the middle of the volume, in diagonals; and its increase from one side of the picture to the other.
    behind: f64,
    tilt: f64,
    /// Number of pixels from one hole to the next.
    holes: usize,
}

fn layer() -> impl Strategy<Value = LayerPlane> {
    ([0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0], -0.4..0.4, -0.5..0.5, 2usize..8)
        .prop_map(|(color, behind, tilt, holes)| LayerPlane { color, behind, tilt, holes })
}

impl LayerPlane {
    fn of(self, volume: &Volume) -> Backdrop {
        Backdrop { plane: self, bounds: volume.bounds() }
    }
}

/// The picture in a volume's world.
#[derive(Clone, Copy, Debug)]
struct Backdrop {
    plane: LayerPlane,
    bounds: (DVec3, DVec3),
}

impl Surfaces for Backdrop {
    fn layer(&self, _: &[Light], view: &View, _: &Control) -> Result<Layer, RenderError> {
        let (Self { plane, bounds: (low, high) }, [width, height]) = (*self, view.size);
        let (middle, diagonal): (DVec3, f64) = (0.5 * (low + high), (high - low).length());
        let rays = Rays::new(view)?;
        let pixels = (0..width * height).map(|i| {
            let (x, y) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
            let ray = rays.at(x, y);
            let across = x / f64::from(width) - 0.5;
            let depth = (middle - ray.origin).dot(ray.direction) + (plane.behind + plane.tilt * across) * diagonal;
            let hole = (i as usize).is_multiple_of(plane.holes) || depth <= 0.0;
            (plane.color, if hole { f32::INFINITY } else { depth as f32 })
        });
        Ok(Layer { pixels: pixels.collect() })
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn;

    fn grid(t: &TestScene) -> &vr_core::GridVolume {
        t.scene.volume.grid().unwrap()
    }

    #[test]
    fn every_kind_is_valid_and_what_it_is_called() {
        for kind in Kind::ALL.into_iter().chain(Kind::OF_OTHER_VOLUMES) {
            assert_eq!(Kind::from_name(kind.name()), Some(kind));
            let scenes: Vec<TestScene> = (0..60).map(|seed| kind.draw(seed)).collect();
            for t in &scenes {
                t.scene.validate().unwrap();
                t.view.validate().unwrap();
                t.view.camera.frame().unwrap();
            }
            let share = |test: &dyn Fn(&TestScene) -> bool| scenes.iter().filter(|t| test(t)).count();
            let range = |t: &TestScene| t.scene.volume.value_range().unwrap_or((0.0, 0.0));
            let far = |t: &TestScene| {
                let (low, high) = t.scene.volume.bounds();
                (t.view.camera.eye - low).length() > 9.0 * (high - low).length()
            };
            let (found, min) = match kind {
                Kind::Plain => (share(&|t| !t.scene.transfer.has_jumps()), 60),
                Kind::Jumps => (share(&|t| t.scene.transfer.has_jumps()), 60),
                Kind::Spikes => (share(&|t| t.scene.transfer.points().len() >= 3), 60),
                Kind::Opaque => (share(&|t| t.scene.transfer.segments().iter().any(|s| s.is_opaque())), 60),
                Kind::Masks | Kind::Holes => (share(&|t| grid(t).vacuum_cells().is_some()), 40),
                Kind::Constants => (share(&|t| range(t).0 == range(t).1), 4),
                Kind::Labels => (share(&|t| t.scene.volume.filter() == Some(Filter::Nearest)), 20),
                Kind::Peaks => {
                    // At the smallest number of all, if not at others.
                    (
                        share(&|t| {
                            t.scene.transfer.segments().iter().any(|s| s.start.opacity == 1.0 && s.from == range(t).0)
                        }),
                        15,
                    )
                }
                Kind::NegativeSlopes => (share(&|t| grid(t).calibration().slope < 0.0), 60),
                Kind::Offsets => (share(&|t| range(t).0.abs() > 900.0), 60),
                Kind::Extremes => (share(&|t| range(t).1 < 1e-36 || range(t).1 > 1e30), 60),
                Kind::GradientOpacity => {
                    (share(&|t| t.scene.shading.as_ref().is_some_and(|s| !s.gradient_opacity.is_empty())), 40)
                }
                Kind::Emission => (share(&|t| t.scene.transfer.has_emission()), 60),
                Kind::Lights => (share(&|t| t.scene.shading.is_some()), 60),
                Kind::Layers => (share(&|t| t.scene.surfaces.is_some()), 60),
                Kind::First => (share(&|t| t.scene.compositing.name() == "first"), 60),
                Kind::Average => (share(&|t| t.scene.compositing == Compositing::Average), 60),
                Kind::Extrema => (share(&|t| t.scene.compositing == Compositing::Maximum), 20),
                Kind::Accumulate => (share(&|t| t.scene.compositing.name() == "accumulate"), 60),
                Kind::Filters => (share(&|t| t.scene.volume.filter() != Some(Filter::Trilinear)), 35),
                Kind::Far => (share(&far), 55),
                Kind::Inside => (
                    share(&|t| {
                        let at = grid(t).placement().to_index(t.view.camera.eye);
                        (0..3).all(|a| at[a] > 0.0 && at[a] < (grid(t).dims()[a] - 1) as f64)
                    }),
                    55,
                ),
                Kind::Mixed => (share(&|t| t.scene.compositing == Compositing::Over), 10),
                Kind::Cells => (share(&|t| t.scene.volume.cells().is_some()), 60),
                Kind::Adaptive => (share(&|t| t.scene.volume.amr().is_some_and(|mesh| mesh.levels() > 1)), 20),
                Kind::Rectilinear => (share(&|t| t.scene.volume.rectilinear().is_some()), 60),
            };
            assert!(found >= min, "{}: {found} of 60", kind.name());
        }
    }

    #[test]
    fn jumps_are_of_all_sorts() {
        let scenes: Vec<TestScene> = (0..200).map(|seed| Kind::Jumps.draw(seed)).collect();
        let some = |what: &str, test: &dyn Fn(&vr_core::transfer::Segment, &vr_core::transfer::Segment) -> bool| {
            drawn::some(&scenes, what, |t| t.scene.transfer.segments().windows(2).any(|w| test(&w[0], &w[1])));
        };
        some("to 1", &|a, b| a.end.opacity < 1.0 && b.start.opacity == 1.0);
        some("to 0.999", &|a, b| a.end.opacity < 0.9 && b.start.opacity == 0.999);
        some("with the same colour", &|a, b| a.end.opacity != b.start.opacity && a.end.color == b.start.color);
        some("from black", &|a, b| a.end.color == [0.0; 3] && b.start.color != [0.0; 3]);
    }
}
