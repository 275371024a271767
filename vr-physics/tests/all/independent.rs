//! The reference against a second solver that shares no code with it: brute force, extrapolated, in 31 digits.
//!
//! The scenes are small and of all the kinds that have been drawn wrongly. The reference's bound must never be below the difference, and
//! it must be small nearly everywhere.

mod dd;
mod field;
mod march;
mod scenes;

use field::Field;
use march::{Answer, March};
use vr_core::{Control, Model, Scene, View};
use vr_physics::Reference;

fn brute(scene: &Scene, view: &View, pixel: [u32; 2]) -> Answer {
    let none = Answer { rgba: [0.0; 4], error: 0.0 };
    Field::new(scene, view, pixel).map_or(none, |field| March::new(scene, &field).solve(scene.compositing))
}

/// The reference's pixel and bound, the other's, and their largest difference.
fn compare(scene: &Scene, view: &View, pixel: [u32; 2]) -> ([f64; 4], f64, Answer, f64) {
    let solution = Reference::default().solve_pixels(scene, view, &Model::Canonical, &[pixel], &Control::default());
    let ours = solution.expect("a scene that can be solved").pixels[0];
    let started = std::time::Instant::now();
    let other = brute(scene, view, pixel);
    if std::env::var("SHOW").is_ok() {
        println!("brute force took {:?}", started.elapsed());
    }
    let differences = (0..4).map(|c| (ours.rgba[c] - other.rgba[c]).abs());
    let apart = differences.fold(0.0, |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(x) });
    (ours.rgba, ours.certainty.value(), other, apart)
}

#[test]
fn the_bound_is_never_below_the_difference() {
    judge(scenes::scene, 1000);
}

#[test]
fn the_bound_is_never_below_the_difference_with_rows_by_gradient() {
    judge(scenes::scene_with_rows, 300);
}

/// Compares the solvers on the scenes of `usual` seeds, or of as many from another first one as the environment says.
fn judge(scene_of: impl Fn(u64) -> (Scene, View, [u32; 2]), usual: u64) {
    let number = |name: &str, default: u64| std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(default);
    let (first, count) = (number("FIRST", 0), number("COUNT", usual));
    let (mut wrong, mut loose, mut vague, mut lit, mut worst) = (0, 0, 0, 0, 0.0f64);
    let started = std::time::Instant::now();
    for seed in first..first + count {
        let (scene, view, pixel) = scene_of(seed);
        let before = started.elapsed();
        let (ours, bound, other, apart) = compare(&scene, &view, pixel);
        let took = (started.elapsed() - before).as_secs_f64();
        if std::env::var("SHOW").is_ok() {
            println!(
                "{:#?} {:#?} {:?} {:?} {view:?}",
                scene.transfer.points(),
                scene.shading,
                scene.compositing,
                scene.volume.value_range()
            );
            println!(
                "{:?} {} {:?} {ours:?} {other:?} {bound:e}",
                scene.transfer.unit_distance(),
                scene.volume.filter().unwrap(),
                scene.transfer.rule()
            );
        }
        let size = ours.iter().copied().fold(1.0, f64::max);
        lit += usize::from(other.rgba[3] > 0.0);
        if took > 1.0 {
            println!("seed {seed}: {took:.1} s, {} {}", scene.volume.filter().unwrap(), scene.compositing.name());
        }
        let allowed = bound + other.error;
        if apart > allowed || allowed.is_nan() {
            wrong += 1;
            println!(
                "seed {seed}: {apart:e} apart, bound {bound:e}, other {:e}; {} {} shaded {}: {ours:?} {:?}",
                other.error,
                scene.volume.filter().unwrap(),
                scene.compositing.name(),
                scene.shading.is_some(),
                other.rgba
            );
        }
        if other.error > 1e-9 {
            vague += 1;
        } else if bound > 1e-6 * size {
            loose += 1;
            if std::env::var("LOOSE").is_ok() {
                println!(
                    "seed {seed}: bound {bound:e}, apart {apart:e} {} {} shaded {}",
                    scene.volume.filter().unwrap(),
                    scene.compositing.name(),
                    scene.shading.is_some()
                );
            }
        } else {
            worst = worst.max(apart / size);
        }
    }
    println!(
        "{count} scenes, {lit} lit: {wrong} wrong, {loose} bounds above 1e-6, {vague} not told by brute force; largest difference {worst:e}"
    );
    assert_eq!(wrong, 0);
    assert!(lit as u64 > count / 4, "{lit} lit");
}
