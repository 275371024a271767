//! Integration rules as users meet them: hard cases, closed forms, floors, shading, holes, and what does not go together. Their orders are
//! measured in f64, next to the rules themselves.

use std::sync::Arc;

use crate::common::*;
use vr_core::*;
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::{self, Effort, Refinement};
use vr_raycast::{Precision, RayCaster, Rule, Step, TransferLookup, Traversal, Vector};

const FINE: Step = Step::Uniform(0.2);
const VOXEL: Step = Step::Uniform(1.0);

fn caster(rule: Rule, step: Step) -> RayCaster {
    RayCaster { rule, step, ..RayCaster::uniform(0.2) }
}

/// Steps of a voxel at most that end at the faces of cells; the rule exact cuts no cell.
fn cells(rule: Rule) -> RayCaster {
    let step = if rule == Rule::Exact { Step::Auto } else { VOXEL };
    RayCaster { traversal: Traversal::Cells, ..caster(rule, step) }
}

/// Half as much again as was measured, case by case: a fifth of a voxel a step.
fn linear_bound(case: &Case) -> f64 {
    match case.name {
        // A hundredth of a step wide, but never stepped over: what is left is the way the field bends within a step.
        "thin-shell" => 0.13,
        "full-u16" => 0.09,
        "missing-voxels" => 0.031,
        "marschner-lobb" => 0.015,
        "two-samples" => 0.011,
        "bright" => 4e-3,
        "anisotropy" | "grazing-rays" | "camera-inside" | "far-origin" | "faint" => 6e-4,
        "opaque-wall" => 7e-6,
        "axis-aligned" | "many-faint-steps" | "constant" => 1e-6,
        // No uniform grids: these rules refuse them.
        "level-boundary" | "uneven-axes" | "slivers" => 0.0,
        other => panic!("no bound for the hard case '{other}'"),
    }
}

fn quadratic_bound(case: &Case) -> f64 {
    match case.name {
        "full-u16" => 0.09,
        "thin-shell" => 0.034,
        "missing-voxels" => 0.016,
        // Shading turns fast where the gradient is nearly 0, and is looked at once a step.
        "two-samples" => 0.011,
        "marschner-lobb" => 3e-3,
        "bright" => 4e-4,
        "camera-inside" | "far-origin" | "grazing-rays" | "anisotropy" | "faint" => 1.1e-4,
        "opaque-wall" => 2e-6,
        "axis-aligned" | "many-faint-steps" | "constant" => 1e-6,
        // No uniform grids: these rules refuse them.
        "level-boundary" | "uneven-axes" | "slivers" => 0.0,
        other => panic!("no bound for the hard case '{other}'"),
    }
}

/// Local steps: what jumps is found in a step of any length, and holes end steps.
fn linear_local_bound(case: &Case) -> f64 {
    match case.name {
        "full-u16" => 0.12,
        "marschner-lobb" => 0.016,
        "two-samples" => 9e-3,
        "bright" => 4e-3,
        "faint" => 2.7e-3,
        "anisotropy" => 2.1e-3,
        "grazing-rays" | "axis-aligned" => 1.5e-3,
        "camera-inside" | "far-origin" => 5e-4,
        "thin-shell" => 3.2e-4,
        "opaque-wall" | "many-faint-steps" => 1.2e-5,
        "missing-voxels" | "constant" => 1e-6,
        // No uniform grids: these rules refuse them.
        "level-boundary" | "uneven-axes" | "slivers" => 0.0,
        other => panic!("no bound for the hard case '{other}'"),
    }
}

fn quadratic_local_bound(case: &Case) -> f64 {
    match case.name {
        "full-u16" => 0.1,
        "two-samples" => 9e-3,
        "marschner-lobb" => 1.8e-3,
        "faint" => 5.2e-4,
        "bright" | "anisotropy" => 3e-4,
        // The field alternates from voxel to voxel, faster than long steps can see.
        "many-faint-steps" => 2.5e-4,
        // Steps are as long as beside any sharp change, and not as short as the shell is thin.
        "thin-shell" => 2e-2,
        "camera-inside" | "far-origin" | "grazing-rays" | "axis-aligned" => 1e-4,
        "opaque-wall" => 2e-6,
        "missing-voxels" | "constant" => 1e-6,
        // No uniform grids: these rules refuse them.
        "level-boundary" | "uneven-axes" | "slivers" => 0.0,
        other => panic!("no bound for the hard case '{other}'"),
    }
}

