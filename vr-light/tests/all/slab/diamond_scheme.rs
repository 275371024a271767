//! Any phase function by finite differences in depth: directions at Gauss's points of each hemisphere, the diamond scheme in cells that crowd at both
//! faces, and a sweep from the bottom to the top. No doubling, no scaling of the forward peak.

use vr_core::scattering::PhaseFunction;

const POINTS: usize = 14;
/// One direction more, at right angles, without weight.
const N: usize = POINTS + 1;

type Matrix = [[f64; N]; N];

/// Gauss's points on [0, 1] by Newton's iteration.
fn gauss() -> [[f64; 2]; POINTS] {
    std::array::from_fn(|i| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (POINTS as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..20 {
            let p = legendre(x, POINTS + 1);
            slope = POINTS as f64 * (p[POINTS - 1] - x * p[POINTS]) / (1.0 - x * x);
            x -= p[POINTS] / slope;
        }
        [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
    })
}

fn legendre(x: f64, count: usize) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for l in 1..count {
        let k = l as f64;
        p.push(((2.0 * k + 1.0) * x * p[l] - k * p[l - 1]) / (k + 1.0));
    }
    p
}

/// Reflected and transmitted share of uniform light, and of a beam at right angles: by reciprocity the radiance there under uniform light.
pub fn slab(thickness: f64, albedo: f64, phase: &PhaseFunction) -> [[f64; 2]; 2] {
    let [coarse, fine] = [400, 800].map(|cells| sweep(thickness, albedo, phase, cells));
    [0, 1].map(|light| [0, 1].map(|way| (4.0 * fine[light][way] - coarse[light][way]) / 3.0))
}

fn sweep(thickness: f64, albedo: f64, phase: &PhaseFunction, cells: usize) -> [[f64; 2]; 2] {
    let g = match phase {
        PhaseFunction::HenyeyGreenstein(lobe) => lobe.g(),
        _ => 0.0,
    };
    let rule = gauss();
    let cosines: [f64; N] = std::array::from_fn(|i| rule.get(i).map_or(1.0, |r| r[0]));
    let weights: [f64; N] = std::array::from_fn(|i| rule.get(i).map_or(0.0, |r| r[1]));
    let polynomials = cosines.map(|mu| legendre(mu, 2 * POINTS));
    let redistribution = |i: usize, j: usize, odd: f64| -> f64 {
        let terms = (0..2 * POINTS).map(|l| {
            let sign = if l % 2 == 1 { odd } else { 1.0 };
            sign * (2 * l + 1) as f64 * g.powi(l as i32) * polynomials[i][l] * polynomials[j][l]
        });
        terms.sum()
    };
    // Per optical depth: down loses by A and gains of up by B; up the other way round.
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let a: Matrix = matrix(|i, j| (0.5 * albedo * redistribution(i, j, 1.0) * weights[j] - unit(i, j)) / cosines[i]);
    let b: Matrix = matrix(|i, j| 0.5 * albedo * redistribution(i, j, -1.0) * weights[j] / cosines[i]);

    let edge = |i: usize| {
        let u = i as f64 / cells as f64;
        thickness * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
    };
    let mut reflection: Matrix = [[0.0; N]; N];
    let mut passed: Matrix = matrix(unit);
    for cell in (0..cells).rev() {
        let h = 0.5 * (edge(cell + 1) - edge(cell));
        // Diamond: d′ − d = h (A (d + d′) + B (u + u′)) and u − u′ = h (A (u + u′) + B (d + d′)), with u′ = R d′. From sums and differences of
        // the two equations: (1 − hA − hB R) d′ = (1 + hA) d + hB u, (1 − hA) u = (R + hA R + hB) d′ + hB d.
        let left = matrix(|i, j| unit(i, j) - h * a[i][j]);
        let forward = matrix(|i, j| unit(i, j) + h * a[i][j]);
        let hb = matrix(|i, j| h * b[i][j]);
        let p = solve(&minus(&left, &product(&hb, &reflection)), &forward, &hb);
        let up = {
            let m = product(&forward, &reflection);
            matrix(|i, j| m[i][j] + hb[i][j])
        };
        // d′ = P d + Q u.
        let with_up = minus(&left, &product(&up, &p[1]));
        let with_down = {
            let m = product(&up, &p[0]);
            matrix(|i, j| m[i][j] + hb[i][j])
        };
        reflection = solve(&with_up, &with_down, &hb)[0];
        let cell_passed = {
            let m = product(&p[1], &reflection);
            matrix(|i, j| p[0][i][j] + m[i][j])
        };
        passed = product(&passed, &cell_passed);
    }
    let radiance = [reflection, passed].map(|m| m.map(|row| row[..POINTS].iter().sum::<f64>() + row[POINTS]));
    // A direction without weight has no column but its own: the part that passes unscattered, which belongs to its row alone.
    let flux = |light: &[f64; N]| -> f64 { (0..POINTS).map(|i| 2.0 * weights[i] * cosines[i] * light[i]).sum() };
    [[flux(&radiance[0]), flux(&radiance[1])], [radiance[0][POINTS], radiance[1][POINTS]]]
}

fn matrix(value: impl Fn(usize, usize) -> f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| value(i, j)))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut product = [[0.0; N]; N];
    for i in 0..N {
        for k in 0..N {
            for j in 0..N {
                product[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    product
}

fn minus(a: &Matrix, b: &Matrix) -> Matrix {
    matrix(|i, j| a[i][j] - b[i][j])
}

/// X and Y of M X = A, M Y = B, for a diagonally heavy M.
fn solve(m: &Matrix, a: &Matrix, b: &Matrix) -> [Matrix; 2] {
    let (mut m, mut x, mut y) = (*m, *a, *b);
    for k in 0..N {
        for i in 0..N {
            if i != k {
                let factor = m[i][k] / m[k][k];
                for j in 0..N {
                    m[i][j] -= factor * m[k][j];
                    x[i][j] -= factor * x[k][j];
                    y[i][j] -= factor * y[k][j];
                }
            }
        }
    }
    [matrix(|i, j| x[i][j] / m[i][i]), matrix(|i, j| y[i][j] / m[i][i])]
}
