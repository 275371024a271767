//! The volume that a scene holds.

use std::sync::Arc;

use glam::DVec3;

use crate::amr::AmrGrid;
use crate::any_grid::AnyGrid;
use crate::cells::CellMesh;
use crate::color_grid::ColorGrid;
use crate::derived::Derived;
use crate::field::{Field, FunctionField};
use crate::filter::Filter;
use crate::grid::UniformGrid;
use crate::grid_volume::GridVolume;
use crate::point_set::PointSet;
use crate::rectilinear::RectilinearGrid;
use crate::shading::GradientMethod;
use crate::voxel::Voxel;

/// A volume of any kind. Cloning is cheap: everything is shared.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::field::FunctionField;
/// use vr_core::{Calibration, Filter, Placement, UniformGrid, Volume};
///
/// let grid = UniformGrid::new([2; 3], vec![7u8; 8], Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// let grid = Volume::from(grid);
/// assert_eq!((grid.kind(), grid.filter()), ("uniform grid", Some(Filter::Trilinear)));
/// assert_eq!(grid.value_range(), Some((7.0, 7.0)));
///
/// let ball = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| 1.0 - p.length())?;
/// assert_eq!(Volume::from(ball).filter(), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub enum Volume {
    /// Values on a uniform grid, and the filter that makes a field of them.
    Grid(Arc<GridVolume>),
    /// Values on a uniform grid, and a colour at each voxel.
    Color(Arc<ColorGrid>),
    /// Scattered points.
    Points(Arc<PointSet>),
    /// A mesh of tetrahedra.
    Cells(Arc<CellMesh>),
    /// Values between axis-parallel planes at uneven distances.
    Rectilinear(Arc<RectilinearGrid>),
    /// Lattices of several levels, finer where it is wanted.
    Amr(Arc<AmrGrid>),
    /// Any other field: a function, or a kind of volume of the caller's own.
    Field(Arc<dyn Field>),
}

impl Volume {
    /// The grid, if it is one.
    pub fn grid(&self) -> Option<&Arc<GridVolume>> {
        match self {
            Self::Grid(grid) => Some(grid),
            Self::Color(_)
            | Self::Points(_)
            | Self::Cells(_)
            | Self::Rectilinear(_)
            | Self::Amr(_)
            | Self::Field(_) => None,
        }
    }

    /// The grid with colours, if it is one.
    pub fn colors(&self) -> Option<&Arc<ColorGrid>> {
        if let Self::Color(colors) = self { Some(colors) } else { None }
    }

    /// True if its places have colours of their own, by which that of the transfer function is multiplied.
    pub fn has_colors(&self) -> bool {
        self.colors().is_some() || self.field().is_some_and(Field::has_colors)
    }

    /// The grid of the values, of a grid with colours or without.
    pub fn value_grid(&self) -> Option<&Arc<GridVolume>> {
        self.grid().or_else(|| self.colors().map(|colors| colors.values()))
    }

    /// The scattered points, if it is made of them.
    pub fn points(&self) -> Option<&Arc<PointSet>> {
        match self {
            Self::Points(points) => Some(points),
            Self::Grid(_) | Self::Color(_) | Self::Cells(_) | Self::Rectilinear(_) | Self::Amr(_) | Self::Field(_) => {
                None
            }
        }
    }

    /// The mesh of cells, if it is one.
    pub fn cells(&self) -> Option<&Arc<CellMesh>> {
        if let Self::Cells(mesh) = self { Some(mesh) } else { None }
    }

    /// The rectilinear grid, if it is one.
    pub fn rectilinear(&self) -> Option<&Arc<RectilinearGrid>> {
        if let Self::Rectilinear(grid) = self { Some(grid) } else { None }
    }

    /// The adaptive mesh, if it is one.
    pub fn amr(&self) -> Option<&Arc<AmrGrid>> {
        if let Self::Amr(grid) = self { Some(grid) } else { None }
    }

    /// The field of a volume that is no grid, which has faster ways of its own, with colours or without.
    pub fn field(&self) -> Option<&dyn Field> {
        match self {
            Self::Grid(_) | Self::Color(_) => None,
            Self::Points(points) => Some(&**points),
            Self::Cells(mesh) => Some(&**mesh),
            Self::Rectilinear(grid) => Some(&**grid),
            Self::Amr(grid) => Some(&**grid),
            Self::Field(field) => Some(&**field),
        }
    }