/// One parabola a cell.
fn quadratic_cells_bound(case: &Case) -> f64 {
    match case.name {
        "thin-shell" => 0.063,
        "two-samples" => 0.05,
        "full-u16" => 0.018,
        "marschner-lobb" | "bright" => 2e-3,
        "opaque-wall" => 1.4e-4,
        "far-origin" => 2e-5,
        "missing-voxels" => 1e-6,
        _ => 1.1e-5,
    }
}

fn exact_bound(case: &Case) -> f64 {
    match case.name {
        // Shaded: one gradient stands for a cell.
        "two-samples" => 0.11,
        // Frames are f32.
        _ => 1e-7,
    }
}

#[test]
fn survives_hard_cases() {
    let exact = RayCaster { precision: Precision::F64, ..cells(Rule::Exact) };
    type Bound = fn(&Case) -> f64;
    // Bounds were measured at this error.
    let local = |rule| caster(rule, Step::Local { error: Step::ERROR / 3.0 });
    let rules: [(RayCaster, Bound); 6] = [
        (caster(Rule::Linear, FINE), linear_bound),
        (caster(Rule::Quadratic, FINE), quadratic_bound),
        (local(Rule::Linear), linear_local_bound),
        (local(Rule::Quadratic), quadratic_local_bound),
        (cells(Rule::Quadratic), quadratic_cells_bound),
        (exact, exact_bound),
    ];
    for (caster, bound) in rules {
        println!("{:?}, {:?}, {:?}", caster.rule, caster.traversal, caster.step);
        let table = check::survives_hard_cases(&caster, bound, &Reference::new(1e-7));
        println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
    }
}

#[test]
fn converges_at_the_documented_orders() {
    for rule in [Rule::Linear, Rule::Quadratic] {
        let caster = RayCaster { rule, ..RayCaster::exact(1.0) };
        // Any filter, the kinks of trilinear fields among them; from two voxels on, for errors above what f32 frames can show.
        let refinement = Refinement { coarsest: 2.0, floor: 1e-7, ..Refinement::new("step", 2.0) };
        let found = check::converges(&caster, &refinement, &Effort::cases(12));
        println!("{}: {}", rule.name(), found.unwrap_or_else(|e| panic!("{e}")));
    }
}

/// The field is the height; rays go straight down.
fn height(transfer: TransferFunction) -> Scene {
    Scene::new(volume([2, 2, 11], |_, _, z| z), transfer)
}

#[test]
fn a_linear_field_is_exact_at_any_step() {
    let c = [0.9, 0.5, 0.2];
    // A jump to opacity 0.4 a unit, from 6 down to 3.3, and nothing else.
    let scene = height(transfer(&[(3.3, c, 0.0), (3.3, c, 0.4), (6.0, c, 0.4), (6.0, c, 0.0)], 1.0));
    let alpha = 1.0 - 0.6f64.powf(2.7);
    for rule in [Rule::Linear, Rule::Quadratic] {
        for step in [10.0, 3.0, 0.7] {
            let (found, _) = pixel(&caster(rule, Step::Uniform(step)), &scene, &down(0.3, 0.6));
            // The table is aligned; f32 places of values have 10⁻⁷ of the range.
            let bound = 4e-6;
            assert_close(found, [c[0] * alpha, c[1] * alpha, c[2] * alpha, alpha], bound, &format!("{rule:?} {step}"));
        }
    }
}

#[test]
fn attenuation_inside_a_step_is_part_of_it() {
    // Ten units of opacity ½: without it, one step would send out ten times as much.
    let scene = height(homogeneous(0.5));
    let alpha = 1.0 - 0.5f64.powi(10);
    for rule in [Rule::Linear, Rule::Quadratic] {
        let (found, _) = pixel(&caster(rule, Step::Uniform(64.0)), &scene, &down(0.5, 0.5));
        assert_close(found, [alpha; 4], 1e-6, &format!("{rule:?}"));
    }
}

/// Waves between 0.05 and 0.95.
fn waves(transfer: TransferFunction) -> Scene {
    let wave = |x: f64, y: f64, z: f64| 0.5 + 0.2 * (0.45 * x).sin() * (0.35 * y + 0.3).cos() + 0.25 * (0.4 * z).sin();
    Scene::new(volume([17, 15, 13], wave), transfer)
}

