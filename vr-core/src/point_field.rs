//! The field of scattered points: its value anywhere, and the points that a ray meets.

use glam::DVec3;

use crate::box_tree::LocalLine;
use crate::parallel::collect;
use crate::point_mixing::PointMixing;
use crate::point_set::PointSet;
use crate::ray::Ray;

/// A support that a ray goes through.
///
/// Distances along the ray are world units behind [`PointCrossings::offset`]: so they keep their digits, however far the ray's origin is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointCrossing {
    /// Number of the point.
    pub point: u32,
    /// Distance along the ray at which it is nearest to the point.
    pub nearest: f64,
    /// Smallest distance of the ray from the point; less than the radius.
    pub distance: f64,
    /// Vector from the point to where the ray is nearest to it, `distance` long.
    pub across: DVec3,
    /// Half the length of the ray inside the support: it enters at `nearest − half` and leaves at `nearest + half`.
    pub half: f64,
    /// Largest error of `nearest`, `distance` and `across` by rounding.
    pub error: f64,
}

/// All supports that a ray goes through.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{PointKernel, PointSet, Ray};
///
/// let points = PointSet::new(vec![DVec3::ZERO], vec![1.0], vec![1.0], vec![1.0], PointKernel::Cone)?;
/// let ray = Ray { origin: DVec3::new(0.6, 0.0, -5.0), direction: DVec3::Z };
/// let crossings = points.crossings(&ray, [0.0, f64::INFINITY]);
/// let crossing = crossings.all[0];
/// assert!((crossings.offset + crossing.nearest - 5.0).abs() < 1e-12);
/// assert!((crossing.distance - 0.6).abs() < 1e-12 && (crossing.half - 0.8).abs() < 1e-12);
/// # Ok::<(), vr_core::PointError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PointCrossings {
    /// World distance along the ray that all others are counted from: that at which the ray is nearest to the middle of the set.
    pub offset: f64,
    /// One for each point, by ascending number of the point.
    pub all: Vec<PointCrossing>,
}

/// Largest number of places that a range of values is taken from.
const MAX_PLACES: usize = 1 << 14;

impl PointSet {
    /// The field at a world position; `None` in vacuum, which is where no support reaches. A support ends before its radius.
    ///
    /// The sum is in f64 and always in the same order.
    pub fn field(&self, at: DVec3) -> Option<f64> {
        if self.mixing() == PointMixing::Mean {
            return self.mean_at(at);
        }
        let mut sum = None;
        self.each_around(at, |k| *sum.get_or_insert(0.0) += self.contribution(k, at));
        sum
    }

    /// The gradient of the field per world unit at a world position, by the kernels' own gradients; `None` in vacuum.
    pub fn gradient(&self, at: DVec3) -> Option<DVec3> {
        if self.mixing() == PointMixing::Mean {
            return self.mean_gradient_at(at);
        }
        let mut sum = None;
        self.each_around(at, |k| *sum.get_or_insert(DVec3::ZERO) += self.contributed_gradient(k, at));
        sum
    }

    /// Calls `visit` with each point whose support holds a world position.
    pub(crate) fn each_around(&self, at: DVec3, mut visit: impl FnMut(usize)) {
        self.index().each_around(at - self.index().middle(), |k| {
            if at.distance(self.positions()[k]) < f64::from(self.radii()[k]) {
                visit(k);
            }
        });
    }

    /// The points whose supports hold a world position, in ascending order.
    pub fn around(&self, at: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        self.each_around(at, |k| found.push(k as u32));
        found.sort_unstable();
        found
    }

    /// The supports that a part of a ray goes through, from one world distance along it to another (+∞ is one).
    ///
    /// A support that is only touched is left out. One that the part lies inside of, or begins or ends in, is given with its whole
    /// chord.
    pub fn crossings(&self, ray: &Ray, [from, to]: [f64; 2]) -> PointCrossings {
        let index = self.index();
        let middle = index.middle();
        let offset = (middle - ray.origin).dot(ray.direction);
        // (origin − middle) + offset · direction, each component off by what it is itself rounded by.
        let component = |a: usize| {
            let (difference, lost) = difference(ray.origin[a], middle[a]);
            offset.mul_add(ray.direction[a], difference) + lost
        };
        let origin = DVec3::new(component(0), component(1), component(2));
        let line = LocalLine { origin, direction: ray.direction, ends: [from - offset, to - offset] };
        let mut all = Vec::new();
        index.each_along(&line, |k| {
            let local = self.positions()[k] - middle;
            let towards = local - origin;
            let nearest = towards.dot(ray.direction);
            let across = ray.direction * nearest - towards;
            let distance = across.length();
            let radius = f64::from(self.radii()[k]);
            let half = ((radius - distance) * (radius + distance)).sqrt();
            if half > 0.0 && nearest + half > line.ends[0] && nearest - half < line.ends[1] {
                let error = 4.0 * f64::EPSILON * (local.length() + origin.length());
                all.push(PointCrossing { point: k as u32, nearest, distance, across, half, error });
            }
        });
        all.sort_unstable_by_key(|c| c.point);
        PointCrossings { offset, all }
    }

