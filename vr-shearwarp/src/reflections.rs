//! Shading by look-up: normals are encoded, and what each of them reflects is tabulated once a light or a view changes (Lacroute 1995).

use glam::DVec3;
use vr_core::{Light, Shading};

/// Reflection at a normal: shaded light is `light·factor + opacity·added`, component by component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reflection {
    /// The last component is 1: opacity is not shaded.
    pub(crate) factor: [f32; 4],
    /// The last component is 0.
    pub(crate) added: [f32; 4],
}

impl Reflection {
    pub(crate) fn new((factor, added): ([f64; 3], [f64; 3])) -> Self {
        let four = |v: [f64; 3], last| [v[0] as f32, v[1] as f32, v[2] as f32, last];
        Self { factor: four(factor, 1.0), added: four(added, 0.0) }
    }
}

/// Steps along an edge of the octahedron's unfolded half.
const EDGE: usize = 127;

/// Number of codes: two-sided shading knows no difference between a normal and its opposite, so that half the sphere is enough;
/// code 0 is no normal at all.
pub(crate) const CODES: usize = 1 + EDGE * EDGE;

/// The code of a normal of any length: the octahedron's upper half, unfolded onto a square (Meyer et al. 2010, *On floating-point normal
/// vectors*), 0.5° off on average, at most 1.1°.
pub(crate) fn encode(gradient: [f32; 3]) -> u16 {
    // Scaled, so that no sum overflows.
    let largest = gradient.iter().fold(0.0f32, |m, c| m.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return 0;
    }
    let up = if gradient[2] < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = gradient.map(|c| c / largest * up);
    let sum = x.abs() + y.abs() + z;
    // The half octahedron is a square standing on its corner: turned by 45° it fills [−1, 1]².
    let (s, t) = ((x + y) / sum, (x - y) / sum);
    let step = |c: f32| ((c + 1.0) * (0.5 * (EDGE - 1) as f32) + 0.5) as usize;
    (1 + step(s).min(EDGE - 1) * EDGE + step(t).min(EDGE - 1)) as u16
}

/// The unit normal of a code; none of code 0.
pub(crate) fn decode(code: u16) -> Option<DVec3> {
    let i = usize::from(code).checked_sub(1)?;
    let at = |k: usize| k as f64 * (2.0 / (EDGE - 1) as f64) - 1.0;
    let (s, t) = (at(i / EDGE), at(i % EDGE));
    let (x, y) = (0.5 * (s + t), 0.5 * (s - t));
    Some(DVec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize())
}

/// Reflection of every code to an eye that looks along `direction`, in the world; normals are in the world, too.
pub(crate) fn table(shading: &Shading, lights: &[Light], direction: DVec3) -> Vec<Reflection> {
    let along = shading.along::<f64>(lights, direction);
    let reflection = |code: usize| {
        Reflection::new(match decode(code as u16) {
            Some(normal) => along.reflect(normal.to_array()),
            None => ([1.0; 3], [0.0; 3]),
        })
    };
    (0..CODES).map(reflection).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_near_their_normals() {
        let mut worst = 0.0f64;
        for i in 0..20_000 {
            // Points spread over the sphere (a Fibonacci lattice).
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 20_000.0;
            let turn = f64::from(i) * 2.399_963_229_728_653;
            let r = (1.0 - z * z).sqrt();
            let normal = DVec3::new(r * turn.cos(), r * turn.sin(), z);
            let code = encode((normal * 1e-30).to_array().map(|c| c as f32));
            assert!(code > 0 && usize::from(code) < CODES);
            let back = decode(code).unwrap();
            worst = worst.max(1.0 - back.dot(normal).abs());
        }
        let degrees = (1.0 - worst).acos().to_degrees();
        assert!(degrees < 1.2, "{degrees}°");
        assert_eq!((encode([0.0; 3]), encode([f32::NAN, 0.0, 0.0]), decode(0)), (0, 0, None));
    }

    #[test]
    fn the_table_is_the_law() {
        let shading = Shading::default();
        let table = table(&shading, &[Light::default()], DVec3::NEG_Z);
        let code = encode([0.0, 0.0, -3.0]);
        let [r, ..] = table[usize::from(code)].factor;
        assert!((f64::from(r) - (shading.ambient + shading.diffuse)).abs() < 1e-6);
        assert!((f64::from(table[usize::from(code)].added[0]) - shading.specular).abs() < 1e-6);
        assert_eq!(table[0], Reflection { factor: [1.0; 4], added: [0.0; 4] });
    }
}
