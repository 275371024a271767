//! Shading of packets, and the tables of rows by gradient that go with it.

use std::sync::Arc;

use vr_core::{Calibration, Scene};
use vr_kernels::tables::{BakedTransfer, resolves_extinction};
use vr_kernels::vector::{Modulation, OpticsTable, PacketShading, RowMixture};

/// Makes the tables of the rows of a scene's transfer function, at the places of another table, for lengths in units of `step` world units; none where it has
/// no rows. `None` if these places are too far apart to tell what a row does.
pub(super) fn row_tables(
    scene: &Scene,
    table: &BakedTransfer<f32>,
    calibration: Calibration,
    step: f64,
) -> Option<Arc<[OpticsTable]>> {
    let spacing = (table.spacing() * calibration.slope).abs();
    let rows = scene.transfer.rows().iter().map(|row| &row.transfer);
    let resolved = rows.clone().all(|transfer| resolves_extinction(transfer, spacing));
    resolved.then(|| rows.map(|transfer| OpticsTable::new(table, transfer, calibration, step)).collect())
}

/// Returns the shading of a scene for gradients along the world's axes, counted in so many values per world unit; `None` where nothing looks at gradients.
/// `tables`: those of its rows.
pub(super) fn world_shading(scene: &Scene, tables: Arc<[OpticsTable]>, unit: f64) -> Option<PacketShading> {
    let shading = scene.gradient_shading()?;
    let reflects = scene.reflection().is_some();
    let shading = PacketShading {
        modulation: Modulation::new(&shading, unit),
        rows: RowMixture::new(&scene.transfer, tables, unit),
        shading,
        lights: scene.lights.clone(),
        to_world: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        reflects,
    };
    (reflects || shading.follows_gradients()).then_some(shading)
}
