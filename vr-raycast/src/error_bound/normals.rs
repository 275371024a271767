//! The gradient along cells of a volume, with a bound of what it is off by.

use vr_core::filter::Lattice;
use vr_core::{GradientMethod, GridVolume, Scene, Voxel, gradient_at_sample};

use super::cone::Corners;
use super::crossed::Crossed;
use super::cubic::Cubic;
use super::polynomials::CubicVector;
use super::series::Series;

/// Gradients of a grid: how they are found.
#[derive(Clone, Debug)]
pub(super) struct Gradients {
    /// True if they are the filter's own, not central differences.
    pub(super) analytic: bool,
    /// Rows of the matrix from gradients per index step to the world, by a common factor.
    pub(super) to_world: [[f64; 3]; 3],
    /// The factor of `to_world`.
    unit: f64,
}

/// The gradient along a cell.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, on the stack")]
pub(super) enum Normals {
    /// None: it is 0 throughout, or nothing looks at it.
    Absent,
    /// World gradient by the powers of a parameter from 0 to 1 along the cell, in units of its largest component there, which is `unit`; each component is off by `off` at most.
    /// `corners`: those at the samples, which say more where it is nearly 0; `None` where the ray may lie in a face.
    Along { powers: [[f64; 4]; 3], off: f64, unit: f64, corners: Option<Corners> },
    /// Nothing is known of them.
    Unknown,
}

/// The gradient on a part of a cell.
pub(super) struct Slopes {
    /// Its components, in units of `unit`.
    pub(super) gradient: [Series; 3],
    /// Its square, in units of the square of that.
    pub(super) square: Series,
    pub(super) unit: f64,
}

impl Gradients {
    /// Returns the gradients of a scene; `None` where nothing looks at them.
    pub(super) fn new(scene: &Scene, volume: &GridVolume) -> Option<Self> {
        let shading = looks_at_gradients(scene).then(|| scene.gradient_shading())??;
        let (matrix, unit) = volume.placement().scaled_gradient_matrix(volume.calibration().slope);
        let to_world = std::array::from_fn(|a| matrix.row(a).to_array());
        Some(Self { analytic: shading.gradient == GradientMethod::Analytic, to_world, unit })
    }

    /// Returns those of a field that gives its own, in the world; `None` where nothing looks at them.
    pub(super) fn of_field(scene: &Scene) -> Option<Self> {
        let to_world = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        looks_at_gradients(scene).then_some(Self { analytic: true, to_world, unit: 1.0 })
    }

    /// Returns the gradient along a cell of a field that is trilinear, or, if `constant`, the same in all of the cell.
    pub(super) fn along<T: Voxel>(&self, lattice: &Lattice<'_, T>, crossed: &Crossed, constant: bool) -> Normals {
        if self.analytic && constant {
            return Normals::Absent;
        }
        let corner = |i: usize| std::array::from_fn(|a| crossed.cell[a] + (i >> a & 1));
        let per_index: [[f64; 3]; 8] = if self.analytic {
            let value = std::array::from_fn::<f64, 8, _>(|i| {
                let [x, y, z] = corner(i);
                lattice.at(x, y, z)
            });
            std::array::from_fn(|i| std::array::from_fn(|a| value[i | 1 << a] - value[i & !(1 << a)]))
        } else {
            std::array::from_fn(|i| gradient_at_sample(lattice, corner(i)))
        };
        let [x, y, z] = crossed.cell;
        let turns = |[i, j, k]: [usize; 3]| match self.analytic {
            true => lattice.at::<f64>(i, j, k) != lattice.at::<f64>(x, y, z),
            false => gradient_at_sample::<T, f64>(lattice, [i, j, k]) != [0.0; 3],
        };
        self.between(&per_index, crossed, || crossed.any_beyond(lattice.dims, turns))
    }

