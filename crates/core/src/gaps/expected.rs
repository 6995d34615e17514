//! The Allan variance that each noise term is expected to show in the pairs of clusters of a record with gaps.
//!
//! A pair compares Σ aⱼ yⱼ, with weights 1/m₂ and −1/m₁ on the samples that are there. Of white noise its variance is
//! 1/m₁ + 1/m₂. Quantization noise y(j) = v(j) − v(j − 1) leaves, of each run of samples, the phase at its two ends;
//! a rate random walk the squares of the sums of the weights after each step; both come from counts, and are exact whole
//! numbers until the last division. Where nothing is missing all are the closed forms of [`crate::terms`].
//!
//! Discrete flicker noise is a mixture of exponentially correlated noise: its variogram is (4/π) Σ 1/(2j − 1) =
//! (4/π) ∫₀^∞ (1 − tanh²ˡ u) du, because Σ t^(2j−2) = (1 − t²ˡ)/(1 − t²). The integrand is smooth and even, so that the
//! trapezoidal rule needs two or three processes with p = tanh² u a decade; those that hardly change within a pair make
//! a random walk.

use super::counts::Counts;
use super::exponential::{LANES, LEAST_PIECES, mean};
use crate::error::Error;
use crate::terms::{bias_instability_avar, gauss_markov_avar_sampled};
use crate::threads::on_threads;
use rayon::prelude::*;

/// Step of the trapezoidal rule in u. What it is off where nothing is missing, 2e-3 at most, is divided out.
const STEP: f64 = 0.6;

/// A process whose γ(2n) is this much stands for a random walk.
const NEARLY_A_WALK: f64 = 0.08;

/// Of a record of more than twice as many starts in all, so many stretches of so many starts tell of short clusters.
const STRETCHES: usize = 16;
const STRETCH: usize = 16_384;

/// Of white noise in stretches, below which they miss nothing to speak of.
const LEAST_EXCESS: f64 = 1e-4;

/// Expected Allan variances at one cluster size for unit coefficients, one sample interval being 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Pairs that count: both clusters at least half full.
    pub pairs: usize,
    /// Of quantization noise.
    pub quantization: f64,
    /// The mean of n²/(m₁m₂): how much the differences that still telescope make of it, over 3/n².
    pub telescoping: f64,
    /// Of a random walk.
    pub random_walk: f64,
    /// Of bias instability, discrete flicker noise.
    pub bias_instability: f64,
    /// Of a sampled rate random walk.
    pub rate_random_walk: f64,
    /// Mean square of the distance of the mean times of two clusters; n² where nothing is missing.
    pub square_distance: f64,
}

/// Expected Allan variances of the mask `there` at the cluster sizes `m`, each with at least one pair of samples.
///
/// A size without a pair has NaN. Clusters of 128 and more samples may begin at every 64th to 128th part of their length
/// only, for exponentially correlated noise and flicker.
///
/// # Errors
///
/// [`Error::ClusterSize`] for a size of which two do not fit in the record; [`Error::Parameter`] if so many threads cannot
/// be had.
pub fn expected(there: &[bool], m: &[usize], threads: Option<usize>) -> Result<Vec<Expected>, Error> {
    check(there, m)?;
    let counts = Counts::of(there);
    on_threads(threads, || m.par_iter().map(|&m| counts.expected(there, m)).collect())
}

/// The same of a Gauss-Markov process of variance 1 and correlation time `time`, in samples.
///
/// # Errors
///
/// Those of [`expected`], and [`Error::Parameter`] for a time that is not positive.
pub fn gauss_markov(
    there: &[bool],
    m: &[usize],
    time: f64,
    threads: Option<usize>,
) -> Result<Vec<f64>, Error> {
    check(there, m)?;
    if !(time > 0.0 && time.is_finite()) {
        return Err(Error::Parameter { name: "correlation time", value: time });
    }
    let counts = Counts::of(there);
    let of_size = |&m: &usize| {
        let ratio = counts.ratios(there, m, &[1.0 / time])[0];
        ratio * gauss_markov_avar_sampled(1.0, time, 1.0, m)
    };
    on_threads(threads, || m.par_iter().map(of_size).collect())
}

fn check(there: &[bool], m: &[usize]) -> Result<(), Error> {
    let largest = there.len() / 2;
    match m.iter().find(|&&m| m == 0 || m > largest) {
        Some(&m) => Err(Error::ClusterSize { m, largest }),
        None => Ok(()),
    }
}

