//! Degrees of freedom of the estimators whose terms are not a stationary sequence, or one without a closed autocovariance:
//! parabolic, total, modified total and Hadamard total variance, and Theo1.
//!
//! All are quadratic forms x'Ax of the phase, with mean tr AΣ and variance 2 tr (AΣ)², where Σ is the
//! generalised autocovariance of the phase: A removes the part of Σ that is arbitrary. The computation is exact
//! and takes N³ steps, so it is limited to records up to [`LONGEST`]. White, flicker and random-walk noise of
//! the rate are the same at any scale, so that a shorter record with the same ratio of averaging time to
//! length represents a longer one. The traces grow linearly with the length if averaging times are a small
//! part of the record.

use super::Kind;
use super::freedom::{Coefficients, Stationary, moments};
use crate::allan::Overlap;
use crate::covariance::PhaseCovariance;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::special::odd_harmonic;
use crate::terms::{NOISE_TERMS, Term};
use std::f64::consts::PI;

/// Longest record that is computed without scaling.
pub const LONGEST: usize = 384;

/// Cluster size of the record that represents a longer one.
const REDUCED_SIZE: usize = 48;

/// Share of quantization noise in the Allan variance below which it is ignored.
pub const SHARE: f64 = 0.01;

/// Cluster size of the stretch that represents a longer one in [`bias`].
const BIAS_SIZE: usize = 64;

/// Equivalent degrees of freedom at the cluster sizes `m`.
///
/// # Errors
///
/// Those of [`super::deviations`] for the sizes; [`Error::Parameter`] for a ramp, which is not a noise, and
/// for quantization noise above [`SHARE`] of the Allan variance at a size that is computed from a shorter record:
/// quantization noise depends on the scale.
pub fn degrees_of_freedom(
    kind: Kind,
    samples: usize,
    m: &[usize],
    coefficients: &Coefficients,
) -> Result<Vec<f64>, Error> {
    kind.check(samples, m)?;
    let scaled =
        |&&m: &&usize| samples > LONGEST && m > REDUCED_SIZE && quantization_share(m, coefficients) > SHARE;
    if !averages_phase(kind) && m.iter().any(|m| scaled(&m)) {
        return Err(Error::Parameter { name: "quantization", value: coefficients.noise[0].sqrt() });
    }
    if coefficients.ramp > 0.0 && kind != Kind::HadamardTotal {
        return Err(Error::Parameter { name: "rate_ramp", value: coefficients.ramp.sqrt() });
    }
    Ok(m.par_iter().map(|&m| freedom_at_size(kind, samples, m, coefficients)).collect())
}

/// Whether an estimator averages the phase over clusters, so that white noise of the phase has a scale too.
fn averages_phase(kind: Kind) -> bool {
    matches!(kind, Kind::Parabolic | Kind::ModifiedTotal)
}

/// Squared coefficients of a record with 1/`scale` times as many samples per time.
fn scaled_noise(kind: Kind, coefficients: &Coefficients, scale: f64) -> [f64; NOISE_TERMS] {
    Term::NOISE.map(|term| {
        let power = match term {
            Term::Quantization if averages_phase(kind) => -1,
            _ => term.interval_power(),
        };
        coefficients.noise[term.index()] * scale.powi(power)
    })
}

fn quantization_share(m: usize, coefficients: &Coefficients) -> f64 {
    let size = m as f64;
    let variance = |(term, theta): (Term, f64)| theta * term.covariance(size, size, 0.0);
    let all: f64 = Term::NOISE.into_iter().zip(coefficients.noise).map(variance).sum();
    variance((Term::Quantization, coefficients.noise[Term::Quantization.index()])) / all
}

