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

/// Walks [`STEPS`] steps of several groups in turn: while one waits for the memory, another goes on.
pub(crate) struct March<'a> {
    pub(crate) scene: MarchScene<'a>,
    pub(crate) rays: &'a mut [Sixteen; GROUPS],
    pub(crate) trails: &'a mut [Trail; GROUPS],
}

/// Groups of sixteen rays that walk in turn.
pub(crate) const GROUPS: usize = 2;

/// A mesh on the screen.
#[derive(Clone, Copy)]
pub(crate) struct MarchScene<'a> {
    pub(crate) links: &'a [[u32; 4]],
    pub(crate) vertices: &'a [ScreenVertex],
    /// See [`super::projected::Projected::widening`].
    pub(crate) widening: f32,
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

/// [`Sixteen`], in vectors.
struct Group<S: Simd> {
    ray: [f32x16<S>; 4],
    corners: [Corner<S>; 3],
    weights: [f32x16<S>; 3],
    depth: f32x16<S>,
    value: f32x16<S>,
    places: u32x16<S>,
    waited: i32x16<S>,
}

impl<S: Simd> Group<S> {
    #[inline(always)]
    fn new(simd: S, rays: &Sixteen) -> Self {
        let [a, b, c] = &rays.corners;
        let [u, v, w] = &rays.weights;
        Self {
            ray: load(simd, &rays.ray),
            corners: [load(simd, a), load(simd, b), load(simd, c)],
            weights: [u.load(simd), v.load(simd), w.load(simd)],
            depth: rays.reached[0].load(simd),
            value: rays.reached[1].load(simd),
            places: u32x16::load_array_ref(simd, &rays.places),
            waited: i32x16::load_array_ref(simd, &rays.waited),
        }
    }

    #[inline(always)]
    fn store(&self, rays: &mut Sixteen) {
        let [a, b, c] = self.corners;
        let [u, v, w] = self.weights;
        rays.corners = [store(a), store(b), store(c)];
        rays.weights = [Lanes::new(u), Lanes::new(v), Lanes::new(w)];
        rays.reached = [Lanes::new(self.depth), Lanes::new(self.value)];
        rays.places = self.places.to_array();
        rays.waited = self.waited.to_array();
    }

    /// Notes where the rays are.
    #[inline(always)]
    fn mark(&self, trail: &mut Trail, step: usize) {
        trail.depths[step] = Lanes::new(self.depth);
        trail.values[step] = Lanes::new(self.value);
    }

    /// Goes through one cell.
    #[inline(always)]
    fn step(&mut self, simd: S, scene: &MarchScene<'_>) {
        let (zero, one, outside) = (splat(simd, 0.0), splat(simd, 1.0), u32x16::splat(simd, OUTSIDE));
        let ray = &self.ray;
        let [a, b, c] = &self.corners;
        let [u, v, w] = self.weights;

        // The vertex across, and what lies behind the three other sides.
        let idle = self.places.simd_eq(outside);
        let sides = idle.select(u32x16::splat(simd, 0), self.places >> 2).to_array();
        let none = f32x4::splat(simd, 0.0);
        let (mut rows, mut at, mut attributes) = ([none; LANES], [none; LANES], [none; LANES]);
        for j in 0..LANES {
            let row = &scene.links[sides[j] as usize];
            let vertex = &scene.vertices[row[0] as usize];
            rows[j] = u32x4::load_array_ref(simd, row).bitcast();
            at[j] = f32x4::load_array_ref(simd, &vertex.place);
            attributes[j] = f32x4::load_array_ref(simd, &vertex.depth_value);
        }
        let rows = transpose(rows);
        let at = transpose(at);
        let [far, there, ..] = transpose(attributes);
        let scale = far * scene.widening + 1.0;
        let x = ((at[0] - ray[0]) + (at[2] - ray[2])) * scale;
        let y = ((at[1] - ray[1]) + (at[3] - ray[3])) * scale;
        let tip = [x, y, far, there];

        // The side that is left by has the ray on the inner side of both of its new edges.
        let (to_a, to_b, to_c) = (side(a, &tip), side(b, &tip), side(c, &tip));
        let first = to_a.simd_le(zero) & to_b.simd_ge(zero);
        let second = to_b.simd_le(zero) & to_c.simd_ge(zero);
        let exit = Exit { first, second };
        let [u, v, w] = [exit.of(to_b, to_c, to_a), -exit.of(to_a, to_b, to_c), exit.of(w, u, v)];
        let (a, b) = (exit.corner(a, b, c), exit.corner(b, c, a));

        // The ray's place on it. Rounding may make a coordinate negative that should be 0, or all of them 0.
        let (p, q, r) = (u.max(zero), v.max(zero), w.max(zero));
        let sum = p + q + r;
        let flat = !sum.simd_gt(zero);
        let (p, q, r) = (pick(flat, one, p), pick(flat, one, q), pick(flat, one, r));
        let part = one / pick(flat, splat(simd, 3.0), sum);
        let depth = (a[2] * p + b[2] * q + tip[2] * r) * part;
        let value = (a[3] * p + b[3] * q + tip[3] * r) * part;
        (self.corners, self.weights) = ([a, b, tip], [u, v, w]);

        // Where nothing lies beyond, the ray stands still from then on.
        let further = depth.simd_gt(self.depth);
        self.waited = further.select(i32x16::splat(simd, 0), self.waited + 1);
        self.depth = pick(idle, self.depth, self.depth.max(depth));
        self.value = pick(idle, self.value, value);
        // The names of the corners begin at the turn: the side that is left by is that many further on.
        let number = (first
            .select(i32x16::splat(simd, 0), second.select(i32x16::splat(simd, 1), i32x16::splat(simd, 2))))
            + (self.places & 3).bitcast::<i32x16<S>>();
        let is_first = number.simd_eq(i32x16::splat(simd, 0)) | number.simd_eq(i32x16::splat(simd, 3));
        let is_second = number.simd_eq(i32x16::splat(simd, 1)) | number.simd_eq(i32x16::splat(simd, 4));
        let to = pick(is_first, rows[1], pick(is_second, rows[2], rows[3]));
        self.places = idle.select(outside, to.bitcast());
    }

    /// True if a ray is on its way.
    #[inline(always)]
    fn walks(&self, simd: S) -> bool {
        self.places.simd_lt(u32x16::splat(simd, OUTSIDE)).any_true()
    }
}

impl Vectorized for March<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { scene, rays: [rays, more_rays], trails: [trail, more_trail] } = self;
        let (mut group, mut more) = (Group::new(simd, rays), Group::new(simd, more_rays));
        group.mark(trail, 0);
        more.mark(more_trail, 0);
        for step in 1..=STEPS {
            group.step(simd, &scene);
            more.step(simd, &scene);
            group.mark(trail, step);
            more.mark(more_trail, step);
            if !(group.walks(simd) || more.walks(simd)) {
                for later in step + 1..=STEPS {
                    group.mark(trail, later);
                    more.mark(more_trail, later);
                }
                break;
            }
        }
        group.store(rays);
        more.store(more_rays);
    }
}
