//! The volume that a scene holds: a grid or points, with what is derived from it once and kept.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;

use crate::filter::{BSpline, Filter, Lattice, Reconstruction, interpolation_coefficients};
use crate::filter::{CatmullRom, Gaussian, Nearest, Trilinear};
use crate::grid::{Calibration, Census, UniformGrid};
use crate::level_ranges::LevelRanges;
use crate::missing::{VacuumCells, fill_missing};
use crate::placement::Placement;
use crate::point_set::PointSet;
use crate::range_blocks::RangeBlocks;
use crate::sampler::Sampler;
use crate::value_frame::framed;
use crate::voxel::{Voxel, VoxelType};

/// A volume of any kind. Cloning is cheap: everything is shared.
#[derive(Clone, Debug)]
pub struct Volume(Arc<Geometry>);

/// The kinds of volume. More will come (adaptive grids, tetrahedra): renderers take the kinds that they
/// know and answer [`crate::RenderError::Unsupported`] to the others.
#[derive(Debug)]
#[non_exhaustive]
// There is one for each volume, behind a pointer: nobody gains from a smaller one.
#[expect(clippy::large_enum_variant)]
pub enum Geometry {
    /// Samples on a uniform grid.
    Uniform(UniformVolume),
    /// Scattered points.
    Points(PointSet),
}

impl Volume {
    /// What kind of volume it is.
    pub fn geometry(&self) -> &Geometry {
        &self.0
    }

    /// The uniform grid, if it is one.
    pub fn uniform(&self) -> Option<&UniformVolume> {
        match &*self.0 {
            Geometry::Uniform(u) => Some(u),
            Geometry::Points(_) => None,
        }
    }

    /// The scattered points, if it is made of them.
    pub fn points(&self) -> Option<&PointSet> {
        match &*self.0 {
            Geometry::Points(p) => Some(p),
            Geometry::Uniform(_) => None,
        }
    }

    /// `uniform grid` or `scattered points`, as error messages name the kind.
    pub fn kind(&self) -> &'static str {
        match &*self.0 {
            Geometry::Uniform(_) => "uniform grid",
            Geometry::Points(_) => "scattered points",
        }
    }

    /// Smallest and largest finite calibrated value, `None` if there is none; for points as in [`PointSet::value_range`].
    pub fn value_range(&self) -> Option<(f64, f64)> {
        match &*self.0 {
            Geometry::Uniform(u) => u.value_range(),
            Geometry::Points(p) => Some(p.value_range()),
        }
    }

    /// Corners of the smallest axis-parallel world box around the volume.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match &*self.0 {
            Geometry::Uniform(u) => u.bounds(),
            Geometry::Points(p) => p.bounds(),
        }
    }

    /// Mean distance between samples in world units, or half the mean radius of points: the default `unit_distance` of a transfer function.
    pub fn mean_spacing(&self) -> f64 {
        match &*self.0 {
            Geometry::Uniform(u) => u.placement().spacing().element_sum() / 3.0,
            Geometry::Points(p) => p.mean_spacing(),
        }
    }

    /// Whether two handles share the same data.
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T: Voxel> From<UniformGrid<T>> for Volume
where
    AnyGrid: From<UniformGrid<T>>,
{
    fn from(grid: UniformGrid<T>) -> Self {
        Self(Arc::new(Geometry::Uniform(UniformVolume::new(grid.into()))))
    }
}

impl From<PointSet> for Volume {
    fn from(points: PointSet) -> Self {
        Self(Arc::new(Geometry::Points(points)))
    }
}

impl From<AnyGrid> for Volume {
    fn from(grid: AnyGrid) -> Self {
        Self(Arc::new(Geometry::Uniform(UniformVolume::new(grid))))
    }
}

/// A uniform grid of any sample type.
#[derive(Clone, Debug)]
pub enum AnyGrid {
    /// Unsigned 8-bit integers.
    U8(UniformGrid<u8>),
    /// Signed 8-bit integers.
    I8(UniformGrid<i8>),
    /// Unsigned 16-bit integers.
    U16(UniformGrid<u16>),
    /// Signed 16-bit integers.
    I16(UniformGrid<i16>),
    /// 32-bit floats.
    F32(UniformGrid<f32>),
}

