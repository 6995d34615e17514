//! Non-negative least squares with few columns, from their inner products.

use crate::gls::Failed;

/// Largest number of columns.
pub(crate) const MAX_COLUMNS: usize = 6;

/// Cosine between a column and the residual below which the column does not improve the fit.
const ROUNDING: f64 = 1e-13;

/// Squared sine of the angle between a column and the span of the previous columns, below which it is left out.
const MIN_SQUARED_SINE: f64 = 1e-14;

/// Inner products of a target and columns.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Products {
    pub count: usize,
    pub target: f64,
    pub right: [f64; MAX_COLUMNS],
    pub gram: [[f64; MAX_COLUMNS]; MAX_COLUMNS],
}

impl Products {
    pub(crate) fn new(count: usize) -> Self {
        Self { count, ..Self::default() }
    }

    /// Adds a row: the target, then the columns.
    #[inline]
    pub(crate) fn add(&mut self, row: &[f64]) {
        let (target, columns) = (row[0], &row[1..=self.count]);
        self.target += target * target;
        for (p, &x) in columns.iter().enumerate() {
            self.right[p] += target * x;
            for (sum, &y) in self.gram[p].iter_mut().zip(&columns[..=p]) {
                *sum += x * y;
            }
        }
    }

    /// Non-negative coefficients x with the smallest ‖columns·x − target‖, by active sets.
    ///
    /// C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1974, chapter 23, with normal equations of
    /// normalised columns. It begins with the columns whose unconstrained coefficients are positive, which is the solution
    /// in most cases.
    pub(crate) fn solve(mut self) -> Result<[f64; MAX_COLUMNS], Failed> {
        let count = self.count;
        let mut scale = [1.0; MAX_COLUMNS];
        for (p, scale) in scale.iter_mut().enumerate().take(count) {
            *scale = self.gram[p][p].sqrt();
            if !(*scale > 0.0 && scale.is_finite() && self.right[p].is_finite()) {
                return Err(Failed);
            }
        }
        for p in 0..count {
            self.right[p] /= scale[p];
            for q in 0..=p {
                let cosine = self.gram[p][q] / (scale[p] * scale[q]);
                (self.gram[p][q], self.gram[q][p]) = (cosine, cosine);
            }
        }
        let mut x = self.normalised();
        for p in 0..count {
            x[p] /= scale[p];
        }
        Ok(x)
    }

    fn normalised(&self) -> [f64; MAX_COLUMNS] {
        let count = self.count;
        let mut used = [false; MAX_COLUMNS];
        used[..count].fill(true);
        let mut x = self.solved(used);
        while x[..count].iter().any(|&value| value < 0.0) {
            for p in 0..count {
                used[p] = used[p] && x[p] > 0.0;
            }
            x = self.solved(used);
        }
        let least = ROUNDING * self.target.sqrt();
        for _ in 0..3 * count {
            let gradient = |p: usize| {
                self.right[p] - self.gram[p][..count].iter().zip(&x).map(|(g, x)| g * x).sum::<f64>()
            };
            let best = (0..count).filter(|&p| !used[p]).map(|p| (p, gradient(p)));
            let best = best.fold((count, least), |best, one| if one.1 > best.1 { one } else { best }).0;
            if best == count {
                break;
            }
            used[best] = true;
            let mut free = self.solved(used);
            while (0..count).any(|p| free[p] < 0.0) {
                let steps = (0..count).filter(|&p| used[p] && free[p] < 0.0).map(|p| x[p] / (x[p] - free[p]));
                let step = steps.fold(f64::INFINITY, f64::min);
                for p in 0..count {
                    x[p] = (x[p] + step * (free[p] - x[p])).max(0.0);
                    used[p] = used[p] && (free[p] >= 0.0 || x[p] > least);
                    if !used[p] {
                        x[p] = 0.0;
                    }
                }
                free = self.solved(used);
            }
            x = free;
        }
        x
    }

