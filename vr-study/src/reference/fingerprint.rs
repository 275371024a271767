//! Fingerprint, in 32 bytes, of everything that reference pixels depend on.

use sha2::{Digest, Sha256};
use vr_core::{Control, Model, Scene, View};
use vr_io::volume_hash;

/// Version of the cache: raised with every change of the file format, of the hash, or of the reference's results.
const VERSION: u32 = 7;

/// Returns the hash of everything that pixels of a view depend on: values and their placement, filter, transfer function, shading and
/// lights, surfaces, compositing, view, and which pixels; `None` for models that cannot be told apart.
pub(crate) fn fingerprint(
    (scene, view): (&Scene, &View),
    model: &Model,
    pixels: &[[u32; 2]],
    tolerance: f64,
) -> Option<[u8; 32]> {
    // What makes a field of the values.
    let model = match (model, scene.volume.filter(), scene.volume.rectilinear()) {
        (Model::Canonical, Some(filter), _) => format!("{filter:?}"),
        (Model::Canonical, None, Some(grid)) => format!("{:?}", grid.gradient_method()),
        (Model::Canonical, None, None) => String::new(),
        (Model::Filtered(filter), ..) => format!("{filter:?}"),
        _ => return None,
    };
    let volume = volume_hash(&scene.volume)?;
    let text = format!("{VERSION} {volume} {tolerance:e} {model} {pixels:?} {}", described(scene, view)?);
    Some(Sha256::digest(text).into())
}

/// Returns a hash, in hexadecimal, of everything that a frame depends on but its volume, for which `volume` stands (a [`vr_io::volume_hash`]), and
/// its renderer, for which `renderer` does; `None` for surfaces that cannot be drawn, or stand in light that is scattered.
pub fn frame_fingerprint((scene, view): (&Scene, &View), volume: &str, renderer: &str) -> Option<String> {
    let filter = scene.volume.filter();
    let text = format!("{volume} {filter:?} {renderer:?} {:?} {}", scene.background, described(scene, view)?);
    Some(hexadecimal(&Sha256::digest(text)))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns scene and view without the volume. The shortest digits that give a float back: two texts are equal where the numbers are.
fn described(scene: &Scene, view: &View) -> Option<String> {
    // Scattered light also meets the sides of surfaces that the layer does not show.
    if scene.scattering.is_some() && scene.surfaces.is_some() {
        return None;
    }
    let layer = scene.layer(view, &Control::default()).ok()?;
    let rows = if scene.transfer.has_rows() { format!(" {:?}", scene.transfer.rows()) } else { String::new() };
    Some(format!(
        "{}{rows} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        env!("CARGO_PKG_VERSION"),
        scene.transfer.points(),
        (scene.transfer.rule(), scene.transfer.unit_distance()),
        scene.shading.as_ref().map(|shading| (shading, &scene.lights)),
        scene.scattering.as_ref().map(|scattering| (scattering, &scene.lights)),
        scene.compositing,
        view.camera,
        view.size,
        view.supersampling,
        view.clip,
        layer.as_ref().map(|layer| &layer.pixels),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::order_scenes;
    use crate::subject::phantom_subject;
    use std::sync::Arc;
    use vr_core::{Compositing, Filter, GradientMethod, TransferFunction};

    #[test]
    fn whatever_changes_a_pixel_changes_the_fingerprint() {
        let subject = phantom_subject("fog", 4, [3, 3]).unwrap();
        let (scene, view) = (subject.scene, subject.view);
        let all = vec![[0, 0], [2, 1]];
        let of = |scene: &Scene, view: &View, model: &Model, pixels: &[[u32; 2]], tolerance: f64| {
            fingerprint((scene, view), model, pixels, tolerance).unwrap()
        };
        let own = of(&scene, &view, &Model::Canonical, &all, 1e-10);
        // The same data elsewhere in memory.
        let again = phantom_subject("fog", 4, [3, 3]).unwrap();
        assert_eq!(own, of(&again.scene, &again.view, &Model::Filtered(Filter::Trilinear), &all, 1e-10));

        let other_samples = phantom_subject("hydrogen", 4, [3, 3]).unwrap().scene.volume;
        let mut points = scene.transfer.points().to_vec();
        points[0].opacity += 1e-15;
        let transfer = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance()).unwrap();
        let scenes = [
            Scene { volume: other_samples, ..scene.clone() },
            scene.with_filter(Filter::BSpline),
            Scene { compositing: Compositing::Maximum, ..scene.clone() },
            Scene { transfer: Arc::new(transfer), ..scene.clone() },
        ];
        let views = [
            View { size: [3, 4], ..view.clone() },
            View { supersampling: 2, ..view.clone() },
            View { camera: view.camera.orbit(1e-9, 0.0), ..view.clone() },
        ];
        let mut seen = vec![own];
        seen.extend(scenes.iter().map(|s| of(s, &view, &Model::Canonical, &all, 1e-10)));
        seen.extend(views.iter().map(|v| of(&scene, v, &Model::Canonical, &all, 1e-10)));
        seen.push(of(&scene, &view, &Model::Filtered(Filter::CatmullRom), &all, 1e-10));
        seen.push(of(&scene, &view, &Model::Canonical, &all[..1], 1e-10));
        seen.push(of(&scene, &view, &Model::Canonical, &all, 1e-9));
        // Volumes that are no uniform grids.
        let uneven = order_scenes::uneven(3);
        let volume = uneven.volume.with_gradient(GradientMethod::Analytic);
        let others = [uneven.clone(), Scene { volume, ..uneven }, order_scenes::adaptive()];
        seen.extend(others.iter().map(|s| of(s, &view, &Model::Canonical, &all, 1e-10)));
        let different: std::collections::BTreeSet<_> = seen.iter().collect();
        assert_eq!(different.len(), seen.len());

        // Frames, whose volumes are told apart by a hash of their own.
        let frame = |scene: &Scene, view: &View, renderer: &str| {
            frame_fingerprint((scene, view), &volume_hash(&scene.volume).unwrap(), renderer).unwrap()
        };
        let own = frame(&scene, &view, "raycast");
        assert_eq!(own, frame(&again.scene, &again.view, "raycast"));
        let mut seen = vec![own, frame(&scene, &view, "splat")];
        seen.extend(scenes.iter().map(|s| frame(s, &view, "raycast")));
        seen.extend(views.iter().map(|v| frame(&scene, v, "raycast")));
        seen.push(frame(&Scene { background: [0.5; 3], ..scene.clone() }, &view, "raycast"));
        let different: std::collections::BTreeSet<_> = seen.iter().collect();
        assert_eq!(different.len(), seen.len());
    }
}
