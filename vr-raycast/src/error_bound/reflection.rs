//! Light that is reflected along a ray, with a bound of what it is off by.

use std::sync::Arc;

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::{GradientMethod, GridVolume, Light, RayShading, Scene, Shading, Voxel, gradient_at_sample};

use super::cone::{Cone, Corners};
use super::crossed::Crossed;
use super::cubic::Cubic;
use super::series::Series;

/// Largest rest of 1/|g|, relative to it, at which nothing else is asked.
const MAX_REST: f64 = 0.01;

/// Reflection in a scene: what holds for all rays.
#[derive(Clone, Debug)]
pub(super) struct Reflection {
    pub(super) shading: Arc<Shading>,
    pub(super) lights: Vec<Light>,
    /// True if no light has a colour, so that all channels change alike.
    is_grey: bool,
    /// Rows of the matrix from gradients per index step to the world, by a common factor.
    pub(super) to_world: [[f64; 3]; 3],
    /// Largest component of reflected light, for colours of at most the largest.
    pub(super) brightest: f64,
}

/// Reflection along one ray.
#[derive(Clone, Debug)]
pub(super) struct RayReflection<'a> {
    reflection: &'a Reflection,
    ray: RayShading<f64>,
}

/// The gradient along a cell.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, on the stack")]
pub(super) enum Normals {
    /// None: it is 0 throughout, or the scene does not reflect. Colours stay.
    Absent,
    /// World gradient by the powers of a parameter from 0 to 1 along the cell, relative to its largest component there; each component is off by `off` at most.
    /// `corners`: those at the samples, which say more where it is nearly 0; `None` where the ray may lie in a face.
    Along { powers: [[f64; 4]; 3], off: f64, corners: Option<Corners> },
    /// Nothing is known of them.
    Unknown,
}

/// Change of colours by reflection on a part of a cell: each channel c becomes c · `factor` + `added`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reflected {
    pub(super) factor: [Series; 3],
    pub(super) added: [Series; 3],
}

impl Reflected {
    /// Returns the light of a colour's channel.
    pub(super) fn of(&self, color: &Series, channel: usize) -> Series {
        color.product(&self.factor[channel]).plus(&self.added[channel])
    }
}

impl Reflection {
    /// Returns the reflection of a scene; `None` where its colours stay as they are.
    pub(super) fn new(scene: &Scene, volume: &GridVolume, brightest: f64) -> Option<Self> {
        let shading = scene.reflection().filter(|shading| !shading.is_flat()).cloned()?;
        let (matrix, _) = volume.placement().scaled_gradient_matrix(volume.calibration().slope);
        let to_world = std::array::from_fn(|a| matrix.row(a).to_array());
        let brightest = shading.max_radiance(&scene.lights, brightest);
        let is_grey = scene.lights.iter().all(|light| light.color.iter().all(|c| *c == light.color[0]));
        Some(Self { shading, lights: scene.lights.clone(), is_grey, to_world, brightest })
    }

    pub(super) fn along(&self, direction: DVec3) -> RayReflection<'_> {
        RayReflection { reflection: self, ray: self.shading.along(&self.lights, direction) }
    }
}

