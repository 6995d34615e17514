//! Expected densities of unit amplitude: at the cosine modes of block means, and in Welch's periodogram.

use crate::matern;
use crate::special::odd_harmonic;
use crate::terms::{NOISE_TERMS, Term};
use pulp::Arch;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex};

/// Lag above which the covariance of two blocks of flicker noise is computed from that of their centres and its second
/// derivative.
const SERIES_LAG: usize = 200;

/// Step of the sum that is a Matérn process, whose relative error is below 1e-5.
pub(crate) const MATERN_STEP: f64 = 1.5;

/// Number of records whose flicker densities are cached, by shape.
const CACHED_RECORDS: usize = 8;

/// A part of the model whose density is proportional to one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// A noise term; the parameter is its squared coefficient.
    Term(Term),
    /// First-order Gauss-Markov process; the parameter is σ².
    GaussMarkov {
        /// Correlation time. \[s\]
        time: f64,
    },
    /// Bias instability with the density f^−α; the parameter is B² at `pivot`.
    Flicker {
        /// α.
        exponent: f64,
        /// Frequency at which the density is that of B. \[Hz\]
        pivot: f64,
    },
    /// Matérn process; the parameter is σ².
    Matern {
        /// Correlation time. \[s\]
        time: f64,
        /// ν.
        smoothness: f64,
    },
    /// Band-pass resonance with a density of 0 at the frequency 0; the parameter is its variance.
    Resonance {
        /// Centre. \[Hz\]
        frequency: f64,
        /// Half width. \[Hz\]
        width: f64,
    },
}

impl Part {
    /// Whether the part is a noise term, whose density has no shape parameter.
    #[must_use]
    pub fn is_term(self) -> bool {
        matches!(self, Self::Term(_))
    }
}

impl From<Term> for Part {
    fn from(term: Term) -> Self {
        Self::Term(term)
    }
}

/// The noise terms, in their order in a model.
pub(crate) const TERMS: [Part; NOISE_TERMS] = {
    let mut parts = [Part::Term(Term::RandomWalk); NOISE_TERMS];
    let mut k = 0;
    while k < NOISE_TERMS {
        parts[k] = Part::Term(Term::NOISE[k]);
        k += 1;
    }
    parts
};

/// Evaluation point of mode k, with θ = πk/M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModePoint {
    sin: f64,
    cos: f64,
    /// 4 sin²(θ/2).
    chord: f64,
    /// Sine and cosine of θ(M − 1).
    last_sin: f64,
    last_cos: f64,
    pub frequency: f64,
}

/// The blocks of samples whose means are transformed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blocks {
    pub samples: usize,
    pub count: usize,
    pub tau0: f64,
}

impl Blocks {
    fn length(self) -> f64 {
        self.samples as f64 * self.tau0
    }

    pub(crate) fn point(self, k: usize) -> ModePoint {
        let m = self.count as f64;
        let theta = PI * k as f64 / m;
        let (sin, cos) = theta.sin_cos();
        // θ(M − 1) = πk − θ.
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        ModePoint {
            sin,
            cos,
            chord: 4.0 * (0.5 * theta).sin().powi(2),
            last_sin: -sign * sin,
            last_cos: sign * cos,
            frequency: k as f64 / (2.0 * m * self.length()),
        }
    }

