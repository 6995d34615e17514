//! Pseudo-inverse of a few columns, and the part of the last column that is orthogonal to the others.

use crate::gls::Failed;

/// Largest number of columns: five terms, the tangent of a shape, and a target.
pub(crate) const MAX_COLUMNS: usize = 7;

/// Share of the largest singular value below which a singular value counts as 0.
const NEGLIGIBLE: f64 = 1e-15;

/// Largest number of sweeps of rotations; five are usual.
const SWEEPS: usize = 30;

/// A row of up to [`MAX_COLUMNS`] columns.
pub(crate) type Row = [f64; MAX_COLUMNS];

/// Pseudo-inverse of columns A that were normalised, from A V = W with orthogonal columns W.
pub(crate) struct PseudoInverse {
    count: usize,
    scale: Row,
    turned: [Row; MAX_COLUMNS],
    /// Inverse squares of the singular values; 0 where the singular values are negligible.
    inverse: Row,
}

impl PseudoInverse {
    /// Decomposes the first `count` columns of `rows`, which it rotates. One-sided Jacobi rotations: M. R.
    /// Hestenes, J. SIAM 6, 1958.
    pub(crate) fn new(rows: &mut [Row], count: usize) -> Result<Self, Failed> {
        let mut scale = [1.0; MAX_COLUMNS];
        for (p, scale) in scale.iter_mut().enumerate().take(count) {
            *scale = product(rows, p, p).sqrt();
            if !(*scale > 0.0 && scale.is_finite()) {
                return Err(Failed);
            }
            for row in rows.iter_mut() {
                row[p] /= *scale;
            }
        }
        let mut turned = [[0.0; MAX_COLUMNS]; MAX_COLUMNS];
        (0..count).for_each(|p| turned[p][p] = 1.0);
        for _ in 0..SWEEPS {
            let mut largest = 0.0_f64;
            for p in 0..count {
                for q in p + 1..count {
                    let (pp, qq, pq) = (product(rows, p, p), product(rows, q, q), product(rows, p, q));
                    let cosine = pq.abs() / (pp * qq).sqrt();
                    if cosine.is_nan() || cosine < 1e-15 {
                        continue;
                    }
                    largest = largest.max(cosine);
                    let zeta = (qq - pp) / (2.0 * pq);
                    let t = 1f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
                    let c = 1.0 / t.hypot(1.0);
                    let s = c * t;
                    for row in rows.iter_mut().chain(&mut turned) {
                        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                    }
                }
            }
            if largest < 1e-14 {
                break;
            }
        }
        let mut inverse = [0.0; MAX_COLUMNS];
        let mut most = 0.0_f64;
        for (p, square) in inverse.iter_mut().enumerate().take(count) {
            *square = product(rows, p, p);
            most = most.max(*square);
        }
        for square in inverse.iter_mut().take(count) {
            *square = if *square > NEGLIGIBLE * NEGLIGIBLE * most { square.recip() } else { 0.0 };
        }
        Ok(Self { count, scale, turned, inverse })
    }

    /// Product of two rows of the pseudo-inverse of the original columns: a covariance of coefficients.
    pub(crate) fn covariance(&self, p: usize, q: usize) -> f64 {
        let sum: f64 = (0..self.count).map(|k| self.turned[p][k] * self.turned[q][k] * self.inverse[k]).sum();
        sum / (self.scale[p] * self.scale[q])
    }

    /// Coefficient of one column for a target, from the rotated rows.
    pub(crate) fn coefficient(&self, p: usize, rows: &[Row], target: impl Iterator<Item = f64>) -> f64 {
        let weights: Row =
            std::array::from_fn(|k| if k < self.count { self.turned[p][k] * self.inverse[k] } else { 0.0 });
        let row = |row: &Row| (0..self.count).map(|k| weights[k] * row[k]).sum::<f64>();
        rows.iter().zip(target).map(|(columns, y)| row(columns) * y).sum::<f64>() / self.scale[p]
    }
}

/// The part of the last of `count` columns that is orthogonal to the others, over its squared length: the row of the
/// pseudo-inverse. By Gram's and Schmidt's method, twice.
pub(crate) fn last_row(rows: &mut [Row], count: usize, out: &mut [f64]) -> Result<(), Failed> {
    let mut scale = 1.0;
    for p in 0..count {
        scale = product(rows, p, p).sqrt();
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Failed);
        }
        for row in rows.iter_mut() {
            row[p] /= scale;
        }
        for _ in 0..2 {
            for q in 0..p {
                let cosine = product(rows, q, p);
                for row in rows.iter_mut() {
                    row[p] -= cosine * row[q];
                }
            }
        }
        if p + 1 < count {
            let left = product(rows, p, p).sqrt();
            // The remainder of a column in the span of the others is 0.
            let factor = if left > f64::EPSILON { left.recip() } else { 0.0 };
            for row in rows.iter_mut() {
                row[p] *= factor;
            }
        }
    }
    let last = count - 1;
    let factor = 1.0 / (product(rows, last, last) * scale);
    if !factor.is_finite() {
        return Err(Failed);
    }
    out.iter_mut().zip(rows).for_each(|(out, row)| *out = row[last] * factor);
    Ok(())
}

fn product(rows: &[Row], p: usize, q: usize) -> f64 {
    rows.iter().map(|row| row[p] * row[q]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Monomials, whose columns are nearly parallel.
    fn rows() -> Vec<Row> {
        (0..20)
            .map(|i| {
                std::array::from_fn(|p| 1e3f64.powi(p as i32) * (f64::from(i) / 20.0 + 0.5).powi(p as i32))
            })
            .collect()
    }

    #[test]
    fn the_last_row_of_the_pseudo_inverse() {
        for count in 1..=5 {
            let columns = rows();
            let mut out = [0.0; 20];
            last_row(&mut columns.clone(), count, &mut out).unwrap();
            for p in 0..count {
                let sum: f64 = out.iter().zip(&columns).map(|(w, row)| w * row[p]).sum();
                let expected = f64::from(u8::from(p + 1 == count));
                assert!(
                    (sum - expected).abs() < 1e-9 * 1e3f64.powi(p as i32 - count as i32 + 1),
                    "{count} {p} {sum}"
                );
            }
            let mut turned = columns.clone();
            let inverse = PseudoInverse::new(&mut turned, count).unwrap();
            let variance: f64 = out.iter().map(|w| w * w).sum();
            assert!((inverse.covariance(count - 1, count - 1) / variance - 1.0).abs() < 1e-9);
            let y = |i: usize| (i as f64).sin();
            let expected: f64 = out.iter().enumerate().map(|(i, w)| w * y(i)).sum();
            let got = inverse.coefficient(count - 1, &turned, (0..20).map(y));
            assert!((got / expected - 1.0).abs() < 1e-8, "{count} {got} {expected}");
        }
    }

    #[test]
    fn a_column_twice_has_the_coefficient_of_least_length() {
        let mut columns: Vec<Row> = rows();
        for row in &mut columns {
            row[1] = row[0];
        }
        let once = columns.len() as f64;
        let inverse = PseudoInverse::new(&mut columns, 2).unwrap();
        assert!((inverse.covariance(0, 0) * once - 0.25).abs() < 1e-12);
        assert!(PseudoInverse::new(&mut [[0.0; MAX_COLUMNS]; 3], 1).is_err());
    }
}
