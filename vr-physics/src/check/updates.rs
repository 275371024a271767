//! Scenes that change one field at a time.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Compositing, Control, Filter, Light, RenderError, Renderer, Scene, Shading};

use super::drawn::draw;
use super::effort::{Effort, Verdict};
use super::fixed_layer::FixedLayer;
use super::invariants::identical;
use super::outcome::{CheckFailure, Report};
use super::test_scene::TestScene;
use super::transformed::{quarter_turned, scaled_world, with_emission_times};

/// After an update to a scene of another transfer function, filter, shading, lights, surfaces, compositing or volume, the picture is the one that a
/// fresh preparation makes, to the last bit; and what a fresh preparation refuses is refused. The fields change one after the other,
/// away from the scene and back to it.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn update_is_prepare(renderer: &dyn Renderer, effort: &Effort) -> Result<Report, CheckFailure> {
    let control = Control::default();
    effort.over("an update is a new preparation", renderer, effort.any_scene(), |test| {
        let mut prepared = renderer.prepare(&test.scene, &control)?;
        prepared.render(&test.view, &control)?;
        // The scene itself comes again and again.
        let own = draw(renderer, test, &control)?;
        for (what, scene) in changes(test) {
            let changed = TestScene { scene, view: test.view.clone() };
            let fresh = if what == OWN { Ok(own.clone()) } else { draw(renderer, &changed, &control) };
            let updated =
                prepared.update(&changed.scene, &control).and_then(|()| prepared.render(&changed.view, &control));
            match (fresh, updated) {
                (Ok(fresh), Ok(updated)) => {
                    if let Verdict::Broken(reason) = identical(&fresh, &updated.frame, what) {
                        return Ok(Verdict::Broken(reason));
                    }
                }
                // What is left of a scene after a refusal is the renderer's own: it starts again.
                (Err(RenderError::Unsupported { .. }), Err(RenderError::Unsupported { .. })) => {
                    prepared = renderer.prepare(&test.scene, &control)?;
                }
                (Err(RenderError::Unsupported(refused)), Ok(_)) => {
                    return Ok(Verdict::Broken(format!(
                        "{what}: drawn, though a new preparation refuses {}",
                        refused.what
                    )));
                }
                (Ok(_), Err(e)) => return Ok(Verdict::Broken(format!("{what}: {e}, though a new preparation draws"))),
                (Err(e), _) => return Ok(Verdict::Broken(format!("{what}: {e}"))),
            }
        }
        Ok(Verdict::Held { measured: 0.0, allowed: 0.0 })
    })
}

/// The scene itself, among its changes.
const OWN: &str = "after changes, and back";

/// The scene with one field changed after the other, itself in between.
fn changes(test: &TestScene) -> Vec<(&'static str, Scene)> {
    let scene = &test.scene;
    let (low, high) = scene.volume.value_range().unwrap_or((0.0, 1.0));
    let light = |direction| Light { direction, color: [0.9, 0.5, 0.2] };
    let shaded = |specular, direction| Scene {
        shading: Some(Arc::new(Shading { specular, ..Shading::default() })),
        lights: vec![light(direction)],
        ..scene.clone()
    };
    let composited = |compositing| Scene { compositing, ..scene.clone() };
    let filtered = |filter| scene.with_filter(filter);
    let middle = (0.5 * (scene.volume.bounds().0 + scene.volume.bounds().1) - test.view.camera.eye).length() as f32;
    let walled = FixedLayer::new(&test.view, |i| ([0.2, 0.4, 0.6], if i % 3 == 0 { f32::INFINITY } else { middle }));
    let own = || (OWN, scene.clone());
    vec![
        ("after another transfer function", with_emission_times(test, |i| 0.5 * (i + 1) as f64).scene),
        ("after another unit distance", {
            let s = scaled_world(test, 2.0).scene;
            Scene { volume: scene.volume.clone(), ..s }
        }),
        own(),
        ("after shading by a headlight", shaded(0.3, None)),
        ("after shading by another light", shaded(0.0, Some(DVec3::new(0.3, -0.5, 0.8)))),
        ("after the same shading by yet another light", shaded(0.0, Some(DVec3::new(-0.8, 0.1, 0.4)))),
        ("after no shading", Scene { shading: None, ..scene.clone() }),
        own(),
        ("after the mean", composited(Compositing::Average)),
        ("after the maximum", composited(Compositing::Maximum)),
        ("after the minimum", composited(Compositing::Minimum)),
        ("after a level", composited(Compositing::Accumulate { level: 0.4 })),
        ("after the first point", composited(Compositing::First { threshold: 0.5 * (low + high) })),
        ("after over", composited(Compositing::Over)),
        own(),
        ("after the nearest sample", filtered(Filter::Nearest)),
        ("after the B-spline", filtered(Filter::BSpline)),
        ("after trilinear interpolation", filtered(Filter::Trilinear)),
        own(),
        ("after a surface", walled.among(scene)),
        ("after no surface", Scene { surfaces: None, ..scene.clone() }),
        own(),
        ("after a volume that lies otherwise", quarter_turned(test, 0).scene),
        ("after a volume in another place", Scene { volume: scaled_world(test, 2.0).scene.volume, ..scene.clone() }),
        own(),
    ]
}
