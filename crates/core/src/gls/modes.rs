//! Third cumulant of a sum of Allan variances, for independent modes of the discrete cosine transform.

use crate::gls::Theta;
use crate::gls::components::Components;
use crate::gls::lanes::add_rows;
use pulp::{Arch, Simd, WithSimd};

impl Components {
    /// Skewness and variance of Σ weights·AVAR over the sizes from number `first`, from independent modes.
    pub(crate) fn skewness(
        &self,
        weights: &[f64],
        first: usize,
        theta: &Theta,
        modes: &mut Vec<f64>,
    ) -> (f64, f64) {
        let count = self.base.multiplicities.len();
        modes.clear();
        modes.resize(2 * count, 0.0);
        let (gains, powers) = modes.split_at_mut(count);
        Arch::new().dispatch(Weighted { out: gains, weights, rows: &self.base.gains[first * count..] });
        for (term, theta) in theta.iter().enumerate().filter(|(_, theta)| **theta != 0.0) {
            let rows = self.spectrum(term);
            Arch::new().dispatch(Weighted { out: powers, weights: std::slice::from_ref(theta), rows });
        }
        let (mut second, mut third) = (0.0, 0.0);
        for ((gain, power), number) in gains.iter().zip(&*powers).zip(&self.base.multiplicities) {
            let part = gain * power;
            let square = number * part * part;
            second += square;
            third += square * part;
        }
        let variance = 2.0 * second;
        (8.0 * third / variance.powf(1.5), variance)
    }
}

/// Adds rows times weights.
struct Weighted<'a> {
    out: &'a mut [f64],
    weights: &'a [f64],
    rows: &'a [f64],
}

impl WithSimd for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for these vectors.
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { out, weights, rows } = self;
        let rows = weights.iter().copied().zip(rows.chunks_exact(out.len()));
        add_rows(simd, out, &rows);
    }
}
