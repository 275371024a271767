//! The Shepp-Logan head in three dimensions.

use glam::DVec3;

use super::Phantom;
use crate::transfer::ControlPoint;

/// A head of ten ellipsoids; the field at a point is the sum of the densities of those that contain it.
///
/// Geometry: Kak & Slaney, *Principles of Computerized Tomographic Imaging*, IEEE Press 1988, table 3.1, with the authors'
/// errata. Densities: Yu, Ye & Wang, "Katsevich-type algorithms for variable radius spiral cone-beam CT", SPIE 5535, 2004,
/// table 1, whose contrast can be seen. After Shepp & Logan, "The Fourier reconstruction of a head section", IEEE Transactions
/// on Nuclear Science 21, 1974.
///
/// The line integral has a closed form: Σ density · chord.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{Phantom, SheppLogan};
///
/// let head = SheppLogan::new();
/// assert_eq!(head.value(0.99 * DVec3::X), 0.0, "beside the head");
/// assert!(head.value(DVec3::ZERO) > 0.0);
/// assert!(head.lipschitz().is_infinite(), "it jumps");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SheppLogan {
    ellipsoids: [Ellipsoid; 10],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Ellipsoid {
    center: DVec3,
    semi_axes: DVec3,
    /// Cosine and sine of the angle from the x axis to the first semi-axis, about z.
    turn: (f64, f64),
    /// Tenths: whole numbers, so that sums are exact and 1 − 0.8 − 0.2 is 0.
    tenths: f64,
}

impl Ellipsoid {
    fn new(semi_axes: [f64; 3], center: [f64; 3], degrees: f64, tenths: f64) -> Self {
        let angle = degrees.to_radians();
        Self { center: center.into(), semi_axes: semi_axes.into(), turn: (libm::cos(angle), libm::sin(angle)), tenths }
    }

    /// A world vector in the frame in which the ellipsoid is the unit sphere.
    fn to_sphere(self, v: DVec3) -> DVec3 {
        let (cos, sin) = self.turn;
        DVec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z) / self.semi_axes
    }

    fn contains(self, p: DVec3) -> bool {
        self.to_sphere(p - self.center).length_squared() <= 1.0
    }

    /// The parameters at which a line enters and leaves; `None` if it misses.
    fn crossing(self, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (o, d) = (self.to_sphere(origin - self.center), self.to_sphere(direction));
        let d2 = d.length_squared();
        // From the point nearest to the centre: no cancellation for origins far away.
        let nearest = -o.dot(d) / d2;
        let inside = 1.0 - (o + d * nearest).length_squared();
        (inside > 0.0).then(|| {
            let half = (inside / d2).sqrt();
            (nearest - half, nearest + half)
        })
    }
}

impl SheppLogan {
    /// The head.
    #[rustfmt::skip]
    pub fn new() -> Self {
        let e = Ellipsoid::new;
        Self {
            ellipsoids: [
                e([0.6900, 0.920, 0.900], [ 0.00,  0.000,  0.000],   0.0, 10.0),
                e([0.6624, 0.874, 0.880], [ 0.00,  0.000,  0.000],   0.0, -8.0),
                e([0.4100, 0.160, 0.210], [-0.22,  0.000, -0.250], 108.0, -2.0),
                e([0.3100, 0.110, 0.220], [ 0.22,  0.000, -0.250],  72.0, -2.0),
                e([0.2100, 0.250, 0.500], [ 0.00,  0.350, -0.250],   0.0,  2.0),
                e([0.0460, 0.046, 0.046], [ 0.00,  0.100, -0.250],   0.0,  2.0),
                e([0.0460, 0.023, 0.020], [-0.08, -0.650, -0.250],   0.0,  1.0),
                e([0.0460, 0.023, 0.020], [ 0.06, -0.650, -0.250],  90.0,  1.0),
                e([0.0560, 0.040, 0.100], [ 0.06, -0.105,  0.625],  90.0,  2.0),
                e([0.0560, 0.056, 0.100], [ 0.00,  0.100,  0.625],   0.0, -2.0),
            ],
        }
    }

