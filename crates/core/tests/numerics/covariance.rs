//! The covariance of Allan variances against known answers and simulated records.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::allan::{Counting, Overlap, allan_variance};
use sigmatau_core::covariance::{Component, Gamma};
use sigmatau_core::error::Error;
use sigmatau_core::generate::{Component as Source, Generator, simulate};
use sigmatau_core::phase::Phase;
use sigmatau_core::terms::Term;
use sigmatau_core::terms::{
    bias_instability_avar, gauss_markov_avar_sampled, quantization_avar, random_walk_avar, rate_ramp_avar,
    rate_random_walk_avar_sampled,
};
use std::f64::consts::PI;

/// Sizes in half octaves up to N / `part`.
fn half_octaves(n: usize, part: usize) -> Vec<usize> {
    let mut sizes: Vec<usize> = (0..64)
        .map(|k| 2f64.powf(0.5 * f64::from(k)).floor() as usize)
        .take_while(|&m| m <= n / part)
        .collect();
    sizes.dedup();
    sizes
}

/// The tolerance is relative, unless `expected` is 0.
fn assert_close(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got - expected).abs() <= tolerance * expected.abs(), "{what}: {got} instead of {expected}");
}

// Equivalent degrees of freedom of 1000 samples, from sums with 40 digits.
const EDF_SIZES: [usize; 6] = [1, 2, 10, 100, 333, 499];
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
const EDF: [[f64; 6]; 4] = [
    [514.0360545969611, 513.2723830287731, 507.1731225296443, 440.2065180102916, 333.231606730452, 3.0],
    [
        666.2222963951936,
        570.2045030833214,
        146.0723257314158,
        12.813267782600164,
        2.6772507268484245,
        1.0053605555705096,
    ],
    [
        809.9231886971629,
        591.5347484880655,
        116.39222419688984,
        9.925601492610287,
        1.8324758496335547,
        1.0000843437495888,
    ],
    [999.0, 513.0074834418098, 91.75477375281, 7.757153217468789, 1.4069539594532092, 1.0000160481766733],
];

#[test]
fn degrees_of_freedom_known_answers() {
    for (component, expected) in Term::NOISE.into_iter().zip(EDF) {
        let edf = Gamma::new(1000, &EDF_SIZES, &[component]).unwrap().edf(&[0.7], 0.0);
        for (got, expected) in edf.into_iter().zip(expected) {
            assert_close(got, expected, 1e-12, &format!("{component:?}"));
        }
    }
}

#[test]
fn degrees_of_freedom_of_quantization_have_a_closed_form() {
    let n_samples = 5000;
    let sizes = half_octaves(n_samples, 2);
    let edf = Gamma::new(n_samples, &sizes, &[Term::Quantization]).unwrap().edf(&[2.0], 0.0);
    for (got, n) in edf.into_iter().zip(sizes) {
        let pairs = |lag: usize| (n_samples + 1).saturating_sub(2 * n + lag) as f64;
        let expected = 36.0 * pairs(0).powi(2) / (36.0 * pairs(0) + 32.0 * pairs(n) + 2.0 * pairs(2 * n));
        assert_close(got, expected, 1e-14, &format!("n {n}"));
    }
}

// Q = 1.63, N = 1, B = 0.188, K = 0.0125, 1000 samples at τ₀ = 1, n = 1, 10, 100: sums with 40 digits.
const MIXTURE: [f64; 4] = [1.63, 1.0, 0.188, 0.0125];
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
const MIXTURE_AVAR: [f64; 3] = [8.993278814234559, 0.19598996628862178, 0.03160455651271644];
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
const MIXTURE_COVARIANCE: [[f64; 3]; 3] = [
    [0.30450618033361493, 0.0016306529023233335, 1.6340276333352965e-05],
    [0.0016306529023233335, 0.0002727642295393753, 6.810532983437638e-06],
    [1.6340276333352965e-05, 6.810532983437638e-06, 0.0001667685702885789],
];

#[test]
fn mixture_known_answers_whatever_the_interval_and_the_order() {
    for tau0 in [1.0, 0.01, 3.7] {
        let gamma = Gamma::new(1000, &[1, 10, 100], &Term::NOISE).unwrap().at_interval(tau0).unwrap();
        // The same rates, in the units of another sample interval.
        let theta: Vec<f64> =
            MIXTURE.iter().zip([1, 0, -1, -2]).map(|(c, e)| c * c * tau0.powi(e + 1)).collect();
        for (got, expected) in gamma.expectation(&theta, 0.0).into_iter().zip(MIXTURE_AVAR) {
            assert_close(got, expected, 1e-13, "avar");
        }
        for (got, &expected) in
            gamma.covariance(&theta, 0.0).into_iter().zip(MIXTURE_COVARIANCE.as_flattened())
        {
            assert_close(got, expected, 1e-13, "covariance");
        }
    }
    let backwards: Vec<Term> = Term::NOISE.into_iter().rev().collect();
    let gamma = Gamma::new(1000, &[100, 1, 10], &backwards).unwrap();
    let theta: Vec<f64> = MIXTURE.iter().rev().map(|c| c * c).collect();
    let covariance = gamma.covariance(&theta, 0.0);
    assert_close(covariance[0], MIXTURE_COVARIANCE[2][2], 1e-13, "100");
    assert_close(covariance[5], MIXTURE_COVARIANCE[0][1], 1e-13, "1, 10");
}

