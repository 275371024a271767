//! Shading by rays of many directions: in perspective, what a normal reflects differs from ray to ray, and no table of normals serves.
//!
//! Each texel's own ray decides: lights and half vectors are made for sixteen texels at a time, and every normal around a sample is asked what it
//! reflects to them. So nothing is interpolated that a table of normals would not interpolate, too. Voxels and normals are gathered once for sixteen columns, as they lie.

use std::sync::LazyLock;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use glam::DVec3;
use vr_core::{Light, Shading};
use vr_kernels::vector::{LANES, pick, power_of, splat, transpose};

use super::cells::{Edges, Places, STEPS_F32};
use super::kernel::Chunk;
use super::over::Over;
use crate::codes::Code;
use crate::factorization::{Factorization, IndexView};
use crate::reflections::{CODES, decode};

/// Unit normal of every code, and 0; zeros and 1 for the code of no normal.
static NORMALS: LazyLock<Box<[[f32; 4]; NORMALS_LEN]>> = LazyLock::new(|| {
    let of = |code: usize| decode(code as u16).map_or([0.0, 0.0, 0.0, 1.0], |n| n.as_vec3().extend(0.0).to_array());
    let mut all: Vec<_> = (0..CODES).map(of).collect();
    all.resize(NORMALS_LEN, [0.0; 4]);
    all.try_into().expect("as many as there are")
});

/// Length of a table of normals: a code that cannot be beyond it is not tested.
const NORMALS_LEN: usize = CODES.next_power_of_two();

/// Shading and lights, and the directions of the texels' rays.
pub(crate) struct RayLights {
    normals: &'static [[f32; 4]; NORMALS_LEN],
    ambient: f32,
    diffuse: f32,
    specular: f32,
    power: Power,
    lights: Vec<DirectedLight>,
    /// World vector from texel (0, 0) back to the eye, of any length, and its change from a texel to the next one to the right, and to the one below.
    to_eye: [DVec3; 3],
}

struct DirectedLight {
    /// Unit vector towards the light; `None` for a light at the eye.
    to_light: Option<[f32; 3]>,
    color: [f32; 3],
}

/// A vector each for sixteen texels.
type Vectors<S> = [f32x16<S>; 3];

impl RayLights {
    pub(crate) fn new(shading: &Shading, lights: &[Light], view: &IndexView, factorization: &Factorization) -> Self {
        let back = |x: f64, y: f64| -factorization.sign * view.world_vector(factorization.step(x, y));
        let origin = back(0.0, 0.0);
        let lights = lights.iter().map(|light| DirectedLight {
            to_light: light.direction.map(|d| d.normalize().as_vec3().to_array()),
            color: light.color.map(|c| c as f32),
        });
        Self {
            normals: &NORMALS,
            ambient: shading.ambient as f32,
            diffuse: shading.diffuse as f32,
            specular: shading.specular as f32,
            power: Power::new(shading.power),
            lights: lights.collect(),
            to_eye: [origin, back(1.0, 0.0) - origin, back(0.0, 1.0) - origin],
        }
    }

    /// Unit vectors to the eye of the sixteen texels from (x, y) on.
    #[inline(always)]
    fn to_eye<S: Simd>(&self, simd: S, x: usize, y: usize) -> Vectors<S> {
        let [origin, right, down] = self.to_eye;
        let first = origin + x as f64 * right + y as f64 * down;
        let steps = f32x16::load_array_ref(simd, &STEPS_F32);
        let (first, right) = (first.as_vec3(), right.as_vec3());
        unit(simd, [steps * right.x + first.x, steps * right.y + first.y, steps * right.z + first.z])
    }