    /// Smallest and largest value of the field at the points' own places (at up to 16 384 of them, evenly chosen by number). Elsewhere a sum may
    /// be beyond them, down to 0 at the edge of a support, and a little higher between points; a mean near its edge may, where one point reaches alone. Computed once and kept.
    pub fn value_range(&self) -> (f64, f64) {
        *self.range().get_or_init(|| {
            let places = self.count().min(MAX_PLACES);
            let at = |i: usize| {
                let k = (i as u64 * self.count() as u64 / places as u64) as usize;
                self.field(self.positions()[k]).unwrap_or(0.0)
            };
            let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
            let nothing = (f64::INFINITY, f64::NEG_INFINITY);
            collect(places, at).into_iter().fold(nothing, |range, v| join(range, (v, v)))
        })
    }
}

/// The difference a − b, and its rounding error (Knuth 1969, "The Art of Computer Programming", volume 2, 4.2.2, theorem C).
fn difference(a: f64, b: f64) -> (f64, f64) {
    let d = a - b;
    let taken = a - d;
    (d, (a - (d + taken)) + (taken - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phantom::{POINT_NAMES, points_by_name};
    use crate::point_kernel::PointKernel;
    use proptest::prelude::*;

    fn by_hand(points: &PointSet, at: DVec3) -> Option<f64> {
        let inside = |&k: &usize| at.distance(points.positions()[k]) < f64::from(points.radii()[k]);
        let all: Vec<usize> = (0..points.count()).filter(inside).collect();
        (!all.is_empty()).then(|| all.iter().map(|&k| points.contribution(k, at)).sum())
    }

    fn crossed_by_hand(points: &PointSet, ray: &Ray, [from, to]: [f64; 2]) -> Vec<u32> {
        let meets = |&k: &usize| {
            let c = points.positions()[k] - ray.origin;
            let s = c.dot(ray.direction);
            let (distance, radius) = ((c - ray.direction * s).length(), f64::from(points.radii()[k]));
            let half = (radius * radius - distance * distance).max(0.0).sqrt();
            distance < radius && s + half > from && s - half < to
        };
        (0..points.count()).filter(meets).map(|k| k as u32).collect()
    }

    /// Clustered in place and radius, some coincident.
    fn sets() -> impl Strategy<Value = PointSet> {
        let place = prop::array::uniform3((-1.0f64..1.0).prop_map(|x| x * x * x));
        let one = (place, -4.0f32..0.0, -1.0f32..1.0);
        (prop::collection::vec(one, 1..200), prop::sample::select(vec![0.0, 1e6])).prop_map(|(all, far)| {
            let mut positions: Vec<DVec3> = all.iter().map(|p| DVec3::from(p.0) + far).collect();
            for k in (4..positions.len()).step_by(5) {
                positions[k] = positions[k - 1];
            }
            let radii = all.iter().map(|p| libm::exp10f(p.1)).collect();
            let values = all.iter().map(|p| p.2).collect();
            PointSet::new(positions, radii, vec![1.0; all.len()], values, PointKernel::CubicSpline).unwrap()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(3), failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        #[test]
        fn the_index_finds_what_a_search_of_all_points_finds(points in sets(), at in prop::array::uniform3(-1.2f64..1.2), to in prop::array::uniform3(-1.0f64..1.0), near in 0usize..200) {
            let middle = points.positions()[near % points.count()];
            for place in [middle, middle + DVec3::from(at) * f64::from(points.radii()[0])] {
                prop_assert_eq!(points.around(place).is_empty(), points.field(place).is_none());
                match (points.field(place), by_hand(&points, place)) {
                    (Some(a), Some(b)) => {
                        // The same numbers in another order.
                        let size: f64 = (0..points.count()).map(|k| points.contribution(k, place).abs()).sum();
                        prop_assert!((a - b).abs() <= 1e-13 * size);
                    }
                    (a, b) => prop_assert_eq!(a, b),
                }
            }
            let direction = DVec3::from(to).normalize_or(DVec3::X);
            for direction in [direction, DVec3::NEG_Y] {
                let ray = Ray { origin: middle - direction * 3.0, direction };
                for part in [[0.0, f64::INFINITY], [2.5, 2.6], [3.0, 3.0 + 1e-6]] {
                    let found: Vec<u32> = points.crossings(&ray, part).all.iter().map(|c| c.point).collect();
                    prop_assert_eq!(found, crossed_by_hand(&points, &ray, part));
                }
            }
        }
    }

    #[test]
    fn gradients_are_differences_of_the_field() {
        let mut tried = 0;
        for kernel in PointKernel::ALL {
            let positions: Vec<DVec3> = (0..60)
                .map(|k: u32| DVec3::from([k * 7919 % 97, k * 104_729 % 89, k * 31 % 83].map(f64::from)) / 60.0)
                .collect();
            let radii: Vec<f32> = (0..60u8).map(|k| 0.2 + 0.01 * f32::from(k)).collect();
            let values: Vec<f32> = (0..60u8).map(|k| f32::from(k % 7) - 2.0).collect();
            let points = PointSet::new(positions, radii, vec![1.0; 60], values, kernel).unwrap();
            for i in 0..200u32 {
                let at = DVec3::from([i * 37 % 101, i * 53 % 103, i * 71 % 107].map(f64::from)) / 70.0;
                let h = 1e-5;
                // Where no edge, centre or core is within the differences: there a cone's and a Gaussian's gradient jump.
                let smooth = |k: usize| {
                    let t = at.distance(points.positions()[k]) / f64::from(points.radii()[k]);
                    t > 0.01 && points.kernel().breakpoints().iter().all(|b| (t - b).abs() > 1e-3)
                };
                let (Some(gradient), true) = (points.gradient(at), (0..60).all(smooth)) else { continue };
                let value = |by: DVec3| points.field(at + by).unwrap_or(0.0);
                let difference = DVec3::from(DVec3::AXES.map(|a| (value(a * h) - value(-a * h)) / (2.0 * h)));
                // h²/6 of third derivatives: a cone's is its slope over the square of the distance, at least (1/500)².
                let size: f64 = (0..60).map(|k| points.amplitude(k).abs() / f64::from(points.radii()[k])).sum();
                assert!((gradient - difference).length() < 1e-5 * size, "{kernel}: {gradient} {difference}");
                tried += 1;
            }
            assert_eq!(points.gradient(DVec3::splat(9.0)), None);
        }
        assert!(tried > 200, "{tried}");
    }

    #[test]
    fn crossings_are_chords_of_spheres() {
        let set = |x: f64| {
            PointSet::new(vec![DVec3::new(x, 2.0, 3.0)], vec![5.0], vec![1.0], vec![1.0], PointKernel::Cone).unwrap()
        };
        let ray = Ray { origin: DVec3::new(1.0, 5.0, -97.0), direction: DVec3::Z };
        let found = set(1.0).crossings(&ray, [0.0, f64::INFINITY]);
        let c = found.all[0];
        assert_eq!((found.offset, c.nearest, c.distance, c.half), (100.0, 0.0, 3.0, 4.0));
        assert_eq!(c.across, DVec3::new(0.0, 3.0, 0.0));
        assert!(set(5.0).crossings(&ray, [0.0, f64::INFINITY]).all.is_empty(), "only touched");
        assert!(set(1.0).crossings(&ray, [0.0, 96.0]).all.is_empty(), "ends before it");
        assert_eq!(set(1.0).crossings(&ray, [100.0, 100.0]).all.len(), 1, "inside it");
    }

    #[test]
    fn ranges_are_of_the_field_where_points_are() {
        for name in POINT_NAMES {
            let points = points_by_name(name, 500).unwrap();
            let values = points.positions().iter().map(|&p| by_hand(&points, p).unwrap());
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h): (f64, f64), v| (l.min(v), h.max(v)));
            let (a, b) = points.value_range();
            assert!((a / low - 1.0).abs() < 1e-12 && (b / high - 1.0).abs() < 1e-12, "{name}: {a} {b}, {low} {high}");
        }
    }

    #[test]
    fn differences_lose_nothing() {
        let (d, lost) = difference(1.0, 1e-20);
        assert_eq!((d, lost), (1.0, -1e-20));
        let (d, lost) = difference(0.1, 1e9);
        assert_eq!((d, lost), (0.1 - 1e9, 0.1 - (d + 1e9)));
    }
}
