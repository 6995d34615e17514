//! Degrees of freedom of the total variance and of Theo1, whose terms are not a stationary sequence.
//!
//! Both are quadratic forms x'Ax of the phase, with mean tr AΣ and variance 2 tr (AΣ)², where Σ is the
//! generalised autocovariance of the phase: A removes the part of Σ that is arbitrary. The computation is exact
//! and takes N³ steps, so it is limited to records up to [`LONGEST`]. White, flicker and random-walk noise of
//! the rate are the same at any scale, so that a shorter record with the same ratio of averaging time to
//! length represents a longer one. The traces grow linearly with the length if averaging times are a small
//! part of the record.

use super::Kind;
use super::freedom::Coefficients;
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

/// Equivalent degrees of freedom of [`Kind::Total`] or [`Kind::Theo1`] at the cluster sizes `m`.
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
    if m.iter().any(|m| scaled(&m)) {
        return Err(Error::Parameter { name: "quantization", value: coefficients.noise[0].sqrt() });
    }
    if coefficients.ramp > 0.0 {
        return Err(Error::Parameter { name: "rate_ramp", value: coefficients.ramp.sqrt() });
    }
    Ok(m.par_iter().map(|&m| freedom_at_size(kind, samples, m, coefficients)).collect())
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
    let scaled_coefficient = |term: Term| {
        let power = term.interval_power();
        // Quantization noise depends on the scale. Its share is at most `SHARE` here.
        if power == 0 && reduced != m { 0.0 } else { coefficients.noise[term.index()] * scale.powi(power) }
    };
    let noise = Term::NOISE.map(scaled_coefficient);
    let length = samples as f64 / scale;
    // Linear interpolation between two lengths, the nearest ones if possible.
    let short = (length.floor() as usize).min(LONGEST);
    let (from, to) =
        if length > LONGEST as f64 { (LONGEST - LONGEST / 4, LONGEST) } else { (short, short + 1) };
    let (low, high) = (traces(kind, from, reduced, noise), traces(kind, to, reduced, noise));
    // Independent terms add to both traces in the same way.
    let fraction = (length - from as f64) / (to - from) as f64;
    let mean = low.0 + (high.0 - low.0) * fraction;
    let square = low.1 + (high.1 - low.1) * fraction;
    mean * mean / square
}

/// tr AΣ and tr (AΣ)².
fn traces(kind: Kind, samples: usize, m: usize, noise: [f64; NOISE_TERMS]) -> (f64, f64) {
    let points = samples + 1;
    let s: Vec<f64> = (0..points).map(|lag| autocovariance(lag, noise)).collect();
    let mut form = vec![0.0; points * points];
    let mut add = |term: &[(usize, f64)], weight: f64| {
        for &(i, weight_i) in term {
            for &(j, weight_j) in term {
                form[i * points + j] += weight * weight_i * weight_j;
            }
        }
    };
    if kind == Kind::Theo1 {
        for start in 0..points - m {
            for a in 1..=m / 2 {
                let term = [(start, 1.0), (start + a, -1.0), (start + m - a, -1.0), (start + m, 1.0)];
                add(&term, 1.0 / a as f64);
            }
        }
    } else {
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
            add(&term, 1.0);
        }
    }
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

    const KINDS: [Kind; 2] = [Kind::Total, Kind::Theo1];

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
            for (samples, m) in [(600, 10), (600, 40), (600, 60), (600, 180), (600, 590)] {
                for term in if m <= REDUCED_SIZE { 0..4 } else { 1..4 } {
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
