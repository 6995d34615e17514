//! A simulated record as a sum of unit noises, which are kept: a slider of a coefficient only changes a factor.

use crate::model::{Model, PARTS, PROCESS};
use sigmatau_core::error::Error;
use sigmatau_core::generate::{Component, Generator};
use sigmatau_core::terms::Term;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// FNV-1a hash of `gyro_x`: the random numbers are those of this channel in `sigmatau.simulate`.
const CHANNEL: u64 = 0x015a_5859;

/// What the samples of a unit noise depend on: number of samples, seed, and up to two parameters.
type Key = (usize, u64, u64, u64);

/// The unit noises of a record.
#[derive(Default)]
pub struct Units {
    parts: [Option<(Key, Vec<f64>)>; PARTS],
}

impl Units {
    /// The record of a model, `n` samples.
    ///
    /// # Errors
    ///
    /// [`Error`] for a parameter out of its range.
    pub fn record(&mut self, model: &Model, n: usize, seed: u64) -> Result<Vec<f64>, Error> {
        let mut rate = vec![0.0; n];
        // The ramp first, in the order of `sigmatau.simulate`.
        let order = [Term::RateRamp].into_iter().chain(Term::NOISE).map(Term::index).chain([PROCESS]);
        for part in order {
            let factor = factor(model, part);
            if factor == 0.0 {
                continue;
            }
            let unit = self.unit(model, part, n, seed)?;
            rate.iter_mut().zip(unit).for_each(|(rate, unit)| *rate += factor * unit);
        }
        Ok(rate)
    }

    fn unit(&mut self, model: &Model, part: usize, n: usize, seed: u64) -> Result<&[f64], Error> {
        let (first, second) = match part {
            PROCESS => (model.time / model.tau0, 0.0),
            part if part == Term::RandomWalk.index() && model.order > 0 => {
                (model.corner * model.tau0, f64::from(model.order))
            }
            _ => (0.0, 0.0),
        };
        let key = (n, seed, first.to_bits(), second.to_bits());
        let place = &mut self.parts[part];
        if place.as_ref().is_none_or(|(of, _)| *of != key) {
            let mut samples = vec![0.0; n];
            let mut generator = Generator::new(n, 1.0, seed)?;
            generator.add(&component(model, part), CHANNEL)?;
            generator.fill(&mut samples)?;
            *place = Some((key, samples));
        }
        Ok(place.as_ref().map_or(&[], |(_, samples)| samples))
    }
}

/// Factor of the unit noise of a part.
fn factor(model: &Model, part: usize) -> f64 {
    let tau0 = model.tau0;
    if part == PROCESS {
        return model.sigma;
    }
    let coefficient = model.terms[part];
    match Term::ALL[part] {
        Term::Quantization => coefficient / tau0,
        Term::RandomWalk if model.order > 0 => coefficient * (2.0 * PI * model.corner).sqrt(),
        Term::RandomWalk => coefficient / tau0.sqrt(),
        Term::BiasInstability => coefficient,
        Term::RateRandomWalk => coefficient * tau0.sqrt(),
        Term::RateRamp => coefficient * tau0,
    }
}

/// The unit noise of a part for a sample interval of 1.
fn component(model: &Model, part: usize) -> Component {
    if part == PROCESS {
        return Component::GaussMarkov { sigma: 1.0, time: model.time / model.tau0, index: 0 };
    }
    let term = Term::ALL[part];
    match model.order {
        order @ 1.. if term == Term::RandomWalk => filtered(order, 2.0 * PI * model.corner * model.tau0),
        _ => Component::Term(term, 1.0),
    }
}

/// White noise after a Butterworth filter of order 1 or 2, for the density 1 and a corner of 1 rad/s. `angle` is the corner
/// times the sample interval.
///
/// The states of order 2 are the output y and its derivative ẏ, which are independent and have the same variance.
fn filtered(order: u8, angle: f64) -> Component {
    if order == 1 {
        let decay = (-angle).exp();
        let sigma = FRAC_1_SQRT_2;
        let noise = sigma * (-(-2.0 * angle).exp_m1()).sqrt();
        return Component::Filtered {
            scale: 1.0,
            transition: vec![decay],
            noise: vec![noise],
            start: vec![sigma],
        };
    }
    // ÿ + √2 ẏ + y = w: decay and frequency are 1/√2, the stationary variance is 1 / (2√2).
    let (sin, cos) = (angle * FRAC_1_SQRT_2).sin_cos();
    let decay = (-angle * FRAC_1_SQRT_2).exp();
    let transition = vec![
        decay * (cos + sin),
        decay * sin * std::f64::consts::SQRT_2,
        -decay * sin * std::f64::consts::SQRT_2,
        decay * (cos - sin),
    ];
    let variance = 0.5 * FRAC_1_SQRT_2;
    let [a, b, c, d] = std::array::from_fn(|k| transition[k]);
    // Cholesky factor of the variance times I − Φ Φᵀ.
    let first = (variance * (1.0 - a * a - b * b)).max(0.0).sqrt();
    let mixed = if first > 0.0 { -variance * (a * c + b * d) / first } else { 0.0 };
    let second = (variance * (1.0 - c * c - d * d) - mixed * mixed).max(0.0).sqrt();
    let sigma = variance.sqrt();
    Component::Filtered {
        scale: 1.0,
        transition,
        noise: vec![first, 0.0, mixed, second],
        start: vec![sigma, 0.0, 0.0, sigma],
    }
}

/// Smallest and largest sample of each of `columns` stretches, in turn.
#[must_use]
pub fn envelope(rate: &[f64], columns: usize) -> Vec<f64> {
    let (n, columns) = (rate.len(), columns.min(rate.len()).max(1));
    (0..columns)
        .flat_map(|k| {
            let stretch = &rate[k * n / columns..((k + 1) * n / columns).max(k * n / columns + 1)];
            let low = stretch.iter().copied().fold(f64::INFINITY, f64::min);
            let high = stretch.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            [low, high]
        })
        .collect()
}
