//! Small dense systems: bounded quadratic programmes and pseudo-inverses; products of a large matrix.

use pulp::{Arch, Simd, WithSimd};

/// Number that is added to the diagonal of a scaled information matrix, so that interchangeable parameters have a step.
const RIDGE: f64 = 1e-9;

/// Number of rows or columns whose products are computed together, so that their sums do not wait for each other.
const ROWS: usize = 4;

/// Share of the largest eigenvalue below which an eigenvalue counts as 0.
const NEGLIGIBLE: f64 = 1e-10;

/// A symmetric matrix in row order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Symmetric {
    pub order: usize,
    pub at: Vec<f64>,
}

impl Symmetric {
    pub(crate) fn zero(order: usize) -> Self {
        Self { order, at: vec![0.0; order * order] }
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> f64 {
        self.at[i * self.order + j]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, value: f64) {
        self.at[i * self.order + j] = value;
        self.at[j * self.order + i] = value;
    }

    /// Square roots of the diagonal, 1 where it is not positive.
    pub(crate) fn scales(&self) -> Vec<f64> {
        (0..self.order).map(|i| self.get(i, i)).map(|d| if d > 0.0 { d.sqrt() } else { 1.0 }).collect()
    }

    /// The scales, and the matrix with a unit diagonal.
    fn scaled(&self) -> (Vec<f64>, Self) {
        let scale = self.scales();
        let mut scaled = self.clone();
        for (row, a) in scaled.at.chunks_exact_mut(self.order.max(1)).zip(&scale) {
            row.iter_mut().zip(&scale).for_each(|(x, b)| *x /= a * b);
        }
        (scale, scaled)
    }

    /// The pseudo-inverse, computed from the matrix scaled to a unit diagonal.
    pub(crate) fn pseudo_inverse(&self) -> Self {
        self.inverse_and_log_determinant().0
    }

    /// The pseudo-inverse, and the logarithm of the determinant; for a singular matrix, of the product of its scaled
    /// eigenvalues above rounding.
    pub(crate) fn inverse_and_log_determinant(&self) -> (Self, f64) {
        let n = self.order;
        let (scale, scaled) = self.scaled();
        let (values, vectors) = scaled.eigen();
        let largest = values.iter().fold(0.0_f64, |a, &b| a.max(b));
        let mut inverse = Self::zero(n);
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = (0..n)
                    .filter(|&k| values[k] > NEGLIGIBLE * largest)
                    .map(|k| vectors[i * n + k] * vectors[j * n + k] / values[k])
                    .sum();
                inverse.set(i, j, sum / (scale[i] * scale[j]));
            }
        }
        let eigen: f64 = values.iter().map(|v| v.max(1e-14).ln()).sum();
        (inverse, eigen + scale.iter().map(|s| 2.0 * s.ln()).sum::<f64>())
    }

    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        self.at.chunks_exact(self.order.max(1)).map(|row| dot(row, x)).collect()
    }

    /// Eigenvalues and eigenvectors (as columns) by cyclic Jacobi rotations.
    pub(crate) fn eigen(mut self) -> (Vec<f64>, Vec<f64>) {
        let n = self.order;
        let mut vectors = vec![0.0; n * n];
        for i in 0..n {
            vectors[i * n + i] = 1.0;
        }
        for _ in 0..40 {
            let off: f64 =
                (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| self.get(i, j).powi(2)).sum();
            if off < 1e-28 {
                break;
            }
            for p in 0..n {
                for q in p + 1..n {
                    self.rotate(p, q, &mut vectors);
                }
            }
        }
        ((0..n).map(|i| self.get(i, i)).collect(), vectors)
    }

    fn rotate(&mut self, p: usize, q: usize, vectors: &mut [f64]) {
        let n = self.order;
        let apq = self.get(p, q);
        if apq == 0.0 {
            return;
        }
        let theta = (self.get(q, q) - self.get(p, p)) / (2.0 * apq);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let t = if theta == 0.0 { 1.0 } else { t };
        let c = 1.0 / (t * t + 1.0).sqrt();
        let s = t * c;
        for k in 0..n {
            let (a, b) = (self.at[k * n + p], self.at[k * n + q]);
            self.at[k * n + p] = c * a - s * b;
            self.at[k * n + q] = s * a + c * b;
        }
        for k in 0..n {
            let (a, b) = (self.at[p * n + k], self.at[q * n + k]);
            self.at[p * n + k] = c * a - s * b;
            self.at[q * n + k] = s * a + c * b;
        }
        for row in vectors.chunks_exact_mut(n) {
            let (a, b) = (row[p], row[q]);
            row[p] = c * a - s * b;
            row[q] = s * a + c * b;
        }
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// [`dot`] of each column and a vector. The sums of some columns are computed together, so that they do not wait for each
/// other.
pub(crate) fn dots(columns: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    let mut sums_of_columns = Vec::with_capacity(columns.len());
    for group in columns.chunks(ROWS) {
        // If fewer columns remain, the last one is repeated.
        let group_columns: [&[f64]; ROWS] =
            std::array::from_fn(|k| &group[k.min(group.len() - 1)][..x.len()]);
        let mut sums = [0.0; ROWS];
        for (i, x) in x.iter().enumerate() {
            sums.iter_mut().zip(group_columns).for_each(|(sum, column)| *sum += column[i] * x);
        }
        sums_of_columns.extend_from_slice(&sums[..group.len()]);
    }
    sums_of_columns
}

/// Product of a matrix, in row order, and a vector.
pub(crate) fn products(rows: &[f64], x: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; rows.len() / x.len()];
    Arch::new().dispatch(Products { rows, x, found: &mut found });
    found
}

