//! Pictures against the renderer's own model, summed in f64: what is left is rounding and tables.

use vr_core::{Classification, Control, Renderer, Scene, Shading};
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, CompositingOrder, Shape, SplatKernel, Splatter};

fn scenes() -> Vec<(&'static str, Scene)> {
    vec![
        ("fog u8", phantom_scene::<u8>("fog", 24, 1.0)),
        ("hydrogen f32", phantom_scene::<f32>("hydrogen", 24, 0.1)),
        ("marschner-lobb", phantom_scene::<f32>("marschner-lobb", 24, 1.0)),
        ("blobs i16", phantom_scene::<i16>("blobs", 24, 1.0)),
        ("shaded", Scene { shading: Some(Shading::default().into()), ..phantom_scene::<u16>("fog", 24, 1.0) }),
    ]
}

fn renderers() -> Vec<(String, Splatter)> {
    let mut all = Vec::new();
    for shape in Shape::ALL {
        for classification in [Classification::Post, Classification::Pre] {
            for buffers in [Buffers::Image, Buffers::Axis, Buffers::Samples] {
                let kernel = SplatKernel::new(shape);
                let one = Splatter { buffers, classification, kernel, termination: 1.0, ..Splatter::default() };
                all.push((format!("{shape:?} {classification:?} {buffers:?}"), one));
            }
        }
    }
    let axis = Splatter { buffers: Buffers::Axis, termination: 1.0, ..Splatter::default() };
    all.push(("back to front".to_owned(), Splatter { order: CompositingOrder::BackToFront, ..axis.clone() }));
    all.push(("axis of values".to_owned(), axis));
    all.push(("thin".to_owned(), Splatter { slice_spacing: 0.3, termination: 1.0, ..Splatter::default() }));
    all
}

#[test]
fn pictures_are_what_the_model_sums() {
    for (name, scene) in scenes() {
        for (how, renderer) in renderers() {
            for (azimuth, elevation, fov) in [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
                // Along an axis, one scene tells.
                if azimuth == 0.0 && name != "hydrogen f32" {
                    continue;
                }
                if renderer.prepare(&scene, &Control::default()).is_err() {
                    assert!(
                        name == "shaded" && renderer.classification == Classification::Pre || how.contains("Samples")
                    );
                    continue;
                }
                let view = view(&scene, azimuth, elevation, fov, 7);
                let m = error_of_model(&renderer, &scene, &view);
                println!("{name:<16} {how:<30} {azimuth:>5} {fov:?}: max {:.1e} RMSE {:.1e}", m.max, m.rmse);
                // Rounding in f32 and tables leave 10⁻⁵; rules for B-splines and sincs a little more, and normals turn fast where gradients are small.
                let allowed = if name == "shaded" { 2e-4 } else { 7e-5 };
                assert!(m.max < allowed, "{name}, {how}: {m}");
            }
        }
    }
}
