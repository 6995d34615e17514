//! The fit of a model: Fisher scoring on Σ ν (ln S + I/S), parameters of parts ≥ 0.

use crate::likelihood::bins::{Bins, MAX_FILTER, Products};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::linear::{Symmetric, bounded_step, dots};
use crate::likelihood::model::{Model, Shape};
use crate::likelihood::power_law::EXPONENTS;
use crate::likelihood::regression::regressed;
use crate::matern::SMOOTHNESS;
use crate::terms::NOISE_TERMS;
use std::sync::Arc;

const STEPS: usize = 40;
const HALVINGS: usize = 12;
const STEP_REDUCTION: f64 = 0.4;

/// Reduction of the deviance at which a fit ends.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Largest step of the logarithm of a shape, and of a coefficient of the filter.
const SHAPE_STEP: f64 = 0.7;
const FILTER_STEP: f64 = 1.5;

/// Largest step of the logarithm of a level.
const LEVEL_STEP: f64 = 1.0;

/// A fitted model.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub model: Model,
    /// Expected densities by bin.
    pub spectrum: Vec<f64>,
    /// Measured densities by bin, without the regressors.
    pub powers: Vec<f64>,
    pub deviance: f64,
    /// Part of the deviance from the regressors (restricted likelihood).
    pub restricted: f64,
    pub beta: Vec<f64>,
    pub beta_covariance: Symmetric,
    /// Degrees of freedom of each bin that the regressors use.
    pub leverage: Vec<f64>,
    /// Derivative of the log-likelihood with respect to Q² from the end values of the angle, whose variance is Q², for each
    /// run.
    pub slope_of_ends: Vec<f64>,
    /// Products of this set of regressors, shared by later fits.
    products: Arc<Vec<Products>>,
}

impl Model {
    /// Initial parameters of a fit, by non-negative least squares with weights that no bin dominates.
    fn start(&mut self, bins: &Bins) {
        const MAX_WEIGHT: f64 = 10.0;
        const MIN_DENSITY_SHARE: f64 = 0.05; // share of the usual density at which the weight of a bin is limited
        let n = self.parts.len();
        let powers = bins.plain_powers();
        let usual = bins.scale;
        // A filter of known shape is close enough to the true filter to determine which noise is filtered.
        let behind = self.family.map(|_| self.response_means(bins));
        let column = |&part: &Part| match behind.as_ref().filter(|_| self.filters(part)) {
            Some(behind) => bins.unit(part).iter().zip(behind).map(|(c, h)| c * h).collect(),
            None => bins.unit(part),
        };
        let columns: Vec<Vec<f64>> = self.parts.iter().map(column).collect();
        let weights: Vec<f64> = (0..bins.len())
            .map(|i| bins.weight(i).sqrt().min(MAX_WEIGHT) / (powers[i] + MIN_DENSITY_SHARE * usual))
            .collect();
        let mut squares = Symmetric::zero(n);
        let weighted: Vec<Vec<f64>> =
            columns.iter().map(|c| c.iter().zip(&weights).map(|(c, w)| c * w).collect()).collect();
        let target: Vec<f64> = powers.iter().zip(&weights).map(|(p, w)| p * w).collect();
        for i in 0..n {
            for (j, product) in dots(&weighted[..=i], &weighted[i]).into_iter().enumerate() {
                squares.set(i, j, product);
            }
        }
        let right = dots(&weighted, &target);
        let found = bounded_step(&squares, &right, &vec![0.0; n], &vec![false; n]);
        let scale = squares.scales();
        self.theta = found.iter().zip(&scale).map(|(x, s)| x.max(1e-12 / s)).collect();
    }

    /// Fits the model.
    pub(crate) fn fit(self, bins: &Bins) -> Fit {
        self.fit_within(bins, STEPS, TOLERANCE, None)
    }

    /// The model without a step of the fit.
    pub(crate) fn at(self, bins: &Bins) -> Fit {
        self.fit_within(bins, 0, TOLERANCE, None)
    }

