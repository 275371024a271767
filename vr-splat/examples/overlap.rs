//! Figures of `docs/figures/vr-splat.md` about errors: kernels, overlap, thickness of sheets, popping. `cargo run --release -p vr-splat --example overlap`

use std::sync::Arc;

use vr_core::Classification;
use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_physics::{Metrics, Reference};
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    kernels();
    overlap()?;
    popping()?;
    Ok(())
}

fn scene(name: &str, n: usize, opacity: f64) -> Result<Scene, Box<dyn std::error::Error>> {
    let phantom = phantom::by_name(name).ok_or("a known phantom")?;
    let mut points = phantom.transfer_points();
    points.iter_mut().for_each(|p| p.opacity *= opacity);
    let transfer = TransferFunction::new(points, OpacityRule::Power, TRANSFER_UNIT_DISTANCE)?;
    Ok(Scene::new(phantom::sample::<f32>(&*phantom, [n; 3])?.into(), transfer))
}

fn kernels() {
    println!("Σ w − 1, at most:\n\n| kernel | radius | error |\n|---|---|---|");
    for shape in Shape::ALL {
        let radii = if shape == Shape::Gaussian { vec![1.5, 2.0, 2.5, 3.0] } else { vec![shape.own_radius()] };
        for radius in radii {
            let kernel = SplatKernel { radius, ..SplatKernel::new(shape) };
            println!("| {shape:?} | {radius} | {:.1e} |", kernel.partition_error());
        }
    }
    println!();
}

/// Voxels that are classified, then spread by a kernel: κ and q are sums of kernels, everywhere.
struct SumOfKernels {
    scene: Scene,
    kernel: SplatKernel,
}

impl ContinuousModel for SumOfKernels {
    fn breakpoints(&self, ray: &Ray) -> Vec<f64> {
        let (low, high) = self.scene.volume.bounds();
        let middle = (0.5 * (low + high) - ray.origin).dot(ray.direction);
        let half = (high - low).length();
        (0..=48).map(|i| middle + half * (f64::from(i) / 24.0 - 1.0)).collect()
    }

    fn medium(&self, ray: &Ray, s: f64) -> Medium {
        let Some(volume) = self.scene.volume.grid() else { return Medium::default() };
        let AnyGrid::F32(grid) = volume.values() else { return Medium::default() };
        let (dims, reach) = (volume.dims(), self.kernel.reach());
        let at = volume.placement().to_index(ray.origin + ray.direction * s).to_array();
        let range = |a: usize| {
            let (low, high) = ((at[a] - reach[a]).ceil().max(0.0), (at[a] + reach[a]).floor());
            low as usize..if high < 0.0 { 0 } else { (high as usize + 1).min(dims[a]) }
        };
        let mut medium = Medium::default();
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let w = self.kernel.at([at[0] - x as f64, at[1] - y as f64, at[2] - z as f64]);
                    let value = f64::from(grid.samples()[(z * dims[1] + y) * dims[0] + x]);
                    let here = self.scene.transfer.at(value);
                    let kappa = w * self.scene.transfer.extinction(here.opacity);
                    medium.extinction += kappa;
                    for c in 0..3 {
                        medium.emission[c] += kappa * here.color[c];
                    }
                }
            }
        }
        medium
    }

    fn bounds(&self, _ray: &Ray, _from: f64, _to: f64) -> Option<MediumBounds> {
        None
    }
}

fn draw(renderer: &Splatter, scene: &Scene, view: &View) -> Result<Frame, RenderError> {
    let control = Control::default();
    Ok(renderer.prepare(scene, &control)?.render(view, &control)?.frame)
}

fn overlap() -> Result<(), Box<dyn std::error::Error>> {
    println!("Against the sum of the same kernels, integrated exactly (RMSE):\n");
    println!(
        "| scene | samples | axis | image 4 | image 2 | image 1 | image 0.5 | image 0.25 |\n|---|---|---|---|---|---|---|---|"
    );
    let kernel = SplatKernel::new(Shape::Gaussian);
    for (name, opacity) in [("fog", 1.0), ("hydrogen", 1.0), ("blobs", 1.0)] {
        let scene = scene(name, 24, opacity)?;
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [16; 2]);
        let model = Model::Continuous(Arc::new(SumOfKernels { scene: scene.clone(), kernel }));
        let truth = Reference::new(1e-6).solve(&scene, &view, &model, &Control::default())?;
        let truth: Vec<[f64; 4]> = truth.pixels.iter().map(|p| p.rgba).collect();
        let base = Splatter { kernel, classification: Classification::Pre, termination: 1.0, ..Splatter::default() };
        let mut row = format!("| {name} |");
        let one = |buffers| Splatter { buffers, ..base.clone() };
        let sheets = [4.0, 2.0, 1.0, 0.5, 0.25].map(|slice_spacing| Splatter { slice_spacing, ..base.clone() });
        for renderer in [one(Buffers::Samples), one(Buffers::Axis)].into_iter().chain(sheets) {
            let m = Metrics::of(&truth, draw(&renderer, &scene, &view)?.pixels());
            row += &format!(" {:.1e} ({:+.1e}) |", m.rmse, m.bias);
        }
        println!("{row}");
    }
    println!();
    Ok(())
}

fn popping() -> Result<(), Box<dyn std::error::Error>> {
    println!("RMSE from one degree to the next, about the switch of axes at 45°:\n");
    println!(
        "| buffers | 40 | 41 | 42 | 43 | 44 | 45 | 46 | 47 | 48 | 49 |\n|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let scene = scene("hydrogen", 48, 1.0)?;
    for buffers in [Buffers::Samples, Buffers::Axis, Buffers::Image] {
        let renderer = Splatter {
            buffers,
            classification: Classification::Pre,
            kernel: SplatKernel::new(Shape::Gaussian),
            ..Splatter::default()
        };
        let frame = |degrees: f64| {
            // Never at 45° itself: the switch lies between two pictures.
            let camera = Camera::framing(scene.volume.bounds(), degrees + 0.5, 0.0, None);
            draw(&renderer, &scene, &View::new(camera, [128; 2]))
        };
        let mut row = format!("| {buffers:?} |");
        let mut before = frame(39.0)?;
        for degrees in 40..50 {
            let after = frame(f64::from(degrees))?;
            let truth: Vec<[f64; 4]> = before.pixels().iter().map(|p| p.map(f64::from)).collect();
            row += &format!(" {:.2e} |", Metrics::of(&truth, after.pixels()).rmse);
            before = after;
        }
        println!("{row}");
    }
    println!();
    Ok(())
}