fn colourful() -> TransferFunction {
    transfer(&[(0.0, [0.2, 0.9, 0.1], 0.02), (0.5, [1.0, 0.4, 0.1], 0.3), (1.0, [0.3, 0.1, 0.9], 0.1)], 1.0)
}

fn opaque() -> TransferFunction {
    transfer(&[(0.3, [0.2, 0.9, 0.1], 0.0), (0.55, [1.0, 0.4, 0.1], 0.95), (0.7, [0.3, 0.1, 0.9], 1.0)], 1.0)
}

#[test]
fn tables_and_single_precision_leave_little() {
    for (name, transfer) in [("colourful", colourful()), ("opaque", opaque())] {
        let scene = waves(transfer);
        let view = oblique(&scene, 24);
        for rule in [Rule::Linear, Rule::Quadratic] {
            for step in [2.0, 1.0, 0.2] {
                let exact = RayCaster { rule, ..RayCaster::exact(step) };
                let truth = render(&exact, &scene, &view).frame;
                let error = |caster: RayCaster| max_error(&render(&caster, &scene, &view).frame, &truth);
                let table = error(RayCaster { transfer_lookup: TransferLookup::Table, ..exact.clone() });
                let single =
                    error(RayCaster { transfer_lookup: TransferLookup::Table, precision: Precision::F32, ..exact });
                println!("{name} {rule:?} {step}: table {table:.1e}, in f32 {single:.1e}");
                // What a chord makes of a colour that changes with depth falls with the cube of the step; in an opaque surface, where κ goes
                // from 0 to a wall in one or two steps that all of a ray's light comes from, with the square.
                let chords = match (name, rule) {
                    ("opaque", Rule::Linear) => 0.15 * (step / 2.0).powi(2),
                    ("opaque", _) => 0.05 * (step / 2.0).powi(2),
                    (_, Rule::Linear) => 4e-3 * (step / 2.0f64).powi(3),
                    _ => 5e-4 * (step / 2.0f64).powi(3),
                };
                assert!(table <= chords + 1e-7, "{name} {rule:?} {step}: {table}");
                // Places of values, 10⁻⁷ of the range, times the slope of κ; and 32 f32 additions a run.
                assert!(single <= chords + 2e-5, "{name} {rule:?} {step}: {single}");
            }
        }
    }
}

#[test]
fn shaded_and_modulated() {
    let shading = Shading { gradient_opacity: vec![(0.0, 0.5), (0.1, 1.5)], ..Shading::default() };
    for (rule, traversal) in
        [(Rule::Linear, Traversal::Samples), (Rule::Quadratic, Traversal::Samples), (Rule::Quadratic, Traversal::Cells)]
    {
        for compositing in [Compositing::Over, Compositing::Accumulate { level: 0.6 }] {
            let scene = Scene { shading: Some(Arc::new(shading.clone())), compositing, ..waves(colourful()) };
            let view = oblique(&scene, 12);
            let want = truth(&scene, &view);
            let error = |step| {
                let caster = RayCaster { rule, traversal, ..RayCaster::exact(step) };
                max_error(&render(&caster, &scene, &view).frame, &want)
            };
            let (coarse, fine) = (error(0.25), error(1.0 / 32.0));
            println!("{rule:?} {traversal:?} {compositing:?}: {coarse:.1e}, {fine:.1e}");
            // The gradient is taken in the middle: the square of the step, as by midpoint.
            assert!(coarse <= 2e-2 && fine <= 1e-3, "{rule:?} {compositing:?}: {coarse} {fine}");
        }
    }
}

#[test]
fn emission_alone_and_modulated() {
    let point = |v, a, e| ControlPoint { emission: Some(e), ..ControlPoint::new(v, [0.0; 3], a) };
    for opacity in [0.0, 0.3] {
        let points =
            vec![point(0.1, 0.0, [0.0; 3]), point(0.5, opacity, [0.2, 0.1, 0.0]), point(0.9, 0.0, [0.0, 0.05, 0.1])];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        for shading in
            [None, Some(Arc::new(Shading { gradient_opacity: vec![(0.05, 0.0), (0.1, 1.5)], ..Shading::default() }))]
        {
            let scene = Scene { shading: shading.clone(), ..waves(transfer.clone()) };
            let view = oblique(&scene, 12);
            let want = truth(&scene, &view);
            for classification in [TransferLookup::Exact, TransferLookup::Table] {
                let error = |rule, step| {
                    let caster = RayCaster { rule, transfer_lookup: classification, ..RayCaster::exact(step) };
                    max_error(&render(&caster, &scene, &view).frame, &want)
                };
                let (linear, quadratic) = (error(Rule::Linear, 0.125), error(Rule::Quadratic, 0.125));
                println!("opacity {opacity}, {}, {classification:?}: {linear:.1e}, {quadratic:.1e}", shading.is_some());
                assert!(linear <= 2e-3 && quadratic <= if shading.is_some() { 2e-3 } else { 5e-5 });
            }
        }
    }
}

