//! Table of the features of scenes that each renderer draws, by the answers of the renderers themselves.

use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::amr::{AmrBlock, AmrCentring};
use vr_core::field::FunctionField;
use vr_core::rectilinear::Centering;
use vr_core::{
    AmrGrid, Calibration, Camera, CellMesh, Clip, ColorGrid, Compositing, Control, ControlPoint, FacetHit, Feature,
    Filter, GradientMethod, GridVolume, Layer, Light, NamedSetting, OpacityRule, Placement, Plane, PointKernel,
    PointMixing, PointSet, Ray, RectilinearGrid, RenderError, Scene, Shading, StudiedRenderer, SurfaceTracer, Surfaces,
    TransferFunction, UniformGrid, View, Volume,
};

/// Answer of a renderer for a feature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Support {
    /// Drawn at its default settings.
    Drawn,
    /// Drawn at some of the settings that it documents, of which this is the first, but not at the defaults.
    InSomeSettings(String),
    /// Refused, for this reason.
    Refused(String),
}

impl fmt::Display for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Drawn => "yes",
            Self::InSomeSettings(_) => "some",
            Self::Refused(_) => "-",
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
        let scenes = scenes();
        let (_, any, view) = scenes[0].clone();
        let draws: Question<'_> = &|renderer, scenes, view| drawn(renderer, scenes, view).map(|_| ());
        let mut rows = answers(renderers, scenes, draws);
        let promises = |renderer: &dyn StudiedRenderer, _: &Variants, _: &View| match renderer.with_max_error(1e-3) {
            Some(Ok(_)) => Ok(()),
            Some(Err(error)) => Err(error.to_string()),
            None => Err("no bound of its error is known".to_owned()),
        };
        rows.extend(answers(renderers, [("a promised error", any, view)], &promises));
        Self { renderers: renderers.iter().map(|renderer| renderer.name()).collect(), rows }
    }

    /// Adds whether renderers tell depths: to know that, small pictures are drawn.
    pub fn with_depths(mut self, renderers: &[Box<dyn StudiedRenderer>]) -> Self {
        self.rows.extend(answers(renderers, depths(), &tells_depth));
        self
    }

    /// Writes the matrix as a page in Markdown: the table, and under it each renderer's reasons and the settings that draw what the defaults do not.
    pub fn page(&self) -> String {
        let mut text =
            format!("| feature | {} |\n|---|{}\n", self.renderers.join(" | "), ":-:|".repeat(self.renderers.len()));
        for (name, answers) in &self.rows {
            let answers: Vec<String> = answers.iter().map(Support::to_string).collect();
            text += &format!("| {name} | {} |\n", answers.join(" | "));
        }
        for (i, renderer) in self.renderers.iter().enumerate() {
            // Features with one reason share a line.
            let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
            for (name, answers) in &self.rows {
                let Some(reason) = reason(&answers[i]) else { continue };
                match lines.iter_mut().find(|(known, _)| *known == reason) {
                    Some((_, names)) => names.push(name),
                    None => lines.push((reason, vec![name])),
                }
            }
            if !lines.is_empty() {
                text += &format!("\n## {renderer}\n\n");
            }
            for (reason, names) in lines {
                text += &format!("- **{}**: {reason}\n", names.join(", "));
            }
        }
        text
    }
}

/// Question to a renderer about scenes that have a feature: `Ok` if it has the feature, otherwise the reason.
type Question<'q> = &'q dyn Fn(&dyn StudiedRenderer, &Variants, &View) -> Result<(), String>;

/// Puts a question about each feature to each renderer.
fn answers(
    renderers: &[Box<dyn StudiedRenderer>],
    features: impl IntoIterator<Item = (&'static str, Scene, View)>,
    question: Question<'_>,
) -> Vec<(&'static str, Vec<Support>)> {
    let others: Vec<_> = renderers.iter().map(|renderer| documented(&**renderer)).collect();
    let each = |(name, scene, view)| {
        let scenes = Variants::new(name, scene);
        let ask = |renderer: &dyn StudiedRenderer| question(renderer, &scenes, &view);
        let of_each = renderers.iter().zip(&others).map(|(renderer, others)| asked(&**renderer, others, &ask));
        (name, of_each.collect())
    };
    features.into_iter().map(each).collect()
}

/// Writes why a feature is not drawn, or not at the defaults; `None` if it is drawn.
fn reason(answer: &Support) -> Option<String> {
    match answer {
        Support::Drawn => None,
        Support::InSomeSettings(setting) => Some(format!("in some settings, such as `{setting}`")),
        Support::Refused(why) => Some(why.clone()),
    }
}

/// A feature's scene, and variants of it for renderers that draw no such scene whatever the feature.
struct Variants {
    own: Scene,
    /// On a mesh of cells; `None` for features of a volume.
    mesh: Option<Scene>,
    scattering: Scene,
}

impl Variants {
    fn new(feature: &str, own: Scene) -> Self {
        Self { mesh: on_mesh(feature, &own), scattering: with_scattering(&own), own }
    }

    /// The variant that mends a refusal, where there is one: a mesh where grids are refused, scattering where its absence is.
    fn after(&self, refusal: &RenderError) -> Option<&Scene> {
        let RenderError::Unsupported(refusal) = refusal else { return None };
        match refusal.feature {
            Feature::VolumeKind => self.mesh.as_ref(),
            Feature::Scattering => Some(&self.scattering),
            _ => None,
        }
    }
}

/// Returns the first of a feature's scenes that a renderer draws: the scene itself, or the variant that its refusal asks for.
///
/// # Errors
/// The reason of the last refusal, which speaks of the feature itself, or of its volume.
fn drawn<'s>(renderer: &dyn StudiedRenderer, scenes: &'s Variants, view: &View) -> Result<&'s Scene, String> {
    let ask = |scene: &'s Scene| renderer.supports(scene, Some(view)).map(|()| scene);
    let answer = ask(&scenes.own).or_else(|refusal| match scenes.after(&refusal) {
        Some(variant) => ask(variant),
        None => Err(refusal),
    });
    answer.map_err(|refusal| match refusal {
        RenderError::Unsupported(refusal) => refusal.what,
        other => other.to_string(),
    })
}