struct Products<'a> {
    rows: &'a [f64],
    x: &'a [f64],
    found: &'a mut [f64],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for the processor.
    fn with_simd<S: Simd>(self, simd: S) {
        let width = self.x.len();
        let (x, rest) = S::as_simd_f64s(self.x);
        for (slots, rows) in self.found.chunks_mut(ROWS).zip(self.rows.chunks(ROWS * width)) {
            // If fewer rows remain, the last one is repeated.
            let row = |k: usize| S::as_simd_f64s(&rows[k.min(slots.len() - 1) * width..][..width]);
            let parts: [(&[S::f64s], &[f64]); ROWS] = std::array::from_fn(row);
            let mut sums = [simd.splat_f64s(0.0); ROWS];
            let [a, b, c, d] = parts.map(|(part, _)| &part[..x.len()]);
            for (i, &x) in x.iter().enumerate() {
                sums[0] = simd.mul_add_f64s(a[i], x, sums[0]);
                sums[1] = simd.mul_add_f64s(b[i], x, sums[1]);
                sums[2] = simd.mul_add_f64s(c[i], x, sums[2]);
                sums[3] = simd.mul_add_f64s(d[i], x, sums[3]);
            }
            for (slot, (sum, (_, part))) in slots.iter_mut().zip(sums.into_iter().zip(parts)) {
                *slot = simd.reduce_sum_f64s(sum) + dot(part, rest);
            }
        }
    }
}

