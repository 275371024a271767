//! Lists the options that a renderer takes and that change nothing in scenes of a kind: neither pixels nor depths nor counts nor stages of the work.
//!
//! An option without effect is to be refused. What may stand here is what changes time or memory alone (vector, budget), or what by chance
//! changes nothing in these scenes. `cargo run --release -p vr-benches --example idle_options`; with `all`, at every documented setting, in minutes.

use std::collections::BTreeMap;
use std::sync::Arc;

use vr_core::{
    Camera, Compositing, Control, OptionKind, OptionSpec, OptionValue, Options, Scene, Shading, StudiedRenderer, View,
    phantom,
};

/// Kinds of scene, with a few scenes each. An option has no effect on a kind if it changes none of its scenes.
fn kinds() -> Vec<(&'static str, Vec<(Scene, View)>)> {
    let scenes = || ["blobs", "shells", "shepp-logan"].map(|name| phantom::by_name(name).unwrap().scene(20).unwrap());
    let view = |scene: &Scene, fov| View::new(Camera::framing(scene.bounds(), 30.0, 20.0, fov), [40, 40]);
    let kind = |change: &dyn Fn(Scene) -> Scene, fov| {
        scenes().map(change).into_iter().map(|scene| (view(&scene, fov), scene)).map(|(v, s)| (s, v)).collect()
    };
    let composited = |compositing| move |scene| Scene { compositing, ..scene };
    let shaded = |scene| Scene { shading: Some(Arc::new(Shading::default())), ..scene };
    vec![
        ("over", kind(&|scene| scene, None)),
        ("perspective", kind(&|scene| scene, Some(30.0))),
        ("shaded", kind(&shaded, None)),
        ("accumulate", kind(&composited(Compositing::Accumulate { level: 0.5 }), None)),
        ("first", kind(&composited(Compositing::First { threshold: 0.4 }), None)),
        ("average", kind(&composited(Compositing::Average), None)),
        ("maximum", kind(&composited(Compositing::Maximum), None)),
        ("minimum", kind(&composited(Compositing::Minimum), None)),
    ]
}

/// Values to try for an option.
fn others(spec: &OptionSpec) -> Vec<OptionValue> {
    match &spec.kind {
        OptionKind::Switch => [true, false].map(OptionValue::Switch).to_vec(),
        OptionKind::Choice(words) => words.iter().map(|&word| OptionValue::Word(word.to_owned())).collect(),
        OptionKind::Number(range) => {
            let tried = [0.0, 1e-3, 0.3, 0.9, 2.5, 3.0, 8.0, 16.0, 512.0];
            tried.into_iter().filter(|&x| range.contains(x)).map(OptionValue::Number).collect()
        }
    }
}

/// Returns all that a frame tells except times: pixels, depths, counts, and the stages of the work. `None` if a scene is refused.
fn told(renderer: &dyn StudiedRenderer, scenes: &[(Scene, View)]) -> Option<Vec<String>> {
    let control = Control::default();
    scenes
        .iter()
        .map(|(scene, view)| {
            renderer.supports(scene, Some(view)).ok()?;
            let drawn = renderer.prepare(scene, &control).ok()?.render(view, &control).ok()?;
            let bits: Vec<u32> = drawn.frame.pixels().iter().flatten().map(|x| x.to_bits()).collect();
            let stages: Vec<&str> = drawn.stats.stages.iter().map(|(stage, _)| *stage).collect();
            Some(format!("{bits:?} {:?} {:?} {stages:?}", drawn.frame.depth(), drawn.stats.counts))
        })
        .collect()
}

fn main() {
    let every_setting = std::env::args().nth(1).is_some_and(|word| word == "all");
    let renderers: Vec<Box<dyn StudiedRenderer>> = vec![
        Box::new(vr_raycast::RayCaster::default()),
        Box::new(vr_shearwarp::ShearWarp::default()),
        Box::new(vr_texslice::TextureSlicer::default()),
        Box::new(vr_splat::Splatter::default()),
    ];
    let mut idle = BTreeMap::<String, Vec<String>>::new();
    for renderer in &renderers {
        for (kind, scenes) in kinds() {
            let mut bases = vec![("default".to_owned(), Options::new())];
            if every_setting {
                bases.extend(renderer.settings().into_iter().map(|s| (s.name, s.options)));
            }
            for (base, options) in bases {
                let Ok(made) = renderer.with_options(&options) else { continue };
                let Some(plain) = told(&*made, &scenes) else { continue };
                for spec in renderer.option_specs() {
                    let usual = options.0.get(spec.key).unwrap_or(&spec.default).clone();
                    // Draws with each other value that is taken.
                    let (mut changes, mut taken) = (false, Vec::new());
                    for value in others(&spec).into_iter().filter(|value| *value != usual) {
                        let mut with = options.clone();
                        with.0.insert(spec.key.to_owned(), value.clone());
                        let Ok(made) = renderer.with_options(&with) else { continue };
                        let Some(other) = told(&*made, &scenes) else { continue };
                        changes |= other != plain;
                        taken.push(value.to_string());
                    }
                    if !changes && !taken.is_empty() {
                        let key = format!("{} {} ({})", renderer.name(), spec.key, taken.join("|"));
                        idle.entry(key).or_default().push(format!("{kind}/{base}"));
                    }
                }
            }
        }
    }
    for (option, places) in &idle {
        println!("{option}: {} places: {}", places.len(), places.join(", "));
    }
}
