//! Comparison of the rules in f64, without the f32 of a frame, with the reference.

use std::sync::Arc;

use vr_core::*;
use vr_physics::Reference;
use vr_physics::fit_order;

use crate::caster::{CompositingOrder, RayCaster, Rule, Step, TransferLookup, Traversal};
use crate::chord::Chord;
use crate::operator::operator;
use crate::render_tables::TablesByPrecision;
use crate::run::Run;
use crate::source::Source;
use crate::walk::{WalkKind, Walks};

fn volume(dims: [usize; 3], placement: Placement, f: impl Fn(f64, f64, f64) -> f64) -> Volume {
    let point = |i: usize| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])].map(|x| x as f64);
    let samples = (0..dims.iter().product()).map(point).map(|[x, y, z]| f(x, y, z) as f32).collect::<Vec<_>>();
    UniformGrid::new(dims, samples, placement, Calibration { slope: -2.0, intercept: 1.5 }).unwrap().into()
}

/// Waves, between 0.05 and 0.95 as calibrated values.
fn waves(filter: Filter, transfer: TransferFunction) -> Scene {
    let wave =
        |x: f64, y: f64, z: f64| 0.5 + 0.2 * (0.41 * x + 0.2).sin() * (0.33 * y + 0.3).cos() + 0.25 * (0.37 * z).sin();
    let placement = Placement::from_spacing([1.0, 0.8, 1.2]).unwrap();
    Scene::new(volume([25; 3], placement, |x, y, z| 0.75 - 0.5 * wave(x, y, z)).with_filter(filter), transfer)
}

const DARK: [f64; 3] = [0.1, 0.3, 0.9];
const BRIGHT: [f64; 3] = [1.0, 0.8, 0.2];

fn points(points: &[(f64, [f64; 3], f64)], rule: OpacityRule) -> TransferFunction {
    let points = points.iter().map(|&(v, c, a)| ControlPoint::new(v, c, a)).collect();
    TransferFunction::new(points, rule, 1.0).unwrap()
}

fn smooth() -> TransferFunction {
    points(&[(0.0, DARK, 0.02), (1.0, BRIGHT, 0.3)], OpacityRule::Extinction)
}

fn kinked() -> TransferFunction {
    let p = [(0.0, DARK, 0.0), (0.35, BRIGHT, 0.02), (0.5, DARK, 0.3), (0.7, BRIGHT, 0.05), (1.0, DARK, 0.2)];
    points(&p, OpacityRule::Power)
}

fn jumping() -> TransferFunction {
    points(&[(0.4, DARK, 0.05), (0.4, BRIGHT, 0.3), (0.6, BRIGHT, 0.3), (0.6, DARK, 0.1)], OpacityRule::Power)
}

/// Returns a ramp that only touches α = 1, and a wall.
fn opaque() -> TransferFunction {
    let p = [
        (0.1, DARK, 0.0),
        (0.3, BRIGHT, 0.1),
        (0.5, DARK, 1.0),
        (0.6, DARK, 0.2),
        (0.8, BRIGHT, 1.0),
        (0.9, DARK, 1.0),
    ];
    points(&p, OpacityRule::Power)
}

fn emitting() -> TransferFunction {
    let p =
        [(0.1, 0.0, [0.0; 3]), (0.5, 0.3, [0.2, 0.1, 0.0]), (0.5, 0.0, [0.5, 0.1, 0.2]), (0.9, 0.9, [0.0, 0.3, 0.1])];
    let p = p.map(|(v, a, e)| ControlPoint { emission: Some(e), ..ControlPoint::new(v, [0.0; 3], a) });
    TransferFunction::new(p.to_vec(), OpacityRule::Power, 1.5).unwrap()
}

fn view(scene: &Scene) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [10, 10])
}