/// Asks a renderer whether its frames of a feature's scene have depths.
///
/// # Errors
/// The reason of its refusal, or that it tells none.
fn tells_depth(renderer: &dyn StudiedRenderer, scenes: &Variants, view: &View) -> Result<(), String> {
    let scene = drawn(renderer, scenes, view)?;
    let control = Control::default();
    let drawn = renderer.prepare(scene, &control).and_then(|mut prepared| prepared.render(view, &control));
    if drawn.is_ok_and(|drawn| drawn.frame.depth().is_some()) {
        Ok(())
    } else {
        Err("drawn, and no depth is told".to_owned())
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

/// Makes a renderer at each setting that it documents, with the setting's name.
fn documented(renderer: &dyn StudiedRenderer) -> Vec<(String, Box<dyn StudiedRenderer>)> {
    let made = |setting: NamedSetting| Some((setting.name, renderer.with_options(&setting.options).ok()?));
    renderer.settings().into_iter().filter_map(made).collect()
}

/// Asks a renderer at its defaults, then at the settings that it documents.
fn asked(
    renderer: &dyn StudiedRenderer,
    documented: &[(String, Box<dyn StudiedRenderer>)],
    ask: &dyn Fn(&dyn StudiedRenderer) -> Result<(), String>,
) -> Support {
    let Err(reason) = ask(renderer) else { return Support::Drawn };
    match documented.iter().find(|(_, other)| ask(&**other).is_ok()) {
        Some((setting, _)) => Support::InSomeSettings(setting.clone()),
        None => Support::Refused(reason),
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

/// Returns a small scene and view for each operator that tells a depth.
fn depths() -> Vec<(&'static str, Scene, View)> {
    let all = scenes();
    let named = |feature: &'static str, name: &str| {
        let (_, scene, view) = all.iter().find(|(known, ..)| *known == name).expect("a feature of this name");
        (feature, scene.clone(), view.clone())
    };
    vec![
        named("depth under over", "over"),
        named("depth under first", "first"),
        named("depth under maximum", "maximum"),
        named("depth in perspective", "perspective"),
    ]
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
    let points = points.expect("a point");
    let mean = Volume::from(points.clone().with_mixing(PointMixing::Mean).expect("a positive weight"));
    let tinted = Volume::from(points.clone().with_colors(vec![[0.5; 3]]).expect("a colour"));
    let points = Volume::from(points);
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
    let colors = plain.volume.grid().map(|grid| ColorGrid::new(GridVolume::clone(grid), [(); 3].map(|()| vec![9; 27])));
    let colors = colors.expect("a grid").expect("colours");
    let turn = DMat3::from_rotation_z(0.3);
    let turned = Placement::oriented(DVec3::ZERO, [1.0; 3], turn).expect("a placement");
    let turned = UniformGrid::new([3; 3], ramp(3), turned, Calibration::default()).expect("a grid");
    let centre = Camera { eye: DVec3::ONE, target: DVec3::new(1.0, 1.0, 2.0), up: DVec3::Y, ..perspective.camera };
    let boxed = Clip { crop: Some((DVec3::ZERO, DVec3::new(2.0, 2.0, 1.0))), planes: Vec::new() };
    let plane = Clip { crop: None, planes: vec![Plane { normal: DVec3::ONE, offset: 3.0 }] };
    let of_scene = |name, scene| (name, scene, view.clone());
    let of_view = |name, view| (name, plain.clone(), view);
    vec![
        of_scene("volume: uniform grid", plain.clone()),
        of_scene("volume: scattered points", with_volume(points.clone())),
        of_scene("weighted mean of scattered points", with_volume(mean)),
        of_scene("colours of scattered points", with_volume(tinted)),
        of_scene("volume: mesh of cells", with_volume(mesh.into())),
        of_scene("volume: rectilinear grid", with_volume(uneven.expect("a grid").into())),
        of_scene("volume: adaptive mesh", with_volume(adaptive.expect("a mesh").into())),
        of_scene("volume: function", with_volume(function.into())),
        of_scene("volume: voxels with colours", with_volume(colors.into())),
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
        of_scene("shading of scattered points", Scene { volume: points.clone(), ..shaded(Shading::default()) }),
        of_scene("opacity by gradient", shaded(modulated.clone())),
        of_scene("opacity by gradient of scattered points", Scene { volume: points, ..shaded(modulated) }),
        of_scene("transfer function by gradient", Scene { transfer: Arc::new(by_rows), ..plain.clone() }),
        of_view("perspective", perspective),
        of_view("camera inside the volume", View { camera: centre, ..view.clone() }),
        of_view("crop box", View { clip: boxed.clone(), ..view.clone() }),
        ("crop box, turned volume", with_volume(turned.into()), View { clip: boxed, ..view.clone() }),
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
            assert_eq!(answers[6] == Support::Drawn, *name != "scattering", "{matrix}");
            // A refusal says why; nothing but the feature's own volume is refused of a scene of points.
            for answer in answers {
                assert!(!matches!(answer, Support::Refused(why) if why.is_empty()), "{name}");
                let of_points = name.ends_with("of scattered points") && !std::ptr::eq(answer, &answers[7]);
                assert!(
                    !matches!(answer, Support::Refused(why) if of_points && !why.contains("scattered points")),
                    "{answer:?}"
                );
            }
        }
    }
}
