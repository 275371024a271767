//! Random adaptive meshes, and scenes of them.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};

use super::assembly;
use super::cameras::viewpoint;
use super::grids::any_spacing;
use super::hashed::Hashed;
use crate::check::TestScene;

/// A box of cells of one level: the index of its first cell, and its size.
type Cells = ([i64; 3], [i64; 3]);

/// The parts of a random mesh.
#[derive(Clone, Debug)]
struct Recipe {
    centring: AmrCentring,
    /// Cells of level 0.
    cells: [i64; 3],
    /// True if level 0 lacks a quarter of its box.
    is_angular: bool,
    levels: Vec<FinerLevel>,
    values: Values,
    /// Edges of a cell of level 0.
    spacing: [f64; 3],
    /// Place of the mesh, in cells of level 0.
    far: f64,
    /// One value in so many is missing.
    missing: Option<u64>,
    seed: u64,
}

/// A level that refines one or two cells of the level before along each axis.
#[derive(Clone, Debug)]
struct FinerLevel {
    ratio: [u32; 3],
    /// Number of refined cells, and their place as a part of where they can lie.
    refined: [i64; 3],
    place: [f64; 3],
    /// Axis along which the level is made of two blocks.
    seam: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
enum Values {
    /// The same everywhere.
    Constant,
    /// A wave of the position, the same on every level.
    Wave,
    /// Values that have nothing to do with each other.
    Noise,
}

/// Any small adaptive mesh: one to three levels, ratios of 1 to 4 along each axis, values of cells or of points, blocks that meet in seams, boxes with and without
/// a missing quarter, missing values, unequal spacings; around the origin, or far from it. Axes are those of the world: the type has no others.
pub fn adaptive_mesh() -> impl Strategy<Value = AmrGrid> {
    meshes(any::<bool>(), proptest::option::weighted(0.25, 4u64..30))
}

/// An adaptive mesh of [`adaptive_mesh`] that fills its box, without missing values.
pub fn tame_adaptive_mesh() -> impl Strategy<Value = AmrGrid> {
    meshes(Just(false), Just(None))
}

/// Any scene of an adaptive mesh: every transfer function, every compositing, clips, shading, rays in the faces between levels.
pub fn adaptive_scene() -> impl Strategy<Value = TestScene> {
    assembly::any_scene(adaptive_mesh(), viewpoint())
}

/// A scene of an adaptive mesh whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold, no shading, no missing
/// values.
pub fn tame_adaptive_scene() -> impl Strategy<Value = TestScene> {
    assembly::tame_scene(tame_adaptive_mesh())
}

fn meshes(
    is_angular: impl Strategy<Value = bool>,
    missing: impl Strategy<Value = Option<u64>>,
) -> impl Strategy<Value = AmrGrid> {
    let centring = prop_oneof![Just(AmrCentring::Cells), Just(AmrCentring::Points)];
    let cells = [2i64..=4, 2i64..=4, 2i64..=4];
    let values = prop_oneof![1 => Just(Values::Constant), 3 => Just(Values::Wave), 3 => Just(Values::Noise)];
    let scale = (-1.5f64..1.5).prop_map(|decades| libm::pow(10.0, decades));
    let place = (scale, [any_spacing(), any_spacing(), any_spacing()], prop_oneof![3 => Just(0.0), 1 => Just(200.0)]);
    (centring, cells, is_angular, vec(finer_level(), 0..=2), values, place, missing, any::<u64>()).prop_map(
        |(centring, cells, is_angular, levels, values, (scale, spacing, far), missing, seed)| {
            let spacing = spacing.map(|s| s * scale);
            Recipe { centring, cells, is_angular, levels, values, spacing, far, missing, seed }.mesh()
        },
    )
}

fn finer_level() -> impl Strategy<Value = FinerLevel> {
    let ratio = || prop_oneof![1 => Just(1u32), 3 => Just(2), 1 => Just(3), 1 => Just(4)];
    let ratio = [ratio(), ratio(), ratio()].prop_map(|[x, y, z]| if x * y * z == 1 { [2, 1, 1] } else { [x, y, z] });
    let refined = [1i64..=2, 1i64..=2, 1i64..=2];
    let place = [0.0..1.0, 0.0..1.0, 0.0..1.0];
    (ratio, refined, place, proptest::option::of(0usize..3)).prop_map(|(ratio, refined, place, seam)| FinerLevel {
        ratio,
        refined,
        place,
        seam,
    })
}

impl Recipe {
    fn mesh(&self) -> AmrGrid {
        // Level 0: two blocks along y on the lower side of x, and one on the upper side, which may lack a half.
        let [x, y, z] = self.cells;
        let (middle, half) = (x / 2, y / 2);
        let upper_end = if self.is_angular { half } else { y };
        let mut blocks = vec![
            self.block(0, ([0; 3], [middle, half, z])),
            self.block(0, ([0, half, 0], [middle, y - half, z])),
            self.block(0, ([middle, 0, 0], [x - middle, upper_end, z])),
        ];
        // Finer levels lie in the part that is always there.
        let mut last: Cells = ([0; 3], if self.is_angular { [middle, y, z] } else { self.cells });
        for (number, level) in self.levels.iter().enumerate() {
            last = level.refined_part(last);
            blocks.extend(level.blocks(last).into_iter().map(|cells| self.block(number + 1, cells)));
        }
        let ratios = self.levels.iter().map(|level| level.ratio).collect();
        let spacing = DVec3::from_array(self.spacing);
        let origin = spacing * self.far;
        AmrGrid::new(origin, spacing, ratios, blocks, self.centring).expect("strategies make valid meshes")
    }