    /// ∫ f ds over the whole line through `origin` along `direction` (of any length but zero), s in world units.
    pub fn line_integral(&self, origin: DVec3, direction: DVec3) -> f64 {
        let chords = self.ellipsoids.iter().filter_map(|e| {
            let (enter, leave) = e.crossing(origin, direction)?;
            Some(e.tenths * (leave - enter))
        });
        chords.sum::<f64>() * direction.length() / 10.0
    }
}

impl Default for SheppLogan {
    fn default() -> Self {
        Self::new()
    }
}

impl Phantom for SheppLogan {
    fn name(&self) -> &'static str {
        "shepp-logan"
    }

    fn value(&self, p: DVec3) -> f64 {
        self.ellipsoids.iter().filter(|e| e.contains(p)).map(|e| e.tenths).sum::<f64>() / 10.0
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    /// The exact range: the skull is 1, and no two of the negative ellipsoids inside the brain (0.2) meet.
    fn value_range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    /// Zero: the field is constant there.
    fn lipschitz_between_breakpoints(&self) -> f64 {
        0.0
    }

    fn lipschitz(&self) -> f64 {
        f64::INFINITY
    }

    fn breakpoints(&self, origin: DVec3, direction: DVec3, out: &mut Vec<f64>) {
        for (enter, leave) in self.ellipsoids.iter().filter_map(|e| e.crossing(origin, direction)) {
            out.extend([enter, leave]);
        }
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.05, [0.10, 0.15, 0.60], 0.0),
            ControlPoint::new(0.20, [0.15, 0.30, 0.90], 0.010),
            ControlPoint::new(0.28, [0.20, 0.80, 0.40], 0.15),
            ControlPoint::new(0.40, [1.00, 0.45, 0.10], 0.08),
            ControlPoint::new(0.60, [1.00, 0.10, 0.05], 0.05),
            ControlPoint::new(1.00, [0.90, 0.85, 0.75], 0.05),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::split_mix::SplitMix64;
    use super::*;

    #[test]
    fn holds_the_values_of_its_parts() {
        let head = SheppLogan::new();
        let at = |x, y, z| head.value(DVec3::new(x, y, z));
        assert_eq!(at(0.0, 0.0, 0.0), 0.2, "brain");
        assert_eq!(at(0.0, 0.9, 0.0), 1.0, "skull");
        assert_eq!(at(-0.22, 0.0, -0.25), 0.0, "ventricle");
        assert_eq!(at(0.0, 0.35, -0.25), 0.4);
        assert_eq!(at(0.06, -0.65, -0.25), 0.3);
        assert_eq!(at(0.95, 0.0, 0.0), 0.0, "air");
        // The long axis of the left ventricle leans to the left of +y.
        assert_eq!(at(-0.22 - 0.3 * 0.309, 0.3 * 0.951, -0.25), 0.0);
    }

    #[test]
    fn line_integrals_agree_with_quadrature_between_breakpoints() {
        let head = SheppLogan::new();
        let mut random = SplitMix64::new(4);
        let mut vector = |reach: f64| DVec3::from_array([(); 3].map(|()| random.between(-reach, reach)));
        for _ in 0..500 {
            let (origin, target) = (vector(3.0), vector(0.8));
            let direction = target - origin;
            let mut cuts = Vec::new();
            head.breakpoints(origin, direction, &mut cuts);
            cuts.sort_by(f64::total_cmp);
            // The field is constant between breakpoints: the midpoint rule is exact.
            let quadrature: f64 = cuts
                .windows(2)
                .map(|w| head.value(origin + direction * (0.5 * (w[0] + w[1]))) * (w[1] - w[0]) * direction.length())
                .sum();
            let closed = head.line_integral(origin, direction);
            assert!((quadrature - closed).abs() < 1e-13, "{origin} {direction}: {quadrature} {closed}");
        }
    }

    #[test]
    fn line_integrals_agree_with_fine_steps() {
        // Knows nothing of breakpoints: an error of at most one step per jump.
        const STEPS: usize = 100_000;
        let head = SheppLogan::new();
        let (origin, direction) = (DVec3::new(-2.0, 0.1, -0.4), DVec3::new(0.97, 0.1, 0.05).normalize());
        let h = 4.0 / STEPS as f64;
        let sum: f64 = (0..STEPS).map(|k| head.value(origin + direction * ((k as f64 + 0.5) * h)) * h).sum();
        assert!((sum - head.line_integral(origin, direction)).abs() < 10.0 * h);
    }
}
