//! Table of the features of scenes that each renderer draws, by the answers of the renderers themselves.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use vr_core::amr::{AmrBlock, AmrCentring};
use vr_core::field::FunctionField;
use vr_core::rectilinear::Centering;
use vr_core::{
    AmrGrid, Calibration, Camera, CellMesh, Clip, Compositing, Control, ControlPoint, FacetHit, Filter, GradientMethod,
    Layer, Light, OpacityRule, Placement, Plane, PointKernel, PointSet, Ray, RectilinearGrid, RenderError, Scene,
    Shading, StudiedRenderer, SurfaceTracer, Surfaces, TransferFunction, UniformGrid, View, Volume,
};

/// Answer of a renderer for a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Drawn at its default settings.
    Drawn,
    /// Drawn at some of the settings that it documents, but not at the defaults.
    InSomeSettings,
    /// Refused.
    Refused,
}

impl fmt::Display for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Drawn => "yes",
            Self::InSomeSettings => "some",
            Self::Refused => "-",
        })
    }
}

/// Features by renderer: asked of each by [`vr_core::Renderer::supports`] about a small scene that has the feature, without drawing it.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureMatrix {
    /// The renderers' names.
    pub renderers: Vec<&'static str>,
    /// The features, and each renderer's answer.
    pub rows: Vec<(&'static str, Vec<Support>)>,
}

