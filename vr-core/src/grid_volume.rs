//! A uniform grid under a filter, with the structures that are derived from it once and kept.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::any_grid::AnyGrid;
use crate::cancel;
use crate::derived::Derived;
use crate::filter::{BSpline, Filter, Lattice, Reconstruction, interpolation_coefficients};
use crate::filter::{CatmullRom, Gaussian, Nearest, Trilinear};
use crate::grid::{Calibration, UniformGrid, ValueStats};
use crate::lazy::computed;
use crate::missing::{VacuumCells, fill_missing};
use crate::placement::Placement;
use crate::sampler::Sampler;
use crate::value_frame::framed;
use crate::voxel::{Voxel, VoxelType};
use crate::with_grid;

/// A uniform grid under a reconstruction filter. Volumes of the same values under other filters share the values
/// ([`GridVolume::with_filter`]), and the structures that are derived from them.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};
///
/// let calibration = Calibration { slope: 0.5, intercept: -1.0 };
/// let grid = UniformGrid::new([2; 3], (0..8u8).collect::<Vec<_>>(), Placement::from_spacing([1.0; 3])?, calibration)?;
/// let linear = GridVolume::new(grid.into(), Filter::Trilinear);
/// assert_eq!(linear.value_range(), Some((-1.0, 2.5)));
///
/// let cubic = linear.with_filter(Filter::CatmullRom);
/// assert_eq!((linear.filter(), cubic.filter()), (Filter::Trilinear, Filter::CatmullRom));
/// assert!(linear.same(&cubic.with_filter(Filter::Trilinear)), "the voxels are shared");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GridVolume {
    values: Arc<Values>,
    filter: Filter,
}

/// The values of a grid and the structures that are derived from them: made when first asked for, then kept.
#[derive(Debug)]
struct Values {
    given: AnyGrid,
    /// Floats in the frame that suits their range; `None` where they are best left as they are.
    framed: OnceLock<Option<AnyGrid>>,
    /// The values with the missing ones filled in, and the cells that are vacuum; `None` where no voxel is missing.
    filled: OnceLock<Option<(UniformGrid<f32>, VacuumCells)>>,
    coefficients: OnceLock<Vec<f32>>,
    derived: Derived,
}

impl GridVolume {
    /// A grid under a filter. Numbers are carried in a frame that suits f32: see [`ValueFrame`](crate::ValueFrame). No voxel is read yet.
    pub fn new(grid: AnyGrid, filter: Filter) -> Self {
        let values = Values {
            given: grid,
            framed: OnceLock::new(),
            filled: OnceLock::new(),
            coefficients: OnceLock::new(),
            derived: Derived::default(),
        };
        Self { values: Arc::new(values), filter }
    }

    /// The values, as they are stored. Of floats, all are read at the first call, for their range; of integers none.
    #[inline]
    pub fn values(&self) -> &AnyGrid {
        let Values { given, framed: in_frame, .. } = &*self.values;
        let AnyGrid::F32(floats) = given else { return given };
        computed(in_frame, || framed(floats).map(AnyGrid::F32)).as_ref().unwrap_or(given)
    }

    /// The filter that makes a field of the values.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The same values under another filter.
    #[must_use]
    pub fn with_filter(&self, filter: Filter) -> Self {
        Self { filter, ..self.clone() }
    }

