//! Scenes that were once drawn wrongly, each with every renderer: drawn right, getting better as steps shrink, or refused.
//!
//! `docs/wrong-results.md` tells what was wrong with each. `VR_CASES=1 cargo test --release -p vr-benches --test all -- cases --nocapture`
//! prints what is found.

use std::path::Path;
use std::sync::Arc;

use vr_core::{Control, Model, Options, RenderError, Renderer, Scene, StudiedRenderer, View};
use vr_io::load_scene;
use vr_mesh::Surface;
use vr_physics::metrics::subgrid;
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_study::reference::ReferencePixels;
use vr_texslice::TextureSlicer;

/// Pixels along each side of a picture that are compared.
const PIXELS: u32 = 32;

/// The RMSE of the default ray caster that a scene may have where it is more than the aim of its steps.
fn documented(scene: &str) -> f64 {
    match scene {
        // Steps of a fifth, under operators of values: where a ray just meets a surface or a jump, or just not, all is at stake.
        "D6_nan_first" => 0.1,
        "modes_20039" => 0.2,
        "modes_first_shade_1040" => 5e-2,
        "D6_nan_average" => 5e-3,
        "D6_nan_maximum" => 3e-3,
        // A wall that one ray grazes, on less than a step.
        "jump_B_blue_fog_to_opaque_persp" => 1.5e-2,
        // Finite jumps between voxels of noise: each is known to a step.
        "gauss_jumps_only" => 2e-2,
        // Noise and lines from voxel to voxel, faster than what the aim was calibrated on.
        "t7_values_1e-40" | "t7_values_pm3e38" => 3.3e-3,
        "wires" => 4.5e-3,
        _ => 2.0 * vr_raycast::Step::ERROR,
    }
}

/// A scene file's scene and view, with its surface drawn.
fn load(path: &Path) -> (Scene, View) {
    let loaded = load_scene(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut scene = loaded.scene;
    if let Some(mesh) = loaded.mesh {
        scene.surfaces = Some(Arc::new(Surface { color: mesh.color, ..Surface::new(mesh.mesh) }));
    }
    (scene, loaded.view)
}

/// RMSE and largest error; `None` where the renderer refuses the scene.
fn errors(renderer: &dyn Renderer, (scene, view): (&Scene, &View), exact: &ReferencePixels) -> Option<[f64; 2]> {
    let control = Control::default();
    let drawn = renderer.prepare(scene, &control).and_then(|mut prepared| prepared.render(view, &control));
    match drawn {
        Ok(rendered) => {
            let metrics = exact.judge(&rendered.frame);
            Some([metrics.rmse, metrics.max])
        }
        Err(RenderError::Unsupported { .. }) => None,
        Err(e) => panic!("{}: {e}", renderer.name()),
    }
}

/// A renderer whose step is an option.
fn with_step(renderer: &dyn StudiedRenderer, key: &str, step: f64) -> Box<dyn StudiedRenderer> {
    renderer.with_options(&Options::new().with(key, step)).expect("a step")
}

#[test]
fn every_scene_is_drawn_right_or_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let mut paths: Vec<_> =
        std::fs::read_dir(&folder).expect("the scenes").map(|e| e.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    assert_eq!(paths.len(), 32);
    let told = std::env::var_os("VR_CASES").is_some();
    let mut wrong = Vec::new();
    for path in &paths {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let (scene, view) = load(path);
        let control = Control::default();
        let pixels = subgrid(PIXELS, view.size);
        let exact =
            ReferencePixels::solve((&scene, &view), &Model::Canonical, pixels, &control).expect("the reference");
        let drawn = (&scene, &view);

        // The default ray caster comes as near as it aims.
        let own = errors(&RayCaster::default(), drawn, &exact);
        let told_of =
            |e: Option<[f64; 2]>| e.map_or("refused".to_owned(), |[rmse, max]| format!("{rmse:.1e} (max {max:.1e})"));
        let mut line = format!("{name}: {}; raycast {}", exact.certainty_text(), told_of(own));
        if own.is_some_and(|[rmse, _]| rmse > documented(&name)) {
            wrong.push(format!("{name}: raycast {}", told_of(own)));
        }

        // The others get better as their steps shrink, down to what tables and rounding leave.
        let stepped: [(&dyn StudiedRenderer, &str); 4] = [
            (&RayCaster::default(), "step"),
            (&TextureSlicer::default(), "slice-distance"),
            (&ShearWarp::default(), "slice-distance"),
            (&Splatter::default(), "slice-distance"),
        ];
        for (renderer, key) in stepped {
            let [coarse, fine] = [1.0, 0.125].map(|step| errors(&*with_step(renderer, key, step), drawn, &exact));
            line += &format!("; {} {} -> {}", renderer.name(), told_of(coarse), told_of(fine));
            if let (Some([coarse, _]), Some([fine, max])) = (coarse, fine)
                && !(fine <= floor(&name, renderer.name()).max(0.5 * coarse) && max.is_finite())
            {
                wrong.push(format!("{name}: {} {coarse:.1e} at a step of 1, {fine:.1e} at an eighth", renderer.name()));
            }
        }
        if told {
            println!("{line}");
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The error that shorter steps do not go below.
fn floor(scene: &str, renderer: &str) -> f64 {
    match (scene, renderer) {
        // First hits on the tips of single voxels of noise: 8.5e-2 with texels of an eighth of a voxel.
        ("modes_20039", "shearwarp") => 0.2,
        // Texels are as large as voxels: shear-warp's picture is as soft as that, whatever the distance of its slices.
        (_, "shearwarp") => 0.1,
        // A surface beside missing voxels that rays graze, in pictures of few pixels.
        ("D6_nan_first", _) => 0.1,
        // One ray grazes the wall.
        ("jump_B_blue_fog_to_opaque_persp", _) => 1.5e-2,
        _ => 2e-3,
    }
}
