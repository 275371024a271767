//! Pictures in which there is nothing to see, which is said: a person who meets one does not know why.

use vr_core::{Clip, Compositing, Frame, Rays, Scene, View};

/// Opacity from which 8 bits show nothing of what lies behind.
const OPAQUE: f32 = 1.0 - 0.5 / 255.0;

/// Returns a note on a picture that is empty or opaque all over; `None` for any other.
pub fn note(frame: &Frame, scene: &Scene, view: &View) -> Option<String> {
    let pixels = frame.pixels();
    if pixels.iter().all(|pixel| *pixel == [0.0; 4]) {
        let reason = if meets(scene, view) {
            "nothing that its rays meet is visible under this transfer function and clip"
        } else {
            "the camera misses the volume, or looks away from it"
        };
        return Some(format!("the picture is empty: {reason}"));
    }
    // Only opacity that is gathered hides something.
    let hides = matches!(scene.compositing, Compositing::Over);
    (hides && pixels.iter().all(|pixel| pixel[3] >= OPAQUE)).then(|| {
        "the picture is opaque all over: the first of the volume in each pixel hides the rest; the transfer function, a clip or --fit may show more"
            .to_owned()
    })
}

/// True if any pixel's ray meets what the clip leaves of the volume's box.
fn meets(scene: &Scene, view: &View) -> bool {
    let Ok(rays) = Rays::new(view) else { return false };
    let (low, high) = scene.volume.bounds();
    let (low, high) = view.clip.crop.map_or((low, high), |crop| (low.max(crop.0), high.min(crop.1)));
    if low.cmpgt(high).any() {
        return false;
    }
    let clip = Clip { crop: Some((low, high)), planes: view.clip.planes.clone() };
    let [width, height] = view.size;
    let at = |x: u32, y: u32| rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
    (0..height).any(|y| (0..width).any(|x| at(x, y).inside(&clip).is_some()))
}

#[cfg(test)]
mod tests {
    use vr_core::Control;

    use super::*;
    use crate::renderers;
    use crate::scene_setup::{Setup, default_scene};

    #[test]
    fn nothing_to_see_is_told_apart() {
        let quiet = crate::console::Console { quiet: true, json: false };
        let setup = Setup::of_file(&default_scene(false).unwrap(), quiet).unwrap();
        let renderer = renderers::named("raycast").unwrap();
        let noted = |change: &dyn Fn(&mut View)| {
            let mut view = View { size: [24, 24], ..setup.view.clone() };
            change(&mut view);
            let mut prepared = renderer.prepare(&setup.scene, &Control::default()).unwrap();
            let frame = prepared.render(&view, &Control::default()).unwrap().frame;
            note(&frame, &setup.scene, &view).unwrap_or_default()
        };
        assert_eq!(noted(&|_| {}), "");
        let away = noted(&|view| {
            let aside = 1e3 * (view.camera.target - view.camera.eye).any_orthogonal_vector();
            view.camera.eye += aside;
            view.camera.target += aside;
        });
        assert!(away.contains("misses the volume"), "{away}");
        let (low, _) = setup.scene.volume.bounds();
        let corner = noted(&|view| view.clip.crop = Some((low, low + 1e-3)));
        assert!(corner.contains("nothing that its rays meet") || corner.contains("misses"), "{corner}");
    }
}