    /// Expected density of a part of unit amplitude at a mode. Quantization noise has the density of samples, which is
    /// exact if the two end values of the angle are regressors; other noise has that of block means. Flicker noise is in
    /// [`flicker_modes`] and in a [`Mixture`](crate::likelihood::power_law::Mixture).
    pub(crate) fn density(self, part: Part, at: &ModePoint) -> f64 {
        let (n, length) = (self.samples as f64, self.length());
        match part {
            Part::Term(Term::Quantization) => 4.0 * (PI * at.frequency * self.tau0).sin().powi(2) / self.tau0,
            Part::Term(Term::RandomWalk) => 1.0,
            Part::Term(Term::RateRandomWalk) => {
                // The differences of block means of a sampled random walk are a moving average of order 1.
                let own = self.tau0 * (2.0 * n * n + 1.0) / (3.0 * n);
                let next = self.tau0 * (n * n - 1.0) / (6.0 * n);
                length * (own + 2.0 * next * at.cos) / at.chord
            }
            Part::GaussMarkov { time } => self.gauss_markov(time).density(at),
            Part::Resonance { frequency, width } => resonance(frequency, width, at.frequency),
            Part::Term(Term::BiasInstability | Term::RateRamp)
            | Part::Flicker { .. }
            | Part::Matern { .. } => f64::NAN,
        }
    }

    /// A Gauss-Markov process of unit variance.
    pub(crate) fn gauss_markov(self, time: f64) -> MarkovModes {
        let (n, m) = (self.samples as f64, self.count as f64);
        let rate = self.tau0 / time;
        let (p, lost) = ((-rate).exp(), -(-rate).exp_m1());
        let q = (-n * rate).exp();
        let lost_block = -(-n * rate).exp_m1();
        let (own, next) = if self.samples == 1 {
            (1.0, p)
        } else {
            let shared = p * (lost_block / (n * lost)).powi(2);
            (block_variance(n, rate, p, lost, lost_block), shared)
        };
        MarkovModes { own, next, q, tail: (-(m - 1.0) * n * rate).exp(), m, length: self.length() }
    }
}

/// Densities of a process whose neighbouring samples have the correlation exp(−τ₀/T), as closed geometric sums.
pub(crate) struct MarkovModes {
    /// Variance of the mean of a block, and its covariance with the next one.
    own: f64,
    next: f64,
    /// Correlation of neighbouring blocks, and of the first and the last block.
    q: f64,
    tail: f64,
    /// Number of blocks, and length of a block. \[s\]
    m: f64,
    length: f64,
}

impl MarkovModes {
    #[inline]
    pub(crate) fn density(&self, at: &ModePoint) -> f64 {
        let &Self { own, next, q, tail, m, length } = self;
        // z = q·e^{iθ}; sums of z^l and l·z^l.
        let (zr, zi) = (q * at.cos, q * at.sin);
        let (tr, ti) = (tail * at.last_cos, tail * at.last_sin);
        let (dr, di) = (1.0 - zr, -zi);
        let (ur, ui) = (1.0 - tr, -ti);
        let (er, ei) = (at.cos, at.sin);
        let first = divide(multiply((er, ei), (ur, ui)), (dr, di));
        let (tz_r, tz_i) = multiply((tr, ti), (zr, zi));
        let bracket = (1.0 - m * tr + (m - 1.0) * tz_r, -m * ti + (m - 1.0) * tz_i);
        let second = divide(multiply((er, ei), bracket), multiply((dr, di), (dr, di)));
        length * (own + 2.0 * next * (first.0 - second.0 / m - first.1 / (m * at.sin)))
    }
}

/// Variance of the mean of n samples of a process with unit variance.
fn block_variance(n: f64, rate: f64, p: f64, lost: f64, lost_block: f64) -> f64 {
    if n * rate < 1e-3 {
        // 1 − x(n² − 1)/(3n) + x²(…), because the closed form loses all digits.
        let x = rate;
        return 1.0 - x * (n * n - 1.0) / (3.0 * n) + x * x * (n * n - 1.0) / 12.0;
    }
    (n * lost * (1.0 + p) - 2.0 * p * lost_block) / (n * n * lost * lost)
}