/// The step d ≥ `least` (≤ 0) that minimises dᵀFd/2 − gᵀd; 0 for a parameter without information or with `held`.
///
/// Active-set method: parameters at their bound are released while that reduces the objective.
pub(crate) fn bounded_step(
    information: &Symmetric,
    gradient: &[f64],
    least: &[f64],
    held: &[bool],
) -> Vec<f64> {
    let n = gradient.len();
    let scale = information.scales();
    let usable: Vec<bool> =
        (0..n).map(|i| !held[i] && information.get(i, i) > 0.0 && gradient[i].is_finite()).collect();
    let f =
        |i: usize, j: usize| information.get(i, j) / (scale[i] * scale[j]) + if i == j { RIDGE } else { 0.0 };
    let g: Vec<f64> = (0..n).map(|i| gradient[i] / scale[i]).collect();
    let bound: Vec<f64> = (0..n).map(|i| least[i] * scale[i]).collect();
    let mut d = vec![0.0; n];
    let mut free = usable.clone();
    for _ in 0..6 * n + 6 {
        let at: Vec<usize> = (0..n).filter(|&i| free[i]).collect();
        let fixed: Vec<usize> = (0..n).filter(|&i| usable[i] && !free[i]).collect();
        let right: Vec<f64> =
            at.iter().map(|&i| g[i] - fixed.iter().map(|&j| f(i, j) * d[j]).sum::<f64>()).collect();
        let solved = solve(&at, &f, &right);
        // The step towards the solution is limited by the bounds.
        let mut share = 1.0;
        let mut first = None;
        for (k, &i) in at.iter().enumerate() {
            if solved[k] < bound[i] - 1e-12 * bound[i].abs() {
                let reach = (bound[i] - d[i]) / (solved[k] - d[i]);
                if reach < share {
                    share = reach.max(0.0);
                    first = Some(i);
                }
            }
        }
        for (k, &i) in at.iter().enumerate() {
            d[i] = (d[i] + share * (solved[k] - d[i])).max(bound[i]);
        }
        if let Some(i) = first {
            d[i] = bound[i];
            free[i] = false;
            continue;
        }
        // All parameters are within bounds: can one at its bound be released?
        let pull = |i: usize| g[i] - (0..n).filter(|&j| usable[j]).map(|j| f(i, j) * d[j]).sum::<f64>();
        match fixed.iter().map(|&i| (pull(i), i)).max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((value, i)) if value > 1e-9 => free[i] = true,
            _ => break,
        }
    }
    d.iter().zip(&scale).map(|(x, s)| x / s).collect()
}

/// Cholesky solution for the rows and columns `at` of a positive definite matrix; rows with a bad pivot are left out.
fn solve(at: &[usize], f: &impl Fn(usize, usize) -> f64, right: &[f64]) -> Vec<f64> {
    let n = at.len();
    let mut lower = vec![0.0; n * n];
    let mut good = vec![true; n];
    for i in 0..n {
        for j in 0..=i {
            let sum = f(at[i], at[j]) - (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum::<f64>();
            if i == j {
                good[i] = sum > 1e-14;
                lower[i * n + i] = if good[i] { sum.sqrt() } else { 1.0 };
            } else {
                lower[i * n + j] = if good[j] { sum / lower[j * n + j] } else { 0.0 };
            }
        }
        if !good[i] {
            lower[i * n..i * n + i].fill(0.0);
        }
    }
    let mut x = right.to_vec();
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| lower[i * n + k] * x[k]).sum();
        x[i] = if good[i] { (x[i] - sum) / lower[i * n + i] } else { 0.0 };
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
        x[i] = if good[i] { (x[i] - sum) / lower[i * n + i] } else { 0.0 };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(order: usize, at: &[f64]) -> Symmetric {
        Symmetric { order, at: at.to_vec() }
    }

    #[test]
    fn a_bound_holds_and_the_rest_moves_on() {
        // Without bounds (1, −1); with d₂ ≥ −0.5 the first parameter is solved again.
        let f = matrix(2, &[2.0, 1.0, 1.0, 2.0]);
        let d = bounded_step(&f, &[1.0, -1.0], &[-9.0, -0.5], &[false, false]);
        assert!((d[1] + 0.5).abs() < 1e-12 && (d[0] - 0.75).abs() < 1e-8, "{d:?}");
        let d = bounded_step(&f, &[1.0, -1.0], &[-9.0, -9.0], &[false, true]);
        assert!(d[1] == 0.0 && (d[0] - 0.5).abs() < 1e-8, "{d:?}");
    }

    #[test]
    fn inverse_and_determinant() {
        let f = matrix(3, &[4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0]);
        let (inverse, log_determinant) = f.inverse_and_log_determinant();
        for i in 0..3 {
            let unit: Vec<f64> = (0..3).map(|j| f64::from(u8::from(i == j))).collect();
            let back = f.times(&inverse.times(&unit));
            assert!(back.iter().zip(&unit).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
        }
        let determinant: f64 = 4.0 * (6.0 - 0.04) - (2.0 - 0.1) + 0.5 * (0.2 - 1.5);
        assert!((log_determinant - determinant.ln()).abs() < 1e-12);
    }
}
