//! The phase and the Allan variance against exact integer arithmetic.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::allan::{Counting, Overlap, allan_variance};
use sigmatau_core::compensated::Sum;
use sigmatau_core::generate::simulate;
use sigmatau_core::phase::Phase;
use sigmatau_core::terms::Term;

/// Terms and their coefficients.
type Noise = &'static [(Term, f64)];

/// Samples are multiples of 2⁻³⁶, below 2¹⁷: exact both as floats and as integers.
const QUANTUM: f64 = 1.0 / (1u64 << 36) as f64;

struct Case {
    name: &'static str,
    noise: Noise,
    /// Mean, in standard deviations of the white noise, which is 0.1.
    mean: f64,
    /// End-to-end drift, in the same unit.
    drift: f64,
}

const SIGMA: f64 = 0.1;

const WHITE: Noise = &[(Term::RandomWalk, SIGMA)];

const CASES: [Case; 5] = [
    Case { name: "white", noise: WHITE, mean: 0.0, drift: 0.0 },
    Case { name: "mean a million times the noise", noise: WHITE, mean: 1e6, drift: 0.0 },
    Case { name: "mean and drift", noise: WHITE, mean: 1e6, drift: 100.0 },
    Case { name: "random walk", noise: &[(Term::RateRandomWalk, SIGMA)], mean: 1e4, drift: 0.0 },
    Case { name: "quantization", noise: &[(Term::Quantization, SIGMA)], mean: 1e6, drift: 0.0 },
];

/// FNV-1a: a seed from the name of the case.
fn seed_of(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn integers(case: &Case, n: usize) -> Vec<i64> {
    let noise = simulate(n, 1.0, case.noise, seed_of(case.name), 0).unwrap();
    let level = |k: usize| SIGMA * (case.mean + case.drift * k as f64 / n as f64);
    noise.iter().enumerate().map(|(k, y)| ((y + level(k)) / QUANTUM).round() as i64).collect()
}

/// Exact except for the last rounding of the sum of squares.
fn exact_avar(phase: &[i128], m: usize) -> f64 {
    let mut sum = Sum::default();
    for k in 0..phase.len() - 2 * m {
        let z = phase[k] - 2 * phase[k + m] + phase[k + 2 * m];
        // The square as a pair of floats, because it may not fit into an integer.
        let leading = z as f64;
        let rest = (z - leading as i128) as f64;
        let square = leading * leading;
        sum.add(square);
        sum.add(leading.mul_add(leading, -square));
        sum.add(2.0 * leading * rest);
    }
    let pairs = (phase.len() - 2 * m) as f64;
    sum.value() * QUANTUM * QUANTUM / (2.0 * (m * m) as f64 * pairs)
}

/// Largest relative error at any size.
fn worst_error(case: &Case, n: usize, sizes: &[usize]) -> f64 {
    let samples = integers(case, n);
    let rate: Vec<f64> = samples.iter().map(|&y| y as f64 * QUANTUM).collect();
    let mut exact = Vec::with_capacity(n + 1);
    exact.push(0i128);
    exact.extend(samples.iter().scan(0i128, |sum, &y| {
        *sum += i128::from(y);
        Some(*sum)
    }));
    let phase = Phase::from_rate(&rate).unwrap();
    let estimates = allan_variance(&phase, sizes, Overlap::Full, Counting::Standard).unwrap();
    let error = |(avar, m): (f64, usize)| (avar / exact_avar(&exact, m) - 1.0).abs();
    let errors: Vec<f64> = estimates.iter().map(|e| error((e.avar, e.m))).collect();
    println!("{}, {n} samples: {errors:?}", case.name);
    errors.into_iter().fold(0.0, f64::max)
}

#[test]
fn short_record() {
    for case in &CASES {
        let worst = worst_error(case, 200_000, &[1, 2, 3, 10, 64, 1000, 4096, 10_000, 65_536, 99_999]);
        assert!(worst <= 1e-12, "{}: {worst:e}", case.name);
    }
}

#[test]
#[ignore = "ten million samples: seconds in a release build"]
fn long_record() {
    for case in &CASES {
        let worst = worst_error(case, 10_000_000, &[1, 2, 10, 64, 1000, 4096, 100_000, 1 << 20, 4_999_999]);
        assert!(worst <= 1e-12, "{}: {worst:e}", case.name);
    }
}

#[test]
#[ignore = "a hundred million samples: 5 GiB, and a minute in a release build"]
fn very_long_record() {
    for case in &CASES {
        let worst = worst_error(case, 100_000_000, &[1, 2, 64, 4096, 1 << 20, 49_999_999]);
        assert!(worst <= 1e-12, "{}: {worst:e}", case.name);
    }
}

#[test]
fn second_differences_one_by_one() {
    for case in &CASES {
        let n = 20_000;
        let samples = integers(case, n);
        let rate: Vec<f64> = samples.iter().map(|&y| y as f64 * QUANTUM).collect();
        let phase = Phase::from_rate(&rate).unwrap();
        let sum = |range: std::ops::Range<usize>| samples[range].iter().map(|&y| i128::from(y)).sum::<i128>();
        for (k, m) in [(0, 1), (4095, 1), (4094, 1), (1, 4096), (0, 10_000), (17, 7777), (8191, 4097)] {
            let exact = (sum(k + m..k + 2 * m) - sum(k..k + m)) as f64 * QUANTUM;
            let error = phase.second_difference(k, m) - exact;
            // The phase deviates within a block for at most 4096 samples, and is rounded once at that value.
            let height = 4096.0
                * SIGMA
                * (1.0 + case.drift)
                * if case.noise[0].0 == Term::RateRandomWalk { 150.0 } else { 1.0 };
            assert!(
                error.abs() <= 4.0 * f64::EPSILON * (height + exact.abs()),
                "{} at {k}, {m}: {error:e}",
                case.name
            );
        }
    }
}
