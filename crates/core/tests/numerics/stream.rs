//! Records in pieces against records as a whole.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sigmatau_core::allan::{Counting, Overlap, allan_variance};
use sigmatau_core::compensated::Sum;
use sigmatau_core::error::Error;
use sigmatau_core::generate::simulate;
use sigmatau_core::phase::Phase;
use sigmatau_core::stream::{Accumulator, GROUP, LARGEST, Long, Strided, stride};
use sigmatau_core::terms::Term;

/// FNV-1a: a seed from the name of the case.
fn seed_of(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// White noise and a random walk with a mean a million times larger, and a drift.
fn record(name: &str, n: usize) -> Vec<f64> {
    let noise = &[(Term::RandomWalk, 1.0), (Term::RateRandomWalk, 1e-3)];
    let noise = simulate(n, 1.0, noise, seed_of(name), 0).unwrap();
    noise.iter().enumerate().map(|(k, y)| 1e6 + 1e-5 * k as f64 + y).collect()
}

fn octaves(most: usize) -> Vec<usize> {
    std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|&m| m <= most).collect()
}

fn assert_relative(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got - expected).abs() <= tolerance * expected.abs(), "{what}: {got:e}, expected {expected:e}");
}

/// The mean square over the starts at multiples of the stride, counted from the first sample of the record.
fn directly(rate: &[f64], start: u64, m: usize) -> (f64, usize) {
    let phase = Phase::from_rate(rate).unwrap();
    let stride = stride(m);
    let first = (start.next_multiple_of(stride as u64) - start) as usize;
    let mut sum = Sum::default();
    let mut pairs = 0;
    for k in (first..=rate.len()).step_by(stride).take_while(|k| k + 2 * m <= rate.len()) {
        let z = phase.second_difference(k, m);
        sum.add(z * z);
        pairs += 1;
    }
    (sum.value() / (2.0 * (m * m) as f64 * pairs as f64), pairs)
}

fn same(got: &[Strided], expected: &[Strided], tolerance: f64) {
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        assert_eq!((got.estimate.m, got.estimate.pairs), (expected.estimate.m, expected.estimate.pairs));
        assert_eq!(got.stride, expected.stride);
        let what = format!("m = {}", got.estimate.m);
        assert_relative(got.estimate.avar, expected.estimate.avar, tolerance, &what);
        // The ramp is 1e-5; its rounding error is that of a rate of 1e6.
        let ramp = got.estimate.ramp - expected.estimate.ramp;
        assert!(ramp.abs() <= 1e-9 * 1e-5 + tolerance * expected.estimate.ramp.abs(), "{what}: {ramp:e}");
    }
}

#[test]
fn strides_leave_at_least_sixty_four_starts_a_cluster() {
    assert_eq!(stride(1), 1);
    assert_eq!(stride(LARGEST), 1);
    assert_eq!(stride(LARGEST + 64), GROUP);
    for m in octaves(1 << 40) {
        let stride = stride(m);
        assert!(m % stride == 0 && m / stride <= LARGEST && (stride == 1 || m / stride >= LARGEST / GROUP));
    }
}

#[test]
fn a_stream_counts_what_the_whole_record_has() {
    let n = 400_000;
    let rate = record("whole", n);
    let mut m = octaves(n / 2);
    m.extend([3, 5, 100, 4095, 3 << 12, 100 * GROUP]);
    let mut stream = Accumulator::new(&m, Long::Strided, 0).unwrap();
    stream.push(&rate).unwrap();
    let snapshot = stream.snapshot().unwrap();
    assert_eq!(snapshot.len(), m.len());
    let phase = Phase::from_rate(&rate).unwrap();
    for Strided { estimate, stride: apart } in snapshot {
        let m = estimate.m;
        assert_eq!(apart, stride(m));
        let (avar, pairs) = directly(&rate, 0, m);
        assert_eq!(estimate.pairs, pairs);
        assert_relative(estimate.avar, avar, 1e-12, &format!("m = {m}"));
        let exact = allan_variance(&phase, &[m], Overlap::Full, Counting::Standard).unwrap()[0];
        if apart == 1 {
            assert_eq!(estimate.pairs, exact.pairs);
            assert_relative(estimate.avar, exact.avar, 1e-12, &format!("m = {m}"));
            // A rate of 1e6 is rounded to 1e-10.
            assert!((estimate.ramp - exact.ramp).abs() < 1e-13, "{m}: {:e} {:e}", estimate.ramp, exact.ramp);
        }
    }
}

