//! Comparison with the direct sums, which are accurate to twelve digits according to `tests/accuracy.rs`.

use super::*;
use crate::allan::{Counting, Estimate, Overlap, allan_variance, largest_cluster};
use crate::generate::simulate;
use crate::terms::Term;
use std::f64::consts::TAU;

/// Terms and their coefficients.
type Noise = &'static [(Term, f64)];

fn noise(samples: usize, terms: Noise) -> Vec<f64> {
    simulate(samples, 1.0, terms, 7, 0).unwrap()
}

/// White noise with standard deviation 1 plus a function of the index.
fn white_and(samples: usize, more: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut rate = noise(samples, &[(Term::RandomWalk, 1.0)]);
    rate.iter_mut().enumerate().for_each(|(k, y)| *y += more(k));
    rate
}

/// Records, by name, for which a difference of large sums is difficult.
fn records(samples: usize) -> Vec<(&'static str, Vec<f64>)> {
    let time = |k: usize| k as f64 / samples as f64;
    let third = samples / 3;
    let mixture = &[
        (Term::RateRamp, 1e-4),
        (Term::Quantization, 10.0),
        (Term::RandomWalk, 1.0),
        (Term::BiasInstability, 0.1),
        (Term::RateRandomWalk, 1e-2),
    ];
    vec![
        ("white", white_and(samples, |_| 0.0)),
        ("random walk", noise(samples, &[(Term::RateRandomWalk, 1.0)])),
        ("quantization", noise(samples, &[(Term::Quantization, 1.0)])),
        ("flicker", noise(samples, &[(Term::BiasInstability, 1.0)])),
        ("mixture", noise(samples, mixture)),
        ("mean a million times the noise", white_and(samples, |_| 1e6)),
        ("mean and strong drift", white_and(samples, |k| 1e6 * (1.0 + time(k)))),
        ("warming up", white_and(samples, |k| 1e5 * (-5.0 * time(k)).exp())),
        ("ramp", (0..samples).map(|k| 7.0 + 2.5e-3 * k as f64).collect()),
        ("coarse", white_and(samples, |_| 0.0).iter().map(|y| (0.3 * y).round()).collect()),
        ("rare steps", (0..samples).map(|k| f64::from(u8::from(k % 7919 == 5))).collect()),
        ("spike", white_and(samples, |k| if k == third { 1e8 } else { 0.0 })),
        (
            "glitch of the phase",
            white_and(samples, |k| [1e8, -1e8].get(k.wrapping_sub(third)).copied().unwrap_or(0.0)),
        ),
        ("strong line", white_and(samples, |k| 1e3 * (TAU * k as f64 / 377.3).sin())),
        ("line alone", (0..samples).map(|k| (TAU * k as f64 / 377.0).sin()).collect()),
    ]
}

