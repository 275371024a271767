//! The way of sixteen rays from cell to cell.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16, mask32x16, u32x4, u32x16};
use vr_kernels::vector::{LANES, Lanes, Vectorized, pick, splat, transpose};

use super::links::OUTSIDE;
use super::projected::{ScreenGradient, ScreenVertex};

/// Steps between two looks at what rays have met.
pub(crate) const STEPS: usize = 8;

/// Sixteen rays on their way; a lane stands still whose place is [`OUTSIDE`].
///
/// `N` is the number of attributes: 1 for the value, 4 with the gradient.
pub(crate) struct Sixteen<const N: usize> {
    /// Corners of the side that each ray goes through, counterclockwise around it: x, y and the depth from `base`.
    pub(crate) corners: [[Lanes; 3]; 3],
    /// Attributes of the corners, of which the value is counted from `base`.
    pub(crate) attributes: [[Lanes; N]; 3],
    /// Barycentric coordinates of the ray on it, not normalised.
    pub(crate) weights: [Lanes; 3],
    /// x and y of the ray, and what they lack.
    pub(crate) ray: [Lanes; 4],
    /// Depth and value of a place that each ray passed not long ago, and what they lack: what is counted from there has no digits to lose.
    pub(crate) base: [Lanes; 4],
    /// Largest depth so far, and the attributes at the last side; depth and value from `base`.
    pub(crate) depth: Lanes,
    pub(crate) here: [Lanes; N],
    /// 4 · side + turn.
    pub(crate) places: [u32; LANES],
    /// Steps without progress.
    pub(crate) waited: [i32; LANES],
}

impl<const N: usize> Default for Sixteen<N> {
    fn default() -> Self {
        Self {
            corners: [[Lanes::ZERO; 3]; 3],
            attributes: [[Lanes::ZERO; N]; 3],
            weights: [Lanes::ZERO; 3],
            ray: [Lanes::ZERO; 4],
            base: [Lanes::ZERO; 4],
            depth: Lanes::ZERO,
            here: [Lanes::ZERO; N],
            places: [OUTSIDE; LANES],
            waited: [0; LANES],
        }
    }
}

impl<const N: usize> Sixteen<N> {
    /// Depth and value from which those of a lane are counted.
    #[inline]
    pub(crate) fn base_of(&self, lane: usize) -> [f64; 2] {
        let base = self.base.each_ref().map(|lanes| f64::from(lanes.0[lane]));
        [base[0] + base[2], base[1] + base[3]]
    }

    /// Largest depth of a lane so far.
    pub(crate) fn reached(&self, lane: usize) -> f64 {
        self.base_of(lane)[0] + f64::from(self.depth.0[lane])
    }
}

/// Depths and attributes of sixteen rays at the sides that they pass, from where they stood on; depth and value from [`Sixteen::base`].
pub(crate) struct Trail<const N: usize> {
    pub(crate) depths: [Lanes; STEPS + 1],
    pub(crate) attributes: [[Lanes; N]; STEPS + 1],
}

impl<const N: usize> Default for Trail<N> {
    fn default() -> Self {
        Self { depths: [Lanes::ZERO; STEPS + 1], attributes: [[Lanes::ZERO; N]; STEPS + 1] }
    }
}

/// Walks [`STEPS`] steps of several groups in turn: while one waits for the memory, another goes on.
pub(crate) struct March<'a, const N: usize> {
    pub(crate) scene: MarchScene<'a>,
    pub(crate) rays: &'a mut [Sixteen<N>; GROUPS],
    pub(crate) trails: &'a mut [Trail<N>; GROUPS],
}

/// Groups of sixteen rays that walk in turn.
pub(crate) const GROUPS: usize = 2;

/// A mesh on the screen.
#[derive(Clone, Copy)]
pub(crate) struct MarchScene<'a> {
    pub(crate) links: &'a [[u32; 4]],
    pub(crate) vertices: &'a [ScreenVertex],
    pub(crate) gradients: &'a [ScreenGradient],
    /// See [`super::projected::Projected::widening`].
    pub(crate) widening: f32,
}

/// A corner of a side as sixteen rays see it, each the axis.
#[derive(Clone, Copy)]
struct Corner<S: Simd, const N: usize> {
    /// x, y and depth.
    at: [f32x16<S>; 3],
    attributes: [f32x16<S>; N],
}

