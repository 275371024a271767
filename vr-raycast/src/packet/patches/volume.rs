//! Volumes that are regular lattices patch by patch, and what packets keep with them.

use std::sync::Arc;

use vr_core::amr::AmrGrid;
use vr_core::{Calibration, RectilinearGrid, Volume};

use super::axis_table::AxisTable;
use super::mesh::{MeshBlock, gradient_length};
use super::mesh_lattices::MeshLattices;
use super::mesh_paces::MeshPaces;
use super::rectilinear::RectilinearPatches;
use super::rectilinear_paces::RectilinearPaces;
use crate::pace::Pace;
use crate::table_range::field_range;

/// Volume that is a regular lattice patch by patch.
#[derive(Clone, Debug)]
pub(super) enum PatchVolume {
    Amr { grid: Arc<AmrGrid>, blocks: Arc<Vec<MeshBlock>>, lattices: Arc<MeshLattices>, paces: Arc<MeshPaces> },
    Rectilinear(Arc<RectilinearGrid>, Arc<[AxisTable; 3]>, Arc<RectilinearPaces>),
}

impl PatchVolume {
    pub(super) fn new(volume: &Volume, pace: &Pace<f32>, has_gradients: bool) -> Option<Self> {
        match volume {
            Volume::Amr(grid) => {
                let blocks = grid.derived().get((), || MeshBlock::all_of(grid));
                let paces = Arc::new(MeshPaces::new(grid, pace));
                let lattices = grid.derived().get((), || MeshLattices::new(grid));
                lattices.make(grid, has_gradients, |block| paces.is_seen(grid, block));
                Some(Self::Amr { grid: Arc::clone(grid), blocks, lattices, paces })
            }
            Volume::Rectilinear(grid) => {
                let paces = Arc::new(RectilinearPaces::new(grid, pace));
                Some(Self::Rectilinear(Arc::clone(grid), RectilinearPatches::tables(grid), paces))
            }
            _ => None,
        }
    }

    /// Values per world unit that a gradient of 1 stands for, as the patches tell gradients.
    pub(super) fn gradient_unit(&self) -> f64 {
        match self {
            Self::Amr { grid, .. } => 1.0 / gradient_length(grid),
            Self::Rectilinear(grid, ..) => {
                grid.lattice().calibration().slope.abs() / RectilinearPatches::gradient_length(grid)
            }
        }
    }
}

/// Range of a volume's numbers as packets read them, and their calibration; `None` for a volume that packets cannot read.
pub(super) fn range_of(volume: &Volume) -> Option<((f64, f64), Calibration)> {
    match volume {
        Volume::Amr(grid) => Some((grid.value_range(), Calibration::default())),
        Volume::Rectilinear(grid) if RectilinearPatches::can_number(grid) => {
            Some((field_range(grid.lattice())?, grid.lattice().calibration()))
        }
        _ => None,
    }
}

/// Runs code for the patches of a volume, whose steps are counted in a unit, of whatever kind they are.
macro_rules! with_patches {
    ($volume:expr, $unit:expr, $patches:ident => $body:expr) => {
        match $volume {
            $crate::packet::patches::volume::PatchVolume::Amr { grid, blocks, lattices, paces } => {
                let samples = grid.samples();
                let $patches =
                    $crate::packet::patches::mesh::MeshPatches { grid, samples, lattices, blocks, paces, unit: $unit };
                $body
            }
            $crate::packet::patches::volume::PatchVolume::Rectilinear(grid, tables, paces) => {
                let $patches =
                    $crate::packet::patches::rectilinear::RectilinearPatches::new(grid, tables, paces, $unit);
                $body
            }
        }
    };
}
pub(super) use with_patches;