fn multiply(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn divide(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let norm = b.0 * b.0 + b.1 * b.1;
    ((a.0 * b.0 + a.1 * b.1) / norm, (a.1 * b.0 - a.0 * b.1) / norm)
}

/// S = 2 g f² / π / ((f² − f₀²)² + 4 g² f²), which has unit variance and is 0 at the frequency 0.
#[inline]
pub(crate) fn resonance(centre: f64, width: f64, f: f64) -> f64 {
    let square = f * f;
    2.0 * width * square / PI / ((square - centre * centre).powi(2) + 4.0 * width * width * square)
}

/// A point at which Welch's periodogram is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FinePoint {
    pub frequency: f64,
    /// sin²(πfτ₀).
    square: f64,
    sin: f64,
    /// 1/(6 (f L τ₀)²): Hann's taper smears f^−k by 1 + k(k + 1) times this.
    smear: f64,
}

impl FinePoint {
    pub(crate) fn new(frequency: f64, tau0: f64, segment: usize) -> Self {
        let sin = (PI * frequency * tau0).sin();
        let cycles = frequency * segment as f64 * tau0;
        Self { frequency, square: sin * sin, sin, smear: 1.0 / (6.0 * cycles * cycles) }
    }

    /// A point without smearing by a taper.
    pub(crate) fn narrow(frequency: f64, tau0: f64) -> Self {
        let sin = (PI * frequency * tau0).sin();
        Self { frequency, square: sin * sin, sin, smear: 0.0 }
    }

    /// Expected density of a part of unit amplitude.
    pub(crate) fn density(&self, part: Part, tau0: f64) -> f64 {
        match part {
            Part::Term(Term::Quantization) => 4.0 * self.square / tau0,
            Part::Term(Term::RandomWalk) => 1.0,
            Part::Term(Term::BiasInstability) => tau0 / (2.0 * self.sin) * (1.0 + 2.0 * self.smear),
            Part::Term(Term::RateRandomWalk) => tau0 * tau0 / (4.0 * self.square) * (1.0 + 6.0 * self.smear),
            Part::Term(Term::RateRamp) => f64::NAN,
            Part::GaussMarkov { time } => MarkovDensity::new(time, tau0).at(self),
            Part::Matern { time, smoothness } => matern_densities(time, smoothness, tau0)
                .map(|(variance, process)| variance * process.at(self))
                .sum(),
            Part::Resonance { frequency, width } => resonance(frequency, width, self.frequency),
            Part::Flicker { exponent, pivot } => {
                let slope = (self.sin / (PI * tau0 * pivot)).powf(1.0 - exponent);
                tau0 / (2.0 * self.sin) * slope * (1.0 + exponent * (exponent + 1.0) * self.smear)
            }
        }
    }
}

/// Density of a Gauss-Markov process of unit variance.
struct MarkovDensity {
    above: f64,
    square: f64,
    slope: f64,
}

impl MarkovDensity {
    fn new(time: f64, tau0: f64) -> Self {
        let (p, lost) = ((-tau0 / time).exp(), -(-tau0 / time).exp_m1());
        Self { above: tau0 * lost * (1.0 + p), square: lost * lost, slope: 4.0 * p }
    }

    #[inline]
    fn at(&self, point: &FinePoint) -> f64 {
        self.above / (self.square + self.slope * point.square)
    }
}

/// The processes whose sum is a Matérn process of unit variance, with their variances.
fn matern_densities(time: f64, smoothness: f64, tau0: f64) -> impl Iterator<Item = (f64, MarkovDensity)> {
    matern::processes(smoothness, time / tau0, MATERN_STEP)
        .into_iter()
        .map(move |(variance, time)| (variance, MarkovDensity::new(time * tau0, tau0)))
}

/// Densities of a part of unit amplitude at some points; factors that depend only on the part are computed once.
pub(crate) fn fine_densities(part: Part, points: &[FinePoint], tau0: f64, densities: &mut [f64]) {
    match part {
        Part::GaussMarkov { time } => {
            let process = MarkovDensity::new(time, tau0);
            evaluate(densities, points, |point| process.at(point));
        }
        Part::Matern { time, smoothness } => {
            densities.fill(0.0);
            for (variance, process) in matern_densities(time, smoothness, tau0) {
                for (density, point) in densities.iter_mut().zip(points) {
                    *density += variance * process.at(point);
                }
            }
        }
        Part::Resonance { frequency, width } => {
            evaluate(densities, points, |point| resonance(frequency, width, point.frequency));
        }
        _ => evaluate(densities, points, |point| point.density(part, tau0)),
    }
}