#[test]
fn vacuum_begins_half_way_between_what_exists_and_what_does_not() {
    // Samples above 6 are missing: cells above 5 are vacuum. Steps of 0.8 from above, so that the border lies in the middle of one.
    let field = |_: f64, _: f64, z: f64| if z > 5.5 { f64::NAN } else { 1.0 };
    let scene = Scene::new(volume([2, 2, 11], field), homogeneous(0.3));
    for rule in [Rule::Linear, Rule::Quadratic] {
        let mut error = 0.0;
        for step in [0.61, 0.67, 0.73, 0.79, 0.83] {
            let (found, _) = pixel(&caster(rule, Step::Uniform(step)), &scene, &down(0.5, 0.5));
            let length = f64::from(found[3]).ln_1p().min(0.0) + (1.0 - f64::from(found[3])).ln() / 0.7f64.ln();
            // Half a step at most, and a quarter where the middle is known.
            let most = if rule == Rule::Linear { 0.5 } else { 0.25 };
            assert!((length - 5.0).abs() <= most * step + 1e-5, "{rule:?} {step}: {length}");
            error += (length - 5.0) / 5.0;
        }
        assert!(error.abs() < 0.15, "as often too long as too short: {error}");
    }
}

/// The picture's error does not depend on where rounding puts the end of a step that ends at a hole.
#[test]
fn steps_that_end_at_faces_end_where_vacuum_begins() {
    let field = |_: f64, _: f64, z: f64| if z > 5.5 { f64::NAN } else { 1.0 };
    let scene = Scene::new(volume([5, 5, 11], field), homogeneous(0.3));
    let alpha = 1.0 - 0.7f64.powi(5);
    for rule in [Rule::Linear, Rule::Quadratic] {
        let local = caster(rule, Step::Local { error: Step::ERROR });
        let casters = [
            // Steps of packets end up to a 1024th of a voxel behind a face.
            (local.clone(), 3e-4),
            (RayCaster { vector: Vector::Off, ..local }, 1e-6),
            (cells(rule), 1e-6),
            (RayCaster { precision: Precision::F64, ..cells(rule) }, 1e-7),
        ];
        for (caster, bound) in casters {
            // Beside an axis, and along one, through voxels and between them.
            for (x, y) in [(1.3, 2.6), (2.0, 2.0), (0.5, 3.0)] {
                let (found, _) = pixel(&caster, &scene, &down(x, y));
                assert_close(found, [alpha; 4], bound, &format!("{caster:?} at {x} {y}"));
            }
        }
    }
}

#[test]
fn what_does_not_go_together_is_an_error_that_names_it() {
    let scene = waves(colourful());
    let error = |caster: RayCaster, scene: &Scene| match caster.prepare(scene, &Control::default()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{caster:?} is accepted"),
    };
    let exact_on_lattice = error(caster(Rule::Exact, VOXEL), &scene);
    assert!(exact_on_lattice.contains("'rule'") && exact_on_lattice.contains("cells"), "{exact_on_lattice}");
    for rule in [Rule::Linear, Rule::Quadratic, Rule::Left] {
        let e = error(RayCaster { traversal: Traversal::Voxels, ..caster(rule, Step::Auto) }, &scene);
        assert!(e.contains("'traversal'") && e.contains("midpoint"), "{e}");
    }
    let smooth = scene.with_filter(Filter::BSpline);
    assert!(error(cells(Rule::Exact), &smooth).contains("bspline"));
    let labels = scene.with_filter(Filter::Nearest);
    assert!(error(caster(Rule::Linear, VOXEL), &labels).contains("nearest"));
    let brightest = Scene { compositing: Compositing::Maximum, ..scene };
    assert!(error(cells(Rule::Exact), &brightest).contains("maximum"));
}
