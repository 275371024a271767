//! Memory is asked for before a mesh is brought onto the screen or its cells are linked, and what does not fit is refused with what it would need.

use std::cell::Cell;

use vr_cells::{CellMarcher, CellProjector};
use vr_core::{Control, RenderError, Renderer, Scene, memory};

use crate::meshes::{mesh, transfer, view};

thread_local! {
    /// Bytes that the meter says are left: the test's own, since the meter is the process's and other tests draw meanwhile.
    static LEFT: Cell<u64> = const { Cell::new(u64::MAX) };
}

#[test]
fn what_does_not_fit_is_refused_before_it_is_made() {
    assert!(memory::set_meter(|| LEFT.get()));
    // 82,944 cells and 15,625 vertices.
    let scene = Scene::new(mesh(24, 0.2, false, |_| false).into(), transfer(0.9));
    let (view, control) = (view(30.0, 20.0, None), Control::default());
    let marcher: &dyn Renderer = &CellMarcher::default();
    for (renderer, left, refusal) in [
        // 32 bytes a vertex before the camera, and 48 on the screen.
        (marcher, 1_200_000, "the mesh of cells on the screen would need 1.2 MB"),
        // Four rows of 16 bytes a cell.
        (marcher, 5_000_000, "the links of the mesh of cells would need 5.3 MB"),
        (&CellProjector::default(), 5_000_000, "the mesh of cells on the screen would need 5.7 MB"),
    ] {
        let mut prepared = renderer.prepare(&scene, &control).unwrap();
        LEFT.set(left);
        let refused = prepared.render(&view, &control).map(drop);
        LEFT.set(u64::MAX);
        assert!(matches!(refused, Err(RenderError::Memory(_))), "{refused:?}");
        let refused = refused.unwrap_err().to_string();
        assert!(refused.starts_with(refusal), "{refused}");
        // A refusal leaves nothing behind: with the memory there, it is drawn.
        assert!(prepared.render(&view, &control).is_ok());
    }
}