    /// Returns the gradient along a cell, trilinear between those at its corners, per index step. `turns_beyond`: true if one that is 0 throughout the cell may
    /// not be beyond the faces that the ray may lie in.
    pub(super) fn between(
        &self,
        per_index: &[[f64; 3]; 8],
        crossed: &Crossed,
        turns_beyond: impl FnOnce() -> bool,
    ) -> Normals {
        // Those of the world, and how large the numbers are that they are sums of.
        let (mut world, mut reaches, mut largest) = ([[0.0f64; 8]; 3], [0.0f64; 8], 0.0f64);
        for (i, g) in per_index.iter().enumerate() {
            for (axis, row) in self.to_world.iter().enumerate() {
                let terms = [row[0] * g[0], row[1] * g[1], row[2] * g[2]];
                world[axis][i] = terms[0] + terms[1] + terms[2];
                reaches[i] = reaches[i].max(terms[0].abs() + terms[1].abs() + terms[2].abs());
                largest = largest.max(world[axis][i].abs());
            }
        }
        let reach = reaches.iter().fold(0.0, |m: f64, &r| if r.is_nan() { f64::NAN } else { m.max(r) });
        if !reach.is_finite() {
            return Normals::Unknown;
        }
        if largest == 0.0 {
            return if reach == 0.0 && !turns_beyond() { Normals::Absent } else { Normals::Unknown };
        }
        // Beyond a face that the ray may lie in, the filter's own gradient is another one.
        if self.analytic && crossed.beyond != [[false; 2]; 3] {
            return Normals::Unknown;
        }
        let off = (64.0 * f64::EPSILON + 6.0 * crossed.misplaced) * (reach / largest);
        let world = world.map(|values| values.map(|x| x / largest));
        let powers = world.map(|values| Cubic::across_box(values, &crossed.part).powers());
        let corners = (!crossed.in_face).then(|| Corners {
            world,
            off: reaches.map(|reach| 64.0 * f64::EPSILON * (reach / largest)),
            part: crossed.part,
            misplaced: crossed.misplaced,
        });
        Normals::Along { powers, off, unit: largest * self.unit, corners }
    }

    /// Returns the gradient along a cell by cubics per index step, which are sums of numbers of at most `reach`.
    pub(super) fn by_cubics(&self, cubics: &CubicVector, reach: f64) -> Normals {
        let (rows, CubicVector { powers: per_index, off }) = (&self.to_world, cubics);
        let world: [[f64; 4]; 3] =
            rows.map(|row| std::array::from_fn(|k| (0..3).map(|a| row[a] * per_index[a][k]).sum::<f64>()));
        let gain = rows.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        let off = gain * (off + 16.0 * f64::EPSILON * reach);
        let largest = world.iter().map(|powers| powers.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        if !off.is_finite() || largest == 0.0 {
            return if off == 0.0 { Normals::Absent } else { Normals::Unknown };
        }
        let powers = world.map(|powers| powers.map(|x| x / largest));
        Normals::Along { powers, off: off / largest, unit: largest * self.unit, corners: None }
    }
}

impl Normals {
    /// Returns the gradient on the part [from, to] of a cell, 0 to 1; `None` where nothing is known of it, and where it is 0.
    pub(super) fn on(&self, part: [f64; 2]) -> Option<Slopes> {
        let Self::Along { powers, off, unit, .. } = self else { return None };
        let gradient = powers.map(|p| Series::part_of(&p, part, *off));
        let squares = gradient.map(|g| g.product(&g));
        Some(Slopes { gradient, square: squares[0].plus(&squares[1]).plus(&squares[2]), unit: *unit })
    }

    /// True if the gradient changes by no more than it is off by on the part [from, to] of a cell: shorter parts would tell no more of it.
    pub(super) fn is_blurred(&self, part: [f64; 2]) -> bool {
        let Self::Along { powers, off, .. } = self else { return true };
        let change = |p: &[f64; 4]| Series::part_of(p, part, 0.0).spread();
        powers.iter().map(change).sum::<f64>() <= 4.0 * off
    }
}

/// True if colours or opacities of a scene follow the gradient.
fn looks_at_gradients(scene: &Scene) -> bool {
    scene.reflection().is_some_and(|shading| !shading.is_flat()) || scene.has_gradient_opacity()
}