impl RayReflection<'_> {
    /// Returns the gradient along a cell. `constant`: the field is, as under the filter nearest.
    pub(super) fn normals<T: Voxel>(&self, lattice: &Lattice<'_, T>, crossed: &Crossed, constant: bool) -> Normals {
        let corner = |i: usize| std::array::from_fn(|a| crossed.cell[a] + (i >> a & 1));
        let analytic = self.reflection.shading.gradient == GradientMethod::Analytic;
        if analytic && constant {
            return Normals::Absent;
        }
        // Gradients per index step at the corners.
        let per_index: [[f64; 3]; 8] = if analytic {
            let value = std::array::from_fn::<f64, 8, _>(|i| {
                let [x, y, z] = corner(i);
                lattice.at(x, y, z)
            });
            std::array::from_fn(|i| std::array::from_fn(|a| value[i | 1 << a] - value[i & !(1 << a)]))
        } else {
            std::array::from_fn(|i| gradient_at_sample(lattice, corner(i)))
        };
        // Those of the world, and how large the numbers are that they are sums of.
        let rows = &self.reflection.to_world;
        let (mut world, mut reaches, mut largest) = ([[0.0f64; 8]; 3], [0.0f64; 8], 0.0f64);
        for (i, g) in per_index.iter().enumerate() {
            for (axis, row) in rows.iter().enumerate() {
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
            return if reach == 0.0 && !turns_beyond(lattice, crossed, analytic) {
                Normals::Absent
            } else {
                Normals::Unknown
            };
        }
        // Beyond a face that the ray may lie in, the filter's own gradient is another one.
        if analytic && crossed.beyond != [[false; 2]; 3] {
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
        Normals::Along { powers, off, corners }
    }

    /// Returns the change of colours on the part [from, to] of a cell, 0 to 1.
    pub(super) fn on(&self, normals: &Normals, part: [f64; 2]) -> Reflected {
        let ray = &self.ray;
        let Normals::Along { powers, off, corners } = normals else {
            if matches!(normals, Normals::Absent) {
                return Reflected { factor: [Series::constant(1.0); 3], added: [Series::constant(0.0); 3] };
            }
            return self.anything();
        };
        let gradient = powers.map(|p| Series::part_of(&p, part, *off));
        let squares = gradient.map(|g| g.product(&g));
        let square = squares[0].plus(&squares[1]).plus(&squares[2]);
        let inverse = square.inverse_root();
        // Where it changes much, the directions at the samples say more.
        let is_known = inverse.is_some_and(|inverse| inverse.rest <= MAX_REST * inverse.c[0]);
        let cone = if is_known { None } else { corners.as_ref().and_then(|corners| corners.cone(part)) };
        if inverse.is_none() && cone.is_none() {
            return self.anything();
        }
        let cosine = |v: &[f64; 3]| cosine(&gradient, v, inverse.as_ref(), cone.as_ref());
        let mut reflected = Reflected { factor: [Series::constant(ray.ambient); 3], added: [Series::constant(0.0); 3] };
        for light in &ray.lights {
            let to_light = cosine(&light.to_light);
            // A headlight's half vector is the direction to it.
            let half = if light.half == light.to_light { to_light } else { cosine(&light.half) };
            let (facing, highlight) = (to_light.times(ray.diffuse), raised(&half, ray.power).times(ray.specular));
            for c in 0..if self.reflection.is_grey { 1 } else { 3 } {
                reflected.factor[c] = reflected.factor[c].plus(&facing.times(light.color[c]));
                reflected.added[c] = reflected.added[c].plus(&highlight.times(light.color[c]));
            }
        }
        if self.reflection.is_grey {
            reflected = Reflected { factor: [reflected.factor[0]; 3], added: [reflected.added[0]; 3] };
        }
        reflected
    }

    /// Returns all that reflection may make of colours.
    fn anything(&self) -> Reflected {
        let ray = &self.ray;
        let total = |c: usize| ray.lights.iter().map(|l| l.color[c]).sum::<f64>();
        let factor = |c: usize| (ray.ambient.min(1.0), (ray.ambient + ray.diffuse * total(c)).max(1.0));
        Reflected {
            factor: std::array::from_fn(|c| Series::between(factor(c).0, factor(c).1)),
            added: std::array::from_fn(|c| Series::between(0.0, ray.specular * total(c))),
        }
    }
}

/// True if a gradient that is 0 throughout a cell may not be beyond the faces that the ray may lie in.
fn turns_beyond<T: Voxel>(lattice: &Lattice<'_, T>, crossed: &Crossed, analytic: bool) -> bool {
    let [x, y, z] = crossed.cell;
    let here: f64 = lattice.at(x, y, z);
    let beyond = |a: usize| {
        let [low, high] = crossed.beyond[a].map(usize::from);
        crossed.cell[a].saturating_sub(low)..=(crossed.cell[a] + 1 + high).min(lattice.dims[a] - 1)
    };
    let turns = |x: usize, y: usize, z: usize| match analytic {
        true => lattice.at::<f64>(x, y, z) != here,
        false => gradient_at_sample::<T, f64>(lattice, [x, y, z]) != [0.0; 3],
    };
    crossed.beyond != [[false; 2]; 3] && beyond(2).any(|z| beyond(1).any(|y| beyond(0).any(|x| turns(x, y, z))))
}

/// Returns the cosine |g·v|/|g|, 0 to 1, between a gradient and a unit vector: as a series by 1/|g|, if that says more than the gradient's cone.
fn cosine(gradient: &[Series; 3], v: &[f64; 3], inverse: Option<&Series>, cone: Option<&Cone>) -> Series {
    let mut range = cone.map_or([0.0, 1.0], |cone| cone.cosine(v));
    let Some(inverse) = inverse else { return Series::between(range[0], range[1]) };
    let [x, y, z] = std::array::from_fn(|a| gradient[a].times(v[a]));
    let towards = x.plus(&y).plus(&z);
    let [low, high] = inverse.range();
    let (middle, spread) = (towards.c[0].abs(), towards.spread());
    range[1] = range[1].min((middle + spread) * high);
    range[0] = range[0].max((middle - spread).max(0.0) * low.max(0.0)).min(range[1]);
    let range = Series::between(range[0], range[1]);
    towards.magnitude().map_or(range, |m| m.product(inverse).or(range))
}

/// Returns a power of a cosine.
fn raised(cosine: &Series, power: f64) -> Series {
    let range = || {
        let [low, high] = cosine.range().map(|x| libm::pow(x.clamp(0.0, 1.0), power));
        Series::between(low, high)
    };
    match cosine.power(power) {
        // So little that its range need not be looked at.
        Some(series) if series.rest <= 1e-3 => series,
        Some(series) => series.or(range()),
        None => range(),
    }
}
