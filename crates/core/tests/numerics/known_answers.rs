//! Published and independently computed values, to the printed digits.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.
#![allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as printed or computed.

use sigmatau_core::allan::{Counting, Estimate, Overlap, allan_variance};
use sigmatau_core::bandlimited::{Filter, band_limited_avar};
use sigmatau_core::phase::Phase;
use sigmatau_core::terms::{
    bias_instability_avar, bias_instability_avar_cutoff, gauss_markov_avar_averaged,
    gauss_markov_avar_sampled, quantization_avar, random_walk_avar, rate_ramp_avar,
    rate_random_walk_avar_averaged, rate_random_walk_avar_sampled, sinusoid_avar,
};
use std::f64::consts::PI;

/// The 1000-point set of NIST SP 1065 (W. J. Riley, *Handbook of Frequency Stability Analysis*, 2008), section 12.4.
fn nbs14() -> Vec<f64> {
    const MODULUS: u64 = 2147483647;
    std::iter::successors(Some(1234567890), |n| Some(16807 * n % MODULUS))
        .take(1000)
        .map(|n| n as f64 / MODULUS as f64)
        .collect()
}

fn adev(rate: &[f64], m: &[usize], overlap: Overlap) -> Vec<f64> {
    let phase = Phase::from_rate(rate).unwrap();
    let estimates = allan_variance(&phase, m, overlap, Counting::Standard).unwrap();
    estimates.into_iter().map(|Estimate { avar, .. }| avar.sqrt()).collect()
}

fn assert_all_close(got: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= relative * expected.abs(), "{got} instead of {expected}");
    }
}

const FACTORS: [usize; 8] = [1, 2, 5, 10, 50, 100, 333, 499];

#[test]
fn nbs14_overlapping() {
    // NIST SP 1065, table 31: 2.922319e-01, 9.159953e-02 and 3.241343e-02 at factors 1, 10 and 100. The other factors,
    // and the digits beyond, were computed with 40 digits.
    let printed = [2.922319e-1, 9.159953e-2, 3.241343e-2];
    let half_a_digit = 5.5e-7;
    assert_all_close(&adev(&nbs14(), &[1, 10, 100], Overlap::Full), &printed, half_a_digit);
    let computed = [
        0.29223187810675916,
        0.2010160421709385,
        0.13318637457744736,
        0.09159953420118654,
        0.039501786819481584,
        0.03241343026056983,
        0.008244123626136668,
        0.0028325053644187104,
    ];
    assert_all_close(&adev(&nbs14(), &FACTORS, Overlap::Full), &computed, 2e-14);
}

#[test]
fn nbs14_not_overlapping() {
    // NIST SP 1065, table 31: 2.922319e-01, 9.965736e-02 and 3.897804e-02 at factors 1, 10 and 100.
    let printed = [2.922319e-1, 9.965736e-2, 3.897804e-2];
    let half_a_digit = 5.5e-7;
    assert_all_close(&adev(&nbs14(), &[1, 10, 100], Overlap::None), &printed, half_a_digit);
    let computed = [
        0.29223187810675916,
        0.2051016155948553,
        0.1359566229954979,
        0.09965736063174786,
        0.043270981191617854,
        0.038978043308026525,
        0.00271619077347962,
        0.002624044593093992,
    ];
    assert_all_close(&adev(&nbs14(), &FACTORS, Overlap::None), &computed, 2e-14);
}

#[test]
fn nine_points() {
    // NIST SP 1065, table 30 and its text.
    let rate = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
    assert_all_close(&adev(&rate, &[1, 2], Overlap::None), &[91.22945, 115.808211], 1e-8);
    assert_all_close(&adev(&rate, &[2], Overlap::Full), &[85.95287], 1e-7);
}

#[test]
fn counting_of_the_paper_leaves_the_last_term_out() {
    let phase = Phase::from_rate(&nbs14()).unwrap();
    let paper = allan_variance(&phase, &[10], Overlap::Full, Counting::Paper).unwrap()[0];
    assert_eq!(paper.pairs, 1000 - 20);
    assert_all_close(&[paper.avar.sqrt()], &[9.161625e-2], 1e-7);
}

const SIZES: [usize; 5] = [1, 2, 7, 100, 10000];
const TAU0: f64 = 0.01;

fn assert_term(avar: impl Fn(usize) -> f64, expected: [f64; 5]) {
    // Exact, or computed with 40 digits or more, up to a few rounding errors.
    assert_all_close(&SIZES.map(avar), &expected, 2e-15);
}

fn tau(m: usize) -> f64 {
    m as f64 * TAU0
}

