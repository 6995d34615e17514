//! Simulated rates: every term has exactly the Allan variance of its sampled closed form in [`crate::terms`], but for
//! flicker noise from a pole bank, see [`crate::pole_bank`].
//!
//! A [`Generator`] fills buffers one after the other; the samples do not depend on how they are cut.

use crate::draws::{Draws, Source};
use crate::error::Error;
use crate::flicker::flicker;
use crate::pole_bank::Bank;
use crate::processes::{Filtered, GaussMarkov, Sinusoid};

/// Noise coefficients in SI units; 0 leaves a term out. All but the ramp are ≥ 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coefficients {
    /// Q, standard deviation of white noise on the phase.
    pub quantization: f64,
    /// N, square root of the two-sided density of white noise on the rate.
    pub random_walk: f64,
    /// B, of the flicker noise B² / (2πf).
    pub bias_instability: f64,
    /// K, of the random walk of the samples, yₖ = yₖ₋₁ + K √τ₀ wₖ.
    pub rate_random_walk: f64,
    /// R, slope of the deterministic ramp R τ₀ k, of either sign.
    pub rate_ramp: f64,
}

/// How flicker noise is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flicker {
    /// All samples at once, with their exact statistics; they are kept in memory.
    Exact,
    /// By a bank of poles, in no memory worth the name.
    Poles,
}

/// A part of the noise of a channel, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// R, the ramp R τ₀ k.
    RateRamp(f64),
    /// Q.
    Quantization(f64),
    /// N.
    RandomWalk(f64),
    /// B, and how it is made.
    BiasInstability(f64, Flicker),
    /// K.
    RateRandomWalk(f64),
    /// White noise behind a filter, sampled: x' = A x + L w, the output is the first state times `scale`.
    Filtered {
        /// Of the output.
        scale: f64,
        /// A, row by row.
        transition: Vec<f64>,
        /// L, row by row; L Lᵀ is the covariance of what one step adds.
        noise: Vec<f64>,
        /// The same of the state at the start.
        start: Vec<f64>,
    },
    /// A first-order Gauss-Markov process.
    GaussMarkov {
        /// Standard deviation.
        sigma: f64,
        /// Correlation time, in seconds.
        time: f64,
        /// Which of the channel's processes it is.
        index: u32,
    },
    /// A sinusoid of random phase.
    Sinusoid {
        /// Amplitude.
        amplitude: f64,
        /// Frequency in Hz.
        frequency: f64,
        /// Which of the channel's sinusoids it is.
        index: u32,
    },
}

impl Term {
    /// Number of the random numbers: each part has its own, so that a new one leaves the others' draws alone.
    fn stream(&self) -> u64 {
        match self {
            Self::RateRamp(_) | Self::Quantization(_) => 0,
            Self::RandomWalk(_) | Self::Filtered { .. } => 1,
            Self::BiasInstability(..) => 2,
            Self::RateRandomWalk(_) => 3,
            Self::GaussMarkov { index, .. } => 1 << 32 | u64::from(*index),
            Self::Sinusoid { index, .. } => 2 << 32 | u64::from(*index),
        }
    }
}

/// Samples made together: what is drawn for them stays in the nearest cache.
const BLOCK: usize = 1024;

/// The noise of one channel, sample after sample.
pub struct Generator {
    n: usize,
    made: usize,
    tau0: f64,
    seed: u64,
    sources: Vec<Box<dyn Source>>,
}

impl Generator {
    /// A generator of `n` samples without noise, to which terms are added.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a `tau0` that is not positive.
    pub fn new(n: usize, tau0: f64, seed: u64) -> Result<Self, Error> {
        if !(tau0 > 0.0 && tau0.is_finite()) {
            return Err(Error::Parameter { name: "tau0", value: tau0 });
        }
        Ok(Self { n, made: 0, tau0, seed, sources: Vec::new() })
    }

