//! The plain way: every texel by itself, all slices, all voxels, no runs, no links, no vectors. What compositing is tested against.

use proptest::prelude::*;
use vr_core::{
    Calibration, Camera, Classification, Compositing, Control, ControlPoint, Filter, LatticeVisitor, Light,
    OpacityRule, Placement, Plane, Projection, Renderer, Scene, Shading, TransferFunction, UniformGrid, View, Voxel,
    gradient_at_sample,
};

use crate::capabilities::last_sample;
use crate::codes::{Code, Codes};
use crate::factorization::IndexView;
use crate::lengths::Lengths;
use crate::optics::{Entry, Optics};
use crate::passes::{TexelLattice, passes};
use crate::prepared::PreparedShearWarp;
use crate::reflections::{Reflection, decode, encode, table};
use crate::region::Region;
use crate::shear_warp::{EmptySpace, ShearWarp};
use crate::slices::{Sampling, Slices};
use crate::steepness::reflects_by_interpolated_gradients;
use crate::warp::WarpFilter;

/// One scene of random voxels and a view of it.
#[derive(Clone, Debug)]
struct Case {
    dims: [usize; 3],
    samples: Vec<u8>,
    wide: bool,
    threshold: u8,
    opacity: f64,
    eye: [f64; 3],
    fov: Option<f64>,
    renderer: ShearWarp,
    shaded: bool,
    level: Option<f64>,
    /// Normal of a clip plane through a point near the middle.
    cut: Option<[f64; 3]>,
    nearest: bool,
}

fn cases() -> impl Strategy<Value = Case> {
    let dims = prop::array::uniform3(2usize..20);
    let voxels = prop_oneof![3 => Just(0u8), 1 => any::<u8>()];
    let samples = prop::collection::vec(voxels, 20 * 20 * 20);
    let renderer = (
        any::<bool>(),
        prop_oneof![Just(1.0), Just(0.5), Just(0.4)],
        prop_oneof![Just(1.0), Just(0.7), Just(0.5)],
        any::<bool>(),
        prop_oneof![Just(0.95), Just(1.0)],
    )
        .prop_map(|(voxels, slice_distance, texel, octree, termination)| ShearWarp {
            classification: if voxels { Classification::Pre } else { Classification::Post },
            slice_distance: slice_distance / texel,
            texel,
            empty_space: if octree { EmptySpace::Octree } else { EmptySpace::Runs },
            termination,
            ..ShearWarp::default()
        });
    let eye = prop::array::uniform3(-1.0f64..1.0).prop_filter("a direction", |e| e.iter().any(|x| x.abs() > 0.1));
    let fov = prop::option::of(20.0f64..100.0);
    let optics = (1u8..255, prop_oneof![0.01f64..0.3, 0.3f64..1.0, Just(1.0)], any::<bool>());
    let cut = prop::option::of(prop::array::uniform3(-1.0f64..1.0));
    let looks = (any::<bool>(), prop::option::of(0.2f64..0.9), cut, prop::bool::weighted(0.3));
    (dims, samples, optics, eye, fov, renderer, looks).prop_map(
        |(dims, samples, (threshold, opacity, wide), eye, fov, renderer, (shaded, level, cut, nearest))| Case {
            dims,
            samples,
            wide,
            threshold,
            opacity,
            eye,
            fov,
            renderer,
            shaded,
            level,
            cut,
            nearest,
        },
    )
}

