//! Options without effect are refused, and say what would be right.

use std::sync::Arc;

use crate::common::*;
use glam::DVec3;
use vr_core::field::FunctionField;
use vr_core::*;
use vr_raycast::RayCaster;

fn bumpy() -> Scene {
    let field = |x: f64, y: f64, z: f64| 0.5 + 0.4 * (0.9 * x).sin() * (0.7 * y + 0.2).cos() * (0.8 * z + 0.5).sin();
    let c = [1.0, 0.6, 0.2];
    Scene::new(volume([9, 10, 11], field), transfer(&[(0.3, c, 0.0), (0.6, [0.1, 0.4, 0.9], 0.3), (0.9, c, 0.6)], 1.0))
}

fn function() -> Scene {
    let bounds = (DVec3::ZERO, DVec3::splat(4.0));
    let field = FunctionField::new(bounds, |p: DVec3| 0.5 + 0.3 * (p.x + p.y).sin()).unwrap();
    Scene { volume: Volume::Field(Arc::new(field)), ..bumpy() }
}

/// Pixels, depths and counts; the reason where the scene is refused.
fn drawn(options: &Options, scene: &Scene) -> Result<String, String> {
    let control = Control::default();
    let caster = RayCaster::default().configure(options).map_err(|e| e.to_string())?;
    let mut prepared = caster.prepare(scene, &control).map_err(|e| e.to_string())?;
    let drawn = prepared.render(&oblique(scene, 16), &control).map_err(|e| e.to_string())?;
    let bits: Vec<u32> = drawn.frame.pixels().iter().flatten().map(|x| x.to_bits()).collect();
    Ok(format!("{bits:?} {:?} {:?}", drawn.frame.depth(), drawn.stats.counts))
}

#[test]
fn a_choice_that_is_not_honoured_is_refused() {
    let kind = |compositing| Scene { compositing, ..bumpy() };
    let over = bumpy();
    let set = |pairs: &[(&str, &str)]| pairs.iter().fold(Options::new(), |options, (k, v)| options.with(k, *v));
    let exact = set(&[("rule", "exact"), ("traversal", "cells")]);
    let voxels = set(&[("traversal", "voxels")]);
    for (base, key, value, scene, word) in [
        (set(&[]), "classification", OptionValue::from("table"), kind(Compositing::Maximum), "classification"),
        (set(&[]), "classification", "table".into(), kind(Compositing::Minimum), "classification"),
        (set(&[]), "classification", "table".into(), kind(Compositing::Average), "classification"),
        (set(&[]), "classification", "table".into(), kind(Compositing::First { threshold: 0.5 }), "classification"),
        (set(&[]), "rule", "linear".into(), kind(Compositing::Maximum), "rule"),
        (set(&[]), "rule", "quadratic".into(), kind(Compositing::Minimum), "rule"),
        (set(&[]), "rule", "linear".into(), kind(Compositing::Average), "rule"),
        (set(&[]), "rule", "quadratic".into(), kind(Compositing::First { threshold: 0.5 }), "rule"),
        (exact.clone(), "classification", "table".into(), over.clone(), "classification"),
        (Options::new().with("max-error", 0.1), "classification", "table".into(), over.clone(), "classification"),
        (set(&[]), "classification", "table".into(), function(), "classification"),
        (voxels, "step", OptionValue::Number(0.5), over.clone(), "traversal"),
        (exact, "step", OptionValue::Number(0.5), over, "traversal"),
    ] {
        assert!(drawn(&base, &scene).is_ok(), "{base:?}");
        let mut with = base.clone();
        with.0.insert(key.to_owned(), value);
        let refusal = drawn(&with, &scene).expect_err("it has no effect");
        assert!(refusal.contains(word), "{with:?}: {refusal}");
    }
}

/// Operators that pick or average evaluate the transfer function by default, so asking for that is allowed, and so is leaving the choice to the caster.
#[test]
fn a_choice_of_what_is_done_anyway_changes_nothing() {
    for compositing in
        [Compositing::Maximum, Compositing::Minimum, Compositing::Average, Compositing::First { threshold: 0.5 }]
    {
        let scene = Scene { compositing, ..bumpy() };
        let usual = drawn(&Options::new(), &scene).unwrap();
        for (key, value) in
            [("classification", "exact"), ("classification", "auto"), ("rule", "midpoint"), ("steps", "auto")]
        {
            assert_eq!(drawn(&Options::new().with(key, value), &scene).unwrap(), usual, "{key}={value}");
        }
    }
}

#[test]
fn a_choice_that_is_honoured_changes_the_picture() {
    let over = bumpy();
    let usual = drawn(&Options::new().with("step", 0.4), &over).unwrap();
    for (key, value) in [("classification", "exact"), ("traversal", "cells"), ("rule", "linear"), ("filter", "bspline")]
    {
        assert_ne!(drawn(&Options::new().with("step", 0.4).with(key, value), &over).unwrap(), usual, "{key}={value}");
    }
}