fn freedom_at_size(kind: Kind, samples: usize, m: usize, coefficients: &Coefficients) -> f64 {
    if samples <= LONGEST {
        let (mean, square) = traces(kind, samples, m, coefficients.noise);
        return mean * mean / square;
    }
    // The scale makes the record short enough, but no coarser than necessary; Theo1 needs an even size.
    let reduced = (LONGEST * m / samples).max(REDUCED_SIZE).min(m) / 2 * 2;
    let reduced = if reduced < 2 || m < REDUCED_SIZE { m } else { reduced };
    let scale = m as f64 / reduced as f64;
    let mut noise = scaled_noise(kind, coefficients, scale);
    if reduced != m && !averages_phase(kind) {
        // Its share is at most `SHARE` here.
        noise[Term::Quantization.index()] = 0.0;
    }
    let length = samples as f64 / scale;
    // Linear interpolation between two lengths, the nearest ones if possible.
    // A length that is a whole number, except for rounding, is not rounded down.
    let short = ((length + 1e-9).floor() as usize).min(LONGEST);
    let (from, to) =
        if length > LONGEST as f64 + 1e-9 { (LONGEST - LONGEST / 4, LONGEST) } else { (short, short + 1) };
    let (low, high) = (traces(kind, from, reduced, noise), traces(kind, to, reduced, noise));
    // Independent terms add to both traces in the same way.
    let fraction = (length - from as f64) / (to - from) as f64;
    let mean = low.0 + (high.0 - low.0) * fraction;
    let square = low.1 + (high.1 - low.1) * fraction;
    mean * mean / square
}

/// Expected modified total variance over the modified Allan variance, or Hadamard total over Hadamard variance. Exact up to
/// 64 samples; a longer stretch is represented by one of 64 or 63 samples.
///
/// # Errors
///
/// [`Error::ClusterSize`] for m = 0.
pub fn bias(kind: Kind, m: &[usize], coefficients: &Coefficients) -> Result<Vec<f64>, Error> {
    let of_size = |&m: &usize| {
        let reduced = if m > BIAS_SIZE { BIAS_SIZE - m % 2 } else { m };
        let noise = scaled_noise(kind, coefficients, m as f64 / reduced.max(1) as f64);
        let (reference, divisor) = match kind {
            Kind::ModifiedTotal => (Stationary::Modified, 12.0 * (reduced as f64).powi(5)),
            _ => (Stationary::Hadamard(Overlap::Full), 36.0 * (reduced as f64).powi(3)),
        };
        let samples = 3 * reduced;
        let variance =
            moments(reference, samples, &[reduced], &Coefficients { noise, ramp: 0.0 })?[0].variance;
        if kind == Kind::HadamardTotal && m == 1 {
            return Ok(1.0);
        }
        let stretches = starts(kind, samples, reduced) as f64;
        Ok(traces(kind, samples, reduced, noise).0 / (divisor * stretches * variance))
    };
    m.par_iter().map(of_size).collect()
}

/// tr AΣ and tr (AΣ)².
fn traces(kind: Kind, samples: usize, m: usize, noise: [f64; NOISE_TERMS]) -> (f64, f64) {
    let points = samples + 1;
    let s: Vec<f64> = (0..points).map(|lag| autocovariance(lag, noise)).collect();
    let form = form(kind, samples, m);
    // AΣ, row by row.
    let mut product = vec![0.0; points * points];
    for (row, form) in product.chunks_mut(points).zip(form.chunks(points)) {
        for (k, &weight) in form.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell += weight * s[k.abs_diff(j)];
            }
        }
    }
    let mean: f64 = (0..points).map(|i| product[i * points + i]).sum();
    let cells = (0..points).flat_map(|i| (0..points).map(move |j| (i, j)));
    let square: f64 = cells.map(|(i, j)| product[i * points + j] * product[j * points + i]).sum();
    (mean, square)
}

/// A of a record, row by row, without the divisor of the estimator.
fn form(kind: Kind, samples: usize, m: usize) -> Vec<f64> {
    let points = samples + 1;
    let mut form = vec![0.0; points * points];
    if kind == Kind::Total {
        for i in 1..samples {
            let mut term = vec![(i, -2.0)];
            if i < m {
                term.extend([(0, 2.0), (m - i, -1.0)]);
            } else {
                term.push((i - m, 1.0));
            }
            if i + m > samples {
                term.extend([(samples, 2.0), (2 * samples - m - i, -1.0)]);
            } else {
                term.push((i + m, 1.0));
            }
            add(&mut form, points, &term, 1.0);
        }
        return form;
    }
    // All other estimators treat every stretch of a record alike.
    let width = stretch_points(kind, m);
    let stretch = stretch_form(kind, m);
    for start in 0..starts(kind, samples, m) {
        for (i, row) in stretch.chunks(width).enumerate() {
            let from = (start + i) * points + start;
            form[from..from + width].iter_mut().zip(row).for_each(|(cell, weight)| *cell += weight);
        }
    }
    form
}