    /// True if both are the same values, in memory, under the same filter.
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.values, &other.values) && self.filter == other.filter
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        with_grid!(&self.values.given, g => g.dims())
    }

    /// Type of the voxels.
    pub fn voxel_type(&self) -> VoxelType {
        fn type_of<T: Voxel>(_: &UniformGrid<T>) -> VoxelType {
            T::TYPE
        }
        with_grid!(&self.values.given, g => type_of(g))
    }

    /// Placement of the grid in the world.
    pub fn placement(&self) -> &Placement {
        with_grid!(&self.values.given, g => g.placement())
    }

    /// Map from stored numbers to values.
    pub fn calibration(&self) -> Calibration {
        with_grid!(self.values(), g => g.calibration())
    }

    /// Range of the stored numbers, and counts of the missing ones.
    pub fn value_stats(&self) -> &ValueStats {
        with_grid!(self.values(), g => g.value_stats())
    }

    /// Memory of the voxels in bytes.
    pub fn sample_bytes(&self) -> usize {
        self.dims().iter().product::<usize>() * self.voxel_type().bytes()
    }

    /// Smallest and largest finite calibrated value.
    pub fn value_range(&self) -> Option<(f64, f64)> {
        let calibration = self.calibration();
        self.value_stats().range.map(|(a, b)| {
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

    /// Lower and upper corner of the smallest axis-parallel world box around it.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let c = self.corners();
        (
            c.iter().copied().reduce(DVec3::min).unwrap_or_default(),
            c.iter().copied().reduce(DVec3::max).unwrap_or_default(),
        )
    }

    /// The cells that are vacuum because a corner is missing; `None` where no voxel is.
    pub fn vacuum_cells(&self) -> Option<&VacuumCells> {
        self.filled().map(|(_, vacuum)| vacuum)
    }

    /// The voxels with missing ones replaced by the nearest finite value; `None` where none is missing.
    #[inline]
    fn filled(&self) -> Option<&(UniformGrid<f32>, VacuumCells)> {
        let make = || match self.values() {
            AnyGrid::F32(g) if g.value_stats().has_missing() => {
                // A copy, the front that fills it, and a bit a cell.
                cancel::claim(
                    "the voxels with missing ones filled in",
                    g.samples().len() as u64 * (4 + 8) + g.samples().len() as u64 / 8,
                );
                Some((fill_missing(g), VacuumCells::new(g)))
            }
            _ => None,
        };
        self.values.filled.get_or_init(make).as_ref()
    }

    /// The voxels of a grid of floats, with missing ones replaced by the nearest finite value; `None` of other voxels.
    pub fn filled_floats(&self) -> Option<&[f32]> {
        match (self.filled(), self.values()) {
            (Some((filled, _)), _) => Some(filled.samples()),
            (None, AnyGrid::F32(grid)) => Some(grid.samples()),
            (None, _) => None,
        }
    }

    /// Coefficients of the B-spline that interpolates the voxels, missing ones filled in: what [`Filter::BSpline`] samples. Made at the first call.
    pub fn spline_coefficients(&self) -> &[f32] {
        self.values.coefficients.get_or_init(|| {
            // Beside them, the columns along z while they are filtered.
            let bytes = 2 * size_of::<f32>() * self.dims().iter().product::<usize>();
            cancel::claim("the coefficients of the B-spline", bytes as u64);
            match self.filled() {
                Some((g, _)) => interpolation_coefficients(&lattice(g)),
                None => with_grid!(self.values(), g => interpolation_coefficients(&lattice(g))),
            }
        })
    }

    /// Makes the structures that the filter needs beyond the values, so that the first frame does not pay for them.
    pub fn prepare_derived(&self) {
        self.filled();
        if self.filter == Filter::BSpline {
            self.spline_coefficients();
        }
    }

    /// Hands the field's sampler to code that is generic over it: one dispatch, none per sample.
    pub fn with_sampler<V: SamplerVisitor>(&self, visitor: V) -> V::Output {
        let filter = self.filter;
        match (filter, self.filled()) {
            (Filter::BSpline, _) => {
                let lattice = Lattice { samples: self.spline_coefficients(), dims: self.dims() };
                visitor.visit(Sampler::<f32, BSpline>::new(lattice, self.vacuum_cells()))
            }
            (_, Some((g, vacuum))) => visit(lattice(g), Some(vacuum), filter, visitor),
            (_, None) => with_grid!(self.values(), g => visit(lattice(g), None, filter, visitor)),
        }
    }

    /// Hands over the voxels themselves (missing ones replaced), to take central differences from.
    pub fn with_lattice<V: LatticeVisitor>(&self, visitor: V) -> V::Output {
        match self.filled() {
            Some((g, _)) => visitor.visit(lattice(g)),
            None => with_grid!(self.values(), g => visitor.visit(lattice(g))),
        }
    }

    /// Structures that renderers derive from the volume and keep with it.
    pub fn derived(&self) -> &Derived {
        &self.values.derived
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
        // Over coefficients, which are f32 whatever the voxels are: no instance of it for each voxel type.
        Filter::BSpline => unreachable!("handed its coefficients instead of the samples by the caller"),
        Filter::CatmullRom => visitor.visit(Sampler::<T, CatmullRom>::new(lattice, vacuum)),
        Filter::Gaussian => visitor.visit(Sampler::<T, Gaussian>::new(lattice, vacuum)),
    }
}

/// Code that is generic over voxel type and filter; see [`GridVolume::with_sampler`].
///
/// # Examples
/// ```
/// use vr_core::filter::Reconstruction;
/// use vr_core::{Calibration, Filter, GridVolume, Placement, Sampler, SamplerVisitor, UniformGrid, Voxel};
///
/// struct ValueAt([f64; 3]);
/// impl SamplerVisitor for ValueAt {
///     type Output = f64;
///     fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> f64 {
///         sampler.value(self.0)
///     }
/// }
///
/// let voxels: Vec<u8> = (0..8).collect();
/// let grid = UniformGrid::new([2; 3], voxels, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// assert_eq!(GridVolume::new(grid.into(), Filter::Trilinear).with_sampler(ValueAt([0.5; 3])), 3.5);
/// # Ok::<(), vr_core::GridError>(())
/// ```
pub trait SamplerVisitor {
    /// Result of the visit.
    type Output;
    /// Does its work with the sampler; called once.
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Self::Output;
}

/// Code that is generic over the voxel type; see [`GridVolume::with_lattice`].
///
/// # Examples
/// ```
/// use vr_core::filter::Lattice;
/// use vr_core::{Calibration, Filter, GridVolume, LatticeVisitor, Placement, UniformGrid, Voxel, gradient_at_sample};
///
/// struct GradientAt([usize; 3]);
/// impl LatticeVisitor for GradientAt {
///     type Output = [f32; 3];
///     fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f32; 3] {
///         gradient_at_sample(&lattice, self.0)
///     }
/// }
///
/// let voxels: Vec<u8> = (0..8).collect();
/// let grid = UniformGrid::new([2; 3], voxels, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// assert_eq!(GridVolume::new(grid.into(), Filter::Nearest).with_lattice(GradientAt([0; 3])), [1.0, 2.0, 4.0]);
/// # Ok::<(), vr_core::GridError>(())
/// ```
pub trait LatticeVisitor {
    /// Result of the visit.
    type Output;
    /// Does its work with the voxels; called once.
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output;
}