/// Returns the pixels of a view in f64, by the engine's passes.
fn draw(caster: &RayCaster, scene: &Scene, view: &View) -> Vec<[f64; 4]> {
    let volume = scene.volume.grid().unwrap();
    let TablesByPrecision::F64(tables) = TablesByPrecision::new(caster, scene, volume, None) else {
        panic!("f64 was asked for")
    };
    let rays = Rays::new(view).unwrap();
    let dims = volume.dims();
    let trace = |x: u32, y: u32| {
        let ray = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let Some(part) = IndexRay::new(&ray, volume.placement(), dims, &view.clip, f64::INFINITY) else {
            return [0.0; 4];
        };
        let source = Source::Grid(Arc::clone(volume));
        let chord = Chord { source: &source, colors: None, ray: part };
        let step = caster.longest_step(volume.placement());
        let kind = if caster.traversal == Traversal::Cells { WalkKind::Cells } else { WalkKind::Lattice(None) };
        let walks = Walks { kind, step, voxel: 1.0, dims };
        let mut walk = walks.along(part, 0, 0, true);
        let (mut run, mut over) =
            (Run::<f64>::new(), operator(scene, volume.calibration(), CompositingOrder::BackToFront));
        over.begin(&chord);
        while walk.next(&mut run.steps) {
            chord.place(&mut run, if caster.rule == Rule::Left { 0.0 } else { 0.5 });
            match &tables.classifier.profile {
                Some(profile) => profile.sample(&chord, &mut run),
                None => {
                    chord.sample(&mut run);
                    0
                }
            };
            tables.classifier.classify(&mut run);
            let _ = over.take(&run, &chord);
        }
        over.finish(&chord).rgba
    };
    (0..view.size[1]).flat_map(|y| (0..view.size[0]).map(move |x| (x, y))).map(|(x, y)| trace(x, y)).collect()
}

fn truth(scene: &Scene, view: &View, tolerance: f64) -> Vec<[f64; 4]> {
    let solution = Reference::new(tolerance).solve(scene, view, &Model::Canonical, &Control::default()).unwrap();
    solution.pixels.iter().map(|p| p.rgba).collect()
}

fn rmse(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let sum: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b) * (a - b)).sum();
    (sum / (4.0 * a.len() as f64)).sqrt()
}

