//! The deviations against exact integer arithmetic.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::allan::Overlap;
use sigmatau_core::compensated::Sum;
use sigmatau_core::deviations::{Kind, deviations, deviations_of_channels};
use sigmatau_core::generate::simulate;
use sigmatau_core::terms::Term;

/// Terms and their coefficients.
type Noise = &'static [(Term, f64)];

/// Samples are multiples of 2⁻³⁶, below 2¹⁷: exact both as floats and as integers.
const QUANTUM: f64 = 1.0 / (1u64 << 36) as f64;

const SIGMA: f64 = 0.1;

struct Case {
    name: &'static str,
    noise: Noise,
    /// Mean, in standard deviations of the white noise; the drift over 200 000 samples or more is in the same unit.
    mean: f64,
    drift: f64,
}

const WHITE: Noise = &[(Term::RandomWalk, SIGMA)];
const WALK: Noise = &[(Term::RateRandomWalk, SIGMA)];
const QUANTIZATION: Noise = &[(Term::Quantization, SIGMA)];

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
    let noise = simulate(n, 1.0, case.noise, seed_of(case.name), 0).unwrap();
    let level = |k: usize| SIGMA * (case.mean + case.drift * k as f64 / n.max(200_000) as f64);
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

/// A sum of squares of integers; they do not fit into a float, and their squares do not fit into an integer.
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

/// The largest or smallest value of each window, computed from windows of half the width.
fn of_windows(values: &[i128], size: usize, of_two: fn(i128, i128) -> i128) -> Vec<i128> {
    let joined =
        |half: &[i128], by: usize| half.iter().zip(&half[by..]).map(|(&a, &b)| of_two(a, b)).collect();
    let (mut best, mut width) = (values.to_vec(), 1);
    while 2 * width <= size {
        best = joined(&best, width);
        width *= 2;
    }
    joined(&best, size - width)
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
        Kind::Total => {
            // Reflected at both ends.
            let (n, m) = (n as i64, m as i64);
            let extended = |k: i64| match k {
                k if k < 0 => 2 * phase[0] - phase[(-k) as usize],
                k if k > n => 2 * phase[n as usize] - phase[(2 * n - k) as usize],
                k => phase[k as usize],
            };
            let terms = (1..n).map(|i| extended(i - m) - 2 * extended(i) + extended(i + m));
            (sum_of_squares(terms) / (2 * (n - 1)) as f64).sqrt() * QUANTUM / size
        }
        Kind::Theo1 => {
            let starts = n + 1 - m;
            let sum: f64 = (0..m / 2)
                .map(|delta| {
                    let terms = (0..starts).map(|i| {
                        (phase[i] - phase[i + m / 2 - delta]) + (phase[i + m] - phase[i + delta + m / 2])
                    });
                    sum_of_squares(terms) / (m / 2 - delta) as f64
                })
                .sum();
            (sum / (0.75 * starts as f64)).sqrt() * QUANTUM / size
        }
        Kind::Parabolic if m == 1 => {
            let terms = (1..n).map(|i| phase[i + 1] - 2 * phase[i] + phase[i - 1]);
            (sum_of_squares(terms) / (2 * (n - 1)) as f64).sqrt() * QUANTUM
        }
        Kind::Parabolic => {
            // Twice the weights.
            let weight = |k: usize| m as i128 - 1 - 2 * k as i128;
            let term = |i: usize| (0..m).map(|k| weight(k) * (phase[i + k] - phase[i + m + k])).sum();
            let mean = sum_of_squares((0..=n - 2 * m).map(term)) / (n + 1 - 2 * m) as f64;
            (18.0 * mean).sqrt() * QUANTUM / (size * size * size)
        }
        Kind::ModifiedTotal => (reflected(phase, m) / 2.0).sqrt() * QUANTUM / size,
        Kind::HadamardTotal if m == 1 => exact(Kind::Hadamard(Overlap::Full), phase, m),
        Kind::HadamardTotal => {
            let rate: Vec<i128> = phase.windows(2).map(|pair| pair[1] - pair[0]).collect();
            (reflected(&rate, m) / 6.0).sqrt() * QUANTUM
        }
        Kind::Mtie => {
            let (most, least) = (of_windows(phase, m + 1, i128::max), of_windows(phase, m + 1, i128::min));
            most.iter().zip(least).map(|(most, least)| most - least).max().unwrap() as f64 * QUANTUM
        }
        Kind::TieRms => {
            let moves = (m..=n).map(|k| phase[k] - phase[k - m]);
            (sum_of_squares(moves) / (n + 1 - m) as f64).sqrt() * QUANTUM
        }
    }
}