    /// Unconstrained coefficients of the used columns by Cholesky factorisation; the other coefficients are 0.
    fn solved(&self, used: [bool; MAX_COLUMNS]) -> [f64; MAX_COLUMNS] {
        let mut factor = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        let mut half = [0.0; MAX_COLUMNS];
        let mut kept = [0; MAX_COLUMNS];
        let mut count = 0;
        for k in (0..self.count).filter(|&k| used[k]) {
            let mut row = [0.0; MAX_COLUMNS];
            for i in 0..count {
                let known: f64 = (0..i).map(|j| row[j] * factor[i][j]).sum();
                row[i] = (self.gram[k][kept[i]] - known) / factor[i][i];
            }
            let pivot = self.gram[k][k] - row[..count].iter().map(|value| value * value).sum::<f64>();
            if pivot <= MIN_SQUARED_SINE {
                continue;
            }
            let root = pivot.sqrt();
            let known: f64 = (0..count).map(|j| row[j] * half[j]).sum();
            half[count] = (self.right[k] - known) / root;
            row[count] = root;
            factor[count] = row;
            kept[count] = k;
            count += 1;
        }
        let mut x = [0.0; MAX_COLUMNS];
        for i in (0..count).rev() {
            let value = half[i] / factor[i][i];
            x[kept[i]] = value;
            for j in 0..i {
                half[j] -= factor[i][j] * value;
            }
        }
        x
    }
}

/// Non-negative coefficients x with the smallest ‖columns·x − target‖, for at most six columns.
///
/// # Errors
///
/// [`Failed`] for a column of zeros, for a number that is not finite, for too many columns or columns of other lengths.
pub fn non_negative(columns: &[&[f64]], target: &[f64]) -> Result<Vec<f64>, Failed> {
    if columns.len() > MAX_COLUMNS || columns.iter().any(|column| column.len() != target.len()) {
        return Err(Failed);
    }
    let mut products = Products::new(columns.len());
    for (i, &y) in target.iter().enumerate() {
        let mut row = [0.0; MAX_COLUMNS + 1];
        row[0] = y;
        row[1..].iter_mut().zip(columns).for_each(|(cell, column)| *cell = column[i]);
        products.add(&row);
    }
    Ok(products.solve()?[..columns.len()].to_vec())
}

/// Non-negative coefficients of columns fitted to a curve with independent relative errors.
pub(crate) fn relative_fit(
    columns: &[&[f64]],
    avar: &[f64],
    errors: &[f64],
) -> Result<[f64; MAX_COLUMNS], Failed> {
    let count = columns.len();
    let mut products = Products::new(count);
    for (i, (avar, error)) in avar.iter().zip(errors).enumerate() {
        let weight = 1.0 / (error * avar);
        let mut row = [0.0; MAX_COLUMNS + 1];
        row[0] = avar * weight;
        row[1..].iter_mut().zip(columns).for_each(|(cell, column)| *cell = column[i] * weight);
        products.add(&row);
    }
    products.solve()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers between −1 and 1.
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    /// The conditions of Karush, Kuhn and Tucker: the gradient is 0 where a coefficient is positive, and not downhill where
    /// it is 0.
    #[test]
    fn solutions_are_optimal() {
        let mut next = numbers(7);
        for trial in 0..400 {
            let (rows, count) = (8 + trial % 9, 1 + trial % MAX_COLUMNS);
            let columns: Vec<Vec<f64>> = (0..count)
                .map(|p| (0..rows).map(|_| (next() + 0.8) * 10f64.powi(p as i32 * 3 - 6)).collect())
                .collect();
            let target: Vec<f64> = (0..rows).map(|_| next()).collect();
            let slices: Vec<&[f64]> = columns.iter().map(|column| &column[..]).collect();
            let x = non_negative(&slices, &target).unwrap();
            let left: Vec<f64> = (0..rows)
                .map(|i| target[i] - (0..count).map(|p| columns[p][i] * x[p]).sum::<f64>())
                .collect();
            for p in 0..count {
                let norm = columns[p].iter().map(|c| c * c).sum::<f64>().sqrt();
                let gradient = columns[p].iter().zip(&left).map(|(c, l)| c * l).sum::<f64>() / norm;
                assert!(x[p] >= 0.0);
                assert!(
                    gradient < 1e-11 && (x[p] == 0.0 || gradient > -1e-11),
                    "{trial} {p} {gradient} {x:?}"
                );
            }
        }
    }

    #[test]
    fn parallel_columns_share_one_coefficient() {
        let one = [1.0, 2.0, 3.0];
        let x = non_negative(&[&one, &one], &one).unwrap();
        assert!((x[0] + x[1] - 1.0).abs() < 1e-12);
        assert_eq!(non_negative(&[&[0.0; 3]], &one), Err(Failed));
        assert_eq!(non_negative(&[], &one), Ok(vec![]));
    }
}
