//! Small dense matrices.

use std::ops::{Index, IndexMut};

/// A square matrix, row by row.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    size: usize,
    values: Vec<f64>,
}

impl Matrix {
    pub(super) fn zero(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size] }
    }

    pub(super) fn from_fn(size: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..size * size).map(|i| value(i / size, i % size)).collect();
        Self { size, values }
    }

    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// A W B, W being a diagonal matrix: a sum over the inner index with weights.
    pub(super) fn weighted(&self, weights: &[f64], other: &Self) -> Self {
        let n = self.size;
        let mut product = Self::zero(n);
        for (row, sums) in self.values.chunks_exact(n).zip(product.values.chunks_exact_mut(n)) {
            for ((a, weight), terms) in row.iter().zip(weights).zip(other.values.chunks_exact(n)) {
                // Directions that are only looked along have no weight.
                if *weight != 0.0 {
                    let factor = a * weight;
                    for (sum, term) in sums.iter_mut().zip(terms) {
                        *sum += factor * term;
                    }
                }
            }
        }
        product
    }

    /// A W v.
    pub(super) fn weighted_vector(&self, weights: &[f64], vector: &[f64]) -> Vec<f64> {
        let sum = |row: &[f64]| row.iter().zip(weights).zip(vector).map(|((a, w), v)| a * w * v).sum();
        self.values.chunks_exact(self.size).map(sum).collect()
    }

    /// Each entry, combined with that of another matrix.
    pub(super) fn zip(mut self, other: &Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        for (a, b) in self.values.iter_mut().zip(&other.values) {
            *a = combine(*a, *b);
        }
        self
    }

    pub(super) fn plus(self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    /// Rows times factors.
    pub(super) fn scaled_rows(mut self, factors: &[f64]) -> Self {
        for (row, factor) in self.values.chunks_exact_mut(self.size).zip(factors) {
            row.iter_mut().for_each(|a| *a *= factor);
        }
        self
    }

    /// Columns times factors.
    pub(super) fn scaled_columns(mut self, factors: &[f64]) -> Self {
        for row in self.values.chunks_exact_mut(self.size) {
            row.iter_mut().zip(factors).for_each(|(a, factor)| *a *= factor);
        }
        self
    }

    /// The part whose rows and columns begin at these places.
    pub(super) fn block(&self, row: usize, column: usize, size: usize) -> Self {
        Self::from_fn(size, |i, j| self[(row + i, column + j)])
    }

    /// Factors, for many right sides.
    pub(super) fn factorized(mut self) -> Factors {
        let n = self.size;
        let mut order: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| self[(i, k)].abs().total_cmp(&self[(j, k)].abs())).unwrap_or(k);
            if pivot != k {
                order.swap(k, pivot);
                for j in 0..n {
                    self.values.swap(k * n + j, pivot * n + j);
                }
            }
            let (upper, lower) = self.values.split_at_mut((k + 1) * n);
            let head = &upper[k * n..];
            for row in lower.chunks_exact_mut(n) {
                row[k] /= head[k];
                let factor = row[k];
                for (a, b) in row[k + 1..].iter_mut().zip(&head[k + 1..]) {
                    *a -= factor * b;
                }
            }
        }
        Factors { matrix: self, order }
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.values[row * self.size + column]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.values[row * self.size + column]
    }
}

/// Triangular factors of a matrix (Gauss's elimination with partial pivoting).
pub(super) struct Factors {
    matrix: Matrix,
    order: Vec<usize>,
}

impl Factors {
    /// The solution X of A X = B.
    pub(super) fn solve(&self, right: &Matrix) -> Matrix {
        let n = self.matrix.size;
        let mut x = Matrix::from_fn(n, |i, j| right[(self.order[i], j)]);
        for i in 0..n {
            for k in 0..i {
                eliminate(&mut x.values, n, i, k, self.matrix[(i, k)]);
            }
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                eliminate(&mut x.values, n, i, k, self.matrix[(i, k)]);
            }
            let pivot = self.matrix[(i, i)];
            x.values[i * n..(i + 1) * n].iter_mut().for_each(|a| *a /= pivot);
        }
        x
    }

    /// The solution x of A x = b.
    pub(super) fn solve_vector(&self, right: &[f64]) -> Vec<f64> {
        let n = self.matrix.size;
        let mut x: Vec<f64> = self.order.iter().map(|&i| right[i]).collect();
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| self.matrix[(i, k)] * x[k]).sum();
            x[i] -= sum;
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| self.matrix[(i, k)] * x[k]).sum();
            x[i] = (x[i] - sum) / self.matrix[(i, i)];
        }
        x
    }
}

/// Subtracts a multiple of row k from row i.
fn eliminate(values: &mut [f64], n: usize, i: usize, k: usize, factor: f64) {
    let (target, source) = if k < i {
        let (low, high) = values.split_at_mut(i * n);
        (&mut high[..n], &low[k * n..(k + 1) * n])
    } else {
        let (low, high) = values.split_at_mut(k * n);
        (&mut low[i * n..(i + 1) * n], &high[..n])
    };
    for (a, b) in target.iter_mut().zip(source) {
        *a -= factor * b;
    }
}