    /// The fit from a neighbour with the same regressors.
    pub(crate) fn refit(self, bins: &Bins, steps: usize, tolerance: f64, from: &Fit) -> Fit {
        let products = (from.model.regressors == self.regressors).then(|| from.products.clone());
        self.fit_within(bins, steps, tolerance, products)
    }

    fn fit_within(
        mut self,
        bins: &Bins,
        steps: usize,
        tolerance: f64,
        products: Option<Arc<Vec<Products>>>,
    ) -> Fit {
        if self.theta.len() != self.parts.len() {
            self.start(bins);
        }
        let products = products.unwrap_or_else(|| Arc::new(bins.products_of(&self.regressors)));
        let weights: Vec<f64> = (0..bins.len()).map(|i| bins.weight(i)).collect();
        let (spectrum, mut slopes) = self.with_slopes(bins);
        let mut fit = Fit::of(self, spectrum, bins, products, &weights);
        for remaining in (0..steps).rev() {
            let step = fit.step(&slopes, &weights, bins);
            let mut length = 1.0;
            let mut better = None;
            for _ in 0..HALVINGS {
                let model = fit.model.moved(&step, length, bins);
                let (spectrum, evaluated) = model.evaluated(bins);
                let next = Fit::of(model, spectrum, bins, fit.products.clone(), &weights);
                if next.deviance <= fit.deviance + 1e-9 {
                    better = Some((next, evaluated));
                    break;
                }
                length *= STEP_REDUCTION;
            }
            let Some((next, evaluated)) = better else { break };
            let gain = fit.deviance - next.deviance;
            fit = next;
            if gain < tolerance || remaining == 0 {
                break;
            }
            slopes = fit.model.slopes(bins, &fit.spectrum, evaluated);
        }
        fit
    }

    /// The model after a share of a step, within the limits of shapes.
    fn moved(&self, step: &[f64], length: f64, bins: &Bins) -> Self {
        let mut model = self.clone();
        let n = self.parts.len();
        for (theta, d) in model.theta.iter_mut().zip(step) {
            *theta = (*theta + length * d).max(0.0);
        }
        for (a, d) in model.filter.iter_mut().zip(&step[n..]) {
            *a += length * d;
        }
        if let Some(family) = model.family {
            family.clamp_parameters(&mut model.filter);
        }
        let mut rest = step[n + self.filter.len() + self.shapes().len()..].iter();
        for (log, d) in model.levels.iter_mut().flat_map(|level| level.logs.iter_mut()).zip(&mut rest) {
            *log += length * d;
        }
        for (own, d) in model.own.iter_mut().zip(rest) {
            own.theta = (own.theta + length * d).max(0.0);
        }
        let (duration, tau0) = (bins.record.duration(), bins.record.tau0);
        for ((j, shape), d) in self.shapes().into_iter().zip(&step[n + self.filter.len()..]) {
            let x = length * d;
            model.parts[j] = match (model.parts[j], shape) {
                (Part::GaussMarkov { time }, _) => {
                    let (shortest, longest) = time_limits(bins);
                    Part::GaussMarkov { time: (time * x.exp()).clamp(shortest, longest) }
                }
                (Part::Matern { time, smoothness }, Shape::Time) => {
                    let (shortest, longest) = time_limits(bins);
                    Part::Matern { time: (time * x.exp()).clamp(shortest, longest), smoothness }
                }
                (Part::Matern { time, smoothness }, _) => {
                    Part::Matern { time, smoothness: (smoothness + x).clamp(SMOOTHNESS.0, SMOOTHNESS.1) }
                }
                (Part::Resonance { frequency, width }, Shape::Frequency) => {
                    let frequency = (frequency + x * width).clamp(2.0 / duration, 0.5 / tau0);
                    Part::Resonance { frequency, width: width.max(bins.least_width(frequency)) }
                }
                (Part::Resonance { frequency, width }, _) => {
                    let least = bins.least_width(frequency);
                    let width = (width * x.exp()).clamp(least, (0.25 * frequency).max(least));
                    Part::Resonance { frequency, width }
                }
                (Part::Flicker { exponent, pivot }, _) => {
                    Part::Flicker { exponent: (exponent + x).clamp(EXPONENTS.0, EXPONENTS.1), pivot }
                }
                (part, _) => part,
            };
        }
        model
    }
}