/// −ln p of the process at u = k·[`STEP`].
fn rate_of(k: usize) -> f64 {
    // ln tanh² u = ln(1 − 1/cosh² u).
    -(-(STEP * k as f64).cosh().powi(-2)).ln_1p()
}

/// Processes up to that which is nearly a walk over two clusters.
fn nodes_for(m: usize) -> usize {
    let longest = 4.0 * 2.0 * m as f64 / NEARLY_A_WALK;
    ((0.5 * longest.ln()) / STEP).ceil() as usize
}

impl Counts {
    fn expected(&self, there: &[bool], m: usize) -> Expected {
        let exact = self.exact(there, m);
        let rates: Vec<f64> = (1..=nodes_for(m)).map(rate_of).collect();
        let ratios = self.ratios(there, m, &rates);
        Expected {
            pairs: exact.pairs,
            quantization: exact.quantization,
            telescoping: exact.telescoping,
            random_walk: exact.random_walk,
            bias_instability: flicker(m, &rates, &ratios, exact.random_walk, exact.rate_random_walk),
            rate_random_walk: exact.rate_random_walk,
            square_distance: exact.square_distance,
        }
    }

    /// For each process, its expected Allan variance over that where nothing is missing.
    fn ratios(&self, there: &[bool], m: usize, rates: &[f64]) -> Vec<f64> {
        let length = m / LEAST_PIECES;
        if length <= 1 {
            return self.ratios_at(there, m, 1, rates);
        }
        // A piece whose multiple the cluster is, or the two multiples on either side of it.
        if let Some(length) = (length / 2 + 1..=length).rev().find(|&length| m % length == 0) {
            return self.ratios_at(there, m / length, length, rates);
        }
        let below = m / length;
        let low = self.ratios_at(there, below, length, rates);
        if 2 * (below + 1) * length > there.len() {
            return low;
        }
        let high = self.ratios_at(there, below + 1, length, rates);
        let share = (m - below * length) as f64 / length as f64;
        let between =
            |(low, high): (&f64, &f64)| if high.is_nan() { *low } else { low + share * (high - low) };
        low.iter().zip(&high).map(between).collect()
    }

    fn ratios_at(&self, there: &[bool], pieces: usize, length: usize, rates: &[f64]) -> Vec<f64> {
        let m = pieces * length;
        let last = (there.len() - 2 * m) / length;
        // How many pairs that count each start stands for.
        let mut weights = vec![0.0; last + 1];
        for start in 0..self.starts(m) {
            if self.pair(start, m).is_some() {
                weights[((start + length / 2) / length).min(last)] += 1.0;
            }
        }
        // A start that stands for others may itself be less than half full, but not empty.
        for (k, weight) in weights.iter_mut().enumerate() {
            let [a, b, c] = [k * length, k * length + m, k * length + 2 * m].map(|k| self.valid[k]);
            if a == b || b == c {
                *weight = 0.0;
            }
        }
        if length > 1 || weights.len() <= 2 * STRETCHES * STRETCH {
            return ratios_of(there, pieces, length, &weights, rates);
        }
        self.ratios_in_stretches(there, m, &weights, rates)
    }

    /// From evenly spread stretches, for short clusters of a long record; every start for itself.
    ///
    /// What samples are lost makes of a process moves with what it makes of white noise, which is known of all pairs: the
    /// excess over 1 is scaled by that.
    fn ratios_in_stretches(&self, there: &[bool], m: usize, weights: &[f64], rates: &[f64]) -> Vec<f64> {
        let white = |range: std::ops::Range<usize>| {
            let of = |start: usize| match self.pair(start, m) {
                Some((m1, m2)) => [1.0, 0.5 / m1 as f64 + 0.5 / m2 as f64],
                None => [0.0; 2],
            };
            range.map(of).fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]])
        };
        let all = white(0..weights.len());
        let mut some = [0.0; 2];
        let mut sums = vec![0.0; rates.len()];
        for k in 0..STRETCHES {
            let first = k * (weights.len() - STRETCH) / (STRETCHES - 1);
            let range = first..first + STRETCH;
            let [pairs, sum] = white(range.clone());
            if pairs > 0.0 {
                let found = ratios_of(&there[first..range.end - 1 + 2 * m], m, 1, &weights[range], rates);
                sums.iter_mut().zip(found).for_each(|(total, ratio)| *total += pairs * ratio);
                some = [some[0] + pairs, some[1] + sum];
            }
        }
        if some[0] == 0.0 {
            return ratios_of(there, m, 1, weights, rates);
        }
        let [excess_all, excess] = [all, some].map(|[pairs, sum]| sum / pairs * m as f64 - 1.0);
        let scale = if excess > LEAST_EXCESS { excess_all / excess } else { 1.0 };
        sums.iter().map(|sum| 1.0 + scale * (sum / some[0] - 1.0)).collect()
    }
}

