//! List of what each engine takes: every combination of what can be turned on, by the engine that is chosen for it.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::cells::{CellMesh, CellValues};
use vr_core::field::FunctionField;
use vr_core::labels::{LabelMap, LabelStyle, LabelledGrid};
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    AnyGrid, Calibration, ColorGrid, Compositing, Control, ControlPoint, Filter, GradientMethod, OpacityRule,
    Placement, PointMixing, RenderError, Scene, Shading, TransferFunction, UniformGrid, Volume, phantom,
};

use super::Engine;
use crate::caster::{RayCaster, Rule, Step};
use crate::prepared::PreparedCaster;

/// Waves between 0 and 1.
fn wave(p: DVec3) -> f64 {
    0.5 + 0.5 * (0.9 * p.x).sin() * (0.7 * p.y + 0.2).cos() * (0.8 * p.z + 0.5).sin()
}

const N: usize = 6;

fn voxels<T>(of: impl Fn(DVec3) -> T) -> Vec<T> {
    (0..N * N * N).map(|i| of(DVec3::new((i % N) as f64, (i / N % N) as f64, (i / N / N) as f64))).collect()
}

fn grid(hole: bool) -> UniformGrid<f32> {
    let value = |p: DVec3| if hole && p == DVec3::splat(2.0) { f32::NAN } else { wave(p) as f32 };
    UniformGrid::new([N; 3], voxels(value), Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default()).unwrap()
}

fn transfer(rows: bool) -> TransferFunction {
    let point = |value, opacity| ControlPoint::new(value, [1.0 - value, value, 0.5], opacity);
    let points = |share: f64| vec![point(0.25, 0.0), point(0.5, 0.5 * share), point(1.0, 0.25 * share)];
    if rows {
        let rows = vec![(0.0, points(0.1)), (1.0, points(1.0))];
        return TransferFunction::of_rows(rows, OpacityRule::Extinction, 1.0).unwrap();
    }
    TransferFunction::new(points(1.0), OpacityRule::Extinction, 1.0).unwrap()
}

fn labelled() -> LabelledGrid {
    let of = |p: DVec3| u8::from(p.x > 2.0) * 5;
    let labels: AnyGrid =
        UniformGrid::new([N; 3], voxels(of), Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default())
            .unwrap()
            .into();
    let red = LabelStyle::Solid { color: [1.0, 0.0, 0.0], opacity: 0.5 };
    let volume = Volume::from(grid(false));
    let map = Arc::new(LabelMap::new(&labels).unwrap());
    let style = |label| if label == 5 { red } else { LabelStyle::VOLUME };
    LabelledGrid::new(Arc::clone(volume.grid().unwrap()), map, style).unwrap()
}

/// Volumes of every kind, by name.
fn volumes() -> Vec<(String, Volume)> {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 4.0,
        blocks: [1; 3],
        block_cells: [4; 3],
        ratios: vec![[2; 3]],
        centring: AmrCentring::Cells,
    };
    let mesh = AmrGrid::refining(&sampling, |p| wave(p) as f32, |low, _, _| low == DVec3::ZERO).unwrap();
    let places: Vec<f64> = (0..N).map(|k| (k * k + 5 * k) as f64 / 10.0).collect();
    let mut uneven = Vec::new();
    for &z in &places {
        for &y in &places {
            uneven.extend(places.iter().map(|&x| wave(DVec3::new(x, y, z)) as f32));
        }
    }
    let uneven = RectilinearGrid::new([places.clone(), places.clone(), places], uneven, Centering::Points).unwrap();
    let points = || phantom::points_by_name("turbulence", 50).unwrap();
    let channel = || voxels(|p| (p.x * 9000.0) as u16);
    let colors =
        ColorGrid::new(Volume::from(grid(false)).grid().unwrap().as_ref().clone(), [channel(), channel(), channel()]);
    let corners = vec![DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y, 4.0 * DVec3::Z];
    let cells = CellMesh::new(corners, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.2, 0.9, 0.4, 0.6])).unwrap();
    let function = FunctionField::new((DVec3::ZERO, DVec3::splat(4.0)), wave).unwrap().with_gradient(|p| p);
    let mut all: Vec<(String, Volume)> =
        Filter::ALL.iter().map(|&f| (format!("grid, {f}"), Volume::from(grid(false)).with_filter(f))).collect();
    all.extend([
        ("grid with holes".into(), grid(true).into()),
        ("grid with colours".into(), Volume::Color(Arc::new(colors.unwrap()))),
        ("points".into(), points().into()),
        ("means of points".into(), points().with_mixing(PointMixing::Mean).unwrap().into()),
        ("points with colours".into(), points().with_colors(vec![[1.0, 0.5, 0.2]; 50]).unwrap().into()),
        ("adaptive mesh".into(), mesh.into()),
        ("rectilinear grid".into(), Volume::Rectilinear(Arc::new(uneven))),
        ("function".into(), function.into()),
        ("labels".into(), Volume::Field(Arc::new(labelled()))),
        ("mesh of cells".into(), cells.into()),
    ]);
    all
}