impl Fit {
    fn of(
        model: Model,
        spectrum: Vec<f64>,
        bins: &Bins,
        products: Arc<Vec<Products>>,
        weights: &[f64],
    ) -> Self {
        let (found, powers) = regressed(&model, &spectrum, bins, &products);
        let mut deviance = found.restricted + found.squares_of_ends;
        for ((s, i), nu) in spectrum.iter().zip(&powers).zip(weights) {
            deviance += nu * (s.ln() + i / s);
        }
        // With missing samples the density behind a filter can be negative in a bin, and its logarithm is NaN: a model
        // without a likelihood.
        if deviance.is_nan() {
            deviance = f64::INFINITY;
        }
        for level in &model.levels {
            deviance += level.logs.iter().map(|x| (x / level.spread).powi(2)).sum::<f64>();
        }
        Self {
            model,
            spectrum,
            powers,
            deviance,
            restricted: found.restricted,
            beta: found.beta,
            beta_covariance: found.covariance,
            leverage: found.leverage,
            slope_of_ends: found.slope_of_ends,
            products,
        }
    }

    /// Measured over expected densities, minus 1.
    pub(crate) fn excess(&self) -> Vec<f64> {
        self.powers.iter().zip(&self.spectrum).map(|(i, s)| i / s - 1.0).collect()
    }

    fn step(&self, slopes: &[Vec<f64>], weights: &[f64], bins: &Bins) -> Vec<f64> {
        let information = self.with_levels(information(slopes, weights));
        let excess = self.excess();
        let mut pull: Vec<f64> = excess.iter().zip(weights).map(|(e, nu)| 0.5 * nu * e).collect();
        pull.iter_mut().zip(&self.leverage).for_each(|(p, h)| *p += 0.5 * h);
        let mut gradient = dots(slopes, &pull);
        let (n, q) = (self.model.parts.len(), self.model.filter.len());
        let shapes = self.model.shapes();
        let first = n + q + shapes.len();
        let levels: Vec<(f64, f64)> = self.levels().collect();
        for (g, (log, weight)) in gradient[first..].iter_mut().zip(&levels) {
            *g -= log * weight;
        }
        self.add_ends(&mut gradient, first);
        let mut least: Vec<f64> = self.model.theta.iter().map(|t| -t).collect();
        least.extend(vec![-FILTER_STEP; q]);
        least.extend(vec![-SHAPE_STEP; shapes.len()]);
        least.extend(vec![-LEVEL_STEP; levels.len()]);
        least.extend(self.model.own.iter().map(|own| -own.theta));
        let mut held = vec![false; least.len()];
        if let Some(j) = self.model.held {
            held[j] = true;
        }
        for (k, &shape) in shapes.iter().enumerate() {
            held[n + q + k] = self.model.held_shape == Some(shape) || self.model.theta[shape.0] <= 0.0;
        }
        debug_assert!(q <= MAX_FILTER && bins.len() == excess.len());
        let mut step = bounded_step(&information, &gradient, &least, &held);
        // A shape stays at the end of its range, and the other parameters take the step of a model that has it there.
        let leaving: Vec<usize> = (0..shapes.len())
            .filter(|&k| leaves_range(self.model.parts[shapes[k].0], shapes[k].1, step[n + q + k], bins))
            .collect();
        if !leaving.is_empty() {
            for k in leaving {
                held[n + q + k] = true;
            }
            step = bounded_step(&information, &gradient, &least, &held);
        }
        let most = if self.model.family.is_some() { SHAPE_STEP } else { FILTER_STEP };
        step[n..n + q].iter_mut().for_each(|d| *d = d.clamp(-most, most));
        step[n + q..first].iter_mut().for_each(|d| *d = d.clamp(-SHAPE_STEP, SHAPE_STEP));
        step[first..first + levels.len()].iter_mut().for_each(|d| *d = d.clamp(-LEVEL_STEP, LEVEL_STEP));
        step
    }

