//! Closed forms of the Allan variance against the integrals of the spectral densities: eq. (11) of the paper, and the
//! integral for samples.

use sigmatau_core::bandlimited::{Filter, band_limited_avar, band_limited_sigma};
use sigmatau_core::{psd, terms};
use std::f64::consts::PI;

/// Nodes and weights of Gauss–Legendre quadrature with eight points on −1 … 1 (Abramowitz & Stegun, table 25.4).
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

fn panel(g: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    half * NODES.iter().map(|&(x, w)| w * (g(middle - half * x) + g(middle + half * x))).sum::<f64>()
}

/// ∫ g over 0 … `end`, in panels of an eighth of the period of sin πfT, which are smaller near 0.
fn integral(g: impl Fn(f64) -> f64, tau: f64, end: f64) -> f64 {
    let width = (0.25 / tau).min(end);
    let near: f64 = (0..40).map(|i| panel(&g, width * 0.5f64.powi(i + 1), width * 0.5f64.powi(i))).sum();
    let count = ((end - width) / width).ceil();
    let step = if count > 0.0 { (end - width) / count } else { 0.0 };
    near + (0..count as usize)
        .map(|i| panel(&g, width + step * i as f64, width + step * (i + 1) as f64))
        .sum::<f64>()
}

/// Eq. (11) of the paper up to `end`, an integer multiple of 1 / T.
fn continuous(density: impl Fn(f64) -> f64, tau: f64, end: f64) -> f64 {
    4.0 * integral(|f| density(f) * (PI * f * tau).sin().powi(4) / (PI * f * tau).powi(2), tau, end)
}

/// The integral for samples, with the transfer function of clusters of `m` samples, up to half the sample rate.
fn sampled(density: impl Fn(f64) -> f64, tau0: f64, m: usize) -> f64 {
    let tau = m as f64 * tau0;
    let transfer = |f: f64| (PI * f * tau).sin().powi(4) / (m as f64 * (PI * f * tau0).sin()).powi(2);
    4.0 * integral(|f| density(f) * transfer(f), tau, 0.5 / tau0)
}

fn assert_relative(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got / expected - 1.0).abs() <= tolerance, "{what}: {got} instead of {expected}");
}

const TAU0: f64 = 0.01;
const SIZES: [usize; 5] = [1, 2, 7, 50, 200];

#[test]
fn continuous_forms() {
    for tau in [0.02, 1.0, 30.0] {
        // With 3/8, the mean of sin⁴, the tail above 5000 / T is 1.5 S / (π² T² f) for a flat density, 8e-5 of the total;
        // it is negligible for steeper densities. The error of using the mean is of the order of its square.
        let end = 5000.0 / tau;
        let tail = |f: f64, slope: f64| 1.5 / ((PI * tau).powi(2) * f * (1.0 + slope));
        let white = continuous(|_| psd::random_walk(0.3), tau, end) + 0.09 * tail(end, 0.0);
        assert_relative(white, terms::random_walk_avar(0.3, tau), 1e-8, "random walk");

        let flicker = continuous(|f| psd::bias_instability(0.3, None, f), tau, end);
        let flicker = flicker + psd::bias_instability(0.3, None, end) * tail(end, 1.0);
        assert_relative(
            flicker,
            terms::bias_instability_avar_cutoff(0.3, f64::INFINITY, tau),
            1e-9,
            "flicker",
        );

        let walk = continuous(|f| psd::rate_random_walk(0.3, f), tau, end);
        assert_relative(walk, terms::rate_random_walk_avar_averaged(0.3, tau), 1e-9, "rate random walk");

        let markov = continuous(|f| psd::gauss_markov(0.3, 2.0, f), tau, end);
        let markov = markov + psd::gauss_markov(0.3, 2.0, end) * tail(end, 2.0);
        assert_relative(markov, terms::gauss_markov_avar_averaged(0.3, 2.0, tau), 1e-8, "Gauss–Markov");
    }
}

#[test]
fn flicker_that_ends_at_a_cut_off() {
    for (f0, tau) in [(0.01, 1.0), (0.3, 1.0), (1.7, 2.0), (30.0, 1.0)] {
        let got = continuous(|f| psd::bias_instability(0.7, Some(f0), f), tau, f0);
        assert_relative(got, terms::bias_instability_avar_cutoff(0.7, f0, tau), 1e-11, "eq. (19)");
    }
}

#[test]
fn sampled_forms() {
    for m in SIZES {
        let tau = m as f64 * TAU0;
        let close = |got, expected, what| assert_relative(got, expected, 1e-11, &format!("{what}, m = {m}"));
        let got = sampled(|f| psd::quantization_sampled(0.3, TAU0, f), TAU0, m);
        close(got, terms::quantization_avar(0.3, tau), "quantization");
        close(sampled(|_| psd::random_walk(0.3), TAU0, m), terms::random_walk_avar(0.3, tau), "random walk");
        let got = sampled(|f| psd::bias_instability_sampled(0.3, TAU0, f), TAU0, m);
        close(got, terms::bias_instability_avar(0.3, m), "bias instability");
        let got = sampled(|f| psd::rate_random_walk_sampled(0.3, TAU0, f), TAU0, m);
        close(got, terms::rate_random_walk_avar_sampled(0.3, TAU0, m), "rate random walk");
        let got = sampled(|f| psd::gauss_markov_sampled(0.3, 0.2, TAU0, f), TAU0, m);
        close(got, terms::gauss_markov_avar_sampled(0.3, 0.2, TAU0, m), "Gauss–Markov");
        let got = sampled(|f| psd::gauss_markov_sampled(0.3, 50.0, TAU0, f), TAU0, m);
        // The density changes within 1 / (2π T_c) of f = 0, where the panels are small.
        close(got, terms::gauss_markov_avar_sampled(0.3, 50.0, TAU0, m), "slow Gauss–Markov");
    }
}