/// Evaluates a function at some points, several side by side if the function has no branches.
pub(crate) fn evaluate<T>(values: &mut [f64], points: &[T], function: impl Fn(&T) -> f64) {
    Arch::new().dispatch(
        #[inline(always)]
        || values.iter_mut().zip(points).for_each(|(value, point)| *value = function(point)),
    );
}

type Kept = Mutex<Vec<((usize, usize), Arc<Vec<f64>>)>>;

/// Densities of flicker noise with B = 1 at the modes 1 … M/8, over the length of a block: they depend only on the shape of
/// the record, and the latest ones are cached.
pub(crate) fn flicker_modes(blocks: Blocks, modes: usize) -> Arc<Vec<f64>> {
    static KNOWN: Kept = Mutex::new(Vec::new());
    let key = (blocks.samples, blocks.count);
    let lock = || KNOWN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some((_, known)) = lock().iter().find(|(shape, known)| *shape == key && known.len() == modes) {
        return known.clone();
    }
    let found = Arc::new(mode_variances(&flicker_covariance(blocks.samples, blocks.count), modes));
    let mut known = lock();
    known.retain(|(shape, _)| *shape != key);
    if known.len() == CACHED_RECORDS {
        known.remove(0);
    }
    known.push((key, found.clone()));
    found
}

/// Covariance of two block means of flicker noise with B = 1, by their distance, up to a constant.
fn flicker_covariance(n: usize, blocks: usize) -> Vec<f64> {
    // The sampled process has the covariance −2h/π at a lag, where h is the sum of odd harmonics; a block mean averages it.
    let near: Vec<f64> = (0..=(SERIES_LAG + 1).min(blocks)).map(|l| twice_summed(l * n)).collect();
    let size = n as f64;
    (0..blocks)
        .map(|l| {
            if n == 1 {
                -2.0 / PI * odd_harmonic(l)
            } else if l + 1 < near.len() {
                let before = near[if l == 0 { 1 } else { l - 1 }];
                (near[l + 1] - 2.0 * near[l] + before) / (2.0 * PI * size * size)
            } else {
                let far = (l * n) as f64;
                -2.0 / PI * odd_harmonic(l * n) + (size * size - 1.0) / (12.0 * PI * far * far)
            }
        })
        .collect()
}

/// A function with the second difference −4h, where h is the sum of odd harmonics.
fn twice_summed(l: usize) -> f64 {
    if l == 0 {
        return 0.0;
    }
    let x = l as f64;
    -(4.0 * x * x - 1.0) / 2.0 * odd_harmonic(l - 1) + 2.0 * x * (x - 1.0) - (x - 1.0).powi(2) / 2.0
}