/// On which side of the axis the edge from a to b passes: positive if it goes around it counterclockwise. Swapping a and b changes the sign and no digit.
///
/// Also where that is in doubt: a ray that runs along faces finds nothing but rounding here.
#[inline(always)]
fn side<S: Simd, const N: usize>(simd: S, a: &Corner<S, N>, b: &Corner<S, N>) -> (f32x16<S>, mask32x16<S>) {
    let forth = a.at[0] * b.at[1];
    let side = forth - a.at[1] * b.at[0];
    (side, side.abs().simd_le(forth.abs() * splat(simd, DOUBTFUL)))
}

/// Part of two products by which they must differ: some ten times of what rounding takes.
const DOUBTFUL: f32 = 1e-6;
/// Steps without progress of a ray that is in doubt: it is left to the plain code.
const IN_DOUBT: i32 = 1 << 20;

#[inline(always)]
fn load<S: Simd, const N: usize>(simd: S, lanes: &[Lanes; N]) -> [f32x16<S>; N] {
    let mut vectors = [splat(simd, 0.0); N];
    for i in 0..N {
        vectors[i] = lanes[i].load(simd);
    }
    vectors
}

#[inline(always)]
fn store<S: Simd, const N: usize>(vectors: &[f32x16<S>; N], lanes: &mut [Lanes; N]) {
    for i in 0..N {
        lanes[i] = Lanes::new(vectors[i]);
    }
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
    fn corner<const N: usize>(self, x: &Corner<S, N>, y: &Corner<S, N>, z: &Corner<S, N>) -> Corner<S, N> {
        let mut corner = *x;
        for i in 0..3 {
            corner.at[i] = self.of(x.at[i], y.at[i], z.at[i]);
        }
        for i in 0..N {
            corner.attributes[i] = self.of(x.attributes[i], y.attributes[i], z.attributes[i]);
        }
        corner
    }
}

/// [`Sixteen`], in vectors.
struct Group<S: Simd, const N: usize> {
    ray: [f32x16<S>; 4],
    corners: [Corner<S, N>; 3],
    weights: [f32x16<S>; 3],
    base: [f32x16<S>; 4],
    depth: f32x16<S>,
    here: [f32x16<S>; N],
    places: u32x16<S>,
    waited: i32x16<S>,
}

impl<S: Simd, const N: usize> Group<S, N> {
    #[inline(always)]
    fn new(simd: S, rays: &Sixteen<N>) -> Self {
        let ([a, b, c], [p, q, r]) = (&rays.corners, &rays.attributes);
        let corners = [
            Corner { at: load(simd, a), attributes: load(simd, p) },
            Corner { at: load(simd, b), attributes: load(simd, q) },
            Corner { at: load(simd, c), attributes: load(simd, r) },
        ];
        Self {
            ray: load(simd, &rays.ray),
            corners,
            weights: load(simd, &rays.weights),
            base: load(simd, &rays.base),
            depth: rays.depth.load(simd),
            here: load(simd, &rays.here),
            places: u32x16::load_array_ref(simd, &rays.places),
            waited: i32x16::load_array_ref(simd, &rays.waited),
        }
    }

    #[inline(always)]
    fn store(&self, rays: &mut Sixteen<N>) {
        for i in 0..3 {
            store(&self.corners[i].at, &mut rays.corners[i]);
            store(&self.corners[i].attributes, &mut rays.attributes[i]);
        }
        store(&self.weights, &mut rays.weights);
        store(&self.base, &mut rays.base);
        rays.depth = Lanes::new(self.depth);
        store(&self.here, &mut rays.here);
        rays.places = self.places.to_array();
        rays.waited = self.waited.to_array();
    }

    /// Moves the base of each ray to the place where it is.
    #[inline(always)]
    fn rebase(&mut self, simd: S) {
        let by = [self.depth, self.here[0]];
        for i in 0..2 {
            // The sum, and what its rounding loses (Knuth's two-sum).
            let sum = self.base[i] + by[i];
            let added = sum - self.base[i];
            let lost = (self.base[i] - (sum - added)) + (by[i] - added);
            (self.base[i], self.base[i + 2]) = (sum, self.base[i + 2] + lost);
        }
        for corner in &mut self.corners {
            corner.at[2] -= by[0];
            corner.attributes[0] -= by[1];
        }
        (self.depth, self.here[0]) = (splat(simd, 0.0), splat(simd, 0.0));
    }

