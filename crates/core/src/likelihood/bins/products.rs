//! Sums over the modes of each bin of products of regressors and of the record.

use crate::likelihood::bins::Bins;
use crate::likelihood::bins::regressors::{ENDS, Products};

/// Number of lowest bins of a run, whose power slow regressors reduce most.
const LOWEST_BINS: usize = 4;

impl Bins<'_> {
    /// The sums that a model with these regressors needs, by run; each of several runs has its regressors.
    pub(crate) fn products_of(&self, used: &[usize]) -> Vec<Products> {
        if self.runs.is_empty() {
            return vec![self.products(used)];
        }
        self.runs.iter().map(|(bins, own)| bins.products(own)).collect()
    }

    /// Share of the degrees of freedom of the lowest bins of a run, which begin at `first`, that remains with a
    /// discrepancy.
    pub(crate) fn freedom_share_at(&self, first: usize, low: usize) -> f64 {
        let lowest = first..first + low.min(LOWEST_BINS);
        let weights: f64 = lowest.clone().map(|bin| self.weight(bin)).sum();
        weights / lowest.map(|bin| self.freedom[bin]).sum::<f64>()
    }

    /// The sums that a model with these regressors needs.
    pub(crate) fn products(&self, used: &[usize]) -> Products {
        let count = used.len();
        let mut squares = Vec::with_capacity(self.low * count * count);
        let mut with_record = Vec::with_capacity(self.low * count);
        for pair in self.edges.windows(2) {
            let inside = &self.used_modes[pair[0]..pair[1]];
            let first = squares.len();
            squares.resize(first + count * count, 0.0);
            for (i, regressor) in used.iter().enumerate() {
                let modes = &self.regressors[*regressor].modes;
                for (j, second) in used[..=i].iter().enumerate() {
                    let second = &self.regressors[*second].modes;
                    let product = inside.iter().map(|&k| modes[k] * second[k]).sum();
                    (squares[first + i * count + j], squares[first + j * count + i]) = (product, product);
                }
                with_record.push(inside.iter().map(|&k| modes[k] * self.record.modes[k]).sum());
            }
        }
        let ends = used.iter().map(|k| ENDS.contains(k)).collect();
        Products { count, ends, squares, with_record }
    }

    /// Mean squares of the modes minus the part that the regressors explain.
    pub(crate) fn residual_power(&self, products: &Products, beta: &[f64]) -> Vec<f64> {
        let n = products.count;
        let mut power = self.low_power.clone();
        if n == 0 {
            return power;
        }
        for (bin, slot) in power.iter_mut().enumerate() {
            let modes = (self.edges[bin + 1] - self.edges[bin]) as f64;
            let mut change = 0.0;
            for i in 0..n {
                change -= 2.0 * beta[i] * products.with_record[bin * n + i];
                for j in 0..n {
                    change += beta[i] * beta[j] * products.squares[(bin * n + i) * n + j];
                }
            }
            *slot = (*slot + change / modes).max(1e-14 * *slot);
        }
        power
    }
}
