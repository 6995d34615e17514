//! Flicker noise for streams: a bank of first-order poles, driven by one white noise.
//!
//! Discrete flicker noise is white noise through (1 − z⁻¹)^(−1/2) = (1 / π) ∫ x^(−1/2) (1 − x)^(−1/2) / (1 − x z⁻¹) dx
//! from 0 to 1. With x = 1 / (1 + e⁻ᵘ) the weight becomes 1 / (2π cosh(u / 2)) du, and eᵘ is the time of the pole in
//! samples: a trapezoidal rule in u spreads the poles evenly over its logarithm. The integrand has no singularity nearer
//! to the real line than π / 2, so that the error falls as exp(−π² / step): 2 · 10⁻⁵ at `STEP`. The poles of the rule
//! beyond either end are replaced by one pole with their total weight and their mean loss.

use crate::draws::{Draws, Source};
use std::f64::consts::{LN_10, PI};

/// Number of poles per decade.
const PER_DECADE: f64 = 2.5;
/// Step of the rule, in u.
const STEP: f64 = LN_10 / PER_DECADE;
/// Largest time of the first pole. \[samples\]
const FIRST_TIME: f64 = 0.03;
/// Smallest ratio of the time of the last pole to the length of the record.
const LAST_TIME_RATIO: f64 = 10.0;
/// Number of poles that are computed together.
const LANES: usize = 4;

/// A pole of the bank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pole {
    /// 1 − p, the share of its state that is lost per sample.
    pub loss: f64,
    /// Weight of its state in the output, for innovations of standard deviation 1.
    pub weight: f64,
}

/// The poles for records of `n` samples, the longest last.
#[must_use]
pub fn poles(n: usize) -> Vec<Pole> {
    let first = (FIRST_TIME.ln() / STEP).floor() as i32;
    let last = ((LAST_TIME_RATIO * n.max(1) as f64).ln() / STEP).ceil() as i32;
    // Beyond this number of steps the remainder is less than 10⁻¹⁶ of the tail.
    let tail = (80.0 / STEP) as i32;
    let mut poles = vec![mean((first - tail..first).map(node))];
    poles.extend((first..=last).map(node));
    poles.push(mean((last + 1..=last + tail).map(node)));
    poles
}

fn node(j: i32) -> Pole {
    let u = f64::from(j) * STEP;
    Pole { loss: 1.0 / (1.0 + u.exp()), weight: STEP / (2.0 * PI * (0.5 * u).cosh()) }
}

/// One pole with the total weight of several, and their weighted mean loss.
fn mean(poles: impl Iterator<Item = Pole>) -> Pole {
    let (weight, loss) = poles.fold((0.0, 0.0), |(w, l), p| (w + p.weight, l + p.weight * p.loss));
    Pole { loss: loss / weight, weight }
}

/// States of the poles at one time, drawn with their joint stationary covariance 1 / (1 − pᵢ pⱼ).
///
/// Its Cholesky factor is explicit, by the orthonormal functions of Malmquist and Takenaka: `L_ij` =
/// √(1 − pⱼ²) / (1 − pᵢ pⱼ) · Π (pᵢ − pₖ) / (1 − pᵢ pₖ), k < j. Only differences of losses occur, which lose no digits.
fn stationary(poles: &[Pole], draws: &mut Draws) -> Vec<f64> {
    let between = |a: f64, b: f64| a + b - a * b; // 1 − pₐ p_b
    let drawn: Vec<f64> = poles.iter().map(|_| draws.normal()).collect();
    let state = |i: usize| {
        let own = poles[i].loss;
        let mut product = 1.0;
        let mut sum = 0.0;
        for (j, &w) in drawn.iter().enumerate().take(i + 1) {
            let other = poles[j].loss;
            sum += between(other, other).sqrt() / between(own, other) * product * w;
            product *= (other - own) / between(own, other);
        }
        sum
    };
    (0..poles.len()).map(state).collect()
}

/// A running bank. As in the exact generator, its output is relative to the sample before the first.
pub(crate) struct Bank {
    kept: Vec<[f64; LANES]>,
    gain: Vec<[f64; LANES]>,
    state: Vec<[f64; LANES]>,
    origin: f64,
    draws: Draws,
}

impl Bank {
    pub(crate) fn new(n: usize, b: f64, mut draws: Draws) -> Self {
        let poles = poles(n);
        let start = stationary(&poles, &mut draws);
        let lanes = |value: &dyn Fn(usize) -> f64| -> Vec<[f64; LANES]> {
            let at = |k: usize| if k < poles.len() { value(k) } else { 0.0 };
            (0..poles.len().div_ceil(LANES)).map(|g| std::array::from_fn(|l| at(LANES * g + l))).collect()
        };
        let kept = lanes(&|k| 1.0 - poles[k].loss);
        let gain = lanes(&|k| b * poles[k].weight);
        let state = lanes(&|k| b * poles[k].weight * start[k]);
        let origin = state.iter().flatten().sum();
        Self { kept, gain, state, origin, draws }
    }
}

impl Source for Bank {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            let w = self.draws.normal();
            let mut sum = [0.0; LANES];
            for ((x, p), g) in self.state.iter_mut().zip(&self.kept).zip(&self.gain) {
                for l in 0..LANES {
                    x[l] = p[l] * x[l] + g[l] * w;
                    sum[l] += x[l];
                }
            }
            *y += sum.iter().sum::<f64>() - self.origin;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::{bias_instability_avar, gauss_markov_avar_sampled};

    /// The autocovariance is Σ Aⱼ pⱼˡ with Aⱼ = aⱼ Σ aᵢ / (1 − pᵢ pⱼ): that of Gauss-Markov processes.
    fn avar(poles: &[Pole], m: usize) -> f64 {
        let part = |p: &Pole| {
            let cross: f64 = poles.iter().map(|o| o.weight / (p.loss + o.loss - p.loss * o.loss)).sum();
            let time = -1.0 / (-p.loss).ln_1p();
            gauss_markov_avar_sampled((p.weight * cross).sqrt(), time, 1.0, m)
        };
        poles.iter().map(part).sum()
    }

    #[test]
    fn deviations_are_within_a_thousandth_up_to_a_third_of_the_record() {
        for n in [4, 100, 4096, 1_000_000, 100_000_000, 1_000_000_000] {
            let poles = poles(n);
            let mut m = 1;
            while m <= n / 3 || m == 1 {
                let off = (avar(&poles, m) / bias_instability_avar(1.0, m)).sqrt() - 1.0;
                assert!(off.abs() < 1e-3, "{n} samples, m = {m}: {off:e}");
                m *= 2;
            }
        }
    }

    #[test]
    fn the_factor_is_that_of_the_covariance() {
        let poles = poles(10_000);
        let between = |a: f64, b: f64| a + b - a * b;
        let n = poles.len();
        let mut factor = vec![vec![0.0; n]; n];
        for (i, row) in factor.iter_mut().enumerate() {
            let own = poles[i].loss;
            let mut product = 1.0;
            for (j, value) in row.iter_mut().enumerate().take(i + 1) {
                let other = poles[j].loss;
                *value = between(other, other).sqrt() / between(own, other) * product;
                product *= (other - own) / between(own, other);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let got: f64 = factor[i].iter().zip(&factor[j]).map(|(a, b)| a * b).sum();
                let expected = 1.0 / between(poles[i].loss, poles[j].loss);
                assert!((got / expected - 1.0).abs() < 1e-12, "{i} {j}: {got} {expected}");
            }
        }
    }
}