    /// Notes where the rays are.
    #[inline(always)]
    fn mark(&self, trail: &mut Trail<N>, step: usize) {
        trail.depths[step] = Lanes::new(self.depth);
        store(&self.here, &mut trail.attributes[step]);
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
        let (mut rows, mut at, mut depth_value, mut gradients) =
            ([none; LANES], [none; LANES], [none; LANES], [none; LANES]);
        for j in 0..LANES {
            let row = &scene.links[sides[j] as usize];
            let vertex = &scene.vertices[row[0] as usize];
            rows[j] = u32x4::load_array_ref(simd, row).bitcast();
            at[j] = f32x4::load_array_ref(simd, &vertex.place);
            depth_value[j] = f32x4::load_array_ref(simd, &vertex.depth_value);
            if N > 1 {
                gradients[j] = f32x4::load_array_ref(simd, &scene.gradients[row[0] as usize]);
            }
        }
        let rows = transpose(rows);
        let at = transpose(at);
        let [far, value, far_rest, value_rest] = transpose(depth_value);
        let base = &self.base;
        let far_from_base = (far - base[0]) + (far_rest - base[2]);
        let mut attributes = [(value - base[1]) + (value_rest - base[3]); N];
        if N > 1 {
            let gradients = transpose(gradients);
            attributes[1..].copy_from_slice(&gradients[..N - 1]);
        }
        let scale = far * scene.widening + 1.0;
        let x = ((at[0] - ray[0]) + (at[2] - ray[2])) * scale;
        let y = ((at[1] - ray[1]) + (at[3] - ray[3])) * scale;
        let tip = Corner { at: [x, y, far_from_base], attributes };

        // The side that is left by has the ray on the inner side of both of its new edges.
        let ((to_a, doubt_a), (to_b, doubt_b), (to_c, doubt_c)) =
            (side(simd, a, &tip), side(simd, b, &tip), side(simd, c, &tip));
        let doubt = doubt_a | doubt_b | doubt_c;
        let first = to_a.simd_le(zero) & to_b.simd_ge(zero);
        let second = to_b.simd_le(zero) & to_c.simd_ge(zero);
        let exit = Exit { first, second };
        let [u, v, w] = [exit.of(to_b, to_c, to_a), -exit.of(to_a, to_b, to_c), exit.of(w, u, v)];
        let (a, b) = (exit.corner(a, b, c), exit.corner(b, c, a));

        // The ray's place on it. Rounding may make a coordinate negative that should be 0, or all of them 0.
        let (p, q, r) = (u.max(zero), v.max(zero), w.max(zero));
        let sum = p + q + r;
        let flat = !sum.simd_gt(zero);
        let (q, r) = (pick(flat, one, q), pick(flat, one, r));
        let part = one / pick(flat, splat(simd, 3.0), sum);
        let (q, r) = (q * part, r * part);
        let depth = a.at[2] + ((b.at[2] - a.at[2]) * q + (tip.at[2] - a.at[2]) * r);
        for i in 0..N {
            let [x, y, z] = [a.attributes[i], b.attributes[i], tip.attributes[i]];
            self.here[i] = pick(idle, self.here[i], x + ((y - x) * q + (z - x) * r));
        }
        (self.corners, self.weights) = ([a, b, tip], [u, v, w]);

        // Where nothing lies beyond, the ray stands still from then on.
        let further = depth.simd_gt(self.depth);
        let waited = further.select(i32x16::splat(simd, 0), self.waited + 1);
        self.waited = idle.select(self.waited, doubt.select(i32x16::splat(simd, IN_DOUBT), waited));
        self.depth = pick(idle, self.depth, self.depth.max(depth));
        // The names of the corners begin at the turn: the side that is left by is that many further on.
        let number = (first
            .select(i32x16::splat(simd, 0), second.select(i32x16::splat(simd, 1), i32x16::splat(simd, 2))))
            + (self.places & 3).bitcast::<i32x16<S>>();
        let is_first = number.simd_eq(i32x16::splat(simd, 0)) | number.simd_eq(i32x16::splat(simd, 3));
        let is_second = number.simd_eq(i32x16::splat(simd, 1)) | number.simd_eq(i32x16::splat(simd, 4));
        let to = pick(is_first, rows[1], pick(is_second, rows[2], rows[3]));
        self.places = (idle | doubt).select(outside, to.bitcast());
    }

    /// True if a ray is on its way.
    #[inline(always)]
    fn walks(&self, simd: S) -> bool {
        self.places.simd_lt(u32x16::splat(simd, OUTSIDE)).any_true()
    }
}

impl<const N: usize> Vectorized for March<'_, N> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { scene, rays: [rays, more_rays], trails: [trail, more_trail] } = self;
        let (mut group, mut more) = (Group::<S, N>::new(simd, rays), Group::<S, N>::new(simd, more_rays));
        group.rebase(simd);
        more.rebase(simd);
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