/// Mean squared second difference of the means of each 3m points, without their slope and between mirror images.
fn reflected(points: &[i128], m: usize) -> f64 {
    let length = 3 * m;
    let half = length / 2;
    // Points are multiplied by the divisor of the slope.
    let divisor = (half * (length - half)) as i128;
    let squares = points.windows(length).map(|stretch| {
        let (first, last) = (&stretch[..half], &stretch[length - half..]);
        let slope = last.iter().sum::<i128>() - first.iter().sum::<i128>();
        let level: Vec<i128> =
            stretch.iter().enumerate().map(|(i, x)| (x - stretch[0]) * divisor - slope * i as i128).collect();
        let mirrored = level.iter().rev().chain(&level).chain(level.iter().rev()).copied();
        let sums = running_sum(&mirrored.collect::<Vec<_>>());
        sum_of_squares(third_differences(&sums, m, 1).take(6 * m)) / (divisor as f64).powi(2)
    });
    let stretches = (points.len() + 1 - length) as f64;
    squares.sum::<f64>() / (6.0 * (m as f64).powi(3) * stretches)
}

fn assert_exact(kind: Kind, n: usize, sizes: &[usize], tolerance: f64) {
    for case in &CASES {
        assert_case(case, kind, n, sizes, tolerance);
    }
}

fn assert_case(case: &Case, kind: Kind, n: usize, sizes: &[usize], tolerance: f64) {
    let (rate, phase) = record(case, n);
    let got = deviations(kind, &rate, sizes).unwrap();
    let errors: Vec<f64> = got.iter().map(|d| (d.deviation / exact(kind, &phase, d.m) - 1.0).abs()).collect();
    println!("{}, {kind:?}, {n} samples: {errors:?}", case.name);
    let worst = errors.into_iter().fold(0.0, f64::max);
    assert!(worst <= tolerance, "{}, {kind:?}, {n} samples: {worst:e}", case.name);
}

const THIRDS: [Kind; 3] = [Kind::Modified, Kind::Hadamard(Overlap::Full), Kind::Hadamard(Overlap::None)];

#[test]
fn third_differences_of_a_short_record() {
    for kind in THIRDS {
        assert_exact(kind, 200_000, &[1, 2, 3, 4, 8, 10, 64, 1000, 4096, 10_000, 65_536, 66_666], 1e-12);
    }
}

#[test]
fn total() {
    assert_exact(
        Kind::Total,
        200_000,
        &[1, 2, 3, 10, 64, 4096, 10_000, 65_536, 100_000, 131_072, 199_999],
        1e-12,
    );
}

#[test]
fn theo1() {
    assert_exact(Kind::Theo1, 5_003, &[10, 12, 64, 1000, 4096, 4500, 5_002], 1e-12);
}

#[test]
fn parabolic() {
    assert_exact(Kind::Parabolic, 6_000, &[1, 2, 7, 31, 32, 33, 64, 1000, 2999, 3000], 1e-12);
}

#[test]
fn reflected_stretches() {
    for kind in [Kind::ModifiedTotal, Kind::HadamardTotal] {
        assert_exact(kind, 1_000, &[1, 2, 3, 16, 63, 64, 100, 333], 1e-12);
    }
}

#[test]
fn time_interval_errors() {
    for kind in [Kind::Mtie, Kind::TieRms] {
        assert_exact(kind, 9_000, &[1, 2, 3, 7, 10, 64, 100, 1000, 4095, 4096, 5000, 8_999, 9_000], 1e-12);
    }
}