#[test]
fn quantization_of_the_paper() {
    // Eq. (15) follows from the right-hand side of eq. (14) where the sum is over whole samples, f ≤ 1 / (2τ₀): there
    // (2πf)² τ₀Q² in eq. (11) gives 4 · 4τ₀Q² / T² ∫ sin⁴(πfT) df = 3Q² / T².
    for m in SIZES {
        let tau = m as f64 * TAU0;
        let got = continuous(|f| psd::quantization(0.3, TAU0, f), tau, 0.5 / TAU0);
        assert_relative(got, terms::quantization_avar(0.3, tau), 1e-11, "eq. (15)");
    }
}

#[test]
fn densities_of_samples_tend_to_the_continuous_ones() {
    // To second order in f τ₀.
    let (f, tolerance) = (1e-4 / TAU0, 1e-6);
    let close = |a, b, what| assert_relative(a, b, tolerance, what);
    close(psd::quantization_sampled(0.3, TAU0, f), psd::quantization(0.3, TAU0, f), "quantization");
    close(
        psd::bias_instability_sampled(0.3, TAU0, f),
        psd::bias_instability(0.3, None, f),
        "bias instability",
    );
    close(psd::rate_random_walk_sampled(0.3, TAU0, f), psd::rate_random_walk(0.3, f), "rate random walk");
    close(psd::gauss_markov_sampled(0.3, 20.0, TAU0, f), psd::gauss_markov(0.3, 20.0, f), "Gauss–Markov");
    // R² / (2πf)³ at 2πf = 1.
    close(psd::rate_ramp(0.3, -0.5 / PI), 0.09, "rate ramp");
}

#[test]
fn folded_butterworth_noise_is_the_sum_of_its_images() {
    for order in 2..=6 {
        for corner in [3.0, 30.0, 70.0] {
            for f in [0.01, 7.0, 33.3, 50.0] {
                let filter = Filter::Butterworth(order);
                let images: f64 = (-3000..=3000)
                    .map(|i| psd::band_limited(0.3, filter, corner, f + f64::from(i) / TAU0))
                    .sum();
                let got = psd::band_limited_sampled(0.3, order, corner, TAU0, f);
                // Far above the corner, the density is a small difference of large contributions of the poles.
                let rounding = 1e-9 * images + 1e-15 * 0.09;
                assert!(
                    (got - images).abs() < rounding,
                    "order {order}, {corner} Hz at {f} Hz: {got}, not {images}"
                );
            }
        }
    }
    // The RC filter's images, x coth x at f = 0.
    let x = PI * 30.0 * TAU0;
    assert_relative(psd::band_limited_sampled(0.3, 1, 30.0, TAU0, 0.0), 0.09 * x / x.tanh(), 1e-14, "RC");
    // With a corner far above the sampling rate, the density is white and contains all images of the pass band.
    let white = psd::band_limited_sampled(0.3, 2, 1e5, TAU0, 20.0);
    assert_relative(
        white,
        band_limited_sigma(0.3, Filter::Butterworth(2), 1e5).powi(2) * TAU0,
        1e-12,
        "white",
    );
}

#[test]
fn filters_fold_their_density() {
    // The folded density follows from eq. (11) with the transfer function of the samples at all frequencies.
    for (filter, folds, tolerance) in [
        (Filter::Butterworth(1), 20_000, 1e-4), // the tail falls as 1 / f²: 2 / π² · f_c / (folds · f_s) is missing
        (Filter::Butterworth(2), 300, 1e-9),
        (Filter::Butterworth(5), 20, 1e-9),
        (Filter::BrickWall, 1, 1e-3), // a jump inside a panel
    ] {
        for m in [1, 2, 7, 50] {
            let tau = m as f64 * TAU0;
            let folded = |f: f64| {
                let one_side: f64 = (0..=folds)
                    .map(|i| {
                        let shift = f64::from(i) / TAU0;
                        let above = psd::band_limited(0.3, filter, 30.0, shift + f);
                        if i == 0 { above } else { above + psd::band_limited(0.3, filter, 30.0, shift - f) }
                    })
                    .sum();
                one_side
            };
            // Coarse enough to be quick with thousands of folds.
            let count = 8 * m;
            let width = 0.5 / TAU0 / count as f64;
            let transfer = |f: f64| (PI * f * tau).sin().powi(4) / (m as f64 * (PI * f * TAU0).sin()).powi(2);
            let got: f64 = (0..count)
                .map(|i| panel(&|f| 4.0 * folded(f) * transfer(f), width * i as f64, width * (i + 1) as f64))
                .sum();
            let expected = band_limited_avar(0.3, filter, 30.0, TAU0, &[m])[0];
            let jump = if filter == Filter::BrickWall { 0.1 / m as f64 } else { 0.0 };
            assert_relative(got, expected, tolerance + jump, &format!("{filter:?}, m = {m}"));
        }
    }
}