/// Variance of the orthonormal DCT-II modes 1 … `modes` of a stationary series with the covariance `lags`, which may have
/// an additive constant.
fn mode_variances(lags: &[f64], modes: usize) -> Vec<f64> {
    let m = lags.len();
    let transform = sigmatau_fft::forward(2 * m);
    let contrast = |l: usize| lags[l] - lags[0];
    let mut input = transform.make_input_vec();
    let mut output = transform.make_output_vec();
    for (l, slot) in input[1..m].iter_mut().enumerate().map(|(i, slot)| (i + 1, slot)) {
        *slot = contrast(l) * (1.0 - l as f64 / m as f64);
    }
    let done = transform.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    let even: Vec<f64> = output[1..=modes].iter().map(|z| 2.0 * z.re).collect();
    input.fill(0.0);
    for (l, slot) in input[1..m].iter_mut().enumerate().map(|(i, slot)| (i + 1, slot)) {
        *slot = contrast(l);
    }
    let done = transform.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    (1..=modes)
        .map(|k| even[k - 1] + 2.0 * output[k].im / (m as f64 * (PI * k as f64 / m as f64).sin()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance of a mode from its definition.
    fn by_definition(covariance: impl Fn(usize) -> f64, m: usize, k: usize) -> f64 {
        let h: Vec<f64> = (0..m)
            .map(|t| (2.0 / m as f64).sqrt() * (PI * k as f64 * (t as f64 + 0.5) / m as f64).cos())
            .collect();
        (0..m)
            .flat_map(|s| (0..m).map(move |t| (s, t)))
            .map(|(s, t)| h[s] * h[t] * covariance(s.abs_diff(t)))
            .sum()
    }

    /// Covariance of block means from that of the samples.
    fn block_covariance(samples: impl Fn(usize) -> f64, n: usize, lag: usize) -> f64 {
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, lag * n + j)));
        pairs.map(|(i, j)| samples(i.abs_diff(j))).sum::<f64>() / (n * n) as f64
    }

    #[test]
    fn gauss_markov_modes_are_exact() {
        for (n, time) in [(1, 0.3), (4, 0.5), (4, 50.0), (7, 1e4)] {
            let blocks = Blocks { samples: n, count: 40, tau0: 0.1 };
            let lags: Vec<f64> =
                (0..40).map(|l| block_covariance(|d| (-0.1 * d as f64 / time).exp(), n, l)).collect();
            for k in [1, 2, 5] {
                let exact = by_definition(|l| lags[l], 40, k) * blocks.length();
                let got = blocks.density(Part::GaussMarkov { time }, &blocks.point(k));
                assert!((got / exact - 1.0).abs() < 1e-7, "n {n}, {time} s, mode {k}: {got} for {exact}");
            }
        }
    }

    #[test]
    fn flicker_and_walk_modes_are_exact() {
        for n in [1, 5] {
            let blocks = Blocks { samples: n, count: 32, tau0: 0.5 };
            let flicker: Vec<f64> =
                (0..32).map(|l| block_covariance(|d| -2.0 / PI * odd_harmonic(d), n, l)).collect();
            // Only contrasts matter, so −|d|/2 represents a random walk.
            let walk: Vec<f64> = (0..32).map(|l| block_covariance(|d| -0.25 * d as f64, n, l)).collect();
            let got = flicker_modes(blocks, 4);
            for k in 1..=4 {
                let exact = by_definition(|l| flicker[l], 32, k);
                assert!((got[k - 1] / exact - 1.0).abs() < 1e-10, "flicker, n {n}, mode {k}");
                let exact = by_definition(|l| walk[l], 32, k) * blocks.length();
                let walk = blocks.density(Part::Term(Term::RateRandomWalk), &blocks.point(k));
                assert!((walk / exact - 1.0).abs() < 1e-10, "walk, n {n}, mode {k}: {walk} for {exact}");
            }
        }
    }

    #[test]
    fn far_blocks_join_the_near_ones() {
        let lags = flicker_covariance(300, SERIES_LAG + 4);
        let second = lags[SERIES_LAG + 2] - 2.0 * lags[SERIES_LAG + 1] + lags[SERIES_LAG];
        assert!((second * PI * ((SERIES_LAG + 1) * (SERIES_LAG + 1)) as f64 - 1.0).abs() < 1e-2, "{second}");
    }

    #[test]
    fn white_behaviour_of_a_fast_process() {
        let blocks = Blocks { samples: 10, count: 100, tau0: 1.0 };
        let part = Part::GaussMarkov { time: 1e-3 };
        assert!((blocks.density(part, &blocks.point(3)) - 1.0).abs() < 1e-12);
        assert!((FinePoint::new(0.1, 1.0, 64).density(part, 1.0) - 1.0).abs() < 1e-12);
    }
}
