//! Identities that hold for every record, and options that must not change the result.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::allan::{Counting, Estimate, Overlap, allan_variance, allan_variances, largest_cluster};
use sigmatau_core::error::Error;
use sigmatau_core::generate::simulate;
use sigmatau_core::phase::{LONGEST_BLOCK as BLOCK, Phase};
use sigmatau_core::terms::Term;

/// A seed from the name of the case (FNV-1a), so that no seed is chosen by hand.
fn seed_of(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn record(name: &str, n: usize) -> Vec<f64> {
    let mixture = &[
        (Term::RateRamp, -1e-5),
        (Term::Quantization, 0.3),
        (Term::RandomWalk, 1.0),
        (Term::BiasInstability, 0.2),
        (Term::RateRandomWalk, 0.01),
    ];
    simulate(n, 1.0, mixture, seed_of(name), 0).unwrap()
}

fn full(rate: &[f64], m: &[usize]) -> Vec<Estimate> {
    allan_variance(&Phase::from_rate(rate).unwrap(), m, Overlap::Full, Counting::Standard).unwrap()
}

fn octaves(n: usize) -> Vec<usize> {
    std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|m| 2 * m <= n).collect()
}

fn assert_relative(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got / expected - 1.0).abs() <= tolerance, "{what}: {got} instead of {expected}");
}

/// Eq. (6) of the paper from cluster means, with an error of about 10⁻¹² for these records.
fn naive(rate: &[f64], m: usize, step: usize) -> (f64, usize) {
    let mut sum: f64 = rate[..m].iter().sum();
    let mut means = vec![sum / m as f64];
    for k in m..rate.len() {
        sum += rate[k] - rate[k - m];
        means.push(sum / m as f64);
    }
    let starts: Vec<usize> = (0..=rate.len() - 2 * m).step_by(step).collect();
    let sum: f64 = starts.iter().map(|&k| (means[k + m] - means[k]).powi(2)).sum();
    (0.5 * sum / starts.len() as f64, starts.len())
}

#[test]
fn ramp_gives_its_closed_form() {
    // Samples are a power of two times an integer, hence exact.
    let r = 2f64.powi(-10);
    let n = 20_000;
    let rate: Vec<f64> = (0..n).map(|k| 3.0 + r * f64::from(k)).collect();
    for estimate in full(&rate, &[1, 2, 3, 100, 1024, 4096, 5000, 10_000]) {
        let m = estimate.m as f64;
        assert_relative(estimate.avar, 0.5 * r * r * m * m, 1e-12, "ramp");
    }
}

#[test]
fn full_overlap_agrees_with_cluster_means() {
    let rate = record("full_overlap", 3 * BLOCK + 77);
    let m = [1, 2, 3, 4, 6, 100, 2047, 2048, 2049, 4096, rate.len() / 2];
    for estimate in full(&rate, &m) {
        let (avar, pairs) = naive(&rate, estimate.m, 1);
        assert_eq!(estimate.pairs, pairs);
        assert_relative(estimate.avar, avar, 1e-10, &format!("m = {}", estimate.m));
    }
}

#[test]
fn disjoint_clusters_agree_with_cluster_means() {
    let rate = record("disjoint", 2 * BLOCK + 1234);
    let phase = Phase::from_rate(&rate).unwrap();
    let m = [1, 2, 7, 100, 3000, rate.len() / 2];
    for counting in [Counting::Standard, Counting::Paper] {
        for estimate in allan_variance(&phase, &m, Overlap::None, counting).unwrap() {
            let (avar, pairs) = naive(&rate, estimate.m, estimate.m);
            assert_eq!(estimate.pairs, pairs);
            assert_eq!(estimate.pairs, rate.len() / estimate.m - 1);
            assert_relative(estimate.avar, avar, 1e-10, &format!("m = {}", estimate.m));
        }
    }
}

#[test]
fn both_countings_differ_by_the_last_term() {
    let rate = record("countings", 10_007);
    let phase = Phase::from_rate(&rate).unwrap();
    let m = [1, 2, 4, 8, 500, 5003];
    let standard = allan_variance(&phase, &m, Overlap::Full, Counting::Standard).unwrap();
    let paper = allan_variance(&phase, &m, Overlap::Full, Counting::Paper).unwrap();
    for (standard, paper) in standard.iter().zip(&paper) {
        let m = standard.m;
        assert_eq!(standard.pairs, rate.len() + 1 - 2 * m);
        assert_eq!(paper.pairs, rate.len() - 2 * m);
        let last = phase.second_difference(rate.len() - 2 * m, m);
        let scale = 2.0 * (m * m) as f64;
        let sum = paper.avar * scale * paper.pairs as f64 + last * last;
        assert_relative(standard.avar * scale * standard.pairs as f64, sum, 1e-13, "sum of squares");
    }
}

#[test]
fn a_constant_rate_is_not_seen() {
    // Samples are multiples of 2⁻²⁰, so that adding the constant is exact.
    let quantum = 2f64.powi(-20);
    let rate: Vec<f64> = record("offset", 10_000).iter().map(|y| (y / quantum).round() * quantum).collect();
    let moved: Vec<f64> = rate.iter().map(|y| y + 4096.0).collect();
    for (a, b) in full(&rate, &octaves(10_000)).iter().zip(full(&moved, &octaves(10_000))) {
        assert_relative(b.avar, a.avar, 1e-14, &format!("m = {}", a.m));
    }
}