fn largest(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_exact_rule_is_the_reference() {
    let rule = RayCaster { rule: Rule::Exact, traversal: Traversal::Cells, step: Step::Auto, ..RayCaster::exact(1.0) };
    for (name, transfer) in [
        ("smooth", smooth()),
        ("kinked", kinked()),
        ("jumping", jumping()),
        ("opaque", opaque()),
        ("emitting", emitting()),
    ] {
        let scene = waves(Filter::Trilinear, transfer);
        let view = view(&scene);
        let truth = truth(&scene, &view, 1e-11);
        let error = largest(&draw(&rule, &scene, &view), &truth);
        println!("{name}: {error:.1e}");
        // Roots of a cubic and logarithms near α = 1, a few dozen of them a ray.
        assert!(error <= 1e-9, "{name}: {error:.1e}");
    }
}

#[test]
fn a_field_with_holes_is_known_cell_by_cell() {
    let hole = |x: f64, y: f64, z: f64| {
        if (x, y, z) == (4.0, 3.0, 5.0) || x + y + z == 3.0 { f64::NAN } else { 0.1 * x + 0.02 * y * z - 0.3 }
    };
    let scene = Scene::new(volume([9; 3], Placement::from_spacing([1.0; 3]).unwrap(), hole), kinked());
    let rule = RayCaster { rule: Rule::Exact, traversal: Traversal::Cells, step: Step::Auto, ..RayCaster::exact(1.0) };
    let view = view(&scene);
    let error = largest(&draw(&rule, &scene, &view), &truth(&scene, &view, 1e-11));
    assert!(error <= 1e-9, "{error:.1e}");
}

/// Errors at five steps, each half the one before, and the order fitted to those above what a table can do.
fn converge(scene: &Scene, caster: &RayCaster, first: f64) -> (f64, Vec<f64>) {
    /// Fixed-point sums and the curvature of κ in an interval leave some 10⁻⁹.
    const FLOOR: f64 = 2e-8;
    let view = view(scene);
    let truth = truth(scene, &view, 1e-12);
    let steps: Vec<f64> = (0..5).map(|k| first / f64::from(1 << k)).collect();
    let at = |&step: &f64| RayCaster { step: RayCaster::exact(step).step, ..caster.clone() };
    let errors: Vec<f64> = steps.iter().map(|step| rmse(&draw(&at(step), scene, &view), &truth)).collect();
    let n = errors.iter().position(|&e| e < FLOOR).unwrap_or(5);
    (if n > 1 { fit_order(&steps[..n], &errors[..n]) } else { f64::NAN }, errors)
}

/// Measures every rule, by integration to rounding and by tables, and asserts its order.
fn assert_orders(
    field: &str,
    filter: Filter,
    traversal: Traversal,
    expected: impl Fn(&str, Rule, bool) -> Option<(f64, f64)>,
) {
    for (name, transfer) in [("smooth", smooth()), ("kinked", kinked()), ("jumping", jumping())] {
        let scene = waves(filter, transfer);
        for (rule, table) in [
            (Rule::Left, false),
            (Rule::Midpoint, false),
            (Rule::Linear, false),
            (Rule::Linear, true),
            (Rule::Quadratic, false),
            (Rule::Quadratic, true),
        ] {
            let classification = if table { TransferLookup::Table } else { TransferLookup::Exact };
            let caster = RayCaster { rule, traversal, transfer_lookup: classification, ..RayCaster::exact(1.0) };
            // A cell is cut from half its edge on.
            let (order, errors) = converge(&scene, &caster, if traversal == Traversal::Cells { 0.5 } else { 2.0 });
            let listed = errors.iter().map(|e| format!("{e:.1e}")).collect::<Vec<_>>().join(" | ");
            println!("| {field} | {name} | {rule:?}{} | {order:.2} | {listed} |", if table { ", table" } else { "" });
            if let Some((min, max)) = expected(name, rule, table) {
                assert!((min..max).contains(&order), "{field}, {name}, {rule:?}, {table}: order {order:.2}");
            }
        }
    }
}

#[test]
fn orders_on_a_smooth_field() {
    assert_orders("smooth field", Filter::BSpline, Traversal::Samples, |transfer, rule, table| {
        Some(match (rule, transfer, table) {
            (Rule::Left, ..) => (0.85, 1.15),
            (Rule::Midpoint, "jumping", _) => (0.8, 1.3),
            (Rule::Midpoint | Rule::Linear, ..) => (1.8, 2.2),
            // Where a jump lies in a step is known to the third order by the parabola, to the second by its chords.
            (Rule::Quadratic, "jumping", false) => (2.6, 3.4),
            (Rule::Quadratic, "jumping", true) => (1.7, 2.6),
            // What the chords' colour does at a kink is of the third order.
            (Rule::Quadratic, "kinked", true) => (3.3, 4.2),
            (Rule::Quadratic, ..) => (3.7, 4.3),
            (Rule::Auto | Rule::Exact, ..) => unreachable!("not measured here"),
        })
    });
}

#[test]
fn kinks_at_cell_faces_leave_order_two_to_every_rule() {
    assert_orders("trilinear field", Filter::Trilinear, Traversal::Samples, |transfer, rule, _| {
        match (rule, transfer) {
            (Rule::Left, _) => Some((0.85, 1.15)),
            (Rule::Midpoint, "jumping") => Some((0.8, 1.3)),
            // Kinks and jumps at once: few of either in a view, and the fit is rough.
            (_, "jumping") => Some((1.4, 2.3)),
            (Rule::Quadratic, _) => Some((1.8, 2.7)),
            _ => Some((1.8, 2.2)),
        }
    });
}

#[test]
fn steps_that_end_at_faces_see_a_smooth_field() {
    assert_orders("trilinear, cells", Filter::Trilinear, Traversal::Cells, |transfer, rule, _| {
        match (rule, transfer) {
            // Cells are cut into different numbers of steps, and those of one step do not change when the step does.
            (Rule::Left, _) => Some((0.8, 1.15)),
            (Rule::Midpoint, "jumping") => Some((0.8, 1.3)),
            (Rule::Midpoint | Rule::Linear, _) => Some((1.7, 2.2)),
            // At its floor from the first step on.
            _ => None,
        }
    });
    // A parabola in each cell: what is left is how far the cubic is from it.
    let caster = RayCaster { rule: Rule::Quadratic, traversal: Traversal::Cells, ..RayCaster::exact(2.0) };
    for transfer in [smooth(), kinked(), jumping()] {
        let scene = waves(Filter::Trilinear, transfer);
        let view = view(&scene);
        let error = rmse(&draw(&caster, &scene, &view), &truth(&scene, &view, 1e-12));
        println!("one parabola a cell: {error:.1e}");
        assert!(error < 1e-6, "{error:.1e}");
    }
}