    /// Fisher information of theta, filter and shapes, of levels and separate terms, and the derivatives from which it is
    /// computed.
    pub(crate) fn information(&self, bins: &Bins) -> (Symmetric, Vec<Vec<f64>>) {
        let weights: Vec<f64> = (0..bins.len()).map(|i| bins.weight(i)).collect();
        let slopes = self.model.with_slopes(bins).1;
        (self.with_levels(information(&slopes, &weights)), slopes)
    }

    /// The rise of the deviance without one part, and the fit without it.
    pub(crate) fn removal_loss(&self, part: usize, bins: &Bins) -> (f64, Fit) {
        let fit = self.model.without(part).refit(bins, STEPS, TOLERANCE, self);
        (fit.deviance - self.deviance, fit)
    }
}

/// Whether a step leads out of the range of a parameter of a Matérn process, at an end of the range.
fn leaves_range(part: Part, shape: Shape, step: f64, bins: &Bins) -> bool {
    let Part::Matern { time, smoothness } = part else { return false };
    let (value, (low, high)) =
        if shape == Shape::Time { (time, time_limits(bins)) } else { (smoothness, SMOOTHNESS) };
    (value <= low && step < 0.0) || (value >= high && step > 0.0)
}

/// Half of `JᵀνJ`.
pub(crate) fn information(slopes: &[Vec<f64>], weights: &[f64]) -> Symmetric {
    let mut found = Symmetric::zero(slopes.len());
    for (i, column) in slopes.iter().enumerate() {
        let weighted: Vec<f64> = column.iter().zip(weights).map(|(c, nu)| 0.5 * nu * c).collect();
        for (j, product) in dots(&slopes[..=i], &weighted).into_iter().enumerate() {
            found.set(i, j, product);
        }
    }
    found
}

/// Limits of correlation times: shorter ones are equivalent to a filter, longer ones to a rate random walk. \[s\]
pub(crate) fn time_limits(bins: &Bins) -> (f64, f64) {
    let shortest = 20.0 * bins.record.tau0;
    (shortest, (0.25 * bins.record.duration()).max(shortest))
}

/// Squares of the four terms of a model.
pub(crate) fn squares(fit: &Fit) -> [f64; NOISE_TERMS] {
    TERMS.map(|part| fit.model.index(part).map_or(0.0, |j| fit.model.theta[j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::summary::Summary;
    use crate::terms::Term;

    #[test]
    fn a_negative_density_has_no_likelihood() {
        let x: Vec<f64> = (0..4096).map(|i| f64::from((i * 7919) % 1013) - 506.0).collect();
        let record = Summary::of(&x, 0.01).unwrap();
        let bins = Bins::new(&record, Arc::new(vec![true; record.density.len()]), Arc::new(Vec::new()));
        let white = Model::new(vec![Part::Term(Term::RandomWalk)], Vec::new()).fit(&bins);
        assert!(white.deviance.is_finite());
        let weights: Vec<f64> = (0..bins.len()).map(|i| bins.weight(i)).collect();
        let mut spectrum = white.spectrum.clone();
        spectrum[3] *= -1e-9;
        let negative = Fit::of(white.model.clone(), spectrum, &bins, white.products.clone(), &weights);
        assert!(negative.deviance.is_infinite());
        let fits = [negative, white];
        let least = fits.iter().min_by(|a, b| a.deviance.total_cmp(&b.deviance)).unwrap();
        assert!(least.deviance.is_finite());
    }
}