#[test]
fn lengths_round_the_borders_of_blocks() {
    let kinds = [Kind::Total, Kind::Theo1, Kind::Mtie, Kind::TieRms];
    for n in [3, 4, 5, 10, 11, 1023, 1026, 1033, 4094, 4095, 4096, 4097, 4098, 5121, 8190, 8191, 8192] {
        for kind in THIRDS.into_iter().chain(kinds) {
            let used = |m: &usize| (kind.smallest()..=kind.largest(n)).contains(m);
            // The definition of Theo1 takes m²: long clusters are in `theo1`.
            let even = |m: &usize| kind != Kind::Theo1 || (m % 2 == 0 && *m <= 1024);
            let sizes = [1, 2, 4, 5, 10, 22, 341, 1023, 1024, 1365, 2730, 4096];
            let sizes: Vec<usize> = sizes.into_iter().filter(used).filter(even).collect();
            if sizes.is_empty() {
                continue;
            }
            // Rounding errors hardly average over few terms, and are largest for sums of the phase of a random walk.
            let tolerance = if kind == Kind::Modified { 1e-10 } else { 1e-11 };
            for case in &CASES[2..4] {
                assert_case(case, kind, n, &sizes, tolerance);
            }
        }
    }
}

#[test]
fn threads_do_not_show() {
    let (first, _) = record(&CASES[2], 300_001);
    let (second, _) = record(&CASES[3], 300_001);
    let channels = [&first[..], &second[..]];
    let kinds = [Kind::Total, Kind::Theo1, Kind::Mtie, Kind::TieRms, Kind::Parabolic];
    let reflected = [Kind::ModifiedTotal, Kind::HadamardTotal];
    for kind in THIRDS.into_iter().chain(kinds).chain(reflected) {
        let sizes: &[usize] = match kind {
            Kind::Theo1 => &[10, 500],
            Kind::ModifiedTotal | Kind::HadamardTotal => &[1, 2],
            _ => &[1, 2, 3, 4, 8, 1000, 90_000],
        };
        let bits = |threads| -> Vec<u64> {
            let of_all = deviations_of_channels(kind, &channels, sizes, threads).unwrap();
            of_all.iter().flatten().map(|d| d.deviation.to_bits()).collect()
        };
        let one = bits(Some(1));
        for threads in [Some(2), Some(3), None] {
            assert_eq!(bits(threads), one, "{kind:?}, {threads:?}");
        }
    }
}

#[test]
fn a_ramp_is_invisible_to_the_hadamard_deviation_only() {
    let (n, slope) = (30_000u32, 0.25);
    let rate: Vec<f64> = (0..n).map(|k| 7.0 + slope * f64::from(k)).collect();
    for d in deviations(Kind::Hadamard(Overlap::Full), &rate, &[1, 10, 1000, 10_000]).unwrap() {
        assert!(d.deviation < 1e-9 * slope, "{d:?}");
    }
    for kind in [Kind::Modified, Kind::Total] {
        for d in deviations(kind, &rate, &[1, 10, 100]).unwrap() {
            let expected = slope * d.m as f64 / 2f64.sqrt();
            // The reflected ends of the total deviation contain the ramp with both signs, in about m of N terms.
            let tolerance = if kind == Kind::Total { 2.0 * d.m as f64 / f64::from(n) } else { 1e-12 };
            assert!((d.deviation / expected - 1.0).abs() <= tolerance, "{kind:?} {d:?}");
        }
    }
}

#[test]
fn what_is_refused() {
    use sigmatau_core::error::Error;
    let rate = [0.5, 0.25, 1.0];
    let got = |kind, m: usize| deviations(kind, &rate, &[m]).unwrap_err();
    assert_eq!(got(Kind::Hadamard(Overlap::Full), 2), Error::ClusterSize { m: 2, largest: 1 });
    assert_eq!(got(Kind::Modified, 0), Error::ClusterSize { m: 0, largest: 1 });
    assert_eq!(got(Kind::Theo1, 10), Error::TooShort { need: 10, got: 3 });
    assert_eq!(got(Kind::Mtie, 4), Error::ClusterSize { m: 4, largest: 3 });
    assert!(matches!(deviations(Kind::Theo1, &[1.0; 100], &[11]), Err(Error::ClusterSize { m: 11, .. })));
    assert_eq!(deviations(Kind::Total, &[0.0, f64::NAN], &[1]), Err(Error::NonFinite { index: 1 }));
    let no_threads = deviations_of_channels(Kind::Total, &[&rate], &[1], Some(0));
    assert_eq!(no_threads, Err(Error::Parameter { name: "threads", value: 0.0 }));
}

#[test]
#[ignore = "ten million samples: seconds in a release build"]
fn long_record() {
    for kind in THIRDS {
        assert_exact(kind, 10_000_000, &[1, 2, 4, 10, 64, 1000, 4096, 100_000, 1 << 20, 3_333_333], 1e-12);
    }
}
