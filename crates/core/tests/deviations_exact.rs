//! The deviations against exact integer arithmetic.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::allan::Overlap;
use sigmatau_core::compensated::Sum;
use sigmatau_core::deviations::{Kind, deviations};
use sigmatau_core::generate::{Coefficients, simulate};

/// Samples are multiples of 2⁻³⁶, below 2¹⁷: exact both as floats and as integers.
const QUANTUM: f64 = 1.0 / (1u64 << 36) as f64;

const SIGMA: f64 = 0.1;

struct Case {
    name: &'static str,
    noise: Coefficients,
    /// In standard deviations of the white noise, as is the drift from end to end.
    mean: f64,
    drift: f64,
}

const NONE: Coefficients = Coefficients {
    quantization: 0.0,
    random_walk: 0.0,
    bias_instability: 0.0,
    rate_random_walk: 0.0,
    rate_ramp: 0.0,
};
const WHITE: Coefficients = Coefficients { random_walk: SIGMA, ..NONE };
const WALK: Coefficients = Coefficients { rate_random_walk: SIGMA, ..NONE };
const QUANTIZATION: Coefficients = Coefficients { quantization: SIGMA, ..NONE };

const CASES: [Case; 5] = [
    Case { name: "white", noise: WHITE, mean: 0.0, drift: 0.0 },
    Case { name: "mean a million times the noise", noise: WHITE, mean: 1e6, drift: 0.0 },
    Case { name: "mean and drift", noise: WHITE, mean: 1e6, drift: 100.0 },
    Case { name: "random walk", noise: WALK, mean: 1e4, drift: 0.0 },
    Case { name: "quantization", noise: QUANTIZATION, mean: 1e6, drift: 0.0 },
];

/// FNV-1a: a seed from the name of the case.
fn seed_of(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Rates, and the phase in multiples of [`QUANTUM`].
fn record(case: &Case, n: usize) -> (Vec<f64>, Vec<i128>) {
    let noise = simulate(n, 1.0, &case.noise, seed_of(case.name), 0).unwrap();
    let level = |k: usize| SIGMA * (case.mean + case.drift * k as f64 / n as f64);
    let samples: Vec<i128> =
        noise.iter().enumerate().map(|(k, y)| ((y + level(k)) / QUANTUM).round() as i128).collect();
    let rate = samples.iter().map(|&y| y as f64 * QUANTUM).collect();
    (rate, running_sum(&samples))
}

fn running_sum(values: &[i128]) -> Vec<i128> {
    let sums = values.iter().scan(0, |sum, &y| {
        *sum += y;
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}

/// A sum of squares of integers that do not fit a float, and their squares not an integer.
fn sum_of_squares(values: impl Iterator<Item = i128>) -> f64 {
    let mut sum = Sum::default();
    for value in values {
        let leading = value as f64;
        let rest = (value - leading as i128) as f64;
        let square = leading * leading;
        sum.add(square);
        sum.add(leading.mul_add(leading, -square));
        sum.add(2.0 * leading * rest);
    }
    sum.value()
}

fn third_differences(points: &[i128], m: usize, step: usize) -> impl Iterator<Item = i128> + '_ {
    (0..points.len() - 3 * m)
        .step_by(step)
        .map(move |k| points[k + 3 * m] - 3 * points[k + 2 * m] + 3 * points[k + m] - points[k])
}

fn exact(kind: Kind, phase: &[i128], m: usize) -> f64 {
    let size = m as f64;
    let n = phase.len() - 1;
    match kind {
        Kind::Hadamard(Overlap::Full) => {
            let mean = sum_of_squares(third_differences(phase, m, 1)) / (n + 1 - 3 * m) as f64;
            (mean / 6.0).sqrt() * QUANTUM / size
        }
        Kind::Hadamard(Overlap::None) => {
            let mean = sum_of_squares(third_differences(phase, m, m)) / (n / m - 2) as f64;
            (mean / 6.0).sqrt() * QUANTUM / size
        }
        Kind::Modified => {
            let sums = running_sum(phase);
            let mean = sum_of_squares(third_differences(&sums, m, 1)) / (n + 2 - 3 * m) as f64;
            (mean / 2.0).sqrt() * QUANTUM / (size * size)
        }
    }
}

const KINDS: [Kind; 3] = [Kind::Modified, Kind::Hadamard(Overlap::Full), Kind::Hadamard(Overlap::None)];

fn assert_exact(n: usize, sizes: &[usize], tolerance: f64) {
    for case in &CASES {
        let (rate, phase) = record(case, n);
        for kind in KINDS {
            let got = deviations(kind, &rate, sizes).unwrap();
            let errors: Vec<f64> =
                got.iter().map(|d| (d.deviation / exact(kind, &phase, d.m) - 1.0).abs()).collect();
            println!("{}, {kind:?}, {n} samples: {errors:?}", case.name);
            let worst = errors.into_iter().fold(0.0, f64::max);
            assert!(worst <= tolerance, "{}, {kind:?}: {worst:e}", case.name);
        }
    }
}

#[test]
fn short_record() {
    assert_exact(200_000, &[1, 2, 3, 4, 8, 10, 64, 1000, 4096, 10_000, 65_536, 66_666], 1e-12);
}

#[test]
fn lengths_round_the_borders_of_blocks() {
    for n in [3, 4, 5, 1023, 1026, 4094, 4095, 4096, 4097, 4098, 5121, 8190, 8191, 8192] {
        let sizes: Vec<usize> =
            [1, 2, 4, 5, 341, 1023, 1024, 1365, 2730].into_iter().filter(|&m| 3 * m <= n).collect();
        // All of the drift lies in one or two blocks here, and few terms share its roundings.
        assert_exact(n, &sizes, 1e-11);
    }
}

#[test]
#[ignore = "ten million samples: seconds in a release build"]
fn long_record() {
    assert_exact(10_000_000, &[1, 2, 4, 10, 64, 1000, 4096, 100_000, 1 << 20, 3_333_333], 1e-12);
}
