//! Renderers that the module has.

use vr_cells::CellMarcher;
use vr_core::{Scene, Volume};
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_view::session::RendererList;

/// The renderers of the module: of each kind of volume one at least. What is not among them makes the module smaller.
pub fn renderers() -> RendererList {
    RendererList {
        all: vec![
            Box::new(RayCaster::default()),
            Box::new(ShearWarp::default()),
            Box::new(Splatter::default()),
            Box::new(CellMarcher::default()),
        ],
        usual,
    }
}

/// Name of the renderer that draws a scene where no other is named.
fn usual(scene: &Scene) -> &'static str {
    match &scene.volume {
        // No ray caster finds the few points, of all, that a ray meets.
        Volume::Points(_) => "splat",
        Volume::Cells(_) => "march",
        _ => "raycast",
    }
}