/// Runs one expression for whichever sample type an [`AnyGrid`] holds: `with_grid!(any, g => g.dims())`.
#[macro_export]
macro_rules! with_grid {
    ($any:expr, $grid:ident => $body:expr) => {
        match $any {
            $crate::AnyGrid::U8($grid) => $body,
            $crate::AnyGrid::I8($grid) => $body,
            $crate::AnyGrid::U16($grid) => $body,
            $crate::AnyGrid::I16($grid) => $body,
            $crate::AnyGrid::F32($grid) => $body,
        }
    };
}

macro_rules! any_grid_from {
    ($($t:ty => $variant:ident),*) => {$(
        impl From<UniformGrid<$t>> for AnyGrid {
            fn from(grid: UniformGrid<$t>) -> Self {
                Self::$variant(grid)
            }
        }
    )*};
}
any_grid_from!(u8 => U8, i8 => I8, u16 => U16, i16 => I16, f32 => F32);

/// A uniform grid and what is derived from it: made when first asked for, then kept.
#[derive(Debug)]
pub struct UniformVolume {
    grid: AnyGrid,
    /// Only where samples are missing.
    filled: OnceLock<Option<(UniformGrid<f32>, VacuumCells)>>,
    coefficients: OnceLock<Vec<f32>>,
    blocks: Mutex<HashMap<(Filter, usize), Arc<RangeBlocks>>>,
    levels: Mutex<HashMap<Filter, Arc<LevelRanges>>>,
}

impl UniformVolume {
    /// Numbers are carried in a frame that suits f32: see [`ValueFrame`](crate::ValueFrame).
    fn new(grid: AnyGrid) -> Self {
        let framed = if let AnyGrid::F32(g) = &grid { framed(g) } else { None };
        Self {
            grid: framed.map_or(grid, AnyGrid::F32),
            filled: OnceLock::new(),
            coefficients: OnceLock::new(),
            blocks: Mutex::default(),
            levels: Mutex::default(),
        }
    }

    /// The samples.
    pub fn grid(&self) -> &AnyGrid {
        &self.grid
    }