    /// Sixteen normals.
    #[inline(always)]
    fn normals<S: Simd>(&self, simd: S, codes: &[u16; LANES]) -> [f32x16<S>; 4] {
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            rows[i] = f32x4::load_array_ref(simd, &self.normals[usize::from(codes[i]) % NORMALS_LEN]);
        }
        transpose(rows)
    }

    /// The factors on the three colours, and the light added to what is opaque, of sixteen normals along each of some edges.
    #[inline(always)]
    fn reflections<S: Simd, const N: usize>(
        &self,
        simd: S,
        normals: &[[f32x16<S>; 4]; N],
        to_eye: &Vectors<S>,
    ) -> [[Vectors<S>; 2]; N] {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let mut all = [[[zero; 3]; 2]; N];
        for e in 0..N {
            // No normal, no shading.
            let flat = normals[e][3];
            all[e][0] = [(one - flat) * self.ambient + flat; 3];
        }
        for light in &self.lights {
            // The cosine between a normal and a light, and the highlight's base.
            let mut cosines = [[zero; 2]; N];
            if let Some([x, y, z]) = light.to_light {
                let to_light = [splat(simd, x), splat(simd, y), splat(simd, z)];
                let half = unit(simd, [to_light[0] + to_eye[0], to_light[1] + to_eye[1], to_light[2] + to_eye[2]]);
                for e in 0..N {
                    cosines[e] = [cosine(simd, &normals[e], &to_light), cosine(simd, &normals[e], &half)];
                }
            } else {
                for e in 0..N {
                    cosines[e] = [cosine(simd, &normals[e], to_eye); 2];
                }
            }
            for e in 0..N {
                let lit = one - normals[e][3];
                let facing = cosines[e][0] * self.diffuse * lit;
                let highlight = self.power.of(simd, cosines[e][1]) * self.specular * lit;
                for c in 0..3 {
                    all[e][0][c] += facing * light.color[c];
                    all[e][1][c] += highlight * light.color[c];
                }
            }
        }
        all
    }
}

/// Cosines between normals, of either side, and unit vectors.
#[inline(always)]
fn cosine<S: Simd>(simd: S, [x, y, z, _]: &[f32x16<S>; 4], v: &Vectors<S>) -> f32x16<S> {
    (*x * v[0] + *y * v[1] + *z * v[2]).abs().min(splat(simd, 1.0))
}

/// The highlight's exponent.
enum Power {
    /// A whole exponent, found by squaring; and the smallest base that is raised, so that no power is subnormal.
    Whole(u32, f32),
    Any(f32),
}

impl Power {
    fn new(power: f64) -> Self {
        /// Largest exponent for which the rounding of the squares stays below 10⁻⁵.
        const LARGEST: f64 = 128.0;
        if power.fract() == 0.0 && power <= LARGEST {
            return Self::Whole(power as u32, if power > 0.0 { libm::exp(-69.0 / power) as f32 } else { 0.0 });
        }
        Self::Any(power as f32)
    }

    /// The power of numbers in [0, 1].
    #[inline(always)]
    fn of<S: Simd>(&self, simd: S, x: f32x16<S>) -> f32x16<S> {
        let one = splat(simd, 1.0);
        match *self {
            Self::Whole(mut power, smallest) => {
                let (mut product, mut square) = (one, x.max(splat(simd, smallest)));
                while power > 1 {
                    if power & 1 == 1 {
                        product *= square;
                    }
                    square *= square;
                    power >>= 1;
                }
                if power == 1 { product * square } else { product }
            }
            Self::Any(power) => power_of(simd, x, power),
        }
    }
}

/// The vectors with length 1; zero where they have no direction.
#[inline(always)]
fn unit<S: Simd>(simd: S, [x, y, z]: Vectors<S>) -> Vectors<S> {
    let square = x * x + y * y + z * z;
    let some = square.simd_gt(splat(simd, f32::MIN_POSITIVE));
    let one = splat(simd, 1.0);
    let inverse = pick(some, one / pick(some, square, one).sqrt(), splat(simd, 0.0));
    [x * inverse, y * inverse, z * inverse]
}

/// Shaded light of sixteen samples.
#[inline(always)]
fn lit<S: Simd>([r, g, b, alpha]: [f32x16<S>; 4], [factor, added]: [Vectors<S>; 2]) -> [f32x16<S>; 4] {
    let (red, green) = (r * factor[0] + added[0] * alpha, g * factor[1] + added[1] * alpha);
    [red, green, b * factor[2] + added[2] * alpha, alpha]
}