#[test]
fn an_exact_accumulator_keeps_every_digit() {
    let rate = record("exact", 50_000);
    let m = octaves(25_000);
    let mut stream = Accumulator::new(&m, Long::Exact, 0).unwrap();
    for chunk in rate.chunks(777) {
        stream.push(chunk).unwrap();
    }
    let phase = Phase::from_rate(&rate).unwrap();
    let expected = allan_variance(&phase, &m, Overlap::Full, Counting::Standard).unwrap();
    let got: Vec<_> = stream.snapshot().unwrap().into_iter().map(|s| s.estimate).collect();
    assert_eq!(got, expected);
}

#[test]
fn chunks_make_no_difference() {
    let n = 300_000;
    let rate = record("chunks", n);
    let m = octaves(n);
    let mut whole = Accumulator::new(&m, Long::Strided, 0).unwrap();
    whole.push(&rate).unwrap();
    let expected = whole.snapshot().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of("cuts"));
    for longest in [3, 100, 70_000, n] {
        let mut stream = Accumulator::new(&m, Long::Strided, 0).unwrap();
        let mut rest = rate.as_slice();
        while !rest.is_empty() {
            let (chunk, tail) = rest.split_at(rng.random_range(0..=longest).min(rest.len()));
            stream.push(chunk).unwrap();
            // A snapshot changes nothing.
            if rng.random_range(0..1000) == 0 {
                stream.snapshot().unwrap();
            }
            rest = tail;
        }
        assert_eq!(stream.samples(), n as u64);
        same(&stream.snapshot().unwrap(), &expected, 1e-12);
    }
}

/// Divides a record, accumulates each stretch separately, and merges neighbours in random order.
fn merged(
    rate: &[f64],
    m: &[usize],
    long: Long,
    start: u64,
    cuts: &[usize],
    rng: &mut ChaCha8Rng,
) -> Accumulator {
    let mut borders = cuts.to_vec();
    borders.push(0);
    borders.push(rate.len());
    borders.sort_unstable();
    let mut parts: Vec<Accumulator> = borders
        .windows(2)
        .map(|pair| {
            let mut part = Accumulator::new(m, long, start + pair[0] as u64).unwrap();
            part.push(&rate[pair[0]..pair[1]]).unwrap();
            part
        })
        .collect();
    while parts.len() > 1 {
        let at = rng.random_range(0..parts.len() - 1);
        let later = parts.remove(at + 1);
        parts[at].merge(&later).unwrap();
    }
    parts.remove(0)
}

#[test]
fn the_order_of_merging_makes_no_difference() {
    let n = 500_000;
    let rate = record("merge", n);
    let m = octaves(n);
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of("merges"));
    // Starts at the border of a group, at the border of a group of groups, and elsewhere.
    for start in [0, 1, 64, 5000, 262_144, 1_000_003] {
        let mut whole = Accumulator::new(&m, Long::Strided, start).unwrap();
        whole.push(&rate).unwrap();
        let expected = whole.snapshot().unwrap();
        for got in &expected {
            let (avar, pairs) = directly(&rate, start, got.estimate.m);
            assert_eq!(got.estimate.pairs, pairs);
            assert_relative(got.estimate.avar, avar, 1e-12, "strided");
        }
        for pieces in [1, 2, 3, 10, 40] {
            let mut cuts: Vec<usize> = (1..pieces).map(|_| rng.random_range(0..=n)).collect();
            // Stretches shorter than a group, and empty ones.
            if pieces == 10 {
                cuts.extend([100, 101, 101, 130, 200, 8192, n - 1, n]);
            }
            let got = merged(&rate, &m, Long::Strided, start, &cuts, &mut rng);
            assert_eq!((got.start(), got.samples()), (start, n as u64));
            same(&got.snapshot().unwrap(), &expected, 1e-12);
        }
    }
}

#[test]
fn a_merged_accumulator_goes_on() {
    let rate = record("goes on", 300_000);
    let m = octaves(100_000);
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of("goes on"));
    for long in [Long::Strided, Long::Exact] {
        let mut got = merged(&rate[..200_000], &m, long, 0, &[70_001, 150_000], &mut rng);
        got.push(&rate[200_000..]).unwrap();
        let mut whole = Accumulator::new(&m, long, 0).unwrap();
        whole.push(&rate).unwrap();
        same(&got.snapshot().unwrap(), &whole.snapshot().unwrap(), 1e-12);
    }
}

