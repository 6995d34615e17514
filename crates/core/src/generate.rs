//! Simulated rates. Every term has exactly the Allan variance of its sampled closed form in [`crate::terms`], except flicker
//! noise from a pole bank, see [`crate::pole_bank`].
//!
//! A [`Generator`] fills consecutive buffers; the samples do not depend on their sizes.

use crate::draws::{Draws, Source};
use crate::error::Error;
use crate::flicker::flicker;
use crate::pole_bank::Bank;
use crate::processes::{Filtered, GaussMarkov, Sinusoid};
use crate::terms::Term;

/// A part of the noise of a channel, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub enum Component {
    /// A term with its coefficient. Flicker noise has its exact statistics, and its samples are kept in memory.
    Term(Term, f64),
    /// Flicker noise of the bias instability B by a bank of poles, which needs hardly any memory.
    PoleBank(f64),
    /// Sampled white noise after a filter: x' = A x + L w; the output is the first state times `scale`.
    Filtered {
        /// Factor of the output.
        scale: f64,
        /// A, row by row.
        transition: Vec<f64>,
        /// L, row by row; L Lᵀ is the covariance of the noise that a step adds.
        noise: Vec<f64>,
        /// L for the state at the start.
        start: Vec<f64>,
    },
    /// A first-order Gauss-Markov process.
    GaussMarkov {
        /// Standard deviation.
        sigma: f64,
        /// Correlation time, in seconds.
        time: f64,
        /// Number of the process in the channel.
        index: u32,
    },
    /// A sinusoid of random phase.
    Sinusoid {
        /// Amplitude.
        amplitude: f64,
        /// Frequency in Hz.
        frequency: f64,
        /// Number of the sinusoid in the channel.
        index: u32,
    },
}

impl Component {
    /// Index of the random stream: each part has a separate one, so that a new part does not change the draws of the others.
    fn stream(&self) -> u64 {
        match self {
            // A ramp has no random numbers.
            Self::Term(Term::RateRamp, _) => 0,
            Self::Term(term, _) => term.index() as u64,
            Self::PoleBank(_) => Term::BiasInstability.index() as u64,
            Self::Filtered { .. } => Term::RandomWalk.index() as u64,
            Self::GaussMarkov { index, .. } => 1 << 32 | u64::from(*index),
            Self::Sinusoid { index, .. } => 2 << 32 | u64::from(*index),
        }
    }
}

/// Number of samples made together, so that their random numbers stay in the nearest cache.
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

    /// Adds a component, with the random numbers of a `channel`: the same seed and channel give the same noise.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a value out of its range, [`Error::Length`] for matrices of unequal size.
    pub fn add(&mut self, component: &Component, channel: u64) -> Result<(), Error> {
        let tau0 = self.tau0;
        let draws = Draws::new(self.seed, channel, component.stream());
        let source: Box<dyn Source> = match *component {
            Component::Term(term, coefficient) => {
                finite(term.name(), coefficient)?;
                self.source_of(term, coefficient, draws)
            }
            Component::PoleBank(b) => {
                finite(Term::BiasInstability.name(), b)?;
                Box::new(Bank::new(self.n, b, draws))
            }
            Component::Filtered { scale, ref transition, ref noise, ref start } => {
                finite("scale", scale)?;
                Box::new(Filtered::new(scale, transition, noise, start, draws)?)
            }
            Component::GaussMarkov { sigma, time, .. } => {
                finite("sigma", sigma)?;
                positive("time", time)?;
                Box::new(GaussMarkov::new(sigma, tau0 / time, draws))
            }
            Component::Sinusoid { amplitude, frequency, .. } => {
                finite("amplitude", amplitude)?;
                positive("frequency", frequency)?;
                Box::new(Sinusoid::new(amplitude, frequency * tau0, draws))
            }
        };
        self.sources.push(source);
        Ok(())
    }

    /// The samples of a term.
    fn source_of(&self, term: Term, coefficient: f64, mut draws: Draws) -> Box<dyn Source> {
        let tau0 = self.tau0;
        match term {
            Term::Quantization => {
                let before = draws.normal();
                Box::new(Quantization { gain: coefficient / tau0, before, draws })
            }
            Term::RandomWalk => Box::new(White { sigma: coefficient / tau0.sqrt(), draws }),
            Term::BiasInstability => {
                Box::new(Stored { samples: flicker(self.n, coefficient, draws.generator()), at: 0 })
            }
            Term::RateRandomWalk => Box::new(Walk { sigma: coefficient * tau0.sqrt(), level: 0.0, draws }),
            Term::RateRamp => Box::new(Ramp { step: coefficient * tau0, at: 0 }),
        }
    }

    /// Number of samples still to be generated.
    #[must_use]
    pub fn left(&self) -> usize {
        self.n - self.made
    }

    /// The next samples, terms in the order in which they were added.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] for more samples than remain.
    pub fn fill(&mut self, rate: &mut [f64]) -> Result<(), Error> {
        if rate.len() > self.left() {
            return Err(Error::Length { expected: self.left(), got: rate.len() });
        }
        for block in rate.chunks_mut(BLOCK) {
            // Initial value of a sum that preserves the sign of zero.
            block.fill(-0.0);
            for source in &mut self.sources {
                source.add(block);
            }
        }
        self.made += rate.len();
        Ok(())
    }
}

/// Simulates `n` rate samples of terms with coefficients in SI units, which are added in their order; all but the ramp are
/// ≥ 0. The same `seed` and `stream` give the same record; streams of a seed are independent.
///
/// # Errors
///
/// [`Error::Parameter`] for a `tau0` that is not positive, or a coefficient out of its range.
pub fn simulate(
    n: usize,
    tau0: f64,
    terms: &[(Term, f64)],
    seed: u64,
    stream: u64,
) -> Result<Vec<f64>, Error> {
    let mut generator = Generator::new(n, tau0, seed)?;
    for &(term, coefficient) in terms {
        if term != Term::RateRamp && (coefficient.is_nan() || coefficient < 0.0) {
            return Err(Error::Parameter { name: term.name(), value: coefficient });
        }
        generator.add(&Component::Term(term, coefficient), stream)?;
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
