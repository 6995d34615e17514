//! The sums T(n) = Σ_{k<n} r(k) r(k + n) at the beginning of a record: the number of products grows with the lag.
//!
//! In the plane of k and n the products fill a triangle. It is cut into squares, each a correlation at all
//! its lags at once, and into small triangles along k = n, which are summed directly. Halves of the range of
//! n are independent, so that they can be computed at the same time.

use super::correlation;
use crate::parallel::join;

/// Largest side of triangles that are summed directly.
const DIRECT_SIDE: usize = 256;

/// T(n) for n ≥ `first`; there must be twice as many values as the largest n.
pub fn head_products(values: &[f64], first: usize, sums: &mut [f64]) {
    correlation::cross(&values[..first], &values[first..], sums);
    add_triangle(values, first, sums);
}

/// Adds the products with k ≥ `first`, for n ≥ `first`.
fn add_triangle(values: &[f64], first: usize, sums: &mut [f64]) {
    if sums.len() <= DIRECT_SIDE {
        for (n, sum) in (first..).zip(sums) {
            *sum += dot(&values[first..n], &values[first + n..]);
        }
        return;
    }
    let (near, far) = sums.split_at_mut(sums.len() / 2);
    let middle = first + near.len();
    join(
        || add_triangle(values, first, near),
        || {
            let mut square = vec![0.0; far.len()];
            correlation::cross(&values[first..middle], &values[first + middle..], &mut square);
            far.iter_mut().zip(square).for_each(|(sum, part)| *sum += part);
            add_triangle(values, middle, far);
        },
    );
}

/// Σ a(k) b(k) over the length of `a`, in lanes that the compiler can vectorise.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b[..a.len()].chunks_exact(8));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a.zip(b) {
        for (lane, (x, y)) in lanes.iter_mut().zip(x.iter().zip(y)) {
            *lane += x * y;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_product_counts_once() {
        // For integers the direct sums are exact, and those by transforms are accurate to 1e-16 of 1e8.
        let values: Vec<f64> = (0..6000u64).map(|k| ((k * k * 7919) % 101) as f64 - 50.0).collect();
        for (first, last) in [(1, 2), (1, 3000), (256, 1024), (700, 1001), (2999, 3000)] {
            let mut sums = vec![f64::NAN; last - first];
            head_products(&values, first, &mut sums);
            for (n, sum) in (first..).zip(sums) {
                let direct: f64 = (0..n).map(|k| values[k] * values[k + n]).sum();
                assert!((sum - direct).abs() < 1e-6, "{first} {last} {n}: {sum} {direct}");
            }
        }
    }
}