/// Adds the square of Σ weight · x(point).
fn add(form: &mut [f64], width: usize, term: &[(usize, f64)], factor: f64) {
    for &(i, weight_i) in term {
        for &(j, weight_j) in term {
            form[i * width + j] += factor * weight_i * weight_j;
        }
    }
}

/// Points of the phase in a stretch.
fn stretch_points(kind: Kind, m: usize) -> usize {
    match kind {
        Kind::Theo1 => m + 1,
        Kind::Parabolic => (2 * m).max(3),
        Kind::ModifiedTotal => 3 * m,
        _ => 3 * m + 1,
    }
}

/// Number of stretches; the parabolic variance leaves out the last one of several samples.
fn starts(kind: Kind, samples: usize, m: usize) -> usize {
    samples + 2 - stretch_points(kind, m) - usize::from(kind == Kind::Parabolic && m > 1)
}

/// The form of a stretch.
fn stretch_form(kind: Kind, m: usize) -> Vec<f64> {
    let width = stretch_points(kind, m);
    let mut form = vec![0.0; width * width];
    let mut add = |term: &[(usize, f64)], factor: f64| add(&mut form, width, term, factor);
    match kind {
        Kind::Theo1 => {
            for a in 1..=m / 2 {
                add(&[(0, 1.0), (a, -1.0), (m - a, -1.0), (m, 1.0)], 1.0 / a as f64);
            }
        }
        Kind::Parabolic if m == 1 => add(&[(0, 1.0), (1, -2.0), (2, 1.0)], 1.0),
        Kind::HadamardTotal if m == 1 => add(&[(0, 1.0), (1, -3.0), (2, 3.0), (3, -1.0)], 1.0),
        Kind::Parabolic => {
            let weight = |k: usize| (m - 1) as f64 / 2.0 - k as f64;
            let clusters = (0..2 * m).map(|k| (k, if k < m { weight(k) } else { -weight(k - m) }));
            add(&clusters.collect::<Vec<_>>(), 1.0);
        }
        _ => reflected_terms(kind, m).iter().for_each(|term| add(term, 1.0)),
    }
    form
}

/// The 6m second differences of means of a reflected stretch, as weights of the points of the phase.
fn reflected_terms(kind: Kind, m: usize) -> Vec<Vec<(usize, f64)>> {
    let length = 3 * m;
    let half = length / 2;
    // The slope is Σ slope[i] x(i).
    let step = 1.0 / (half * (length - half)) as f64;
    let slope = |i: usize| step * (f64::from(u8::from(i >= length - half)) - f64::from(u8::from(i < half)));
    let term = |shift: usize| {
        let mut weights = vec![0.0; length];
        for k in 0..length {
            let i = (shift + k) % (2 * length);
            weights[if i < length { i } else { 2 * length - 1 - i }] += if k / m == 1 { -2.0 } else { 1.0 };
        }
        let of_line: f64 = weights.iter().enumerate().map(|(i, weight)| weight * i as f64).sum();
        weights.iter_mut().enumerate().for_each(|(i, weight)| *weight -= of_line * slope(i));
        if kind == Kind::HadamardTotal {
            // A rate is the difference of two points of the phase.
            weights.push(0.0);
            for k in (0..length).rev() {
                weights[k + 1] += weights[k];
                weights[k] = -weights[k];
            }
        }
        weights.into_iter().enumerate().collect()
    };
    (0..2 * length).map(term).collect()
}