/// Each stretch is so long that starts end within its groups.
#[test]
fn later_stages_are_merged_like_the_first() {
    let n = 11_000_000;
    let rate = record("later stages", n);
    let m = octaves(n);
    let mut whole = Accumulator::new(&m, Long::Strided, 17).unwrap();
    whole.push(&rate).unwrap();
    let expected = whole.snapshot().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of("later stages"));
    let got = merged(&rate, &m, Long::Strided, 17, &[5_300_001], &mut rng);
    same(&got.snapshot().unwrap(), &expected, 1e-12);
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let rate = record("refused", 1000);
    let make = |m: &[usize], long, start| {
        let mut stream = Accumulator::new(m, long, start).unwrap();
        stream.push(&rate).unwrap();
        stream
    };
    let mut stream = make(&[1, 10], Long::Strided, 0);
    let before = stream.snapshot().unwrap();
    for later in [
        make(&[1, 10], Long::Strided, 0),
        make(&[1, 10], Long::Strided, 1001),
        make(&[1, 11], Long::Strided, 1000),
        make(&[1, 10, 1 << 20], Long::Strided, 1000),
        make(&[1, 10], Long::Exact, 1000),
    ] {
        assert!(matches!(stream.merge(&later), Err(Error::Parameter { .. })));
    }
    for (index, bad) in [(0, f64::NAN), (5, f64::INFINITY), (9, 1e131)] {
        let mut chunk = rate[..10].to_vec();
        chunk[index] = bad;
        assert_eq!(stream.push(&chunk), Err(Error::NonFinite { index }));
    }
    assert_eq!(stream.snapshot().unwrap(), before);
    for m in [0, LARGEST + 1] {
        let expected = Error::ClusterSize { m, largest: usize::MAX };
        assert_eq!(Accumulator::new(&[m], Long::Strided, 0).err(), Some(expected));
    }
    assert!(Accumulator::new(&[LARGEST + 1], Long::Exact, 0).is_ok());
}

#[test]
fn a_short_stream_shows_what_it_has() {
    for long in [Long::Strided, Long::Exact] {
        let mut stream = Accumulator::new(&octaves(1 << 30), long, 0).unwrap();
        assert_eq!(stream.snapshot().unwrap(), []);
        stream.push(&[1.0]).unwrap();
        assert_eq!(stream.snapshot().unwrap(), []);
        stream.push(&[3.0]).unwrap();
        let snapshot = stream.snapshot().unwrap();
        assert_eq!(snapshot.len(), 1);
        assert_eq!((snapshot[0].estimate.avar, snapshot[0].estimate.ramp), (2.0, 2.0));
    }
}

#[test]
fn the_largest_samples_do_not_overflow_in_groups() {
    let rate: Vec<f64> = (0..300_000).map(|k| if k / 7000 % 2 == 0 { 1e130 } else { -1e130 }).collect();
    let mut stream = Accumulator::new(&octaves(150_000), Long::Strided, 0).unwrap();
    stream.push(&rate).unwrap();
    assert!(stream.snapshot().unwrap().iter().all(|s| s.estimate.avar.is_finite()));
}

/// Loss of precision by strides, from the spread of their difference to full overlap: negligible for white noise and slower
/// noise.
#[test]
fn strides_lose_little_of_white_noise_and_a_random_walk() {
    let n = 1 << 17;
    let m = 1 << 13; // The smallest size with a stride has 128 starts per cluster.
    let cases: [(&str, &[(Term, f64)]); 2] =
        [("stride white", &[(Term::RandomWalk, 1.0)]), ("stride walk", &[(Term::RateRandomWalk, 1.0)])];
    for (name, noise) in cases {
        let (mut own, mut lost) = (0.0, 0.0);
        let records = 40;
        for stream in 0..records {
            let rate = simulate(n, 1.0, noise, seed_of(name), stream).unwrap();
            let mut accumulator = Accumulator::new(&[m], Long::Strided, 0).unwrap();
            accumulator.push(&rate).unwrap();
            let strided = accumulator.snapshot().unwrap()[0].estimate.avar;
            let phase = Phase::from_rate(&rate).unwrap();
            let full = allan_variance(&phase, &[m], Overlap::Full, Counting::Standard).unwrap()[0].avar;
            own += (full.ln()).powi(2);
            lost += (strided.ln() - full.ln()).powi(2);
        }
        // The estimator spreads by tens of percent, its difference to the strided one by less than one percent.
        let lost = (lost / f64::from(records as u32)).sqrt();
        assert!(lost < 0.01, "{name}: {lost}, of {}", (own / f64::from(records as u32)).sqrt());
    }
}