    /// Kind in messages: `uniform grid`, `coloured grid`, `scattered points`, `mesh of cells`, `rectilinear grid`, `adaptive mesh`, `function`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Grid(_) => "uniform grid",
            Self::Color(_) => "coloured grid",
            Self::Points(points) => points.kind(),
            Self::Cells(mesh) => mesh.kind(),
            Self::Rectilinear(grid) => grid.kind(),
            Self::Amr(grid) => grid.kind(),
            Self::Field(field) => field.kind(),
        }
    }

    /// The filter of a grid; `None` for volumes that have none.
    pub fn filter(&self) -> Option<Filter> {
        self.value_grid().map(|grid| grid.filter())
    }

    /// The same volume under another filter; a volume that has none stays as it is.
    #[must_use]
    pub fn with_filter(&self, filter: Filter) -> Self {
        match self {
            Self::Grid(grid) => Self::Grid(Arc::new(grid.with_filter(filter))),
            Self::Color(colors) => Self::Color(Arc::new(colors.with_filter(filter))),
            other => other.clone(),
        }
    }

    /// The same volume with another source of its gradient, where the volume itself has one: a rectilinear grid. Of uniform grids, renderers
    /// find it as the scene's shading says.
    #[must_use]
    pub fn with_gradient(&self, gradient: GradientMethod) -> Self {
        match self {
            Self::Rectilinear(grid) => {
                Self::Rectilinear(Arc::new(RectilinearGrid::clone(grid).with_gradient(gradient)))
            }
            other => other.clone(),
        }
    }

    /// Smallest and largest finite calibrated value, `None` if there is none; for points as in [`PointSet::value_range`], for other fields as in
    /// [`Field::value_range`].
    pub fn value_range(&self) -> Option<(f64, f64)> {
        match self {
            Self::Grid(grid) => grid.value_range(),
            Self::Color(colors) => colors.values().value_range(),
            Self::Points(points) => Some(points.value_range()),
            Self::Cells(mesh) => Some(mesh.value_range()),
            Self::Rectilinear(grid) => grid.value_range(),
            Self::Amr(grid) => Some(grid.value_range()),
            Self::Field(field) => field.value_range(),
        }
    }

    /// Corners of the smallest axis-parallel world box around the volume.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::Grid(grid) => grid.bounds(),
            Self::Color(colors) => colors.values().bounds(),
            Self::Points(points) => points.bounds(),
            Self::Cells(mesh) => mesh.bounds(),
            Self::Rectilinear(grid) => grid.bounds(),
            Self::Amr(grid) => grid.bounds(),
            Self::Field(field) => field.bounds(),
        }
    }

    /// Mean distance between voxels in world units, the mean step of a rectilinear grid, half the mean radius of points, the edge of a cube of six cells,
    /// the mean edge of the finest cells of an adaptive mesh, or a field's own spacing: the default `unit_distance` of a transfer function.
    pub fn mean_spacing(&self) -> f64 {
        match self {
            Self::Grid(grid) => mean_spacing(grid),
            Self::Color(colors) => mean_spacing(colors.values()),
            Self::Points(points) => points.mean_spacing(),
            Self::Cells(mesh) => mesh.mean_spacing(),
            Self::Rectilinear(grid) => grid.mean_spacing(),
            Self::Amr(grid) => grid.mean_spacing(),
            Self::Field(field) => field.spacing(),
        }
    }

    /// Makes the structures that drawing needs beyond the data, so that the first frame does not pay for them.
    pub fn prepare_derived(&self) {
        match self {
            Self::Grid(grid) => grid.prepare_derived(),
            Self::Color(colors) => colors.values().prepare_derived(),
            Self::Points(points) => points.prepare_derived(),
            Self::Cells(mesh) => mesh.prepare_derived(),
            Self::Rectilinear(grid) => grid.lattice().prepare_derived(),
            Self::Amr(grid) => grid.prepare_derived(),
            Self::Field(field) => field.prepare_derived(),
        }
    }

    /// Structures that others derive from the volume and keep with it, whatever its filter; `None` for other fields, which keep none. A grid with
    /// colours has those of its values: a key tells apart what depends on the colours.
    pub fn derived(&self) -> Option<&Derived> {
        match self {
            Self::Grid(grid) => Some(grid.derived()),
            Self::Color(colors) => Some(colors.values().derived()),
            Self::Points(points) => Some(points.derived()),
            Self::Cells(mesh) => Some(mesh.derived()),
            Self::Rectilinear(grid) => Some(grid.derived()),
            Self::Amr(grid) => Some(grid.derived()),
            Self::Field(_) => None,
        }
    }

    /// True if both are the same data under the same filter.
    pub fn same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Grid(a), Self::Grid(b)) => a.same(b),
            (Self::Color(a), Self::Color(b)) => a.same(b),
            (Self::Points(a), Self::Points(b)) => Arc::ptr_eq(a, b),
            (Self::Cells(a), Self::Cells(b)) => Arc::ptr_eq(a, b),
            (Self::Rectilinear(a), Self::Rectilinear(b)) => a.same(b),
            (Self::Amr(a), Self::Amr(b)) => Arc::ptr_eq(a, b),
            (Self::Field(a), Self::Field(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// Mean of the three edges of a voxel.
fn mean_spacing(grid: &GridVolume) -> f64 {
    grid.placement().spacing().element_sum() / 3.0
}

impl<T: Voxel> From<UniformGrid<T>> for Volume
where
    AnyGrid: From<UniformGrid<T>>,
{
    fn from(grid: UniformGrid<T>) -> Self {
        AnyGrid::from(grid).into()
    }
}

impl From<ColorGrid> for Volume {
    fn from(colors: ColorGrid) -> Self {
        Self::Color(Arc::new(colors))
    }
}

impl From<PointSet> for Volume {
    fn from(points: PointSet) -> Self {
        Self::Points(Arc::new(points))
    }
}

impl From<CellMesh> for Volume {
    fn from(mesh: CellMesh) -> Self {
        Self::Cells(Arc::new(mesh))
    }
}

impl From<RectilinearGrid> for Volume {
    fn from(grid: RectilinearGrid) -> Self {
        Self::Rectilinear(Arc::new(grid))
    }
}

impl From<AmrGrid> for Volume {
    fn from(grid: AmrGrid) -> Self {
        Self::Amr(Arc::new(grid))
    }
}

impl From<FunctionField> for Volume {
    fn from(field: FunctionField) -> Self {
        Self::Field(Arc::new(field))
    }
}

/// A grid under the default filter, trilinear.
impl From<AnyGrid> for Volume {
    fn from(grid: AnyGrid) -> Self {
        Self::Grid(Arc::new(GridVolume::new(grid, Filter::default())))
    }
}