#[test]
fn parts_add_up_in_any_units() {
    let mut components = Term::NOISE.map(Component::Term).to_vec();
    components.push(Component::GaussMarkov { tc: 12.0 });
    let gamma = Gamma::new(700, &[1, 3, 50, 200], &components).unwrap().at_interval(0.02).unwrap();
    let (theta, ramp): ([f64; 5], f64) = ([1e-4, 2.0, 0.3, 0.1, 0.7], -0.3);
    let mut sum = [0.0; 16];
    for p in 0..gamma.terms() {
        let parts = (0..gamma.terms()).map(|q| (theta[p] * theta[q], gamma.noise_part(p, q)));
        for (factor, part) in parts.chain([(theta[p] * ramp * ramp, gamma.ramp_part(p))]) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += factor * part);
        }
    }
    for (got, expected) in gamma.covariance(&theta, ramp).into_iter().zip(sum) {
        assert_close(got, expected, 1e-13, "sum of parts");
    }
    // The expectation is that of the closed forms.
    let tau = 0.02 * 50.0;
    let expected = quantization_avar(1e-2, tau)
        + random_walk_avar(2f64.sqrt(), tau)
        + bias_instability_avar(0.3f64.sqrt(), 50)
        + rate_random_walk_avar_sampled(0.1f64.sqrt(), 0.02, 50)
        + gauss_markov_avar_sampled(0.7f64.sqrt(), 12.0 * 0.02, 0.02, 50)
        + rate_ramp_avar(ramp, tau);
    assert_close(gamma.expectation(&theta, ramp)[2], expected, 1e-13, "closed forms");
}

/// The smallest squared pivot of the Cholesky decomposition of the correlation matrix; not positive if the decomposition
/// fails.
fn least_pivot(covariance: &[f64], order: usize) -> f64 {
    let scale: Vec<f64> = (0..order).map(|i| covariance[i * order + i].sqrt()).collect();
    let mut factor = vec![0.0; order * order];
    let mut least = f64::INFINITY;
    for i in 0..order {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| factor[i * order + k] * factor[j * order + k]).sum();
            let rest = covariance[i * order + j] / (scale[i] * scale[j]) - dot;
            factor[i * order + j] = if i == j { rest.sqrt() } else { rest / factor[j * order + j] };
            if i == j {
                least = least.min(rest);
            }
        }
    }
    least
}

#[test]
fn covariance_on_half_octaves_has_a_cholesky_decomposition() {
    for n_samples in [1 << 12, 1 << 20] {
        let sizes = half_octaves(n_samples, 3);
        let gamma = Gamma::new(n_samples, &sizes, &Term::NOISE).unwrap();
        let mixtures: [[f64; 4]; 7] = [
            MIXTURE.map(|c| c * c),
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [100.0, 1.0, 0.0, 1e-8],
            [0.0, 1.0, 1e-4, 1e-10],
        ];
        for (theta, ramp) in mixtures.into_iter().flat_map(|theta| [(theta, 0.0), (theta, 1e-6)]) {
            let covariance = gamma.covariance(&theta, ramp);
            for (i, j) in (0..sizes.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (above, below) = (covariance[i * sizes.len() + j], covariance[j * sizes.len() + i]);
                assert_eq!(above.to_bits(), below.to_bits());
            }
            let least = least_pivot(&covariance, sizes.len());
            // Far above the rounding errors of 40 squares; a rate random walk has the smallest pivot, 0.008 for n = 1.
            assert!(least > 1e-3, "N {n_samples}, θ {theta:?}, ramp {ramp}: {least}");
        }
    }
}

#[test]
fn simulated_records_scatter_as_the_covariance_says() {
    const TRIALS: u64 = 4000;
    let (n_samples, tau0) = (512, 0.5);
    let sizes = half_octaves(n_samples, 3);
    let truth = &[
        (Term::RateRamp, 0.01),
        (Term::Quantization, 0.4),
        (Term::RandomWalk, 1.0),
        (Term::BiasInstability, 0.3),
        (Term::RateRandomWalk, 0.05),
    ];
    let theta = [0.4, 1.0, 0.3, 0.05f64].map(|c| c * c);
    let gamma = Gamma::new(n_samples, &sizes, &Term::NOISE).unwrap().at_interval(tau0).unwrap();
    let (mean, covariance) = (gamma.expectation(&theta, 0.01), gamma.covariance(&theta, 0.01));

    let cells = sizes.len() * sizes.len();
    let (mut sums, mut squares) = (vec![0.0; cells], vec![0.0; cells]);
    for stream in 0..TRIALS {
        let rate = simulate(n_samples, tau0, truth, 20_081, stream).unwrap();
        let phase = Phase::from_rate(&rate).unwrap();
        let estimates = allan_variance(&phase, &sizes, Overlap::Full, Counting::Standard).unwrap();
        let excess: Vec<f64> =
            estimates.iter().zip(&mean).map(|(estimate, mean)| estimate.avar - mean).collect();
        for cell in 0..cells {
            let product = excess[cell / sizes.len()] * excess[cell % sizes.len()];
            sums[cell] += product;
            squares[cell] += product * product;
        }
    }
    let trials = TRIALS as f64;
    for cell in 0..cells {
        let got = sums[cell] / trials;
        let error = ((squares[cell] / trials - got * got) / trials).sqrt();
        // The limit is in standard errors, for 120 distinct cells of products with heavy tails.
        let sigmas = (got - covariance[cell]) / error;
        let (n, m) = (sizes[cell / sizes.len()], sizes[cell % sizes.len()]);
        assert!(sigmas.abs() < 4.5, "n {n}, m {m}: {got} instead of {}, {sigmas} σ", covariance[cell]);
        // The test is sensitive: the errors of the variances are a few percent.
        assert!(n != m || error < 0.1 * got, "n {n}: {got} ± {error}");
    }
}