/// s(l) of [`PhaseCovariance`], summed over the terms.
fn autocovariance(lag: usize, noise: [f64; NOISE_TERMS]) -> f64 {
    let l = lag as f64;
    let unit_autocovariance = |term: Term| match term {
        Term::Quantization => f64::from(u8::from(lag == 0)),
        Term::RandomWalk => -0.5 * l,
        Term::BiasInstability => ((4.0 * l * l - 1.0) * odd_harmonic(lag) - 3.0 * l * l) / (4.0 * PI),
        Term::RateRandomWalk => (l * l * l - l) / 12.0,
        Term::RateRamp => 0.0,
    };
    let used = Term::NOISE.into_iter().zip(noise).filter(|&(_, theta)| theta > 0.0);
    used.map(|(term, theta)| theta * unit_autocovariance(term)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(kind: Kind, samples: usize, m: usize, noise: [f64; NOISE_TERMS]) -> f64 {
        let (mean, square) = traces(kind, samples, m, noise);
        mean * mean / square
    }

    const KINDS: [Kind; 5] =
        [Kind::Total, Kind::Theo1, Kind::Parabolic, Kind::ModifiedTotal, Kind::HadamardTotal];

    #[test]
    fn total_variance_at_cluster_size_1_is_the_allan_variance() {
        for (term, expected) in [(0, 514.036_054_6), (1, 666.222_296_4), (2, 809.923_188_7), (3, 999.0)] {
            let mut noise = [0.0; NOISE_TERMS];
            noise[term] = 1.0;
            let got = exact(Kind::Total, 1000, 1, noise);
            assert!((got / expected - 1.0).abs() < 1e-9, "{got} instead of {expected}");
        }
    }

    #[test]
    fn a_short_record_stands_for_a_longer_one() {
        for kind in KINDS {
            // Longer than the longest record without scaling, with sizes below and above the reduced one.
            let sizes = [(450, 10), (450, 60), (450, 136), (450, 442)];
            for (samples, m) in sizes.into_iter().filter(|&(samples, m)| m <= kind.largest(samples)) {
                for term in if m <= REDUCED_SIZE || averages_phase(kind) { 0..4 } else { 1..4 } {
                    let mut coefficients = Coefficients::default();
                    coefficients.noise[term] = 1.0;
                    let got = degrees_of_freedom(kind, samples, &[m], &coefficients).unwrap()[0];
                    let expected = exact(kind, samples, m, coefficients.noise);
                    println!("{kind:?}, m {m}, term {term}: {got} instead of {expected}");
                    assert!(
                        (got / expected - 1.0).abs() < 0.03,
                        "{kind:?}, m {m}, term {term}: {got} instead of {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn total_is_as_published_at_long_averaging_times() {
        // b T / τ − c of NIST SP 1065, table 7, and of C. A. Greenhall, D. A. Howe and D. B. Percival, "Total variance,
        // an estimator of long-term frequency stability", IEEE Trans. UFFC 46(5), 1999.
        for (term, b, c) in [(1, 1.5, 0.0), (2, 1.168_32, 0.222), (3, 0.927_07, 0.358)] {
            let mut coefficients = Coefficients::default();
            coefficients.noise[term] = 1.0;
            for m in [1000, 10_000, 50_000] {
                let got = degrees_of_freedom(Kind::Total, 100_000, &[m], &coefficients).unwrap()[0];
                let expected = b * 1e5 / m as f64 - c;
                assert!(
                    (got / expected - 1.0).abs() < 0.02,
                    "term {term}, m {m}: {got} instead of {expected}"
                );
            }
        }
    }

    #[test]
    fn what_is_refused() {
        let noise = Coefficients { noise: [1.0, 1.0, 0.0, 0.0], ramp: 0.0 };
        assert!(degrees_of_freedom(Kind::Total, 1000, &[10], &noise).is_ok());
        let got = degrees_of_freedom(Kind::Total, 1000, &[10, 100], &noise);
        assert_eq!(got, Err(Error::Parameter { name: "quantization", value: 1.0 }));
        assert!(degrees_of_freedom(Kind::Total, LONGEST, &[10], &noise).is_ok());
        let ramp = Coefficients { ramp: 4.0, ..Coefficients::default() };
        let got = degrees_of_freedom(Kind::Theo1, 100, &[10], &ramp);
        assert_eq!(got, Err(Error::Parameter { name: "rate_ramp", value: 2.0 }));
    }
}
