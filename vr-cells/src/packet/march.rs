//! The way of sixteen rays from cell to cell.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16, mask32x16, u32x4, u32x16};
use vr_kernels::vector::{LANES, Lanes, Vectorized, pick, splat, transpose};

use super::links::OUTSIDE;
use super::projected::ScreenVertex;

/// Steps between two looks at what rays have met.
pub(crate) const STEPS: usize = 8;

/// Sixteen rays on their way; a lane stands still whose place is [`OUTSIDE`].
pub(crate) struct Sixteen {
    /// Corners of the side that each ray goes through, counterclockwise around it: x, y, depth and value.
    pub(crate) corners: [[Lanes; 4]; 3],
    /// Barycentric coordinates of the ray on it, not normalised.
    pub(crate) weights: [Lanes; 3],
    /// x and y of the ray, and what they lack.
    pub(crate) ray: [Lanes; 4],
    /// Largest depth so far, and the value at the last side.
    pub(crate) reached: [Lanes; 2],
    /// 4 · side + turn.
    pub(crate) places: [u32; LANES],
    /// Steps without progress.
    pub(crate) waited: [i32; LANES],
}

impl Default for Sixteen {
    fn default() -> Self {
        Self {
            corners: [[Lanes::ZERO; 4]; 3],
            weights: [Lanes::ZERO; 3],
            ray: [Lanes::ZERO; 4],
            reached: [Lanes::ZERO; 2],
            places: [OUTSIDE; LANES],
            waited: [0; LANES],
        }
    }
}

/// Depths and values of sixteen rays at the sides that they pass, from where they stood on.
pub(crate) struct Trail {
    pub(crate) depths: [Lanes; STEPS + 1],
    pub(crate) values: [Lanes; STEPS + 1],
}

impl Default for Trail {
    fn default() -> Self {
        Self { depths: [Lanes::ZERO; STEPS + 1], values: [Lanes::ZERO; STEPS + 1] }
    }
}

/// Walks [`STEPS`] steps.
pub(crate) struct March<'a> {
    pub(crate) links: &'a [[u32; 4]],
    pub(crate) vertices: &'a [ScreenVertex],
    /// See [`super::projected::Projected::widening`].
    pub(crate) widening: f32,
    pub(crate) rays: &'a mut Sixteen,
    pub(crate) trail: &'a mut Trail,
}

/// A corner of a side as sixteen rays see it, each the axis: x, y, depth, value.
type Corner<S> = [f32x16<S>; 4];

