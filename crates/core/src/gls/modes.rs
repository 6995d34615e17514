//! Modes of the discrete cosine transform, taken as independent: the third cumulant of a sum of Allan variances.

use crate::gls::Theta;
use crate::gls::components::Components;
use crate::gls::lanes::add_rows;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// The lowest modes, which are all used.
const LOW_MODES: usize = 512;

/// Modes that represent all higher ones.
const HIGH_MODES: usize = 400;

impl Components {
    /// Skewness and variance of Σ weights·AVAR from the size number `first` on, computed from independent modes.
    pub(crate) fn skewness(
        &self,
        weights: &[f64],
        first: usize,
        theta: &Theta,
        modes: &mut Vec<f64>,
    ) -> (f64, f64) {
        let count = self.base.modes.len();
        modes.clear();
        modes.resize(2 * count, 0.0);
        let (gains, powers) = modes.split_at_mut(count);
        Arch::new().dispatch(Weighted { out: gains, weights, rows: &self.base.gains[first * count..] });
        for (term, theta) in theta.iter().enumerate().filter(|(_, theta)| **theta != 0.0) {
            let rows = self.spectrum(term);
            Arch::new().dispatch(Weighted { out: powers, weights: std::slice::from_ref(theta), rows });
        }
        let (mut second, mut third) = (0.0, 0.0);
        for ((gain, power), number) in gains.iter().zip(&*powers).zip(&self.base.modes) {
            let part = gain * power;
            let square = number * part * part;
            second += square;
            third += square * part;
        }
        let variance = 2.0 * second;
        (8.0 * third / variance.powf(1.5), variance)
    }
}

/// Angles π k/n of modes of the discrete cosine transform, and the number of modes that each represents.
pub(crate) fn modes(n: usize) -> (Vec<f64>, Vec<f64>) {
    let last = n.saturating_sub(1).max(1);
    let mut k: Vec<f64> = (1..=LOW_MODES.min(last)).map(|k| k as f64).collect();
    if last > LOW_MODES {
        let (from, to) = (((LOW_MODES + 1) as f64).log10(), (last as f64).log10());
        let step = (to - from) / (HIGH_MODES - 1) as f64;
        let high = (0..HIGH_MODES).map(|j| 10f64.powf(from + step * j as f64).round_ties_even());
        k.extend(high.map(|k| k.min(last as f64)));
        k.dedup();
    }
    let edge = |j: usize| match j {
        0 => 0.5,
        j if j == k.len() => n as f64 - 0.5,
        j => 0.5 * (k[j] + k[j - 1]),
    };
    let numbers = (0..k.len()).map(|j| edge(j + 1) - edge(j)).collect();
    (k.iter().map(|k| PI * k / n as f64).collect(), numbers)
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
    #[allow(clippy::inline_always)] // Into a function that is compiled for these vectors.
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { out, weights, rows } = self;
        let rows = weights.iter().copied().zip(rows.chunks_exact(out.len()));
        add_rows(simd, out, &rows);
    }
}
