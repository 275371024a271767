//! Reference of scenes that scatter: means over random paths, whose noise is known.

use vr_core::clock::Instant;
use vr_core::{Control, RenderError, Renderer, Scene, View};
use vr_light::{LightRenderer, LightScene, PathTracer};

use super::ReferencePixels;

/// Seed above the 32 bits of a renderer's: reference and picture are independent.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;
/// Paths of all pixels together.
const PATHS: u64 = 1 << 22;
/// Smallest and largest number of paths of a pixel.
const PATHS_OF_PIXEL: [u64; 2] = [256, 4096];

/// Draws pixels of a view by random paths, with light that is scattered any number of times.
pub(super) fn solve(
    (scene, view): (&Scene, &View),
    pixels: Vec<[u32; 2]>,
    control: &Control,
) -> Result<ReferencePixels, RenderError> {
    let start = Instant::now();
    LightRenderer::default().supports(scene, Some(view))?;
    let [least, most] = PATHS_OF_PIXEL;
    let paths = (PATHS / pixels.len().max(1) as u64).clamp(least, most);
    let lit = LightScene::of_scene(scene, &view.clip)?;
    let film = PathTracer::new(&lit, SEED).trace_pixels(view, &pixels, paths, control)?;
    let of_each = |number: &dyn Fn(usize, usize) -> f64| -> Vec<[f64; 4]> {
        (0..pixels.len()).map(|pixel| std::array::from_fn(|channel| number(pixel, channel))).collect()
    };
    let means = of_each(&|pixel, channel| film.mean(pixel, channel));
    let errors = of_each(&|pixel, channel| film.standard_error(pixel, channel));
    Ok(ReferencePixels::of_means(pixels, means, errors, start.elapsed()))
}

#[cfg(test)]
mod tests {
    use vr_core::Model;

    use super::*;
    use crate::subject::phantom_subject;

    #[test]
    fn pictures_by_random_paths_err_by_their_noise() {
        let mut subject = phantom_subject("fog", 8, [12, 9]).unwrap();
        subject.scene.scattering = Some(Default::default());
        let (view, control) = ((&subject.scene, &subject.view), Control::default());
        let solve = |pixels| ReferencePixels::solve(view, &Model::Canonical, pixels, &control).unwrap();
        let all = solve(vr_physics::metrics::subgrid(u32::MAX, [12, 9]));
        // Some pixels are those of the whole picture.
        let some = solve(vec![[3, 4], [7, 2]]);
        assert_eq!(some.rgba(), [all.rgba()[4 * 12 + 3], all.rgba()[2 * 12 + 7]]);
        let renderer = LightRenderer { paths: 64, ..LightRenderer::default() };
        let mut prepared = renderer.prepare(&subject.scene, &control).unwrap();
        let frame = prepared.render(&subject.view, &control).unwrap().frame;
        let account = all.noise_account(&frame).unwrap();
        // 108 pixels tell the noise within a third: three standard deviations of a mean of so many squares that spread as those of a normal
        // distribution do, and more than that where few pixels have most of the noise.
        let noise = account.picture_noise.unwrap();
        assert!((account.rmse / noise - 1.0).abs() < 0.33, "{account:?}");
        // 4096 paths against 64.
        assert!((account.reference_noise / noise / 0.125 - 1.0).abs() < 0.33, "{account:?}");
    }
}