/// For each process, its mean Allan variance over that where nothing is missing.
fn ratios_of(there: &[bool], pieces: usize, length: usize, weights: &[f64], rates: &[f64]) -> Vec<f64> {
    let whole = vec![true; 2 * pieces * length];
    let together = |rates: &[f64]| {
        let mut lanes = [1.0; LANES];
        lanes[..rates.len()].copy_from_slice(rates);
        let found = mean(there, pieces, length, weights, &lanes);
        let full = mean(&whole, pieces, length, &[1.0], &lanes);
        (0..rates.len()).map(|lane| found[lane] / full[lane]).collect::<Vec<f64>>()
    };
    rates.chunks(LANES).flat_map(together).collect()
}

/// Of discrete flicker noise, from the ratios of its processes.
fn flicker(m: usize, rates: &[f64], ratios: &[f64], white: f64, walk: f64) -> f64 {
    let size = m as f64;
    let full_walk = (2.0 * size * size + 1.0) / (6.0 * size);
    // Those beyond the last, together: 1 − pˡ is 4l·exp(−2u).
    let beyond = (-2.0 * STEP * (rates.len() + 1) as f64).exp() / (1.0 - (-2.0 * STEP).exp());
    let walks = 8.0 * beyond;
    let (mut found, mut full) = (0.5 * white + walks * walk, 0.5 / size + walks * full_walk);
    for (&rate, &ratio) in rates.iter().zip(ratios) {
        let of_process = gauss_markov_avar_sampled(1.0, 1.0 / rate, 1.0, m);
        found += of_process * ratio;
        full += of_process;
    }
    found / full * bias_instability_avar(1.0, m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms;
    use std::f64::consts::PI;

    fn mask(n: usize) -> Vec<bool> {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        (0..n)
            .map(|k| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 40) % 20 != 0 && !(n / 3..n / 3 + n / 10).contains(&k)
            })
            .collect()
    }

    /// Mean over the pairs of ½ Σ aᵢ aⱼ c(i, j).
    fn brute(there: &[bool], m: usize, c: impl Fn(usize, usize) -> f64) -> f64 {
        let (mut total, mut pairs) = (0.0, 0.0);
        for start in 0..=there.len() - 2 * m {
            let count = |k: usize| there[k..k + m].iter().filter(|&&v| v).count();
            let (m1, m2) = (count(start), count(start + m));
            if 2 * m1 < m || 2 * m2 < m {
                continue;
            }
            let weights: Vec<(usize, f64)> = (start..start + 2 * m)
                .filter(|&k| there[k])
                .map(|k| (k, if k < start + m { -1.0 / m1 as f64 } else { 1.0 / m2 as f64 }))
                .collect();
            pairs += 1.0;
            for &(i, a) in &weights {
                for &(j, b) in &weights {
                    total += 0.5 * a * b * c(i, j);
                }
            }
        }
        total / pairs
    }

    fn close(got: f64, expected: f64, tolerance: f64) {
        assert!((got / expected - 1.0).abs() <= tolerance, "{got} instead of {expected}");
    }

    #[test]
    fn every_term_equals_sums_over_a_mask() {
        let there = mask(150);
        let sizes = [1, 2, 3, 8, 13, 31, 50];
        let harmonic = |l: usize| (1..=l).map(|j| 1.0 / (2 * j - 1) as f64).sum::<f64>();
        for (e, &m) in expected(&there, &sizes, None).unwrap().iter().zip(&sizes) {
            let near = |i: usize, j: usize| i.abs_diff(j);
            close(e.random_walk, brute(&there, m, |i, j| f64::from(u8::from(i == j))), 1e-12);
            let phase = |i, j| match near(i, j) {
                0 => 2.0,
                1 => -1.0,
                _ => 0.0,
            };
            close(e.quantization, brute(&there, m, phase), 1e-12);
            close(e.rate_random_walk, brute(&there, m, |i, j| i.min(j) as f64 + 1.0), 1e-12);
            close(0.5 * e.square_distance, brute(&there, m, |i, j| (i * j) as f64), 1e-10);
            // 5e-5 at most; the quadrature is the only approximation here.
            let flicker = |i, j| -2.0 / PI * harmonic(near(i, j));
            close(e.bias_instability, brute(&there, m, flicker), 5e-5);
            for time in [0.3, 7.0, 2000.0] {
                let got = gauss_markov(&there, &[m], time, None).unwrap()[0];
                close(got, brute(&there, m, |i, j| (-(near(i, j) as f64) / time).exp()), 1e-10);
            }
        }
    }

    #[test]
    fn without_a_gap_they_are_the_closed_forms() {
        let there = vec![true; 40_000];
        let sizes = [1, 2, 7, 64, 127, 128, 384, 1009, 8192, 20_000];
        let times = nodes(20_000);
        for (e, &m) in expected(&there, &sizes, None).unwrap().iter().zip(&sizes) {
            let size = m as f64;
            assert_eq!(e.pairs, 40_001 - 2 * m);
            close(e.quantization, terms::quantization_avar(1.0, size), 1e-12);
            close(e.telescoping, 1.0, 1e-12);
            close(e.random_walk, terms::random_walk_avar(1.0, size), 1e-12);
            close(e.bias_instability, terms::bias_instability_avar(1.0, m), 1e-9);
            close(e.rate_random_walk, terms::rate_random_walk_avar_sampled(1.0, 1.0, m), 1e-12);
            close(e.square_distance, size * size, 1e-12);
            assert!(e.ratios.len() <= times.len());
            e.ratios.iter().for_each(|&ratio| close(ratio, 1.0, 1e-9));
            close(
                gauss_markov(&there, &[m], 30.0, None).unwrap()[0],
                terms::gauss_markov_avar_sampled(1.0, 30.0, 1.0, m),
                1e-9,
            );
        }
    }

    #[test]
    fn the_quadrature_alone_is_flicker() {
        // Without the last division.
        for m in [1, 2, 3, 10, 64, 1000, 100_000, 10_000_000] {
            let size = m as f64;
            let rates: Vec<f64> = (1..=nodes_for(m)).map(rate_of).collect();
            let beyond = (-2.0 * STEP * (rates.len() + 1) as f64).exp() / (1.0 - (-2.0 * STEP).exp());
            let walk = 8.0 * beyond * (2.0 * size * size + 1.0) / (6.0 * size);
            let processes =
                rates.iter().map(|r| gauss_markov_avar_sampled(1.0, 1.0 / r, 1.0, m)).sum::<f64>();
            let got = 2.0 / PI * STEP * (0.5 / size + walk + processes);
            close(got, bias_instability_avar(1.0, m), 2e-3);
        }
    }

    #[test]
    fn starts_that_stand_for_others_are_good_enough() {
        let there = mask(6000);
        for m in [256, 300, 509, 1000, 1500] {
            let counts = Counts::of(&there);
            let rates: Vec<f64> = (1..=nodes_for(m)).map(rate_of).collect();
            let some = counts.ratios(&there, m, &rates);
            let all = counts.ratios_at(&there, m, 1, &rates);
            for (some, all) in some.iter().zip(&all) {
                close(*some, *all, 1e-3);
            }
        }
    }

    #[test]
    fn stretches_are_good_enough() {
        // Five in a hundred lost and an outage that few of the stretches meet.
        let there = mask(1_200_000);
        let counts = Counts::of(&there);
        for m in [1, 3, 24, 96] {
            let rates: Vec<f64> = (1..=nodes_for(m)).map(rate_of).collect();
            let weights: Vec<f64> =
                (0..counts.starts(m)).map(|k| f64::from(u8::from(counts.pair(k, m).is_some()))).collect();
            assert!(weights.len() > 2 * STRETCHES * STRETCH);
            let some = counts.ratios_at(&there, m, 1, &rates);
            let all = ratios_of(&there, m, 1, &weights, &rates);
            for (some, all) in some.iter().zip(&all) {
                close(*some, *all, 3e-4);
            }
        }
    }
}