/// True if any of sixteen samples has light or opacity.
#[inline(always)]
fn any<S: Simd>(simd: S, [r, g, b, alpha]: [f32x16<S>; 4]) -> bool {
    (r + g + b + alpha).simd_gt(splat(simd, 0.0)).any_true()
}

impl<P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8> Over<'_, P, PRE_CLASSIFIED, SHADING> {
    /// Normals at the left and at the right of sixteen texels, along each edge.
    #[inline(always)]
    fn normals_beside<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        places: &Places<S>,
    ) -> [[[f32x16<S>; 4]; N]; 2] {
        let rays = self.rays.expect("made where rays are shaded one by one");
        let mut beside = [[[splat(simd, 0.0); 4]; N]; 2];
        for e in 0..N {
            let codes = self.normals[edges.at[e] + places.first..].first_chunk().expect("room behind the last");
            let normals = rays.normals(simd, codes);
            for c in 0..4 {
                [beside[0][e][c], beside[1][e][c]] = places.beside::<UNIT>(simd, normals[c]);
            }
        }
        beside
    }

    /// Samples shaded by what reflects at the voxels around them to each texel's ray, interpolated.
    #[inline(always)]
    pub(super) fn lit_by_rays<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        places: &Places<S>,
        at: &Chunk,
        samples: [f32x16<S>; 4],
    ) -> [f32x16<S>; 4] {
        if !any(simd, samples) {
            return samples;
        }
        let rays = self.rays.expect("made where rays are shaded one by one");
        let to_eye = rays.to_eye(simd, at.x, at.y);
        let normals = self.normals_beside::<S, N, UNIT>(simd, edges, places);
        let mut mean = [[splat(simd, 0.0); 3]; 2];
        for right in 0..2 {
            let reflections = rays.reflections(simd, &normals[right], &to_eye);
            for e in 0..N {
                let weight = places.weight_beside(simd, right) * edges.weights[e];
                for i in 0..2 {
                    for c in 0..3 {
                        mean[i][c] += reflections[e][i][c] * weight;
                    }
                }
            }
        }
        lit(samples, mean)
    }

    /// Classified voxels, each shaded for the texel's ray, and interpolated.
    #[inline(always)]
    pub(super) fn of_voxels_by_rays<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        table: &P::Table,
        edges: &Edges<N>,
        places: &Places<S>,
        at: &Chunk,
    ) -> [f32x16<S>; 4] {
        let nothing = splat(simd, 0.0);
        let mut samples = [[[nothing; 4]; N]; 2];
        let mut all = nothing;
        for e in 0..N {
            let voxels: &[P; LANES] =
                self.voxels[edges.at[e] + places.first..].first_chunk().expect("room behind the last");
            let mut rows = [f32x4::splat(simd, 0.0); LANES];
            for i in 0..LANES {
                rows[i] = f32x4::load_array_ref(simd, self.row(table, voxels[i]));
            }
            let columns = transpose(rows);
            for c in 0..4 {
                all += columns[c];
                [samples[0][e][c], samples[1][e][c]] = places.beside::<UNIT>(simd, columns[c]);
            }
        }
        let mut sum = [nothing; 4];
        if !all.simd_gt(nothing).any_true() {
            return sum;
        }
        let rays = self.rays.expect("made where rays are shaded one by one");
        let to_eye = rays.to_eye(simd, at.x, at.y);
        let normals = self.normals_beside::<S, N, UNIT>(simd, edges, places);
        for right in 0..2 {
            let reflections = rays.reflections(simd, &normals[right], &to_eye);
            for e in 0..N {
                let weight = places.weight_of_voxels(simd, right) * edges.of_voxels[e];
                let shaded = lit(samples[right][e], reflections[e]);
                for c in 0..4 {
                    sum[c] += shaded[c] * weight;
                }
            }
        }
        let counts = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, at.n as f32));
        for c in 0..4 {
            sum[c] = pick(counts, sum[c], nothing);
        }
        sum
    }
}