#[test]
fn sign_and_scale() {
    let rate = record("scale", 10_000);
    let scaled: Vec<f64> = rate.iter().map(|y| -8.0 * y).collect();
    for (a, b) in full(&rate, &octaves(10_000)).iter().zip(full(&scaled, &octaves(10_000))) {
        assert_eq!(b.avar.to_bits(), (64.0 * a.avar).to_bits(), "a power of two changes no digit");
    }
}

#[test]
fn a_chain_of_octaves_equals_one_size_at_a_time() {
    let rate = record("chain", 5 * BLOCK + 3);
    let sizes = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 513, 1026, 2052, 4104, 8208];
    for together in full(&rate, &sizes) {
        let alone = full(&rate, &[together.m])[0];
        assert_eq!(together.avar.to_bits(), alone.avar.to_bits(), "m = {}", together.m);
    }
}

#[test]
fn sizes_come_back_in_the_order_asked_for() {
    let rate = record("order", 1000);
    let m = [8, 1, 500, 1, 2];
    let estimates = full(&rate, &m);
    assert_eq!(estimates.iter().map(|e| e.m).collect::<Vec<_>>(), m);
    assert_eq!(estimates[1], estimates[3]);
    assert!(full(&rate, &[]).is_empty());
}

#[test]
fn threads_do_not_change_a_bit() {
    let n = 300_000;
    let channels = [record("axis x", n), record("axis y", n), record("axis z", n)];
    let channels: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    let mut m = octaves(n);
    m.extend([3, 5, 777, 77_777]);
    for overlap in [Overlap::Full, Overlap::None] {
        let run = |threads| allan_variances(&channels, &m, overlap, Counting::Standard, threads).unwrap();
        let expected = run(Some(1));
        for threads in [Some(2), Some(4), None] {
            assert_eq!(run(threads), expected, "{threads:?} threads");
        }
    }
}

#[test]
fn short_records() {
    for n in 0..6usize {
        let rate: Vec<f64> = (0..n).map(|k| (k * k) as f64).collect();
        let phase = Phase::from_rate(&rate).unwrap();
        assert_eq!(phase.samples(), n);
        let standard = allan_variance(&phase, &[1], Overlap::Full, Counting::Standard);
        let paper = allan_variance(&phase, &[1], Overlap::Full, Counting::Paper);
        if n < 2 {
            assert_eq!(standard, Err(Error::TooShort { need: 2, got: n }));
        } else {
            let (avar, pairs) = naive(&rate, 1, 1);
            let [estimate] = standard.unwrap()[..] else { panic!("one size, one estimate") };
            assert_eq!((estimate.m, estimate.avar, estimate.pairs), (1, avar, pairs));
        }
        if n < 3 {
            assert_eq!(paper, Err(Error::TooShort { need: 3, got: n }));
        } else {
            assert_eq!(paper.unwrap()[0].pairs, n - 2);
        }
    }
}

#[test]
fn sizes_without_a_pair_are_refused() {
    let phase = Phase::from_rate(&[0.0; 10]).unwrap();
    for (overlap, counting, largest) in [
        (Overlap::Full, Counting::Standard, 5),
        (Overlap::Full, Counting::Paper, 4),
        (Overlap::None, Counting::Standard, 5),
        (Overlap::None, Counting::Paper, 5),
    ] {
        assert_eq!(largest_cluster(10, overlap, counting), largest);
        assert!(allan_variance(&phase, &[1, largest], overlap, counting).is_ok());
        for m in [0, largest + 1] {
            let expected = Err(Error::ClusterSize { m, largest });
            assert_eq!(allan_variance(&phase, &[1, m], overlap, counting), expected);
        }
    }
}

#[test]
fn samples_that_cannot_be_summed_are_named() {
    for (index, bad) in
        [(0, f64::NAN), (4095, f64::INFINITY), (4096, f64::NEG_INFINITY), (9000, f64::NAN), (123, 1e131)]
    {
        let mut rate = record("bad", 10_000);
        rate[index] = bad;
        let expected = Error::NonFinite { index };
        assert_eq!(Phase::from_rate(&rate).err(), Some(expected.clone()));
        let channels: [&[f64]; 2] = [&[0.0, 1.0], &rate];
        let together = allan_variances(&channels, &[1], Overlap::Full, Counting::Standard, None);
        assert_eq!(together, Err(expected.clone()));
    }
}

#[test]
fn largest_samples_do_not_overflow() {
    let rate: Vec<f64> = (0..20_000).map(|k| if k % 2 == 0 { 1e130 } else { -1e130 }).collect();
    // Every pair differs by 2e130, so the variance is half its square. Equal terms are all rounded in one direction, 512
    // times per partial sum.
    assert_relative(full(&rate, &[1])[0].avar / 1e200, 2e60, 512.0 * f64::EPSILON, "alternating record");
    assert_eq!(
        allan_variances(&[&rate], &[1], Overlap::Full, Counting::Standard, Some(0)),
        Err(Error::Parameter { name: "threads", value: 0.0 })
    );
}
