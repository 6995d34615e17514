//! Components of the expected Allan variances, their covariance and their skewness, by term.
//!
//! They depend on the length of the record, the cluster sizes and the shapes of the terms, but not on the
//! data. They are computed once and shared by all axes, all steps of a fit and all files of a run.
//!
//! The expected Allan variance is Σ θ(p) D(p), its covariance Σ θ(p) θ(q) Γ(p, q), exact for finite records
//! ([`crate::covariance`]). The third cumulant of a weighted sum of Allan variances is computed as if the modes of the
//! discrete cosine transform were independent, which is exact for white noise plus a random walk: with the spectrum
//! θ·S(k) at mode k and its gain g(k, n) in the variance at n, the cumulant of order r of Σ h(n) AVAR(n) is
//! 2^(r−1) (r−1)! Σₖ (Σₙ h(n) g(k, n) θ·S(k))^r.

use crate::covariance::{Component, Gamma};
use crate::error::Error;
use crate::gls::angles::modes;
use crate::gls::cache::Cache;
use crate::gls::{LINEAR, Theta};
use crate::terms::{self, Term};
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of cached components of the noise terms, and of further ones.
const CACHED: usize = 16;
const CACHED_EXTRA: usize = 32;

/// The four noise terms at some cluster sizes of a record of `n` samples.
#[derive(Debug)]
pub struct Base {
    n: usize,
    sizes: Vec<usize>,
    /// Expected Allan variances for θ = 1, one row per term.
    design: Vec<f64>,
    /// Γ(p, q) of the pairs p ≤ q; for unequal terms the sum of both orders.
    noise: Vec<f64>,
    /// Covariance, for θ = 1, of the ramps estimated from the mean second differences; one matrix per term.
    slopes: Vec<f64>,
    /// Power of a mode for θ = 1, divided by n; one row per term.
    spectra: Vec<f64>,
    /// One row per cluster size.
    pub(super) gains: Vec<f64>,
    /// Number of modes that each mode represents.
    pub(super) multiplicities: Vec<f64>,
    /// Sines of half the angles of the modes.
    sines: Vec<f64>,
    /// m²: twice the variance of a ramp of 1.
    squares: Vec<f64>,
}

/// Shape of an additional term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A first-order Gauss-Markov process of a correlation time; its θ is the variance. \[samples\]
    GaussMarkov(f64),
    /// A sinusoid of random phase and a frequency; its θ is the squared amplitude. [cycles per sample]
    Sinusoid(f64),
}

/// An additional term at the same cluster sizes.
#[derive(Debug)]
pub struct Extra {
    design: Vec<f64>,
    /// Γ with each of the four terms, in both orders, then with itself.
    noise: Vec<f64>,
    slopes: Vec<f64>,
    spectrum: Vec<f64>,
}

/// The terms of a fit.
#[derive(Debug, Clone)]
pub struct Components {
    /// The noise terms.
    pub base: Arc<Base>,
    /// A further component.
    pub extra: Option<Arc<Extra>>,
}

impl Base {
    /// Components for a record of `n` samples at increasing cluster sizes, at most n/2; cached for later calls.
    ///
    /// # Errors
    ///
    /// As for [`Gamma::new`].
    pub fn new(n: usize, sizes: &[usize]) -> Result<Arc<Self>, Error> {
        static CACHE: Cache<(usize, Vec<usize>), Base> = Cache::new(CACHED);
        CACHE.get((n, sizes.to_vec()), || Self::computed(n, sizes))
    }

    fn computed(n: usize, sizes: &[usize]) -> Result<Self, Error> {
        let gamma = Gamma::new(n, sizes, &Term::NOISE)?;
        let design =
            Term::NOISE.iter().flat_map(|term| sizes.iter().map(|&m| term.avar(1.0, 1.0, m))).collect();
        let mut noise = Vec::new();
        for p in 0..LINEAR {
            for q in p..LINEAR {
                noise.extend(both(&gamma, p, q));
            }
        }
        let squares: Vec<f64> = sizes.iter().map(|&m| m as f64 * m as f64).collect();
        let slopes = (0..LINEAR).flat_map(|p| slopes(&gamma, p, &squares)).collect();
        let (angles, multiplicities) = modes(n);
        let sines: Vec<f64> = angles.iter().map(|angle| (0.5 * angle).sin()).collect();
        let density = |term: &Term, angle: &f64| term.psd(1.0, 1.0, angle / (2.0 * PI)) / n as f64;
        let spectra = Term::NOISE
            .iter()
            .flat_map(|term| angles.iter().map(move |angle| density(term, angle)))
            .collect();
        let gain = |m: usize, square: f64, k: usize| {
            2.0 * (0.5 * (m as f64 * angles[k])).sin().powi(4) / (square * (sines[k] * sines[k]))
        };
        let rows = sizes.iter().zip(&squares);
        let gains = rows.flat_map(|(&m, &square)| (0..multiplicities.len()).map(move |k| (m, square, k)));
        let gains = gains.map(|(m, square, k)| gain(m, square, k)).collect();
        Ok(Self {
            n,
            sizes: sizes.to_vec(),
            design,
            noise,
            slopes,
            spectra,
            gains,
            multiplicities,
            sines,
            squares,
        })
    }