/// Kinds of shading, by name, and whether rows of the transfer function go with them.
fn looks() -> Vec<(&'static str, Option<Shading>, bool)> {
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let factors = Shading { gradient_opacity: vec![(0.0, 0.2), (1.0, 2.0)], ..Shading::default() };
    vec![
        ("unshaded", None, false),
        ("shaded", Some(Shading::default()), false),
        ("shaded by the filter's gradient", Some(analytic), false),
        ("opacity by the gradient", Some(factors), false),
        ("rows by gradient", None, true),
        ("rows by gradient, shaded", Some(Shading::default()), true),
    ]
}

const OPERATORS: [Compositing; 6] = [
    Compositing::Over,
    Compositing::Accumulate { level: 0.9 },
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::Average,
    Compositing::First { threshold: 0.6 },
];

/// One combination.
struct Choice<'a> {
    volume: &'a str,
    rule: Rule,
    step: Step,
    picks: bool,
    has_rows: bool,
}

impl Choice<'_> {
    /// Reason why rays go one by one; `None` if packets take the combination.
    fn reason(&self) -> Option<&'static str> {
        let is_local = matches!(self.step, Step::Local { .. });
        match self.volume {
            "function" | "mesh of cells" => Some("fields that are asked place by place"),
            "labels" if self.picks => Some("values picked under labels"),
            "labels" if self.has_rows => Some("codes of labels under rows by gradient"),
            "labels" if self.rule == Rule::Left => Some("labels by the rule left"),
            "adaptive mesh" | "rectilinear grid" if self.rule == Rule::Left => Some("patches by the rule left"),
            _ if is_local && self.rule == Rule::Left => Some("local steps by the rule left"),
            _ => None,
        }
    }
}

#[test]
fn every_combination_goes_to_the_engine_that_is_told() {
    let control = Control::default().with_threads(1);
    let steps = [
        ("uniform", Step::Uniform(0.5)),
        ("local", Step::Local { error: 1e-3 }),
        ("homogeneous", Step::Homogeneous { step: 0.5, error: 1e-2 }),
        ("variance", Step::Variance { step: 0.5, error: 1e-2 }),
    ];
    let mut counts: BTreeMap<(bool, String), usize> = BTreeMap::new();
    let mut refused = 0;
    for (name, volume) in &volumes() {
        for (look, shading, rows) in looks() {
            for compositing in OPERATORS {
                let transfer = match volume {
                    Volume::Field(_) if name == "labels" => {
                        labelled().transfer(&transfer(rows)).unwrap_or(transfer(rows))
                    }
                    _ => transfer(rows),
                };
                let shading = shading.clone().map(Arc::new);
                let scene = Scene { compositing, shading, ..Scene::new(volume.clone(), transfer) };
                for (steps, step) in steps {
                    for rule in [Rule::Midpoint, Rule::Left, Rule::Linear, Rule::Quadratic] {
                        let caster = RayCaster { rule, step, ..RayCaster::default() };
                        let engine = match PreparedCaster::new(caster, &scene, &control) {
                            Ok(prepared) => prepared.engine,
                            // What does not go together is no combination.
                            Err(RenderError::Unsupported(_) | RenderError::Parameter(_)) => {
                                refused += 1;
                                continue;
                            }
                            Err(error) => panic!("{name}: {error}"),
                        };
                        let is_plain = matches!(engine, Engine::Plain(_) | Engine::Field(..));
                        let picks = !compositing.integrates_light();
                        let choice = Choice { volume: name, rule, step, picks, has_rows: rows };
                        let reason = choice.reason();
                        let what =
                            format!("{name}, {}, {look}, {steps} steps, rule {}", compositing.name(), rule.name());
                        assert_eq!(is_plain, reason.is_some(), "{what}: {reason:?}");
                        let kind = format!("{name}, {}: {}", compositing.name(), reason.unwrap_or("packets"));
                        *counts.entry((is_plain, kind)).or_default() += 1;
                    }
                }
            }
        }
    }
    for ((is_plain, kind), count) in &counts {
        println!("{} {count:3} of {kind}", if *is_plain { "one by one:" } else { "sixteen:   " });
    }
    let of = |plain: bool| counts.iter().filter(|((p, _), _)| *p == plain).map(|(_, n)| n).sum::<usize>();
    println!("sixteen at once {}, one by one {}, refused {refused}", of(false), of(true));
    assert!(of(false) > of(true), "most goes sixteen at once");
}
