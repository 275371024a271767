//! Volumes made from volumes: larger worlds, and quarter turns.

use glam::{DMat3, DVec3};
use vr_core::amr::{AmrBlock, AmrCentring};
use vr_core::rectilinear::Centering;
use vr_core::{
    AmrGrid, AnyGrid, CellMesh, GridVolume, Placement, RectilinearGrid, UniformGrid, Volume, Voxel, with_grid,
};

/// The volume in a world `s` times as large.
///
/// # Panics
/// Panics if it is no grid, mesh or rectilinear grid, or if numbers leave what f64 holds.
pub(super) fn scaled(volume: &Volume, s: f64) -> Volume {
    match volume {
        Volume::Cells(mesh) => with_vertices(mesh, |v| v * s),
        Volume::Amr(mesh) => {
            let ratios = (1..mesh.levels()).map(|level| mesh.ratio_of(level)).collect();
            let (origin, spacing) = (mesh.origin() * s, mesh.spacing_of(0) * s);
            let scaled = AmrGrid::new(origin, spacing, ratios, mesh.blocks().to_vec(), mesh.centring());
            scaled.expect("still a mesh").into()
        }
        Volume::Rectilinear(grid) => {
            let axes = grid.axes().each_ref().map(|axis| axis.places().iter().map(|x| x * s).collect());
            rectilinear(grid, axes, values(grid))
        }
        _ => {
            let grid = uniform(volume);
            let old = grid.placement();
            let columns = old.axes();
            let axes = DMat3::from_cols(columns.x_axis * s, columns.y_axis * s, columns.z_axis * s);
            with_placement(grid, Placement::new(old.origin() * s, axes).expect("still a placement"))
        }
    }
}

/// The volume turned by 90°, so that axis `a` comes to lie on axis `b`, and axis `b` on the other direction of `a`; `turn` does so to places.
///
/// # Panics
/// Panics if it is no grid, mesh or rectilinear grid.
pub(super) fn quarter_turned(volume: &Volume, (a, b): (usize, usize), turn: impl Fn(DVec3) -> DVec3) -> Volume {
    match volume {
        Volume::Cells(mesh) => with_vertices(mesh, turn),
        Volume::Amr(mesh) => turned_mesh(mesh, (a, b), turn),
        Volume::Rectilinear(grid) => {
            let mut axes = grid.axes().each_ref().map(|axis| axis.places().to_vec());
            axes.swap(a, b);
            axes[a] = axes[a].iter().rev().map(|x| 0.0 - x).collect();
            rectilinear(grid, axes, turned_values(&values(grid), grid.dims(), (a, b)))
        }
        _ => turned_grid(uniform(volume), (a, b), turn),
    }
}

/// Cell i of a level becomes cell j: j_b = i_a, j_a = −1 − i_b; a point has no width, so that j_a = −i_b.
fn turned_mesh(mesh: &AmrGrid, (a, b): (usize, usize), turn: impl Fn(DVec3) -> DVec3) -> Volume {
    let width = i64::from(mesh.centring() == AmrCentring::Cells);
    let turned_block = |block: &AmrBlock| {
        let (mut first, mut dims) = (block.first, block.dims);
        first.swap(a, b);
        dims.swap(a, b);
        let last = block.first[b] + block.dims[b] as i64 - 1;
        first[a] = -width - last;
        AmrBlock { level: block.level, first, dims, values: turned_values(&block.values, block.dims, (a, b)) }
    };
    let swapped_ratio = |level: usize| {
        let mut ratio = mesh.ratio_of(level);
        ratio.swap(a, b);
        ratio
    };
    let mut spacing = mesh.spacing_of(0).to_array();
    spacing.swap(a, b);
    let ratios = (1..mesh.levels()).map(swapped_ratio).collect();
    let blocks = mesh.blocks().iter().map(turned_block).collect();
    let turned = AmrGrid::new(turn(mesh.origin()), spacing.into(), ratios, blocks, mesh.centring());
    turned.expect("still a mesh").into()
}

fn turned_grid(volume: &GridVolume, (a, b): (usize, usize), turn: impl Fn(DVec3) -> DVec3) -> Volume {
    let old = volume.placement();
    let columns = [old.axes().x_axis, old.axes().y_axis, old.axes().z_axis];
    let mut axes = columns.map(&turn);
    axes[b] = turn(columns[a]);
    axes[a] = DVec3::ZERO - turn(columns[b]);
    let origin = turn(old.origin() + columns[b] * (volume.dims()[b] - 1) as f64);
    let placement = Placement::new(origin, DMat3::from_cols(axes[0], axes[1], axes[2])).expect("still a placement");
    fn build<T: Voxel>(grid: &UniformGrid<T>, (a, b): (usize, usize), placement: Placement) -> UniformGrid<T> {
        let mut dims = grid.dims();
        dims.swap(a, b);
        let samples = turned_values(grid.samples(), grid.dims(), (a, b));
        UniformGrid::new(dims, samples, placement, grid.calibration()).expect("still a grid")
    }
    under_filter(volume, with_grid!(volume.values(), grid => build(grid, (a, b), placement).into()))
}