    /// The components at some of the sizes.
    pub(crate) fn at_sizes(&self, indices: &[usize]) -> Self {
        let (order, count) = (self.order(), self.multiplicities.len());
        let entries = |all: &[f64]| -> Vec<f64> {
            let selected = |matrix: &[f64]| -> Vec<f64> {
                indices
                    .iter()
                    .flat_map(|&i| indices.iter().map(move |&j| (i, j)))
                    .map(|(i, j)| matrix[i * order + j])
                    .collect()
            };
            all.chunks_exact(order * order).flat_map(selected).collect()
        };
        Self {
            n: self.n,
            sizes: indices.iter().map(|&k| self.sizes[k]).collect(),
            design: self
                .design
                .chunks_exact(order)
                .flat_map(|row| indices.iter().map(move |&k| row[k]))
                .collect(),
            noise: entries(&self.noise),
            slopes: entries(&self.slopes),
            spectra: self.spectra.clone(),
            gains: indices.iter().flat_map(|&k| &self.gains[k * count..][..count]).copied().collect(),
            multiplicities: self.multiplicities.clone(),
            sines: self.sines.clone(),
            squares: indices.iter().map(|&k| self.squares[k]).collect(),
        }
    }

    /// Samples in the record.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// The cluster sizes.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// m².
    #[must_use]
    pub fn squares(&self) -> &[f64] {
        &self.squares
    }

    /// Number of modes that each mode represents.
    #[must_use]
    pub fn multiplicities(&self) -> &[f64] {
        &self.multiplicities
    }

    pub(crate) fn order(&self) -> usize {
        self.sizes.len()
    }
}

impl Extra {
    /// An additional term for given components; processes are cached for later calls.
    ///
    /// # Errors
    ///
    /// As for [`Gamma::new`].
    pub fn new(base: &Base, shape: Shape) -> Result<Arc<Self>, Error> {
        static CACHE: Cache<(usize, Vec<usize>, u64), Extra> = Cache::new(CACHED_EXTRA);
        match shape {
            Shape::GaussMarkov(time) => {
                CACHE.get((base.n, base.sizes.clone(), time.to_bits()), || Self::process(base, time))
            }
            Shape::Sinusoid(frequency) => Ok(Arc::new(Self::sinusoid(base, frequency))),
        }
    }

    fn process(base: &Base, time: f64) -> Result<Self, Error> {
        let with: Vec<Component> = Term::NOISE
            .into_iter()
            .map(Component::Term)
            .chain([Component::GaussMarkov { tc: time }])
            .collect();
        let gamma = Gamma::new(base.n, &base.sizes, &with)?;
        let decay = -(-1.0 / time).exp_m1();
        let power =
            |s: &f64| decay * (2.0 - decay) / (decay * decay + 4.0 * (1.0 - decay) * s * s) / base.n as f64;
        Ok(Self {
            design: process_avar(&base.sizes, time),
            noise: (0..=LINEAR).flat_map(|p| both(&gamma, p, LINEAR)).collect(),
            slopes: slopes(&gamma, LINEAR, &base.squares),
            spectrum: base.sines.iter().map(power).collect(),
        })
    }

    /// A sinusoid is not noise: it enters the covariance only through the noise at its frequency. The squared amplitude
    /// measured in a record of n samples has the variance 8A²S(f)/n, with S two-sided, and every Allan variance is
    /// proportional to it.
    fn sinusoid(base: &Base, frequency: f64) -> Self {
        let order = base.order();
        let design: Vec<f64> =
            base.sizes.iter().map(|&m| terms::sinusoid_avar(1.0, frequency, 1.0, m)).collect();
        let mut noise = Vec::with_capacity((LINEAR + 1) * order * order);
        for density in Term::NOISE.iter().map(|term| term.psd(1.0, 1.0, frequency)).chain([0.0]) {
            let factor = 8.0 / base.n as f64 * density;
            noise.extend(design.iter().flat_map(|x| design.iter().map(move |y| factor * x * y)));
        }
        Self {
            design,
            noise,
            slopes: vec![0.0; order * order],
            spectrum: vec![0.0; base.multiplicities.len()],
        }
    }
}

