//! The Hadamard variance, 1 / (6τ²) times the mean square of third differences of the phase: NIST SP 1065, eqs. (17)
//! and (19). A constant rate and its linear drift have no effect.

use super::thirds::{Correction, Curve, sums_of_squares, third_of_sums};
use crate::compensated::Sum;
use crate::deviations::deviation::Deviation;
use crate::parallel::prelude::*;
use crate::phase::Phase;

/// The mean over all N + 1 − 3m third differences.
pub(super) fn overlapping(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let sums = sums_of_squares(phase, m);
    m.iter().zip(sums).map(|(&m, sum)| deviation(m, phase.samples() + 1 - 3 * m, sum)).collect()
}

/// Squared differences of each whole cluster, k·m … (k + 1)·m − 1, and the next two.
pub(super) fn disjoint(phase: &Phase, m: &[usize]) -> Vec<Deviation> {
    let of_size = |&m: &usize| {
        let terms = phase.samples() / m - 2;
        let mut sum = Sum::default();
        for term in 0..terms {
            let d = third_difference(phase, term * m, m);
            sum.add(d * d);
        }
        deviation(m, terms, sum.value())
    };
    m.par_iter().map(of_size).collect()
}

fn deviation(m: usize, terms: usize, sum_of_squares: f64) -> Deviation {
    let size = m as f64;
    Deviation { m, deviation: (sum_of_squares / (6.0 * terms as f64)).sqrt() / size, terms }
}

fn third_difference(phase: &Phase, k: usize, m: usize) -> f64 {
    let [x, y, z, w] = std::array::from_fn(|i| phase.values[k + i * m]);
    let Constant(anchors) = phase.correction(std::array::from_fn(|i| phase.origin(k + i * m)));
    (w - x) + 3.0 * (y - z) + anchors
}

/// A correction that is the same for all starts of a window.
#[derive(Clone, Copy)]
pub struct Constant(f64);

impl Correction for Constant {
    #[inline(always)]
    #[allow(clippy::inline_always)] // The loop that calls it is only fast if this is inlined.
    fn at(self, _: f64) -> f64 {
        self.0
    }
}

impl Curve for Phase {
    /// Number of the block whose anchor is the origin.
    type Origin = usize;
    type Correction = Constant;

    fn values(&self) -> &[f64] {
        &self.values
    }

    fn block(&self) -> usize {
        self.block
    }

    fn origin(&self, point: usize) -> usize {
        point / self.block
    }

    fn correction(&self, blocks: [usize; 4]) -> Constant {
        if blocks[0] == blocks[3] {
            return Constant(0.0);
        }
        Constant(third_of_sums(blocks.map(|block| self.anchors[block])))
    }

    fn lift(&self, point: usize, window: &mut [f64]) {
        let border = self.block - point % self.block;
        if border < window.len() {
            let step = self.step_to(point / self.block + 1);
            for value in &mut window[border..] {
                *value += step;
            }
        }
    }
}