/// White noise of density 1 after a filter of order 1, sampled.
fn filtered_noise(corner: f64) -> Source {
    let decay = (-2.0 * PI * corner).exp();
    let sigma = (PI * corner).sqrt();
    let noise = sigma * (1.0 - decay * decay).sqrt();
    Source::Filtered { scale: 1.0, transition: vec![decay], noise: vec![noise], start: vec![sigma] }
}

#[test]
fn filtered_records_scatter_as_the_covariance_says() {
    const TRIALS: u64 = 4000;
    let n_samples = 512;
    let sizes = [1, 2, 5, 16, 50, 170, 256];
    for corner in [0.02, 0.3] {
        let components = [Component::LowPassed { order: 1, corner }, Component::Term(Term::RateRandomWalk)];
        let walk = 0.02;
        let gamma = Gamma::new(n_samples, &sizes, &components).unwrap();
        let edf = gamma.edf(&[1.0, walk * walk], 0.0);
        let mut samples: Vec<Vec<f64>> = vec![Vec::new(); sizes.len()];
        for seed in 0..TRIALS {
            let mut generator = Generator::new(n_samples, 1.0, seed).unwrap();
            generator.add(&filtered_noise(corner), 0).unwrap();
            generator.add(&Source::Term(Term::RateRandomWalk, walk), 0).unwrap();
            let mut rate = vec![0.0; n_samples];
            generator.fill(&mut rate).unwrap();
            let phase = Phase::from_rate(&rate).unwrap();
            let estimates = allan_variance(&phase, &sizes, Overlap::Full, Counting::Standard).unwrap();
            samples.iter_mut().zip(estimates).for_each(|(samples, estimate)| samples.push(estimate.avar));
        }
        let trials = TRIALS as f64;
        for ((samples, edf), size) in samples.into_iter().zip(edf).zip(sizes) {
            let mean = samples.iter().sum::<f64>() / trials;
            let moment =
                |power: i32| samples.iter().map(|avar| (avar / mean - 1.0).powi(power)).sum::<f64>() / trials;
            let spread = moment(2);
            let error = ((moment(4) - spread * spread) / trials).sqrt();
            let sigmas = (spread - 2.0 / edf) / error;
            assert!(
                sigmas.abs() < 3.0,
                "corner {corner}, n {size}: {spread} instead of {}, {sigmas} σ",
                2.0 / edf
            );
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let sizes = half_octaves(30_000, 2);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Gamma::new(30_000, &sizes, &Term::NOISE).unwrap())
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn wrong_arguments_are_refused() {
    let of = |n_samples: usize, sizes: &[usize], tc: f64| {
        Gamma::new(n_samples, sizes, &[Component::GaussMarkov { tc }]).map(|_| ())
    };
    assert_eq!(of(1, &[1], 1.0), Err(Error::TooShort { need: 2, got: 1 }));
    assert_eq!(of(100, &[3, 51], 1.0), Err(Error::ClusterSize { m: 51, largest: 50 }));
    assert_eq!(of(100, &[0], 1.0), Err(Error::ClusterSize { m: 0, largest: 50 }));
    assert_eq!(of(100, &[50, 50], 1.0), Ok(()));
    assert_eq!(of(100, &[], 1.0), Ok(()));
    for tc in [0.0, -1.0, f64::INFINITY, 1e200] {
        assert_eq!(of(100, &[1], tc), Err(Error::Parameter { name: "tc", value: tc }));
    }
    assert!(of(100, &[1], f64::NAN).is_err());
    for (order, corner, name) in [(0, 1.0, "order"), (2, 0.0, "corner"), (2, f64::INFINITY, "corner")] {
        let refused = Gamma::new(100, &[1], &[Component::LowPassed { order, corner }]);
        assert!(matches!(refused, Err(Error::Parameter { name: of, .. }) if of == name));
    }
    let gamma = Gamma::new(100, &[1], &Term::NOISE).unwrap();
    assert_eq!(gamma.at_interval(0.0), Err(Error::Parameter { name: "tau0", value: 0.0 }));
}
