//! Isotropic scattering by Milne's integral equation, S(τ) = Q(τ) + ϖ/2 ∫ E₁(|τ − t|) S(t) dt: no direction is discretised.
//!
//! S is constant in cells that crowd at both faces (Galerkin's method, all integrals exact by E₃); fluxes then err by the square of the cells, and
//! the last two powers are taken out by Richardson's extrapolation.

/// Eₙ(x), n = 1, 2, 3.
pub fn exponential_integral(n: u32, x: f64) -> f64 {
    if x == 0.0 {
        return 1.0 / (f64::from(n) - 1.0);
    }
    let first = if x < 1.0 {
        // −γ − ln x + x − x²/4 + …
        let mut sum = -0.577_215_664_901_532_9 - x.ln();
        let mut term = 1.0;
        for k in 1..30 {
            let k = f64::from(k);
            term *= -x / k;
            sum -= term / k;
        }
        sum
    } else {
        // A continued fraction, by Lentz's method.
        let mut b = x + 1.0;
        let (mut c, mut d) = (1e300, 1.0 / b);
        let mut h = d;
        for i in 1..200 {
            let a = -f64::from(i * i);
            b += 2.0;
            d = 1.0 / (a * d + b);
            c = b + a / c;
            h *= c * d;
            if (c * d - 1.0).abs() < 1e-16 {
                break;
            }
        }
        h * (-x).exp()
    };
    let second = (-x).exp() - x * first;
    match n {
        1 => first,
        2 => second,
        _ => 0.5 * ((-x).exp() - x * second),
    }
}

/// Reflected and transmitted share of uniform light, and of a beam at right angles, of an isotropic slab; and by how much the last extrapolation
/// changed
/// any of them.
pub fn isotropic_slab(thickness: f64, albedo: f64) -> ([[f64; 2]; 2], f64) {
    let [a, b, c] = [64, 128, 256].map(|cells| galerkin(thickness, albedo, cells));
    let mut max_change = 0.0f64;
    let extrapolated = [0, 1].map(|i| {
        [0, 1].map(|j| {
            let (coarse, fine) = ((4.0 * b[i][j] - a[i][j]) / 3.0, (4.0 * c[i][j] - b[i][j]) / 3.0);
            max_change = max_change.max((fine - coarse).abs());
            (16.0 * fine - coarse) / 15.0
        })
    });
    (extrapolated, max_change)
}

fn galerkin(thickness: f64, albedo: f64, n: usize) -> [[f64; 2]; 2] {
    let e3 = |x: f64| exponential_integral(3, x);
    let edges: Vec<f64> = (0..=n)
        .map(|i| {
            let u = i as f64 / n as f64;
            thickness * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        })
        .collect();
    let width = |i: usize| edges[i + 1] - edges[i];
    let table: Vec<f64> =
        (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| e3((edges[i] - edges[j]).abs())).collect();
    let at = |i: usize, j: usize| table[i * (n + 1) + j];
    let mut matrix: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let entry = |j: usize| {
                let kernel = match i.cmp(&j) {
                    std::cmp::Ordering::Equal => 2.0 * width(i) - 1.0 + 2.0 * at(i, i + 1),
                    _ => {
                        let (i, j) = (i.min(j), i.max(j));
                        (at(i + 1, j) - at(i, j)) - (at(i + 1, j + 1) - at(i, j + 1))
                    }
                };
                f64::from(u8::from(i == j)) * width(i) - 0.5 * albedo * kernel
            };
            (0..n).map(entry).collect()
        })
        .collect();
    // Uniform light of radiance 1/π, and a beam of flux 1.
    let diffuse = |i: usize| 0.5 * albedo * (at(0, i) - at(0, i + 1)) / std::f64::consts::PI;
    let beam = |i: usize| 0.25 * albedo * ((-edges[i]).exp() - (-edges[i + 1]).exp()) / std::f64::consts::PI;
    for (i, row) in matrix.iter_mut().enumerate() {
        row.extend([diffuse(i), beam(i)]);
    }
    eliminate(&mut matrix);
    let direct = [2.0 * e3(thickness), (-thickness).exp()];
    [0, 1].map(|light| {
        let flux = |far: usize| -> f64 {
            let terms = (0..n).map(|i| matrix[i][n + light] * (at(far, i) - at(far, i + 1)).abs());
            2.0 * std::f64::consts::PI * terms.sum::<f64>()
        };
        [flux(0), flux(n) + direct[light]]
    })
}

/// Solves for the columns behind the square part; diagonally dominant, so without pivots.
fn eliminate(matrix: &mut [Vec<f64>]) {
    let n = matrix.len();
    for k in 0..n {
        let head = matrix[k].clone();
        for (i, row) in matrix.iter_mut().enumerate() {
            if i > k {
                let factor = row[k] / head[k];
                row[k..].iter_mut().zip(&head[k..]).for_each(|(a, b)| *a -= factor * b);
            }
        }
    }
    for k in (0..n).rev() {
        for column in n..n + 2 {
            let sum: f64 = (k + 1..n).map(|j| matrix[k][j] * matrix[j][column]).sum();
            matrix[k][column] = (matrix[k][column] - sum) / matrix[k][k];
        }
    }
}
