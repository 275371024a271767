//! Pixels of a phantom as the function that it is: the limit of pictures of its voxels as they become infinitely many.

use std::sync::Arc;

use vr_core::image_order::{ImageSample, trace_pixels};
use vr_core::phantom::Phantom;
use vr_core::{Control, Counts, Feature, IndexRay, Ray, RenderError, Scene, Unsupported, View};

use crate::optics::Optics;
use crate::reference::{Pixel, Reference, Solution};
use crate::solver::level;
use crate::transport::transport;
use vr_core::field::{FunctionField, FunctionLine};

impl Reference {
    /// Solves some pixels of a phantom under the transfer function of a scene, inside the box of the scene's grid, in the order given.
    ///
    /// The difference to the scene's own pixels is the error of sampling and reconstruction. Errors are estimates: bounds could only be made
    /// of the largest slope of a phantom, and would be far too wide.
    ///
    /// # Errors
    /// [`RenderError::Unsupported`] where the scene is shaded, does not integrate light, or has another kind of volume than a uniform grid;
    /// a view or scene that makes no sense, or cancellation.
    pub fn solve_phantom(
        &self,
        phantom: &Arc<dyn Phantom>,
        (scene, view): (&Scene, &View),
        pixels: &[[u32; 2]],
        control: &Control,
    ) -> Result<Solution, RenderError> {
        scene.validate()?;
        let unsupported = |feature: Feature, what: &str| Unsupported {
            renderer: "physics",
            feature,
            what: format!("{what} of a phantom without samples"),
        };
        let level = level(scene.compositing)
            .ok_or_else(|| unsupported(Feature::Compositing, "compositing other than over and accumulate"))?;
        if scene.shading.is_some() {
            return Err(unsupported(Feature::Shading, "shading").into());
        }
        if scene.transfer.has_rows() {
            return Err(unsupported(Feature::GradientOpacity, "a transfer function by gradient").into());
        }
        let volume = scene
            .volume
            .grid()
            .ok_or_else(|| unsupported(Feature::VolumeKind, "a volume that is not a uniform grid"))?;
        let field = FunctionField::of_phantom(Arc::clone(phantom));
        let layer = scene.layer(view, control)?;
        let optics = Optics::new(&scene.transfer, None);
        let trace = |(): &mut (), ray: &Ray, spot: ImageSample, counts: &mut Counts| {
            let layer = layer.as_ref();
            let far = layer.map_or(f64::INFINITY, |l| l.depth(spot.pixel));
            let part = IndexRay::new(ray, volume.placement(), volume.dims(), &view.clip, far);
            let mut pixel = part.map_or(Pixel::EMPTY, |part| {
                counts.rays += 1;
                let line = FunctionLine::new(&field, *ray, part.start + part.offset, part.end + part.offset);
                let t = transport(&line, &optics, self.tolerance(), level);
                counts.samples += t.pieces;
                Pixel::emitted(&t, 0.0)
            });
            if let Some(layer) = layer {
                pixel.rgba = layer.under(spot.pixel, pixel.rgba);
                pixel.depth = pixel.depth.min(far);
            }
            pixel
        };
        let (pixels, counts) = trace_pixels(view, pixels, control, || (), trace)?;
        Ok(Solution { pixels, counts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Certainty;
    use crate::metrics::subgrid;
    use vr_core::phantom::{self};
    use vr_core::{Camera, Compositing, Model, OpacityRule, TransferFunction};

    /// Differences to the phantom itself, at grids of 33³ and 65³ voxels.
    fn differences(name: &str) -> [f64; 2] {
        let phantom: Arc<dyn Phantom> = phantom::by_name(name).unwrap().into();
        [33, 65].map(|n| {
            let scene = phantom::sampled_scene::<f32>(&*phantom, n, 1.0).unwrap();
            let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [24, 24]);
            let (control, pixels) = (Control::default(), subgrid(12, view.size));
            let reference = Reference::new(1e-7);
            let itself = reference.solve_phantom(&phantom, (&scene, &view), &pixels, &control).unwrap();
            let sampled = reference.solve_pixels(&scene, &view, &Model::Canonical, &pixels, &control).unwrap();
            println!("{name} {n}: {:?}, {} pieces", itself.certainty(), itself.counts.samples);
            assert!(matches!(itself.certainty(), Certainty::Estimate(e) if e < 1e-6) && itself.counts.rays > 0);
            let square = |(a, b): (&Pixel, &Pixel)| (0..4).map(|c| (a.rgba[c] - b.rgba[c]).powi(2)).sum::<f64>();
            let sum: f64 = itself.pixels.iter().zip(&sampled.pixels).map(square).sum();
            (sum / (4 * pixels.len()) as f64).sqrt()
        })
    }

    #[test]
    fn sampled_phantoms_converge_to_the_function() {
        for name in ["hydrogen", "fog"] {
            let [coarse, fine] = differences(name);
            // The trilinear field is of order 2 in the spacing.
            assert!(fine > 0.0 && coarse / fine > 3.0, "{name}: {coarse:.1e}, then {fine:.1e}");
        }
    }

    #[test]
    fn what_has_no_gradient_is_not_shaded() {
        let phantom: Arc<dyn Phantom> = phantom::by_name("fog").unwrap().into();
        let grid = phantom::sample::<f32>(&*phantom, [3; 3]).unwrap();
        let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, 1.0).unwrap();
        let scene = Scene { compositing: Compositing::Maximum, ..Scene::new(grid.into(), transfer) };
        let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [2, 2]);
        let solved = Reference::default().solve_phantom(&phantom, (&scene, &view), &[[0, 0]], &Control::default());
        assert!(matches!(solved, Err(RenderError::Unsupported { .. })));
        let over = Scene { compositing: Compositing::Over, ..scene };
        let solved =
            Reference::default().solve_phantom(&phantom, (&over, &view), &[[1, 1]], &Control::default()).unwrap();
        assert!(solved.pixels[0].certainty.value() < 1e-6);
    }
}