#[test]
fn closed_forms() {
    assert_term(|m| quantization_avar(1e-3, tau(m)), [0.03, 0.0075, 0.0006122448979591836, 3e-6, 3e-10]);
    assert_term(
        |m| random_walk_avar(0.005, tau(m)),
        [0.0025, 0.00125, 0.00035714285714285714, 2.5e-5, 2.5e-7],
    );
    let flicker = [
        4.99109901536183773e-6,
        3.99287921228947018e-6,
        3.52666910321025907e-6,
        3.46014370924900637e-6,
        3.45956631123999289e-6,
    ];
    assert_term(|m| bias_instability_avar(0.0028, m), flicker);
    let walk = [5e-11, 7.5e-11, 2.3571428571428573e-10, 3.3335e-9, 3.33333335e-7];
    assert_term(|m| rate_random_walk_avar_sampled(1e-4, TAU0, m), walk);
    let walk = [
        3.3333333333333335e-11,
        6.666666666666667e-11,
        2.3333333333333335e-10,
        3.3333333333333334e-9,
        3.333333333333334e-7,
    ];
    assert_term(|m| rate_random_walk_avar_averaged(1e-4, tau(m)), walk);
    assert_term(|m| rate_ramp_avar(1e-6, tau(m)), [5e-17, 2e-16, 2.4500000000000004e-15, 5e-13, 5e-9]);
}

#[test]
fn gauss_markov_and_sinusoid() {
    let sampled = [
        9.9950016662500833e-10,
        1.4980017488339705e-9,
        4.6898651595073285e-9,
        6.1895234761206997e-8,
        1.700018351430939e-7,
    ];
    assert_term(|m| gauss_markov_avar_sampled(1e-3, 10.0, TAU0, m), sampled);
    let averaged = [
        6.6616689991669126e-10,
        1.3313351986674536e-9,
        4.6422465003294381e-9,
        6.1891906585643399e-8,
        1.7000181597657896e-7,
    ];
    assert_term(|m| gauss_markov_avar_averaged(1e-3, 10.0, tau(m)), averaged);
    let sinusoid = [1.351087990165597e-10, 5.402891708309786e-10, 6.591762353864713e-9, 5.250766368933746e-7];
    let got = SIZES.map(|m| sinusoid_avar(1e-3, 0.37, TAU0, m));
    assert_all_close(&got[..4], &sinusoid, 1e-14);
    // The averaging time is 37 whole periods.
    assert!(got[4] < 1e-30);
}

#[test]
fn flicker_with_a_cut_off() {
    // Eq. (19) of the paper for B = 1, by f₀T; computed with 60 digits.
    let expected = [
        (0.01, 0.00031405593150197424),
        (0.1, 0.030402516214497007),
        (0.5, 0.37352607531571646),
        (1.0, 0.43080261037169963),
        (2.0, 0.43837579876084764),
        (5.0, 0.44079102844775996),
        (20.0, 0.44124097883301578),
    ];
    for (f0, expected) in expected {
        assert_all_close(&[bias_instability_avar_cutoff(1.0, f0, 1.0)], &[expected], 2e-15);
    }
}

#[test]
fn filters() {
    let rounding = 6e-10;
    let first_order = [0.002120410495, 0.001313891963, 0.0004527064906, 3.379255146e-5, 3.394926653e-7];
    // σ = 0.05 after one pole at 30 Hz: N² = 2σ² / ω_c.
    let n = 0.05 * (2.0 / (2.0 * PI * 30.0)).sqrt();
    assert_all_close(
        &band_limited_avar(n, Filter::Butterworth(1), 30.0, TAU0, &SIZES),
        &first_order,
        rounding,
    );
    let butterworth = [0.001135520778, 0.001001415634, 0.0003444209893, 2.534229398e-5, 2.54341456e-7];
    assert_all_close(
        &band_limited_avar(0.005, Filter::Butterworth(2), 30.0, TAU0, &SIZES),
        &butterworth,
        rounding,
    );
    let brick_wall = [0.0007431732714, 0.001095121563, 0.000338100862, 2.491328365e-5, 2.499913275e-7];
    assert_all_close(&band_limited_avar(0.005, Filter::BrickWall, 30.0, TAU0, &SIZES), &brick_wall, rounding);
}

#[test]
fn mixture() {
    // Q = 1.63, N = 1, B = 0.188, K = 0.0125 at τ₀ = 1; computed with 40 digits.
    let avar = |m: usize| {
        let tau = m as f64;
        quantization_avar(1.63, tau)
            + random_walk_avar(1.0, tau)
            + bias_instability_avar(0.188, m)
            + rate_random_walk_avar_sampled(0.0125, 1.0, m)
    };
    let expected = [8.993278814234559, 0.19598996628862178, 0.03160455651271644];
    assert_all_close(&[1, 10, 100].map(avar), &expected, 2e-15);
}
