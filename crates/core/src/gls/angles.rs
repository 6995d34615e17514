//! Angles of modes of the discrete cosine transform: all low modes, and some that represent the high ones.

use std::f64::consts::PI;

/// Number of the lowest modes, which are all used.
const LOW_MODES: usize = 512;

/// Number of modes that represent all higher modes.
const HIGH_MODES: usize = 400;

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