    /// Adds a term, with the random numbers of a `channel`: the same seed and channel give the same noise.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a value out of its range, [`Error::Length`] for matrices of unequal size.
    pub fn add(&mut self, term: &Term, channel: u64) -> Result<(), Error> {
        let tau0 = self.tau0;
        let mut draws = Draws::new(self.seed, channel, term.stream());
        let source: Box<dyn Source> = match *term {
            Term::RateRamp(slope) => {
                finite("rate_ramp", slope)?;
                Box::new(Ramp { step: slope * tau0, at: 0 })
            }
            Term::Quantization(q) => {
                finite("quantization", q)?;
                let before = draws.normal();
                Box::new(Quantization { gain: q / tau0, before, draws })
            }
            Term::RandomWalk(n) => {
                finite("random_walk", n)?;
                Box::new(White { sigma: n / tau0.sqrt(), draws })
            }
            Term::BiasInstability(b, Flicker::Exact) => {
                finite("bias_instability", b)?;
                Box::new(Stored { samples: flicker(self.n, b, draws.generator()), at: 0 })
            }
            Term::BiasInstability(b, Flicker::Poles) => {
                finite("bias_instability", b)?;
                Box::new(Bank::new(self.n, b, draws))
            }
            Term::RateRandomWalk(k) => {
                finite("rate_random_walk", k)?;
                Box::new(Walk { sigma: k * tau0.sqrt(), level: 0.0, draws })
            }
            Term::Filtered { scale, ref transition, ref noise, ref start } => {
                finite("scale", scale)?;
                Box::new(Filtered::new(scale, transition, noise, start, draws)?)
            }
            Term::GaussMarkov { sigma, time, .. } => {
                finite("sigma", sigma)?;
                positive("time", time)?;
                Box::new(GaussMarkov::new(sigma, tau0 / time, draws))
            }
            Term::Sinusoid { amplitude, frequency, .. } => {
                finite("amplitude", amplitude)?;
                positive("frequency", frequency)?;
                Box::new(Sinusoid::new(amplitude, frequency * tau0, draws))
            }
        };
        self.sources.push(source);
        Ok(())
    }

    /// Samples still to be made.
    #[must_use]
    pub fn left(&self) -> usize {
        self.n - self.made
    }

    /// The next samples, terms in the order in which they were added.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] for more samples than are left.
    pub fn fill(&mut self, rate: &mut [f64]) -> Result<(), Error> {
        if rate.len() > self.left() {
            return Err(Error::Length { expected: self.left(), got: rate.len() });
        }
        for block in rate.chunks_mut(BLOCK) {
            // What a sum begins with that keeps every sign.
            block.fill(-0.0);
            for source in &mut self.sources {
                source.add(block);
            }
        }
        self.made += rate.len();
        Ok(())
    }
}

/// Simulates `n` rate samples. The same `seed` and `stream` give the same record; streams of a seed are independent.
///
/// # Errors
///
/// [`Error::Parameter`] for a `tau0` that is not positive, or a coefficient out of its range.
pub fn simulate(n: usize, tau0: f64, c: &Coefficients, seed: u64, stream: u64) -> Result<Vec<f64>, Error> {
    let mut generator = Generator::new(n, tau0, seed)?;
    finite("rate_ramp", c.rate_ramp)?;
    let terms = [
        ("rate_ramp", c.rate_ramp.abs(), Term::RateRamp(c.rate_ramp)),
        ("quantization", c.quantization, Term::Quantization(c.quantization)),
        ("random_walk", c.random_walk, Term::RandomWalk(c.random_walk)),
        ("bias_instability", c.bias_instability, Term::BiasInstability(c.bias_instability, Flicker::Exact)),
        ("rate_random_walk", c.rate_random_walk, Term::RateRandomWalk(c.rate_random_walk)),
    ];
    for (name, size, term) in terms {
        if !(size >= 0.0 && size.is_finite()) {
            return Err(Error::Parameter { name, value: size });
        }
        if size > 0.0 {
            generator.add(&term, stream)?;
        }
    }
    let mut rate = vec![0.0; n];
    generator.fill(&mut rate)?;
    Ok(rate)
}

fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::Parameter { name, value }) }
}

fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(Error::Parameter { name, value }) }
}

struct Ramp {
    step: f64,
    at: usize,
}

impl Source for Ramp {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            *y += self.step * self.at as f64;
            self.at += 1;
        }
    }
}

struct Quantization {
    gain: f64,
    before: f64,
    draws: Draws,
}

impl Source for Quantization {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            let error = self.draws.normal();
            *y += self.gain * (error - self.before);
            self.before = error;
        }
    }
}

struct White {
    sigma: f64,
    draws: Draws,
}

impl Source for White {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            *y += self.sigma * self.draws.normal();
        }
    }
}

struct Walk {
    sigma: f64,
    level: f64,
    draws: Draws,
}

impl Source for Walk {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            self.level += self.sigma * self.draws.normal();
            *y += self.level;
        }
    }
}

struct Stored {
    samples: Vec<f64>,
    at: usize,
}

impl Source for Stored {
    fn add(&mut self, rate: &mut [f64]) {
        for (y, x) in rate.iter_mut().zip(&self.samples[self.at..]) {
            *y += x;
        }
        self.at += rate.len();
    }
}
