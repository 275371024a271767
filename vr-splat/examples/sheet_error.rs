//! Figures of `docs/figures/vr-splat.md` about sheets of values by kernel: RMSE of sheets 2, 1, ½ and ¼ voxels apart against sheets of a 32nd of one.
//! `cargo run --release -p vr-splat --example sheet_error`

use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_physics::Metrics;
use vr_splat::{Shape, SplatKernel, Splatter};

/// Voxels along each axis, and pixels along each edge of the picture.
const SIDE: usize = 48;
const PIXELS: u32 = 128;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("| scene, kernel | 2 | 1 | 0.5 | 0.25 |\n|---|---|---|---|---|");
    for name in ["fog", "hydrogen", "blobs"] {
        let phantom = phantom::by_name(name).ok_or("a known phantom")?;
        let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE)?;
        let scene = Scene::new(phantom::sample::<f32>(&*phantom, [SIDE; 3])?.into(), transfer);
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [PIXELS; 2]);
        for (shape, kernel_name) in
            [(Shape::Bilinear, "bilinear"), (Shape::Gaussian, "Gaussian"), (Shape::Cone, "cone")]
        {
            let frame = |slice_spacing: f64| -> Result<Frame, RenderError> {
                let kernel = SplatKernel::new(shape);
                let renderer = Splatter { slice_spacing, kernel, termination: 1.0, ..Splatter::default() };
                let control = Control::default();
                Ok(renderer.prepare(&scene, &control)?.render(&view, &control)?.frame)
            };
            let truth: Vec<[f64; 4]> = frame(1.0 / 32.0)?.pixels().iter().map(|p| p.map(f64::from)).collect();
            let mut row = format!("| {name}, {kernel_name} |");
            for slice_spacing in [2.0, 1.0, 0.5, 0.25] {
                row += &format!(" {:.1e} |", Metrics::of(&truth, frame(slice_spacing)?.pixels()).rmse);
            }
            println!("{row}");
        }
    }
    Ok(())
}