/// Value i becomes value j: j_b = i_a, j_a = n_b − 1 − i_b.
fn turned_values<T: Copy>(values: &[T], old: [usize; 3], (a, b): (usize, usize)) -> Vec<T> {
    let mut dims = old;
    dims.swap(a, b);
    let mut turned = Vec::with_capacity(values.len());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let j = [x, y, z];
                let mut i = j;
                i[a] = j[b];
                i[b] = old[b] - 1 - j[a];
                turned.push(values[(i[2] * old[1] + i[1]) * old[0] + i[0]]);
            }
        }
    }
    turned
}

/// A mesh with its vertices in other places.
fn with_vertices(mesh: &CellMesh, moved: impl Fn(DVec3) -> DVec3) -> Volume {
    let vertices = mesh.vertices().iter().map(|&v| moved(v)).collect();
    CellMesh::new(vertices, mesh.cells().to_vec(), mesh.values().clone()).expect("still a mesh").into()
}

/// A rectilinear grid on other axes, with the gradient of an old one.
fn rectilinear(old: &RectilinearGrid, axes: [Vec<f64>; 3], values: Vec<f32>) -> Volume {
    let grid = RectilinearGrid::new(axes, values, Centering::Points).expect("still a grid");
    grid.with_gradient(old.gradient_method()).into()
}

/// The values of a rectilinear grid, as they were given: stored ones may have lost an offset, which fits f32 better.
pub(super) fn values(grid: &RectilinearGrid) -> Vec<f32> {
    let calibration = grid.lattice().calibration();
    let AnyGrid::F32(stored) = grid.lattice().values() else { unreachable!("rectilinear grids hold f32") };
    stored.samples().iter().map(|&x| calibration.value(x.into()) as f32).collect()
}

fn uniform(volume: &Volume) -> &GridVolume {
    volume.grid().expect("only grids, meshes and rectilinear grids can be transformed")
}

fn with_placement(volume: &GridVolume, placement: Placement) -> Volume {
    fn build<T: Voxel>(grid: &UniformGrid<T>, placement: Placement) -> UniformGrid<T> {
        UniformGrid::new(grid.dims(), grid.samples().to_vec(), placement, grid.calibration()).expect("still a grid")
    }
    under_filter(volume, with_grid!(volume.values(), grid => build(grid, placement).into()))
}

/// A grid under the filter of an old one.
fn under_filter(old: &GridVolume, grid: AnyGrid) -> Volume {
    Volume::from(grid).with_filter(old.filter())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::{drawn::draw, tame_adaptive_mesh, tame_rectilinear_grid};

    /// A quarter turn about z.
    fn turn(v: DVec3) -> DVec3 {
        DVec3::new(0.0 - v.y, v.x, v.z)
    }

    /// Places well inside elements, where rounding leads into no other one.
    fn agree(before: &Volume, after: &Volume, moved: impl Fn(DVec3) -> DVec3) {
        let (low, high) = before.bounds();
        let (range, field) = (before.value_range().unwrap(), [before, after].map(|v| v.field().unwrap()));
        for k in 0..60u32 {
            let part = |n: u32| f64::from(k * n % 61) / 61.0 + 1e-3;
            let at = low + (high - low) * DVec3::new(part(7), part(23), part(41));
            // The rim of a mesh is vacuum where it is coarse.
            let (Some(a), Some(b)) = (field[0].value(at), field[1].value(moved(at))) else {
                assert_eq!(field[0].value(at).is_none(), field[1].value(moved(at)).is_none(), "{at}");
                continue;
            };
            // Coordinates are 200 cells away at most, each part of one is off by 10⁻¹³.
            let allowed = 1e-9 * (range.1 - range.0).max(range.0.abs()).max(range.1.abs());
            assert!((a - b).abs() <= allowed, "{at}: {a}, then {b}");
        }
    }

    #[test]
    fn fields_are_taken_along() {
        let meshes = draw(tame_adaptive_mesh(), 40).into_iter().map(Volume::from);
        let grids = draw(tame_rectilinear_grid(), 40).into_iter().map(Volume::from);
        for volume in meshes.chain(grids) {
            agree(&volume, &quarter_turned(&volume, (0, 1), turn), turn);
            agree(&volume, &scaled(&volume, 3.0), |v| v * 3.0);
        }
    }

    #[test]
    fn four_quarter_turns_are_none() {
        for mesh in draw(tame_adaptive_mesh(), 40) {
            let volume = Volume::from(mesh.clone());
            let back = (0..4).fold(volume, |v, _| quarter_turned(&v, (0, 1), turn));
            assert_eq!((back.amr().unwrap().blocks(), back.bounds()), (mesh.blocks(), mesh.bounds()));
        }
        for grid in draw(tame_rectilinear_grid(), 40) {
            let back = (0..4).fold(Volume::from(grid.clone()), |v, _| quarter_turned(&v, (1, 2), |v| v));
            let back = back.rectilinear().unwrap();
            assert_eq!((back.axes(), values(back)), (grid.axes(), values(&grid)));
        }
    }
}