    /// Samples along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        with_grid!(&self.grid, g => g.dims())
    }

    /// Type of the samples.
    pub fn voxel_type(&self) -> VoxelType {
        fn of<T: Voxel>(_: &UniformGrid<T>) -> VoxelType {
            T::TYPE
        }
        with_grid!(&self.grid, g => of(g))
    }

    /// Where the grid lies in the world.
    pub fn placement(&self) -> &Placement {
        with_grid!(&self.grid, g => g.placement())
    }

    /// What the stored numbers mean.
    pub fn calibration(&self) -> Calibration {
        with_grid!(&self.grid, g => g.calibration())
    }

    /// Range and missing samples, in stored units.
    pub fn census(&self) -> &Census {
        with_grid!(&self.grid, g => g.census())
    }

    /// Bytes of the samples.
    pub fn sample_bytes(&self) -> usize {
        self.dims().iter().product::<usize>() * self.voxel_type().bytes()
    }

    /// Smallest and largest finite calibrated value.
    pub fn value_range(&self) -> Option<(f64, f64)> {
        let calibration = self.calibration();
        self.census().range.map(|(a, b)| {
            let (a, b) = (calibration.value(a.into()), calibration.value(b.into()));
            (a.min(b), a.max(b))
        })
    }

    /// The eight corners of the box in the world.
    pub fn corners(&self) -> [DVec3; 8] {
        let d = self.dims().map(|n| (n - 1) as f64);
        std::array::from_fn(|c| {
            let pick = |axis: usize| if c >> axis & 1 == 1 { d[axis] } else { 0.0 };
            self.placement().to_world(DVec3::new(pick(0), pick(1), pick(2)))
        })
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let c = self.corners();
        (
            c.iter().copied().reduce(DVec3::min).unwrap_or_default(),
            c.iter().copied().reduce(DVec3::max).unwrap_or_default(),
        )
    }

    /// The cells that are vacuum because a corner is missing; `None` where no sample is.
    pub fn vacuum_cells(&self) -> Option<&VacuumCells> {
        self.filled().map(|(_, vacuum)| vacuum)
    }

    /// The samples with missing ones replaced by the nearest finite value; `None` where none is missing.
    fn filled(&self) -> Option<&(UniformGrid<f32>, VacuumCells)> {
        let make = || match &self.grid {
            AnyGrid::F32(g) if g.census().nan + g.census().infinite > 0 => Some((fill_missing(g), VacuumCells::new(g))),
            _ => None,
        };
        self.filled.get_or_init(make).as_ref()
    }

    /// Coefficients of the interpolating B-spline.
    fn coefficients(&self) -> &[f32] {
        self.coefficients.get_or_init(|| match self.filled() {
            Some((g, _)) => interpolation_coefficients(&lattice(g)),
            None => with_grid!(&self.grid, g => interpolation_coefficients(&lattice(g))),
        })
    }

    /// Makes what a filter needs beyond the samples, so that the first frame does not pay for it.
    pub fn warm(&self, filter: Filter) {
        self.filled();
        if filter == Filter::BSpline {
            self.coefficients();
        }
    }

    /// Hands the sampler of a filter to code that is generic over it: one dispatch, none per sample.
    pub fn with_sampler<V: SamplerVisitor>(&self, filter: Filter, visitor: V) -> V::Output {
        match (filter, self.filled()) {
            (Filter::BSpline, _) => {
                let lattice = Lattice { samples: self.coefficients(), dims: self.dims() };
                visitor.visit(Sampler::<f32, BSpline>::new(lattice, self.vacuum_cells()))
            }
            (_, Some((g, vacuum))) => visit(lattice(g), Some(vacuum), filter, visitor),
            (_, None) => with_grid!(&self.grid, g => visit(lattice(g), None, filter, visitor)),
        }
    }

    /// Hands over the samples themselves (missing ones replaced), to take central differences from.
    pub fn with_lattice<V: LatticeVisitor>(&self, visitor: V) -> V::Output {
        match self.filled() {
            Some((g, _)) => visitor.visit(lattice(g)),
            None => with_grid!(&self.grid, g => visitor.visit(lattice(g))),
        }
    }

    /// Ranges of the field of a filter per block of `edge`³ cells, in stored units; made once and kept.
    pub fn range_blocks(&self, filter: Filter, edge: usize) -> Arc<RangeBlocks> {
        let mut blocks = self.blocks.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let made = blocks.entry((filter, edge)).or_insert_with(|| Arc::new(RangeBlocks::of_field(self, filter, edge)));
        Arc::clone(made)
    }

    /// Ranges of the field of a filter in small blocks, in two bytes each; made once and kept.
    pub fn level_ranges(&self, filter: Filter) -> Arc<LevelRanges> {
        let mut levels = self.levels.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Arc::clone(levels.entry(filter).or_insert_with(|| Arc::new(LevelRanges::of_field(self, filter))))
    }
}

fn lattice<T: Voxel>(grid: &UniformGrid<T>) -> Lattice<'_, T> {
    Lattice { samples: grid.samples(), dims: grid.dims() }
}

fn visit<T: Voxel, V: SamplerVisitor>(
    lattice: Lattice<'_, T>,
    vacuum: Option<&VacuumCells>,
    filter: Filter,
    visitor: V,
) -> V::Output {
    match filter {
        Filter::Nearest => visitor.visit(Sampler::<T, Nearest>::new(lattice, vacuum)),
        Filter::Trilinear => visitor.visit(Sampler::<T, Trilinear>::new(lattice, vacuum)),
        // Over coefficients, which are f32 whatever the samples are: no instance of it for each voxel type.
        Filter::BSpline => unreachable!("handed its coefficients instead of the samples by the caller"),
        Filter::CatmullRom => visitor.visit(Sampler::<T, CatmullRom>::new(lattice, vacuum)),
        Filter::Gaussian => visitor.visit(Sampler::<T, Gaussian>::new(lattice, vacuum)),
    }
}

/// Code that is generic over voxel type and filter; see [`UniformVolume::with_sampler`].
pub trait SamplerVisitor {
    /// What it returns.
    type Output;
    /// Called once, with the sampler.
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Self::Output;
}

/// Code that is generic over the voxel type; see [`UniformVolume::with_lattice`].
pub trait LatticeVisitor {
    /// What it returns.
    type Output;
    /// Called once, with the samples.
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output;
}
