//! Simulated records against their expected Allan variance.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use rayon::prelude::*;
use sigmatau_core::allan::{Counting, Overlap, allan_variance};
use sigmatau_core::error::Error;
use sigmatau_core::generate::{Component, Generator, simulate};
use sigmatau_core::phase::Phase;
use sigmatau_core::terms::{self, Term};

/// Terms and their coefficients.
type Noise = &'static [(Term, f64)];

/// FNV-1a: a seed from the name of the case.
fn seed_of(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

const TAU0: f64 = 0.01;
const SAMPLES: usize = 3000;
const RECORDS: u64 = 400;
/// A normal deviate exceeds it once in 16 000 cases; there are 66 here, strongly correlated along τ.
const STANDARD_ERRORS: f64 = 4.0;

/// The mean over many records must agree with `expected` within its own scatter, at every octave.
fn assert_expected_avar(name: &str, c: Noise, expected: impl Fn(usize) -> f64) {
    let octaves: Vec<usize> = (0..11).map(|i| 1 << i).collect();
    let records: Vec<Vec<f64>> = (0..RECORDS)
        .into_par_iter()
        .map(|stream| {
            let rate = simulate(SAMPLES, TAU0, c, seed_of(name), stream).unwrap();
            let phase = Phase::from_rate(&rate).unwrap();
            let estimates = allan_variance(&phase, &octaves, Overlap::Full, Counting::Standard).unwrap();
            estimates.iter().map(|estimate| estimate.avar).collect()
        })
        .collect();
    for (i, &m) in octaves.iter().enumerate() {
        let n = RECORDS as f64;
        let mean = records.iter().map(|record| record[i]).sum::<f64>() / n;
        let variance = records.iter().map(|record| (record[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let standard_error = (variance / n).sqrt();
        let deviation = (mean - expected(m)) / standard_error;
        assert!(deviation.abs() <= STANDARD_ERRORS, "{name}, m = {m}: {deviation:.1} standard errors");
    }
}

fn tau(m: usize) -> f64 {
    m as f64 * TAU0
}

#[test]
fn quantization() {
    let c = &[(Term::Quantization, 2e-3)];
    assert_expected_avar("quantization", c, |m| terms::quantization_avar(2e-3, tau(m)));
}

#[test]
fn random_walk() {
    let c = &[(Term::RandomWalk, 0.03)];
    assert_expected_avar("random_walk", c, |m| terms::random_walk_avar(0.03, tau(m)));
}

#[test]
fn bias_instability() {
    let c = &[(Term::BiasInstability, 0.7)];
    assert_expected_avar("bias_instability", c, |m| terms::bias_instability_avar(0.7, m));
}

#[test]
fn rate_random_walk() {
    let c = &[(Term::RateRandomWalk, 0.1)];
    assert_expected_avar("rate_random_walk", c, |m| terms::rate_random_walk_avar_sampled(0.1, TAU0, m));
}

#[test]
fn all_terms_together() {
    let c = &[
        (Term::RateRamp, -1e-3),
        (Term::Quantization, 2e-4),
        (Term::RandomWalk, 0.005),
        (Term::BiasInstability, 0.01),
        (Term::RateRandomWalk, 0.003),
    ];
    assert_expected_avar("mixture", c, |m| c.iter().map(|(term, value)| term.avar(*value, TAU0, m)).sum());
}

#[test]
fn ramp_is_not_random() {
    let c = &[(Term::RateRamp, -2.0)];
    assert_eq!(simulate(4, 0.5, c, 1, 0).unwrap(), [0.0, -1.0, -2.0, -3.0]);
}

#[test]
fn a_record_is_the_sum_of_its_terms() {
    let [q, n, b, k] = [
        &[(Term::Quantization, 1e-3)],
        &[(Term::RandomWalk, 0.02)],
        &[(Term::BiasInstability, 0.3)],
        &[(Term::RateRandomWalk, 0.4)],
    ];
    let all = &[
        (Term::Quantization, 1e-3),
        (Term::RandomWalk, 0.02),
        (Term::BiasInstability, 0.3),
        (Term::RateRandomWalk, 0.4),
    ];
    let run = |c: Noise| simulate(1000, TAU0, c, seed_of("sum"), 7).unwrap();
    let (together, alone) = (run(all), [q, n, b, k].map(|c| run(c)));
    for (i, y) in together.iter().enumerate() {
        let sum: f64 = alone.iter().map(|record| record[i]).sum();
        // The limit is a few rounding errors of the terms.
        assert!((y - sum).abs() <= 1e-14, "sample {i}");
    }
}

#[test]
fn seed_and_stream_name_a_record() {
    let c = &[(Term::RandomWalk, 1.0), (Term::BiasInstability, 1.0)];
    let run = |seed, stream| simulate(100, 1.0, c, seed, stream).unwrap();
    assert_eq!(run(1, 2), run(1, 2));
    assert_ne!(run(1, 2), run(1, 3));
    assert_ne!(run(1, 2), run(2, 2));
    assert_ne!(run(1, 2), run(2, 1));
}

#[test]
fn a_longer_record_begins_like_a_shorter_one_where_it_can() {
    let c = &[
        (Term::RateRamp, 1.0),
        (Term::Quantization, 1.0),
        (Term::RandomWalk, 1.0),
        (Term::RateRandomWalk, 1.0),
    ];
    let long = simulate(100, 1.0, c, 5, 0).unwrap();
    assert_eq!(simulate(40, 1.0, c, 5, 0).unwrap(), long[..40]);
}

/// Flicker noise, exact and as a sum of poles.
const EXACT: Component = Component::Term(Term::BiasInstability, 0.3);
const POLES: Component = Component::PoleBank(0.3);

/// All kinds of noise, on one channel.
fn everything(n: usize, flicker: &Component) -> Generator {
    let mut generator = Generator::new(n, TAU0, seed_of("everything")).unwrap();
    let filter = Component::Filtered {
        scale: 0.5,
        transition: vec![0.9, 0.1, -0.1, 0.8],
        noise: vec![0.3, 0.0, 0.1, 0.2],
        start: vec![1.0, 0.0, 0.0, 1.0],
    };
    let terms = [
        Component::Term(Term::RateRamp, -0.1),
        Component::Term(Term::Quantization, 1e-3),
        Component::Term(Term::RandomWalk, 0.02),
        flicker.clone(),
        Component::Term(Term::RateRandomWalk, 0.4),
        filter,
        Component::GaussMarkov { sigma: 0.1, time: 0.3, index: 0 },
        Component::Sinusoid { amplitude: 0.1, frequency: 3.7, index: 0 },
    ];
    for term in &terms {
        generator.add(term, 3).unwrap();
    }
    generator
}

#[test]
fn buffers_of_any_size_hold_the_same_samples() {
    for flicker in [&EXACT, &POLES] {
        let mut whole = vec![0.0; 5000];
        everything(5000, flicker).fill(&mut whole).unwrap();
        for size in [1, 7, 1024, 1025] {
            let mut generator = everything(5000, flicker);
            let mut pieces = vec![0.0; 5000];
            for piece in pieces.chunks_mut(size) {
                generator.fill(piece).unwrap();
            }
            assert_eq!(pieces, whole, "{flicker:?}, buffers of {size}");
            assert_eq!(generator.left(), 0);
        }
    }
}

#[test]
fn no_more_samples_than_were_asked_for() {
    let mut generator = everything(10, &POLES);
    generator.fill(&mut [0.0; 8]).unwrap();
    assert_eq!(generator.fill(&mut [0.0; 3]), Err(Error::Length { expected: 2, got: 3 }));
}

#[test]
fn wrong_terms_are_refused() {
    let add = |term: Component| Generator::new(10, TAU0, 1).unwrap().add(&term, 0).unwrap_err();
    let infinite = f64::INFINITY;
    assert_eq!(
        add(Component::Term(Term::RandomWalk, infinite)),
        Error::Parameter { name: "random_walk", value: infinite }
    );
    let process = Component::GaussMarkov { sigma: 1.0, time: 0.0, index: 0 };
    assert_eq!(add(process), Error::Parameter { name: "time", value: 0.0 });
    let line = Component::Sinusoid { amplitude: 1.0, frequency: -1.0, index: 0 };
    assert_eq!(add(line), Error::Parameter { name: "frequency", value: -1.0 });
    let filter =
        |start| Component::Filtered { scale: 1.0, transition: vec![0.5; 4], noise: vec![0.5; 4], start };
    assert_eq!(add(filter(vec![1.0; 3])), Error::Length { expected: 4, got: 3 });
}

#[test]
fn shortest_records() {
    let c = &[
        (Term::RateRamp, 1.0),
        (Term::Quantization, 1.0),
        (Term::RandomWalk, 1.0),
        (Term::BiasInstability, 1.0),
        (Term::RateRandomWalk, 1.0),
    ];
    for n in 0..4 {
        let rate = simulate(n, 1.0, c, 1, 0).unwrap();
        assert_eq!(rate.len(), n);
        assert!(rate.iter().all(|y| y.is_finite()));
    }
    assert_eq!(simulate(3, 1.0, &[], 1, 0).unwrap(), [0.0; 3]);
}

#[test]
fn bad_parameters_are_named() {
    let error = |tau0, c: Noise| simulate(10, tau0, c, 1, 0).unwrap_err();
    assert_eq!(error(0.0, &[]), Error::Parameter { name: "tau0", value: 0.0 });
    assert_eq!(error(f64::INFINITY, &[]), Error::Parameter { name: "tau0", value: f64::INFINITY });
    let negative = &[(Term::BiasInstability, -1.0)];
    assert_eq!(error(1.0, negative), Error::Parameter { name: "bias_instability", value: -1.0 });
    let infinite = &[(Term::RateRamp, f64::INFINITY)];
    assert_eq!(error(1.0, infinite), Error::Parameter { name: "rate_ramp", value: f64::INFINITY });
    let nan = &[(Term::RandomWalk, f64::NAN)];
    assert!(matches!(error(1.0, nan), Error::Parameter { name: "random_walk", .. }));
    assert_eq!(error(-1.0, &[]).to_string(), "tau0 = -1 is out of range");
}
