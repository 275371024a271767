//! Figures of `docs/figures/vr-texslice.md`: errors of formats and distances, the thin shell, orders, compression, and what skipping saves.
//!
//! `cargo run --release -p vr-texslice --example figures`

use vr_core::phantom::{self};
use vr_core::*;
use vr_physics::{Metrics, Reference, fit_order};
use vr_texslice::{Format, Proxy, TextureSlicer};

fn phantom_scene(name: &str, n: usize) -> Scene {
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, n, 1.0).expect("a valid size")
}

/// A smooth field of floats under a smooth transfer function, or one that jumps.
fn waves(jumps: bool) -> Scene {
    let n = 17;
    let wave = |i: usize| {
        let [x, y, z] = [i % n, i / n % n, i / (n * n)].map(|k| k as f64);
        (0.5 + 0.2 * libm::sin(0.5 * x) * libm::cos(0.4 * y + 0.3) + 0.25 * libm::sin(0.45 * z)) as f32
    };
    let placement = Placement::from_spacing([1.0; 3]).expect("a placement");
    let grid =
        UniformGrid::new([n; 3], (0..n * n * n).map(wave).collect::<Vec<_>>(), placement, Calibration::default());
    let smooth = vec![ControlPoint::new(0.0, [0.2, 0.9, 0.1], 0.02), ControlPoint::new(1.0, [1.0, 0.1, 0.6], 0.20)];
    let steps = [(0.4, 0.0), (0.4, 0.3), (0.6, 0.3), (0.6, 0.05)];
    let jumping = steps.map(|(v, a)| ControlPoint::new(v, [1.0, 0.5, 0.2], a)).to_vec();
    let (points, rule) = if jumps { (jumping, OpacityRule::Power) } else { (smooth, OpacityRule::Extinction) };
    Scene::new(grid.expect("a grid").into(), TransferFunction::new(points, rule, 1.0).expect("valid points"))
}

fn view(scene: &Scene, fov: Option<f64>, side: u32) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, fov), [side; 2])
}

fn truth(scene: &Scene, view: &View) -> Vec<[f64; 4]> {
    let solution = Reference::new(1e-8).solve(scene, view, &Model::Canonical, &Control::default());
    solution.expect("a view that it can solve").pixels.iter().map(|p| p.rgba).collect()
}

fn error(renderer: &TextureSlicer, scene: &Scene, view: &View, truth: &[[f64; 4]]) -> (Metrics, Counts) {
    let control = Control::default();
    let drawn = renderer.prepare(scene, &control).and_then(|mut p| p.render(view, &control)).expect("can be drawn");
    (Metrics::of(truth, drawn.frame.pixels()), drawn.stats.counts)
}

fn main() {
    let brute = TextureSlicer::brute_force();
    let with = |format, proxy, slice_spacing| TextureSlicer { format, proxy, slice_spacing, ..brute.clone() };

    println!("Orders of convergence: RMSE at slices 1, ½, ¼, ⅛, 1/16 of a voxel apart, and the order fitted to it.\n");
    println!("| scene | setting | RMSE | order |\n|---|---|---|--:|");
    for (name, jumps) in [("smooth", false), ("jumps", true)] {
        let scene = waves(jumps);
        for fov in [None, Some(40.0)] {
            let view = view(&scene, fov, 24);
            let truth = truth(&scene, &view);
            for (label, format, proxy) in [
                ("planes", Format::Scalar, Proxy::Planes),
                ("shells", Format::Scalar, Proxy::Shells),
                ("pre-integrated", Format::PreIntegrated, Proxy::Planes),
            ] {
                let steps = [1.0, 0.5, 0.25, 0.125, 0.0625];
                let errors = steps.map(|d| error(&with(format, proxy, d), &scene, &view, &truth).0.rmse);
                let listed = errors.map(|e| format!("{e:.1e}")).join(", ");
                let order = fit_order(&steps, &errors);
                let kind = if fov.is_some() { "perspective" } else { "parallel" };
                println!("| {name} | {label}, {kind} | {listed} | {order:.2} |");
            }
        }
    }

    println!("\nErrors by texture and distance, parallel: RMSE (largest), 64³ bytes, 64² rays.\n");
    println!("| scene | setting | 2 | 1 | ½ | ¼ |\n|---|---|--:|--:|--:|--:|");
    for name in ["fog", "hydrogen", "blobs", "shells"] {
        let scene = phantom_scene(name, 64);
        let view = view(&scene, None, 64);
        let truth = truth(&scene, &view);
        for (label, format, proxy) in [
            ("scalar", Format::Scalar, Proxy::Planes),
            ("pre-integrated", Format::PreIntegrated, Proxy::Planes),
            ("compressed", Format::Compressed, Proxy::Planes),
            ("rgba", Format::Rgba, Proxy::Planes),
            ("stacks", Format::Scalar, Proxy::Stacks),
        ] {
            let cells = [2.0, 1.0, 0.5, 0.25].map(|d| {
                let (m, _) = error(&with(format, proxy, d), &scene, &view, &truth);
                format!("{:.1e} ({:.0e})", m.rmse, m.max)
            });
            println!("| {name} | {label} | {} |", cells.join(" | "));
        }
    }

    println!("\nFragments drawn of all, slices ½ voxel apart, 64³ bytes, 256² rays.\n");
    println!("| scene | blocks skipped | and ended at 0.9999 |\n|---|--:|--:|");
    for name in ["fog", "hydrogen", "blobs", "shells"] {
        let scene = phantom_scene(name, 64);
        let view = view(&scene, None, 256);
        let drawn = |renderer: &TextureSlicer| {
            let control = Control::default();
            let picture = renderer.prepare(&scene, &control).and_then(|mut p| p.render(&view, &control));
            picture.expect("can be drawn").stats.counts.samples as f64
        };
        let all = drawn(&brute);
        let skipping = drawn(&TextureSlicer { skip_empty_space: true, ..brute.clone() }) / all;
        let ending = drawn(&TextureSlicer::default()) / all;
        println!("| {name} | {:.0} % | {:.0} % |", 100.0 * skipping, 100.0 * ending);
    }
}
