//! Generators of noise other than the five terms: Gauss-Markov processes, sinusoids, filtered white noise.

use crate::draws::{Draws, Source};
use crate::error::Error;
use std::f64::consts::TAU;

/// First-order Gauss-Markov process, stationary from its first sample.
pub(crate) struct GaussMarkov {
    kept: f64,
    added: f64,
    level: f64,
    draws: Draws,
}

impl GaussMarkov {
    /// `ratio` is the sample interval over the correlation time.
    pub(crate) fn new(sigma: f64, ratio: f64, mut draws: Draws) -> Self {
        let kept = (-ratio).exp();
        let added = sigma * (-(-2.0 * ratio).exp_m1()).sqrt();
        let level = sigma * draws.normal();
        Self { kept, added, level, draws }
    }
}

impl Source for GaussMarkov {
    fn add(&mut self, rate: &mut [f64]) {
        for y in rate {
            *y += self.level;
            self.level = self.kept * self.level + self.added * self.draws.normal();
        }
    }
}

/// Sinusoid whose phase is counted in units of 2⁻⁶⁴ turns, so that it does not drift.
pub(crate) struct Sinusoid {
    amplitude: f64,
    phase: u64,
    step: u64,
}

/// Turns in the units of the phase, without whole turns.
fn turns(value: f64) -> u64 {
    const UNITS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;
    // A fraction that rounds up to a whole turn is 0.
    ((value - value.floor()) * UNITS_PER_TURN) as u128 as u64
}

impl Sinusoid {
    /// `step` is in turns per sample.
    pub(crate) fn new(amplitude: f64, step: f64, mut draws: Draws) -> Self {
        // The direction of two normal deviates is uniform.
        let (x, y) = (draws.normal(), draws.normal());
        Self { amplitude, phase: turns(y.atan2(x) / TAU), step: turns(step) }
    }
}

impl Source for Sinusoid {
    fn add(&mut self, rate: &mut [f64]) {
        const TURN: f64 = TAU / 18_446_744_073_709_551_616.0;
        for y in rate {
            // As a signed number it is within half a turn of 0.
            *y += self.amplitude * (TURN * self.phase as i64 as f64).sin();
            self.phase = self.phase.wrapping_add(self.step);
        }
    }
}

/// White noise after a filter: x' = A x + L w, stationary from its first sample; the output is the first state.
pub(crate) struct Filtered {
    scale: f64,
    transition: Vec<f64>,
    noise: Vec<f64>,
    state: Vec<f64>,
    next: Vec<f64>,
    drawn: Vec<f64>,
    draws: Draws,
}

impl Filtered {
    pub(crate) fn new(
        scale: f64,
        transition: &[f64],
        noise: &[f64],
        start: &[f64],
        mut draws: Draws,
    ) -> Result<Self, Error> {
        let order = transition.len().isqrt();
        for matrix in [transition, noise, start] {
            if matrix.len() != order * order || order == 0 {
                return Err(Error::Length { expected: order * order, got: matrix.len() });
            }
        }
        let drawn: Vec<f64> = (0..order).map(|_| draws.normal()).collect();
        let state = start.chunks_exact(order).map(|row| dot(row, &drawn)).collect();
        Ok(Self {
            scale,
            transition: transition.to_vec(),
            noise: noise.to_vec(),
            state,
            next: vec![0.0; order],
            drawn,
            draws,
        })
    }
}

impl Source for Filtered {
    fn add(&mut self, rate: &mut [f64]) {
        let order = self.state.len();
        for y in rate {
            *y += self.scale * self.state[0];
            for w in &mut self.drawn {
                *w = self.draws.normal();
            }
            let rows = self.transition.chunks_exact(order).zip(self.noise.chunks_exact(order));
            for (x, (a, l)) in self.next.iter_mut().zip(rows) {
                *x = dot(a, &self.state) + dot(l, &self.drawn);
            }
            std::mem::swap(&mut self.state, &mut self.next);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