/// On which side of the axis the edge from a to b passes: positive if it goes around it counterclockwise. Swapping a and b changes the sign and no digit.
#[inline(always)]
fn side<S: Simd>(a: &Corner<S>, b: &Corner<S>) -> f32x16<S> {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
fn load<S: Simd>(simd: S, corner: &[Lanes; 4]) -> Corner<S> {
    [corner[0].load(simd), corner[1].load(simd), corner[2].load(simd), corner[3].load(simd)]
}

#[inline(always)]
fn store<S: Simd>(corner: Corner<S>) -> [Lanes; 4] {
    [Lanes::new(corner[0]), Lanes::new(corner[1]), Lanes::new(corner[2]), Lanes::new(corner[3])]
}

/// The side by which each ray leaves: that of the first edge, of the second, or of the third.
#[derive(Clone, Copy)]
struct Exit<S: Simd> {
    first: mask32x16<S>,
    second: mask32x16<S>,
}

impl<S: Simd> Exit<S> {
    /// One of three by the side.
    #[inline(always)]
    fn of(self, x: f32x16<S>, y: f32x16<S>, z: f32x16<S>) -> f32x16<S> {
        pick(self.first, x, pick(self.second, y, z))
    }

    #[inline(always)]
    fn corner(self, x: &Corner<S>, y: &Corner<S>, z: &Corner<S>) -> Corner<S> {
        [self.of(x[0], y[0], z[0]), self.of(x[1], y[1], z[1]), self.of(x[2], y[2], z[2]), self.of(x[3], y[3], z[3])]
    }
}

impl Vectorized for March<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { links, vertices, widening, rays, trail } = self;
        let ray = load(simd, &rays.ray);
        let [mut a, mut b, mut c] =
            [load(simd, &rays.corners[0]), load(simd, &rays.corners[1]), load(simd, &rays.corners[2])];
        let [mut u, mut v, mut w] =
            [rays.weights[0].load(simd), rays.weights[1].load(simd), rays.weights[2].load(simd)];
        let [mut depth, mut value] = [rays.reached[0].load(simd), rays.reached[1].load(simd)];
        let mut places = u32x16::load_array_ref(simd, &rays.places);
        let mut waited = i32x16::load_array_ref(simd, &rays.waited);
        let (zero, outside) = (splat(simd, 0.0), u32x16::splat(simd, OUTSIDE));
        let numbers = [
            i32x16::splat(simd, 0),
            i32x16::splat(simd, 1),
            i32x16::splat(simd, 2),
            i32x16::splat(simd, 3),
            i32x16::splat(simd, 4),
        ];
        trail.depths[0] = Lanes::new(depth);
        trail.values[0] = Lanes::new(value);

        for step in 1..=STEPS {
            // The vertex across, and what lies behind the three other sides.
            let idle = places.simd_eq(outside);
            let sides = idle.select(u32x16::splat(simd, 0), places >> 2).to_array();
            let turns = places & 3;
            let none = f32x4::splat(simd, 0.0);
            let (mut rows, mut at, mut attributes) = ([none; LANES], [none; LANES], [none; LANES]);
            for j in 0..LANES {
                let row = &links[sides[j] as usize];
                let vertex = &vertices[row[0] as usize];
                rows[j] = u32x4::load_array_ref(simd, row).bitcast();
                at[j] = f32x4::load_array_ref(simd, &vertex.place);
                attributes[j] = f32x4::load_array_ref(simd, &vertex.depth_value);
            }
            let rows = transpose(rows);
            let at = transpose(at);
            let [far, there, ..] = transpose(attributes);
            let scale = far * widening + 1.0;
            let tip = [
                ((at[0] - ray[0]) + (at[2] - ray[2])) * scale,
                ((at[1] - ray[1]) + (at[3] - ray[3])) * scale,
                far,
                there,
            ];

            // The side that is left by has the ray on the inner side of both of its new edges.
            let (to_a, to_b, to_c) = (side(&a, &tip), side(&b, &tip), side(&c, &tip));
            let first = to_a.simd_le(zero) & to_b.simd_ge(zero);
            let second = to_b.simd_le(zero) & to_c.simd_ge(zero);
            let exit = Exit { first, second };
            [u, v, w] = [exit.of(to_b, to_c, to_a), -exit.of(to_a, to_b, to_c), exit.of(w, u, v)];
            (a, b, c) = (exit.corner(&a, &b, &c), exit.corner(&b, &c, &a), tip);

            // The ray's place on it. Rounding may make a coordinate negative that should be 0, or all of them 0.
            let (p, q, r) = (u.max(zero), v.max(zero), w.max(zero));
            let sum = p + q + r;
            let flat = !sum.simd_gt(zero);
            let one = splat(simd, 1.0);
            let (p, q, r) = (pick(flat, one, p), pick(flat, one, q), pick(flat, one, r));
            let part = one / pick(flat, splat(simd, 3.0), sum);
            let new_depth = (a[2] * p + b[2] * q + c[2] * r) * part;
            let new_value = (a[3] * p + b[3] * q + c[3] * r) * part;

            // Where nothing lies beyond, the ray stands still from then on.
            let further = new_depth.simd_gt(depth);
            waited = further.select(i32x16::splat(simd, 0), waited + 1);
            depth = pick(idle, depth, depth.max(new_depth));
            value = pick(idle, value, new_value);
            trail.depths[step] = Lanes::new(depth);
            trail.values[step] = Lanes::new(value);
            let [zeroth, one_on, two_on, three_on, four_on] = numbers;
            let left = first.select(zeroth, second.select(one_on, two_on)) + turns.bitcast::<i32x16<S>>();
            let is_first = left.simd_eq(zeroth) | left.simd_eq(three_on);
            let is_second = left.simd_eq(one_on) | left.simd_eq(four_on);
            let to = pick(is_first, rows[1], pick(is_second, rows[2], rows[3]));
            places = idle.select(outside, to.bitcast());
            if !places.simd_lt(outside).any_true() {
                for later in step + 1..=STEPS {
                    trail.depths[later] = Lanes::new(depth);
                    trail.values[later] = Lanes::new(value);
                }
                break;
            }
        }

        rays.corners = [store(a), store(b), store(c)];
        rays.weights = [Lanes::new(u), Lanes::new(v), Lanes::new(w)];
        rays.reached = [Lanes::new(depth), Lanes::new(value)];
        rays.places = places.to_array();
        rays.waited = waited.to_array();
    }
}