/// Sizes in each octave, including both ends, and near the borders of groups and blocks.
fn sampled(largest: usize) -> Vec<usize> {
    let mut sizes: Vec<usize> = (0..=largest.ilog2())
        .flat_map(|octave| (0..5).map(move |k| (1 << octave) + ((k << octave) / 5)))
        .chain([1023, 1025, 4095, 4097, largest - 256, largest - 1, largest])
        .filter(|&m| m <= largest)
        .collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

fn every_size(phase: &Phase, counting: Counting) -> Vec<Estimate> {
    let largest = largest_cluster(phase.samples(), Overlap::Full, counting);
    let sizes: Vec<usize> = (1..=largest).collect();
    allan_variance(phase, &sizes, Overlap::Full, counting).unwrap()
}

#[test]
fn agrees_with_the_direct_sums() {
    for (samples, counting) in [(60_000, Counting::Paper), (131_071, Counting::Standard)] {
        for (name, rate) in records(samples) {
            let phase = Phase::from_rate(&rate).unwrap();
            let height = phase.values.iter().fold(0.0, |height: f64, value| height.max(value.abs()));
            let all = every_size(&phase, counting);
            let direct = allan_variance(&phase, &sampled(all.len()), Overlap::Full, counting).unwrap();
            for expected in direct {
                let got = all[expected.m - 1];
                assert_eq!((got.m, got.pairs), (expected.m, expected.pairs));
                // The documented tolerance of this module.
                let error = (got.avar - expected.avar).abs();
                assert!(error <= 1e-9 * expected.avar, "{name}, {samples}, {}: {error:e}", got.m);
                // The direct sums add 1024 points of the phase without compensation: as many roundings, at
                // the height of the sum.
                let sums = f64::EPSILON * 1024.0 * 1024.0 * height;
                let rounding = sums / (got.m as f64).powi(2) / got.pairs as f64;
                let ramp = (got.ramp - expected.ramp).abs();
                assert!(
                    ramp <= 1e-15 * expected.ramp.abs() + rounding,
                    "{name}, {samples}, {}: {ramp:e}",
                    got.m
                );
            }
        }
    }
}

#[test]
fn errors_stay_within_their_bound() {
    let samples = 60_000;
    for (name, rate) in records(samples) {
        let phase = Phase::from_rate(&rate).unwrap();
        let trend = Trend::new(&phase);
        for (smallest, largest) in [(256, 1023), (1024, 20_000), (5000, 29_000)] {
            let group = Group::new(&phase, &trend, samples + 1, smallest, largest);
            let (sums, error, rounding) = group.sums();
            let sizes: Vec<usize> = group.sizes.clone().step_by(97).collect();
            let direct = allan_variance(&phase, &sizes, Overlap::Full, Counting::Standard).unwrap();
            let mut worst: f64 = 0.0;
            for expected in direct {
                let (m, pairs) = (expected.m as f64, expected.pairs as f64);
                let sum = expected.avar * 2.0 * m * m * pairs;
                // The direct sum is accurate to 1e-12 and to the rounding of the phase.
                let off = (sums[expected.m - smallest].value() - sum).abs() - 1e-12 * sum - rounding;
                worst = worst.max(off / error);
            }
            println!("{name}, {smallest}: {worst:.3} of the bound");
            assert!(worst < 0.8, "{name}, {smallest}: {worst}");
        }
    }
}

#[test]
fn nothing_is_nothing() {
    for value in [0.0, 0.1, -1e6 / 3.0] {
        let phase = Phase::from_rate(&vec![value; 60_000]).unwrap();
        let trend = Trend::new(&phase);
        // All sums are returned despite the rounding: half a minute of direct sums would not be more
        // accurate.
        assert!(sums_of_squares(&phase, &trend, 60_001, 29_000).iter().all(Option::is_some));
        for estimate in every_size(&phase, Counting::Standard) {
            // The phase is rounded at the height of a block: 4096 times the rounding error of the mean.
            let rounding = 4096.0 * f64::EPSILON * f64::EPSILON * value;
            assert!(estimate.avar >= 0.0 && estimate.avar <= rounding * rounding, "{value}: {estimate:?}");
        }
    }
}

#[test]
fn zeros_are_exact() {
    // Period 2: the variance is 0 at even sizes, and 1/(2m²) at odd ones.
    let rate: Vec<f64> = (0..20_000).map(|k| f64::from(k % 2)).collect();
    for estimate in every_size(&Phase::from_rate(&rate).unwrap(), Counting::Standard) {
        let m = estimate.m as f64;
        let expected = if estimate.m % 2 == 0 { 0.0 } else { 0.5 / m / m };
        assert!((estimate.avar - expected).abs() <= 1e-9 * expected, "{estimate:?}");
    }
}

#[test]
fn a_ramp_makes_half_its_square() {
    let ramp = 1.0 / 1024.0;
    let rate: Vec<f64> = (0..150_000).map(|k| 100.0 + ramp * f64::from(k)).collect();
    for estimate in every_size(&Phase::from_rate(&rate).unwrap(), Counting::Paper) {
        let expected = 0.5 * (ramp * estimate.m as f64).powi(2);
        assert!((estimate.avar / expected - 1.0).abs() <= 1e-9, "{estimate:?}");
    }
}

#[test]
fn threads_do_not_show() {
    for (name, rate) in records(60_000).into_iter().take(4) {
        let phase = Phase::from_rate(&rate).unwrap();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let bits = |e: Estimate| (e.avar.to_bits(), e.ramp.to_bits());
            pool.install(|| every_size(&phase, Counting::Standard)).into_iter().map(bits).collect::<Vec<_>>()
        };
        let one = with(1);
        assert!(one == with(2) && one == with(4), "{name}");
    }
}

#[test]
fn order_and_repetition_do_not_matter() {
    let phase = Phase::from_rate(&white_and(12_000, |_| 0.0)).unwrap();
    let all = every_size(&phase, Counting::Standard);
    let sizes: Vec<usize> = (1..=6000).rev().chain([7, 5000, 6000, 300]).collect();
    let shuffled = allan_variance(&phase, &sizes, Overlap::Full, Counting::Standard).unwrap();
    for (m, estimate) in sizes.into_iter().zip(shuffled) {
        assert_eq!((estimate.m, estimate.avar.to_bits()), (m, all[m - 1].avar.to_bits()));
    }
}
