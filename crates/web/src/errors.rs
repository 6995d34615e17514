//! The exact error of an Allan deviation for a given noise, and the length of record that it needs.

use crate::model::{Model, PARTS};
use sigmatau_core::covariance::{Component, Gamma, variances};
use sigmatau_core::distributions::gamma_quantile;
use sigmatau_core::error::Error;
use sigmatau_core::gls::{Components, Failed, LINEAR, Shape, Theta, detectable};
use sigmatau_core::terms::{NOISE_TERMS, Term};

/// Longest record that is considered; each search takes seconds where none is found. [samples]
const LONGEST: usize = 100_000_000;

/// Shortest record that is considered, and the ratio of the record to its longest averaging time: those of `sigmatau plan`.
const SHORTEST: usize = 64;
const LONGEST_SHARE: usize = 3;

/// Ratio of lengths at which a search ends; two digits suffice.
const STEP: f64 = 1.02;

const LEVEL: f64 = 0.95;

/// The tensors of a grid of cluster sizes, which do not depend on the coefficients.
#[derive(Default)]
pub struct Tensors {
    key: Option<(usize, Vec<usize>, [Component; PARTS - 1])>,
    gammas: Vec<Gamma>,
}

/// Squares of the coefficients of the noise, the last of the process; the ramp is separate.
fn squares(model: &Model) -> [f64; PARTS - 1] {
    let mut theta = [0.0; PARTS - 1];
    for term in Term::NOISE {
        theta[term.index()] = model.coefficient(term).powi(2);
    }
    theta[NOISE_TERMS] = model.sigma.powi(2);
    theta
}

fn components(model: &Model) -> [Component; PARTS - 1] {
    let mut parts = [Component::GaussMarkov { tc: model.time / model.tau0 }; PARTS - 1];
    for term in Term::NOISE {
        parts[term.index()] = Component::Term(term);
    }
    if model.order > 0 {
        let corner = model.corner * model.tau0;
        parts[Term::RandomWalk.index()] = Component::LowPassed { order: model.order, corner };
    }
    parts
}

impl Tensors {
    /// For each cluster size: degrees of freedom of the overlapped variance, and the factors on a measured deviation that
    /// give the ends of its 95 % interval.
    ///
    /// # Errors
    ///
    /// [`Error`] for a size that leaves no pair.
    pub fn freedom(&mut self, model: &Model, n: usize, sizes: &[usize]) -> Result<Vec<f64>, Error> {
        let terms = components(model);
        let key = (n, sizes.to_vec(), terms);
        if self.key.as_ref() != Some(&key) {
            self.gammas =
                sizes.iter().map(|&m| Gamma::new(n, &[m], &terms)).collect::<Result<Vec<_>, _>>()?;
            self.key = Some(key);
        }
        let (theta, ramp) = (squares(model), model.coefficient(Term::RateRamp));
        let mut rows = Vec::new();
        for gamma in &self.gammas {
            let edf = gamma.clone().at_interval(model.tau0)?.edf(&theta, ramp)[0];
            let factor = |side: f64| (0.5 * edf / gamma_quantile(0.5 * edf, 0.5 + side * 0.5 * LEVEL)).sqrt();
            rows.extend([edf, factor(1.0), factor(-1.0)]);
        }
        Ok(rows)
    }
}

/// Coefficients squared for a sample interval of 1.
fn in_samples(model: &Model) -> [f64; PARTS - 1] {
    let mut theta = squares(model);
    for term in Term::NOISE {
        theta[term.index()] *= model.tau0.powi(term.interval_power() - 2);
    }
    theta
}

/// Samples of the shortest record whose deviation at the cluster size `m` has at most a relative standard error; None above
/// [`LONGEST`].
#[must_use]
pub fn samples_for_error(model: &Model, m: usize, error: f64) -> Option<usize> {
    let (terms, theta) = (components(model), in_samples(model));
    let ramp = model.coefficient(Term::RateRamp) * model.tau0;
    let avar = crate::model::total(&model.avar(&[m]), 1)[0];
    let exact = |n: usize| {
        let variance = variances(n, &[m], &terms, &theta, ramp).map_or(f64::INFINITY, |all| all[0]);
        0.5 * variance.sqrt() / avar
    };
    shortest((2 * m).max(4), |n| exact(n) <= error)
}

/// Samples of the shortest record that shows a noise term of the model with a probability, as `sigmatau plan` computes
/// them; None above [`LONGEST`]. Not for the bias instability, which must also be told apart from Gauss-Markov processes.
#[must_use]
pub fn samples_to_show(model: &Model, term: Term, power: f64) -> Option<usize> {
    let mut theta: Theta = [0.0; LINEAR + 1];
    theta.copy_from_slice(&in_samples(model));
    let wanted = theta[term.index()];
    theta[term.index()] = 0.0;
    if theta.iter().all(|&square| square == 0.0) || wanted == 0.0 {
        return None;
    }
    let process = (model.sigma > 0.0).then_some(Shape::GaussMarkov(model.time / model.tau0));
    shortest(SHORTEST, |n| {
        smallest_square(n, term, &theta, process, power).is_ok_and(|square| square <= wanted)
    })
}

/// The smallest square of a term that a record of `n` samples shows.
fn smallest_square(
    n: usize,
    term: Term,
    theta: &Theta,
    process: Option<Shape>,
    power: f64,
) -> Result<f64, Failed> {
    let largest = n / LONGEST_SHARE;
    let mut sizes: Vec<usize> =
        (0..=largest.ilog2()).flat_map(|j| [1 << j, 3 << j]).filter(|&size| size <= largest).collect();
    sizes.sort_unstable();
    let parts = Components::new(n, &sizes, process).map_err(|_| Failed)?;
    let expected = |k: usize| (0..parts.terms()).map(|p| theta[p] * parts.design(p)[k]).sum::<f64>();
    let mut avar: Vec<f64> = (0..sizes.len()).map(expected).collect();
    avar.sort_unstable_by(f64::total_cmp);
    let scale = f64::midpoint(avar[(avar.len() - 1) / 2], avar[avar.len() / 2]);
    let scaled = theta.map(|square| square / scale);
    detectable(&parts, term.index(), &scaled, LEVEL, power).map(|square| square * scale)
}

/// The shortest record for which `suffices` holds, to two digits.
fn shortest(from: usize, suffices: impl Fn(usize) -> bool) -> Option<usize> {
    let (mut low, mut high) = (from, from);
    while !suffices(high) {
        (low, high) = (high, 4 * high);
        if high > LONGEST {
            return None;
        }
    }
    while high as f64 > STEP * low as f64 {
        let middle = (low as f64 * high as f64).sqrt().round() as usize;
        if suffices(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}
