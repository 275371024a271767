//! A uniform grid as a mesh of cells.

use glam::DVec3;

use super::error::CellError;
use super::mesh::{CellMesh, CellValues};
use super::split::Shape;
use crate::grid_volume::GridVolume;
use crate::voxel::Voxel;
use crate::with_grid;

impl CellMesh {
    /// The mesh of six tetrahedra for each cell of a grid, with the values of its voxels, whatever its filter. In a cell the two fields differ as
    /// linear interpolation in tetrahedra differs from trilinear interpolation.
    ///
    /// # Errors
    /// [`CellError`] for more voxels than a mesh may have vertices, or values none of which is finite.
    ///
    /// # Examples
    /// ```
    /// use vr_core::{Calibration, CellMesh, Filter, GridVolume, Placement, UniformGrid};
    ///
    /// let grid = UniformGrid::new([3; 3], vec![1u8; 27], Placement::from_spacing([1.0; 3])?, Calibration::default())?;
    /// assert_eq!(CellMesh::of_grid(&GridVolume::new(grid.into(), Filter::default()))?.cells().len(), 6 * 8);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_grid(grid: &GridVolume) -> Result<Self, CellError> {
        let ([nx, ny, nz], placement, calibration) = (grid.dims(), grid.placement(), grid.calibration());
        let count = nx * ny * nz;
        if u32::try_from(count.saturating_mul(6)).is_err() {
            return Err(CellError::TooMany { what: "cells", found: count.saturating_mul(6) });
        }
        let mut vertices = Vec::with_capacity(count);
        for z in 0..nz {
            for y in 0..ny {
                vertices.extend((0..nx).map(|x| placement.to_world(DVec3::new(x as f64, y as f64, z as f64))));
            }
        }
        let values: Vec<f64> = with_grid!(grid.values(), voxels => {
            voxels.samples().iter().map(|v| calibration.value(f64::from(v.to_f32()))).collect()
        });
        let mut cells = Vec::with_capacity(6 * (nx - 1) * (ny - 1) * (nz - 1));
        for z in 0..nz - 1 {
            for y in 0..ny - 1 {
                for x in 0..nx - 1 {
                    let corner = |i: usize| (((z + (i >> 2)) * ny + y + (i >> 1 & 1)) * nx + x + (i & 1)) as u32;
                    Shape::Voxel.split(&std::array::from_fn::<u32, 8, _>(corner), &mut cells);
                }
            }
        }
        // Axes of a left-handed placement mirror every cell.
        if placement.axes().determinant() < 0.0 {
            cells.iter_mut().for_each(|cell| cell.swap(2, 3));
        }
        Self::new(vertices, cells, CellValues::Vertices(values))
    }
}