    fn block(&self, level: usize, (first, cells): Cells) -> AmrBlock {
        let beyond = i64::from(self.centring == AmrCentring::Points);
        let dims = cells.map(|n| n + beyond);
        let mut values = Vec::new();
        for z in first[2]..first[2] + dims[2] {
            for y in first[1]..first[1] + dims[1] {
                values.extend((first[0]..first[0] + dims[0]).map(|x| self.value(level, [x, y, z])));
            }
        }
        AmrBlock { level, first, dims: dims.map(|n| n as usize), values }
    }

    /// The value of a place on a level's lattice.
    fn value(&self, level: usize, at: [i64; 3]) -> f32 {
        let hashed = Hashed::of(self.seed, [level as i64, at[0], at[1], at[2]]);
        // The first one stays.
        let is_first = level == 0 && at == [0; 3];
        if !is_first && self.missing.is_some_and(|n| hashed.is_one_in(n)) {
            return f32::NAN;
        }
        let value = match self.values {
            Values::Constant => 0.7,
            Values::Noise => hashed.part(),
            Values::Wave => {
                let middle = if self.centring == AmrCentring::Cells { 0.5 } else { 0.0 };
                let cells_of_level_0 = |a: usize| {
                    let parts: f64 = self.levels[..level].iter().map(|l| f64::from(l.ratio[a])).product();
                    (at[a] as f64 + middle) / parts
                };
                let [x, y, z] = [0, 1, 2].map(cells_of_level_0);
                0.5 + 0.3 * libm::sin(1.1 * x + 0.4 * y) + 0.2 * libm::cos(1.3 * z - 0.6 * y)
            }
        };
        value as f32
    }
}

impl FinerLevel {
    /// The cells of this level that refine some of a box of the level before.
    fn refined_part(&self, (first, cells): Cells) -> Cells {
        let ratio = self.ratio.map(i64::from);
        let size: [i64; 3] = std::array::from_fn(|a| self.refined[a].min(cells[a]));
        let low: [i64; 3] =
            std::array::from_fn(|a| first[a] + (self.place[a] * (cells[a] - size[a] + 1) as f64) as i64);
        (std::array::from_fn(|a| low[a] * ratio[a]), std::array::from_fn(|a| size[a] * ratio[a]))
    }

    /// The blocks of the level: one, or two where two cells of the level before meet.
    fn blocks(&self, (first, cells): Cells) -> Vec<Cells> {
        let seam = self.seam.map(|axis| (axis, i64::from(self.ratio[axis])));
        let Some((axis, size)) = seam.filter(|&(axis, size)| size < cells[axis]) else { return vec![(first, cells)] };
        let (mut lower, mut upper) = ((first, cells), (first, cells));
        lower.1[axis] = size;
        upper.0[axis] += size;
        upper.1[axis] -= size;
        vec![lower, upper]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn::{self, draw, scenes_are_solved, tame_scenes_are_certain};

    #[test]
    fn every_scene_is_solved_and_every_feature_is_drawn() {
        let scenes = draw(adaptive_scene(), 300);
        let some = |what: &str, test: &dyn Fn(&TestScene, &AmrGrid) -> bool| {
            drawn::some(&scenes, what, |t| test(t, t.scene.volume.amr().unwrap()));
        };
        for levels in 1..=3 {
            some("levels", &|_, mesh| mesh.levels() == levels);
        }
        some("values of points", &|_, mesh| mesh.centring() == AmrCentring::Points);
        some("unequal ratios", &|_, mesh| (1..mesh.levels()).any(|l| mesh.ratio_of(l)[0] != mesh.ratio_of(l)[1]));
        some("ratios of 4", &|_, mesh| (1..mesh.levels()).any(|l| mesh.ratio_of(l).contains(&4)));
        some("a seam", &|_, mesh| (1..mesh.levels()).any(|l| mesh.blocks_of(l).len() == 2));
        some("missing values", &|_, mesh| mesh.missing_values() > 0);
        some("shading", &|t, _| t.scene.shading.is_some());
        some("clips", &|t, _| t.view.clip.crop.is_some() || !t.view.clip.planes.is_empty());
        some("jumps", &|t, _| t.scene.transfer.has_jumps());
        some("an eye inside", &|t, mesh| {
            let (low, high) = mesh.bounds();
            t.view.camera.eye.cmpgt(low).all() && t.view.camera.eye.cmplt(high).all()
        });
        scenes_are_solved(&scenes);
    }

    #[test]
    fn tame_scenes_are_certain_and_most_are_visible() {
        tame_scenes_are_certain(&draw(tame_adaptive_scene(), 200), 1e-7);
    }
}