impl FeatureMatrix {
    /// Asks renderers for every feature.
    pub fn of(renderers: &[Box<dyn StudiedRenderer>]) -> Self {
        let others: Vec<Vec<Box<dyn StudiedRenderer>>> =
            renderers.iter().map(|renderer| documented(&**renderer)).collect();
        let asked_of = |draws: &dyn Fn(&dyn StudiedRenderer) -> bool| -> Vec<Support> {
            renderers.iter().zip(&others).map(|(renderer, others)| asked(&**renderer, others, draws)).collect()
        };
        let mut rows: Vec<(&'static str, Vec<Support>)> = scenes()
            .into_iter()
            .map(|(name, scene, view)| {
                let others: Vec<Scene> = on_mesh(name, &scene).into_iter().chain([with_scattering(&scene)]).collect();
                let draws = |renderer: &dyn StudiedRenderer| {
                    let draws = |scene: &Scene| renderer.supports(scene, Some(&view)).is_ok();
                    draws(&scene) || others.iter().any(draws)
                };
                (name, asked_of(&draws))
            })
            .collect();
        let promises = |renderer: &dyn StudiedRenderer| matches!(renderer.with_max_error(1e-3), Some(Ok(_)));
        rows.push(("a promised error", asked_of(&promises)));
        Self { renderers: renderers.iter().map(|renderer| renderer.name()).collect(), rows }
    }
}

/// Returns the scene of a feature on a mesh of cells, for renderers that draw no grids; `None` for features of a grid.
fn on_mesh(feature: &str, scene: &Scene) -> Option<Scene> {
    let of_grids = ["volume", "missing", "filter"].iter().any(|start| feature.starts_with(start));
    let mesh = scene.volume.grid().filter(|_| !of_grids).and_then(|grid| CellMesh::of_grid(grid).ok())?;
    Some(Scene { volume: mesh.into(), ..scene.clone() })
}

/// Returns the scene of a feature with scattering, for renderers that draw no other.
fn with_scattering(scene: &Scene) -> Scene {
    Scene { scattering: Some(Arc::default()), ..scene.clone() }
}

/// Makes a renderer at each setting that it documents.
fn documented(renderer: &dyn StudiedRenderer) -> Vec<Box<dyn StudiedRenderer>> {
    renderer.settings().iter().filter_map(|setting| renderer.with_options(&setting.options).ok()).collect()
}

/// Asks a renderer at its defaults, then at the settings that it documents.
fn asked(
    renderer: &dyn StudiedRenderer,
    documented: &[Box<dyn StudiedRenderer>],
    draws: &dyn Fn(&dyn StudiedRenderer) -> bool,
) -> Support {
    if draws(renderer) {
        Support::Drawn
    } else if documented.iter().any(|other| draws(&**other)) {
        Support::InSomeSettings
    } else {
        Support::Refused
    }
}

impl fmt::Display for FeatureMatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first = self.rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        write!(f, "{:first$}", "")?;
        for name in &self.renderers {
            write!(f, "  {name}")?;
        }
        writeln!(f)?;
        for (name, answers) in &self.rows {
            write!(f, "{name:first$}")?;
            for (renderer, answer) in self.renderers.iter().zip(answers) {
                write!(f, "  {answer:>width$}", width = renderer.chars().count())?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

/// Returns a small scene and view for each feature.
fn scenes() -> Vec<(&'static str, Scene, View)> {
    let grid = |missing: bool| -> Volume {
        let samples: Vec<f32> = (0..27).map(|i| if missing && i == 13 { f32::NAN } else { i as f32 / 26.0 }).collect();
        let placement = Placement::from_spacing([1.0; 3]).expect("a placement");
        UniformGrid::new([3; 3], samples, placement, Calibration::default()).expect("a grid").into()
    };
    let transfer = |emission: Option<[f64; 3]>| {
        let point = |value, opacity| ControlPoint { emission, ..ControlPoint::new(value, [0.8; 3], opacity) };
        let points = vec![point(0.0, 0.0), point(1.0, 0.5)];
        TransferFunction::new(points, OpacityRule::Power, 1.0).expect("a transfer function")
    };
    let plain = Scene::new(grid(false), transfer(None));
    let camera = |fov| Camera::framing(plain.volume.bounds(), 30.0, 20.0, fov);
    let view = View::new(camera(None), [8, 8]);
    let points = PointSet::new(vec![DVec3::ONE], vec![1.0], vec![1.0], vec![1.0], PointKernel::CubicSpline);
    let mesh = CellMesh::of_grid(plain.volume.grid().expect("a grid")).expect("cells");
    let ramp = |n: usize| (0..n * n * n).map(|i| (i % n) as f32 / n as f32).collect::<Vec<f32>>();
    let axis = vec![0.0, 0.5, 2.0];
    let uneven = RectilinearGrid::new([axis.clone(), axis.clone(), axis], ramp(3), Centering::Points);
    let block = |level: usize, n: usize| AmrBlock { level, first: [0; 3], dims: [n; 3], values: ramp(n) };
    let blocks = vec![block(0, 3), block(1, 2)];
    let adaptive = AmrGrid::new(DVec3::ZERO, DVec3::splat(0.7), vec![[2; 3]], blocks, AmrCentring::Cells);
    let function = FunctionField::new((DVec3::ZERO, DVec3::splat(2.0)), |p| 0.5 * p.x).expect("a box");
    let with_volume = |volume: Volume| Scene { volume, ..plain.clone() };
    let shaded = |shading: Shading| Scene { shading: Some(Arc::new(shading)), ..plain.clone() };
    let composited = |compositing| Scene { compositing, ..plain.clone() };
    let modulated = Shading { gradient_opacity: vec![(0.0, 0.0), (1.0, 1.0)], ..Shading::default() };
    let row = |gradient, opacity| (gradient, vec![ControlPoint::new(0.0, [0.8; 3], opacity)]);
    let by_rows = TransferFunction::of_rows(vec![row(0.0, 0.0), row(1.0, 0.5)], OpacityRule::Power, 1.0);
    let by_rows = by_rows.expect("a transfer function");
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let perspective = View { camera: camera(Some(30.0)), ..view.clone() };
    let boxed = Clip { crop: Some((DVec3::ZERO, DVec3::new(2.0, 2.0, 1.0))), planes: Vec::new() };
    let plane = Clip { crop: None, planes: vec![Plane { normal: DVec3::ONE, offset: 3.0 }] };
    let of_scene = |name, scene| (name, scene, view.clone());
    let of_view = |name, view| (name, plain.clone(), view);
    vec![
        of_scene("volume: uniform grid", plain.clone()),
        of_scene("volume: scattered points", with_volume(points.expect("a point").into())),
        of_scene("volume: mesh of cells", with_volume(mesh.into())),
        of_scene("volume: rectilinear grid", with_volume(uneven.expect("a grid").into())),
        of_scene("volume: adaptive mesh", with_volume(adaptive.expect("a mesh").into())),
        of_scene("volume: function", with_volume(function.into())),
        of_scene("missing values", with_volume(grid(true))),
        of_scene("filter: nearest", plain.with_filter(Filter::Nearest)),
        of_scene("filter: B-spline", plain.with_filter(Filter::BSpline)),
        of_scene("filter: Catmull-Rom", plain.with_filter(Filter::CatmullRom)),
        of_scene("filter: Gaussian", plain.with_filter(Filter::Gaussian)),
        of_scene("over", plain.clone()),
        of_scene("accumulate", composited(Compositing::Accumulate { level: 0.5 })),
        of_scene("first", composited(Compositing::First { threshold: 0.5 })),
        of_scene("average", composited(Compositing::Average)),
        of_scene("maximum", composited(Compositing::Maximum)),
        of_scene("minimum", composited(Compositing::Minimum)),
        of_scene("emission of its own", Scene { transfer: Arc::new(transfer(Some([0.1; 3]))), ..plain.clone() }),
        of_scene("shading", shaded(Shading::default())),
        ("shading in perspective", shaded(Shading::default()), perspective.clone()),
        of_scene("shading, analytic gradients", shaded(analytic)),
        of_scene("opacity by gradient", shaded(modulated)),
        of_scene("transfer function by gradient", Scene { transfer: Arc::new(by_rows), ..plain.clone() }),
        of_view("perspective", perspective),
        of_view("crop box", View { clip: boxed, ..view.clone() }),
        of_view("clip planes", View { clip: plane, ..view.clone() }),
        of_scene("scattering", with_scattering(&plain)),
        of_scene("opaque surfaces", Scene { surfaces: Some(Arc::new(NoSurface)), ..plain.clone() }),
        of_view("several rays a pixel", View { supersampling: 2, ..view.clone() }),
    ]
}

/// Surfaces without geometry: renderers are asked about them, and do not draw them.
#[derive(Debug)]
struct NoSurface;

impl Surfaces for NoSurface {
    fn layer(&self, _: &[Light], view: &View, _: &Control) -> Result<Layer, RenderError> {
        let pixels = view.size[0] as usize * view.size[1] as usize;
        Ok(Layer { pixels: vec![([0.0; 3], f32::INFINITY); pixels] })
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ZERO)
    }

    fn can_be_traced(&self) -> bool {
        true
    }

    fn tracer(&self) -> Option<Arc<dyn SurfaceTracer>> {
        Some(Arc::new(Self))
    }
}

impl SurfaceTracer for NoSurface {
    fn nearest(&self, _: &Ray, _: [f64; 2], _: Option<u32>) -> Option<FacetHit> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A renderer draws what it says that it supports, and refuses what it says that it does not.
    #[test]
    fn answers_are_kept() {
        let renderers: Vec<Box<dyn StudiedRenderer>> = vec![
            Box::new(vr_raycast::RayCaster::default()),
            Box::new(vr_shearwarp::ShearWarp::default()),
            Box::new(vr_texslice::TextureSlicer::default()),
            Box::new(vr_splat::Splatter::default()),
            Box::new(vr_cells::CellMarcher::default()),
            Box::new(vr_cells::CellProjector::default()),
            Box::new(vr_physics::Reference::default()),
            Box::new(vr_light::LightRenderer { paths: 2, ..Default::default() }),
        ];
        let control = Control::default();
        for (name, scene, view) in scenes() {
            for renderer in &renderers {
                let answer = renderer.supports(&scene, Some(&view));
                let drawn = renderer.prepare(&scene, &control).and_then(|mut p| p.render(&view, &control));
                match (answer, drawn) {
                    (Ok(()), Ok(_)) => {}
                    (Err(RenderError::Unsupported(a)), Err(RenderError::Unsupported(b))) => assert_eq!(a, b),
                    (answer, drawn) => {
                        panic!("{name}, {}: {answer:?}, then {:?}", renderer.name(), drawn.map(|_| "drawn"))
                    }
                }
            }
        }
        let matrix = FeatureMatrix::of(&renderers);
        for (name, answers) in &matrix.rows {
            let drawn = if *name == "scattering" { Support::Refused } else { Support::Drawn };
            assert_eq!(answers[6], drawn, "{matrix}");
        }
    }
}