impl Case {
    fn scene(&self) -> Scene {
        let n = self.dims.iter().product();
        let placement = Placement::from_spacing([1.0, 1.25, 0.75]).unwrap();
        // Kinks at integers, so that what is transparent in a cell is so at every entry of a table that the cell can reach.
        let points = vec![
            ControlPoint::new(f64::from(self.threshold) - 1.0, [0.1, 0.9, 0.3], 0.0),
            ControlPoint::new(255.0, [1.0, 0.2, 0.6], self.opacity),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let volume = if self.wide {
            let samples: Vec<i16> = self.samples[..n].iter().map(|&s| i16::from(s)).collect();
            UniformGrid::new(self.dims, samples, placement, Calibration::default()).unwrap().into()
        } else {
            UniformGrid::new(self.dims, self.samples[..n].to_vec(), placement, Calibration::default()).unwrap().into()
        };
        let mut scene = Scene::new(volume, transfer);
        if self.nearest {
            scene = scene.with_filter(Filter::Nearest);
        }
        if self.shaded {
            scene.shading = Some(Shading::default().into());
            let side = Light { direction: Some(glam::DVec3::new(0.3, 2.0, -1.0)), color: [0.2, 0.5, 0.9] };
            scene.lights.push(side);
        }
        if let Some(level) = self.level {
            scene.compositing = Compositing::Accumulate { level };
        }
        scene
    }

    fn view(&self, scene: &Scene) -> View {
        let (low, high) = scene.volume.bounds();
        let middle = 0.5 * (low + high);
        let size = (high - low).length();
        // In perspective sometimes from inside.
        let eye = middle + glam::DVec3::from(self.eye) * size * 0.8;
        let projection = match self.fov {
            Some(fov) => Projection::Perspective { fov },
            None => Projection::Orthographic { height: size },
        };
        let up = glam::DVec3::new(0.17, 0.9, -0.31);
        let mut view = View::new(Camera { eye, target: middle, up, projection }, [24, 20]);
        view.clip.planes.extend(self.cut.map(|normal| {
            let normal = glam::DVec3::from(normal) + 0.01;
            Plane { normal, offset: normal.dot(middle) + 0.1 }
        }));
        view
    }
}

/// Rounding of a place between two voxels in f32.
const ON_A_FACE: f64 = 1e-5;

/// Gradients that cancel to this part of their lengths have no direction of their own in f32.
const NO_DIRECTION: f64 = 1e-4;

/// Light that normals reflect along a ray, by their codes, and by gradients.
type Reflections<'a> = (&'a dyn Fn(u16) -> Reflection, &'a dyn Fn([f64; 3]) -> Reflection);

/// Final content of one texel; true with it if under nearest rounding decides in any slice: half way between two voxels on which is its own, and between gradients that
/// cancel on their direction.
fn texel<P: Code>(
    case: &Case,
    scene: &Scene,
    codes: &Codes,
    slices: &Slices,
    [x, y]: [usize; 2],
    (optics, lengths): (&Optics, &Lengths<P>),
    (by_code, by_gradient): Reflections<'_>,
) -> ([f64; 4], bool) {
    let axes = slices.axes();
    let interpolates = case.shaded && reflects_by_interpolated_gradients(&case.renderer, scene);
    let (mut sum, mut is_on_face) = ([0.0f64; 4], false);
    let level = case.level.unwrap_or(1.0);
    let chord = slices.chord(x as f64, y as f64);
    for (i, slice) in slices.slices.iter().enumerate() {
        let [first, end] = slices.row(i, y).valid;
        if !(first..end).contains(&x) || sum[3] >= case.renderer.termination.min(level) {
            continue;
        }
        let at: [f64; 2] = std::array::from_fn(|a| slice.map.offset[a] + slice.map.scale * [x, y][a] as f64);
        let cell: [usize; 2] = std::array::from_fn(|a| (at[a] as usize).min(case.dims[axes[a]] - 2));
        let place: [f64; 2] = std::array::from_fn(|a| at[a] - cell[a] as f64);
        let place = [place[0], place[1], slice.fraction.into()];
        is_on_face |= case.nearest && place.iter().any(|t| (t - 0.5).abs() < ON_A_FACE);
        let (mut value, mut classified) = (0.0, [0.0f64; 4]);
        let (mut factor, mut added) = ([0.0f64; 4], [0.0f64; 4]);
        let (mut slope, mut steepness) = ([0.0f64; 3], 0.0f64);
        let layers = if case.renderer.slice_spacing() == 1.0 { 1 } else { 2 };
        let table = &lengths.table;
        for corner in 0..4 * layers {
            let high = [corner & 1, corner >> 1 & 1, corner >> 2];
            let mut index = [0; 3];
            (index[axes[0]], index[axes[1]]) = (cell[0] + high[0], cell[1] + high[1]);
            index[axes[2]] = slice.layer + high[2];
            let part = |high: usize, t: f64| if high == 1 { t } else { 1.0 - t };
            let weight_at = |[u, v, w]: [f64; 3]| {
                let weight = part(high[0], u) * part(high[1], v);
                if layers == 2 { weight * part(high[2], w) } else { weight }
            };
            let weight = weight_at(place);
            let of_voxel = if case.nearest { weight_at(place.map(f64::round)) } else { weight };
            let stored = case.samples[(index[2] * case.dims[1] + index[1]) * case.dims[0] + index[0]];
            let code = codes.code(f32::from(stored));
            value += of_voxel * f64::from(code);
            let row = P::row(table, P::of(code).place(optics.codes_begin())).map(f64::from);
            let reflection = if case.shaded {
                by_code(encode(gradient(scene, index)))
            } else {
                Reflection { factor: [1.0; 4], added: [0.0; 4] }
            };
            if interpolates {
                let gradient = gradient(scene, index).map(f64::from);
                (0..3).for_each(|a| slope[a] += weight * gradient[a]);
                steepness += weight * gradient.iter().map(|g| g.abs()).sum::<f64>();
            }
            for c in 0..4 {
                let (f, a) = (f64::from(reflection.factor[c]), f64::from(reflection.added[c]));
                factor[c] += weight * f;
                added[c] += weight * a;
                classified[c] += of_voxel * (row[c] * f + row[3] * a);
            }
        }
        if interpolates {
            let length = slope.iter().map(|g| g.abs()).sum::<f64>();
            is_on_face |= steepness > 0.0 && length < NO_DIRECTION * steepness;
            let reflection = by_gradient(slope);
            (factor, added) = (reflection.factor.map(f64::from), reflection.added.map(f64::from));
        }
        let mut sample = if case.renderer.classification == Classification::Pre {
            classified
        } else {
            let place = (value as f32 * optics.scale + optics.bias) as usize;
            let row = P::row(table, place).map(f64::from);
            std::array::from_fn(|c| row[c] * factor[c] + row[3] * added[c])
        };
        let share = slices.share(slice.depth, chord);
        let ratio = lengths.ratios.as_ref().map_or(1.0, |ratios| ratios.at(x, y)) * share;
        if lengths.ratios.is_some() && case.renderer.classification == Classification::Post {
            let alpha = -(-sample[3] * ratio).exp_m1();
            let shines = if sample[3] > 0.0 { alpha / sample[3] } else { ratio };
            sample = [sample[0] * shines, sample[1] * shines, sample[2] * shines, alpha];
        } else if (ratio - 1.0).abs() > 1e-6 && sample[3] > 0.0 {
            let cut = if sample[3] >= 1.0 { 1.0 } else { -((ratio * (-sample[3]).ln_1p()).exp_m1()) };
            let grown = cut / sample[3];
            sample = sample.map(|s| s * grown);
        }
        let clear = 1.0 - sum[3];
        let after = sum[3] + clear * sample[3];
        let part = if after > level { (level - sum[3]) / (after - sum[3]) } else { 1.0 };
        sum = std::array::from_fn(|c| sum[c] + clear * sample[c] * part);
    }
    (sum, is_on_face)
}

fn gradient(scene: &Scene, index: [usize; 3]) -> [f32; 3] {
    struct At([usize; 3]);
    impl LatticeVisitor for At {
        type Output = [f32; 3];
        fn visit<T: Voxel>(self, lattice: vr_core::filter::Lattice<'_, T>) -> [f32; 3] {
            gradient_at_sample::<T, f32>(&lattice, self.0)
        }
    }
    let volume = scene.volume.grid().unwrap();
    let spacing = volume.placement().spacing();
    let gradient = volume.with_lattice(At(index));
    std::array::from_fn(|a| gradient[a] / spacing[a] as f32)
}

/// Differences of the composited texels of all passes from the plain ones.
#[derive(Debug, Default)]
struct Differences {
    /// Texels compared.
    all: usize,
    /// Differences larger than rounding explains, where both or neither are opaque. There should be none.
    unexplained: Vec<f64>,
    /// Differences of texels that only just are opaque, or only just not, and end one slice earlier the one way than the other.
    at_the_end: Vec<f64>,
}

/// Opacities so close to the termination are rounded to either side of it.
const AT_THE_END: f64 = 2e-3;

fn compare<P: Code>(case: &Case) -> Differences {
    let scene = case.scene();
    let view = case.view(&scene);
    let control = Control::default();
    let volume = scene.volume.grid().unwrap();
    let codes = Codes::of(volume);
    let calibration = volume.calibration();
    let optics = match case.renderer.classification {
        Classification::Post => Optics::of_values(&scene.transfer, calibration, &codes),
        Classification::Pre => Optics::of_voxels(&scene.transfer, calibration, &codes),
    };
    let entry = match case.renderer.classification {
        Classification::Post if case.fov.is_some() => Entry::Depth,
        _ => Entry::Sample,
    };
    let index_view = IndexView::new(&view, volume.placement()).unwrap();
    let last = last_sample(case.dims);
    let region = Region::of(&view, volume.placement(), case.dims).unwrap();
    let shading = scene.shading.clone().unwrap_or_default();
    let reflections = table(&shading, &scene.lights, view.camera.frame().unwrap().z_axis);
    let mut prepared = PreparedShearWarp::new(case.renderer.clone(), &scene, &control).unwrap();
    let mut differences = Differences::default();
    let end = case.renderer.termination.min(case.level.unwrap_or(1.0));
    // Rounding; and a value half way between two entries of a table, at one sample or another, put to either by it.
    let allowed = 2e-5 + case.opacity / (256.0 - f64::from(case.threshold));
    let Some(region) = region else { return differences };
    for pass in passes(&index_view, region.corners(), last, TexelLattice::of(&case.renderer, volume)).unwrap() {
        let slices = Slices::new(
            pass.factorization,
            &region,
            case.dims[pass.factorization.axes[2]],
            case.renderer.slice_spacing(),
            Sampling::of(&scene, volume, case.renderer.slice_spacing()),
        );
        let lengths = Lengths::<P>::new(&optics, &index_view, &pass.factorization, slices.spacing, true, entry);
        let image = prepared.composited(&index_view, &view, &pass, &slices, &control).unwrap();
        let [width, height] = pass.factorization.size;
        for y in 0..height {
            for x in 0..width {
                let f = &pass.factorization;
                let along = shading.along::<f64>(
                    &scene.lights,
                    index_view.world_vector(f.sign * f.step(x as f64, y as f64)).normalize(),
                );
                // In perspective, normals reflect other light along each ray.
                let reflection = |code: u16| match decode(code) {
                    Some(normal) if case.fov.is_some() => Reflection::new(along.reflect(normal.to_array())),
                    _ => reflections[usize::from(code)],
                };
                let by_gradient = |gradient: [f64; 3]| Reflection::new(along.reflect(gradient));
                let reflections: Reflections<'_> = (&reflection, &by_gradient);
                let (plain, is_on_face) =
                    texel(case, &scene, &codes, &slices, [x, y], (&optics, &lengths), reflections);
                let fast = image[y * width + x].map(f64::from);
                let off = (0..4).map(|c| (plain[c] - fast[c]).abs()).fold(0.0, f64::max);
                differences.all += 1;
                if off > allowed && !is_on_face {
                    let nearest = (plain[3] - end).abs().min((fast[3] - end).abs());
                    let ended = case.renderer.termination < 1.0 && nearest < AT_THE_END;
                    if ended { &mut differences.at_the_end } else { &mut differences.unexplained }.push(off);
                }
            }
        }
    }
    differences
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_fast_is_what_is_plain(case in cases()) {
        let differences = if case.wide { compare::<u16>(&case) } else { compare::<u8>(&case) };
        let Differences { all, unexplained, at_the_end } = &differences;
        prop_assert!(unexplained.is_empty(), "{unexplained:?} of {all} texels");
        // A texel that ends one slice earlier lacks what was behind 1 − termination.
        let lost = 1.0 - case.renderer.termination + AT_THE_END;
        prop_assert!(at_the_end.iter().all(|&off| off <= 1.2 * lost), "{at_the_end:?}");
        prop_assert!(at_the_end.len() * 100 <= *all, "{at_the_end:?} of {all} texels");
    }
}

#[test]
fn empty_and_full_volumes_of_any_size() {
    for dims in [[2, 2, 2], [3, 2, 5], [17, 16, 33]] {
        for (fill, alpha) in [(0u8, 0.0f32), (255, 1.0)] {
            for slice_distance in [1.0, 0.5] {
                let points = vec![ControlPoint::new(10.0, [1.0; 3], 0.0), ControlPoint::new(20.0, [1.0; 3], 1.0)];
                let placement = Placement::from_spacing([1.0; 3]).unwrap();
                let samples = vec![fill; dims.iter().product()];
                let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap();
                let scene = Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
                let (low, high) = scene.volume.bounds();
                let middle = 0.5 * (low + high);
                let projection = Projection::Orthographic { height: 4.0 };
                let eye = middle + glam::DVec3::new(3.0, 5.0, 40.0);
                let view = View::new(Camera { eye, target: middle, up: glam::DVec3::Y, projection }, [9, 9]);
                for filter in [WarpFilter::Bilinear, WarpFilter::Cubic] {
                    let renderer = ShearWarp { slice_distance, warp: filter, ..ShearWarp::default() };
                    let control = Control::default();
                    let frame = renderer.prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame;
                    assert!((frame.pixel(4, 4)[3] - alpha).abs() < 1e-6, "{dims:?} {fill}: {:?}", frame.pixel(4, 4));
                }
            }
        }
    }
}