impl Components {
    /// The noise terms and at most one further component.
    ///
    /// # Errors
    ///
    /// As for [`Gamma::new`].
    pub fn new(n: usize, sizes: &[usize], extra: Option<Shape>) -> Result<Self, Error> {
        let base = Base::new(n, sizes)?;
        let extra = extra.map(|shape| Extra::new(&base, shape)).transpose()?;
        Ok(Self { base, extra })
    }

    /// Number of terms.
    #[must_use]
    pub fn terms(&self) -> usize {
        LINEAR + usize::from(self.extra.is_some())
    }

    /// Expected Allan variances of a term for θ = 1.
    ///
    /// # Panics
    ///
    /// If there is no such term.
    #[must_use]
    pub fn design(&self, term: usize) -> &[f64] {
        self.part(term, |base| &base.design, |extra| &extra.design, self.base.order())
    }

    /// Covariance of the ramps estimated from the mean second differences, for θ = 1.
    ///
    /// # Panics
    ///
    /// If there is no such term.
    #[must_use]
    pub fn slopes(&self, term: usize) -> &[f64] {
        self.part(term, |base| &base.slopes, |extra| &extra.slopes, self.base.order().pow(2))
    }

    /// Power of each mode for θ = 1, divided by n.
    ///
    /// # Panics
    ///
    /// If there is no such term.
    #[must_use]
    pub fn spectrum(&self, term: usize) -> &[f64] {
        self.part(term, |base| &base.spectra, |extra| &extra.spectrum, self.base.multiplicities.len())
    }

    /// Γ of two terms p ≤ q; for unequal terms the sum of both orders.
    pub(crate) fn noise(&self, p: usize, q: usize) -> &[f64] {
        let size = self.base.order().pow(2);
        match &self.extra {
            Some(extra) if q == LINEAR => &extra.noise[p * size..][..size],
            _ => &self.base.noise[(p * (2 * LINEAR - p - 1) / 2 + q) * size..][..size],
        }
    }

    fn part(
        &self,
        term: usize,
        linear: fn(&Base) -> &Vec<f64>,
        more: fn(&Extra) -> &Vec<f64>,
        size: usize,
    ) -> &[f64] {
        match &self.extra {
            Some(extra) if term == LINEAR => more(extra),
            _ => &linear(&self.base)[term * size..][..size],
        }
    }

    /// Degrees of freedom 2·AVAR²/Var of the variances from number `first`, for θ and a ramp per sample.
    #[must_use]
    pub fn degrees_of_freedom(&self, first: usize, theta: &Theta, ramp: f64) -> Vec<f64> {
        let order = self.base.order();
        let terms = self.terms();
        let of_size = |i: usize| {
            let at = i * (order + 1);
            let square = self.base.squares[i];
            let (mut mean, mut variance) = (0.5 * ramp * ramp * square, 0.0);
            for p in 0..terms {
                mean += theta[p] * self.design(p)[i];
                variance += (ramp * square).powi(2) * theta[p] * self.slopes(p)[at];
                for q in p..terms {
                    variance += theta[p] * theta[q] * self.noise(p, q)[at];
                }
            }
            2.0 * mean * mean / variance
        };
        (first..order).map(of_size).collect()
    }
}

/// Expected Allan variances of a process of variance 1.
pub(crate) fn process_avar(sizes: &[usize], time: f64) -> Vec<f64> {
    sizes.iter().map(|&m| terms::gauss_markov_avar_sampled(1.0, time, 1.0, m)).collect()
}

/// Γ(p, q); for unequal terms the sum of both orders.
fn both(gamma: &Gamma, p: usize, q: usize) -> Vec<f64> {
    let mut part = gamma.noise_part(p, q);
    if p != q {
        for x in &mut part {
            *x *= 2.0;
        }
    }
    part
}

fn slopes(gamma: &Gamma, term: usize, squares: &[f64]) -> Vec<f64> {
    let products = squares.iter().flat_map(|x| squares.iter().map(move |y| x * y));
    gamma.ramp_part(term).iter().zip(products).map(|(drift, square)| drift / square).collect()
}
