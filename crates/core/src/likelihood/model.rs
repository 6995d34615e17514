//! A model of the density of a channel, and its fit: Fisher scoring on Σ ν (ln S + I/S), parameters of parts ≥ 0.

use crate::likelihood::bins::{Bins, MOST_FILTER, Products};
use crate::likelihood::expected::{FinePoint, Part};
use crate::likelihood::filter_shapes::{self, Family};
use crate::likelihood::linear::{Symmetric, bounded_step, dot};
use crate::likelihood::power_law::EXPONENTS;
use crate::likelihood::running_mean::{RunningMean, tapered};
use crate::likelihood::runs::{Level, Own, regressed};
use crate::terms::Term;
use std::borrow::Cow;
use std::sync::Arc;

const STEPS: usize = 40;
const HALVINGS: usize = 12;
const SHORTER: f64 = 0.4;

/// Fall of the deviance at which a fit ends.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Largest step of the logarithm of a shape, and of a coefficient of the filter.
const SHAPE_STEP: f64 = 0.7;
const FILTER_STEP: f64 = 1.5;

/// Change of a number of a filter of known shape for its derivative, and the least ln |H|² that is told from 0.
const SHIFT: f64 = 0.005;
const LEAST_LOG_POWER: f64 = -60.0;

/// Largest step of the logarithm of a level.
const LEVEL_STEP: f64 = 1.0;

/// Share of the median density that is added, so that a model of nothing has a likelihood.
const FLOOR: f64 = 1e-9;

/// Relative change of a shape for its derivative; change of an exponent.
const DIFFERENCE: f64 = 0.02;

/// Which number of a part that is not a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Time,
    Frequency,
    Width,
    Exponent,
}

/// Parts with their parameters, and a filter that acts on all but quantization noise.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub parts: Vec<Part>,
    /// Squared coefficients, σ² or variances.
    pub theta: Vec<f64>,
    /// ln |H|² = Σ aₖ (cos 2πk f τ₀ − 1); or the numbers of a family.
    pub filter: Vec<f64>,
    /// The family of a filter whose shape is known.
    pub family: Option<Family>,
    /// Whether the filter acts on the random walk alone: all slower noise is behind it.
    pub of_white: bool,
    /// A filter of known shape, beside that.
    pub mean: Option<RunningMean>,
    /// Indices of the regressors.
    pub regressors: Vec<usize>,
    /// Parameter that is not fitted.
    pub held: Option<usize>,
    pub held_shape: Option<(usize, Shape)>,
    /// Of several runs: terms that differ from run to run, and terms of single runs.
    pub levels: Vec<Level>,
    pub own: Vec<Own>,
}

/// A fitted model.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub model: Model,
    /// Expected densities by bin.
    pub spectrum: Vec<f64>,
    /// Measured densities by bin, without the regressors.
    pub powers: Vec<f64>,
    pub deviance: f64,
    /// Part of the deviance that the regressors cause (restricted likelihood).
    pub restricted: f64,
    pub beta: Vec<f64>,
    pub beta_covariance: Symmetric,
    /// Degrees of freedom that the regressors take from each bin.
    pub leverage: Vec<f64>,
    /// Slope of the logarithm of the likelihood by Q², of the end values of the angle, whose variance it is; of each run.
    pub slope_of_ends: Vec<f64>,
    /// Of this set of regressors; shared by the fits that follow.
    products: Arc<Vec<Products>>,
}

impl Model {
    pub(crate) fn new(parts: Vec<Part>, regressors: Vec<usize>) -> Self {
        Self {
            theta: Vec::new(),
            filter: Vec::new(),
            family: None,
            of_white: false,
            mean: None,
            held: None,
            held_shape: None,
            levels: Vec::new(),
            own: Vec::new(),
            parts,
            regressors,
        }
    }

    pub(crate) fn index(&self, part: impl Into<Part>) -> Option<usize> {
        let part = part.into();
        self.parts.iter().position(|&p| p == part)
    }

    /// The model without a part. Regressors stay: both likelihoods are of the same data.
    pub(crate) fn without(&self, part: usize) -> Self {
        let mut model = self.clone();
        model.parts.remove(part);
        model.theta.remove(part);
        (model.held, model.held_shape) = (None, None);
        model
    }

    pub(crate) fn with(&self, part: Part, theta: f64) -> Self {
        let mut model = self.clone();
        model.parts.push(part);
        model.theta.push(theta);
        model
    }

    /// The model without its filter, unless that is a running mean.
    pub(crate) fn unfiltered(self) -> Self {
        let of_white = self.of_white && self.mean.is_some();
        Self { filter: Vec::new(), family: None, of_white, ..self }
    }

    /// Parts that are not terms.
    pub(crate) fn processes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(|&j| !self.parts[j].is_term())
    }

    fn shapes(&self) -> Vec<(usize, Shape)> {
        let mut found = Vec::new();
        for (j, part) in self.parts.iter().enumerate() {
            match part {
                Part::GaussMarkov { .. } => found.push((j, Shape::Time)),
                Part::Flicker { .. } => found.push((j, Shape::Exponent)),
                Part::Resonance { .. } => found.extend([(j, Shape::Frequency), (j, Shape::Width)]),
                Part::Term(_) => {}
            }
        }
        found
    }

    /// Numbers that are fitted to the densities: without the coefficients of regressors.
    pub(crate) fn parameters_beside_curves(&self) -> usize {
        let levels =
            self.levels.iter().filter(|level| self.index(level.part).is_some_and(|j| self.theta[j] > 0.0));
        let of_runs = levels.map(|level| level.logs.len().saturating_sub(1)).sum::<usize>();
        self.numbers() + of_runs + self.own.len()
    }

    /// Numbers of the model of all runs: without levels and terms of single runs.
    pub(crate) fn numbers(&self) -> usize {
        self.parts.len() + self.filter.len() + self.shapes().len()
    }

    /// |H|² at the low bins and at the points of the others; None without a filter.
    fn response(&self, bins: &Bins) -> Option<(Vec<f64>, Vec<f64>)> {
        if self.filter.is_empty() && self.mean.is_none() {
            return None;
        }
        if let Some(family) = self.family {
            return Some(responses(family.shape(&self.filter), bins));
        }
        let of = |cosines: &[Vec<f64>], of_mean: &dyn Fn(RunningMean, usize) -> f64| {
            let mut sum = vec![0.0; cosines[0].len()];
            if let Some(mean) = self.mean {
                sum.iter_mut().enumerate().for_each(|(i, s)| *s = of_mean(mean, i));
            }
            for (a, cosine) in self.filter.iter().zip(cosines) {
                sum.iter_mut().zip(cosine).for_each(|(s, c)| *s += a * c);
            }
            for s in &mut sum {
                *s = s.exp();
            }
            sum
        };
        let spacing = bins.record.frequency(1);
        let low = of(&bins.cosines_low, &|mean, i| bins.mean_of_modes(i, |f| mean.log_power(f).exp()).ln());
        let high = of(&bins.cosines_high, &|mean, i| {
            let f = bins.fine_points[i].frequency;
            // With missing samples, what the taper shares is in the matrix.
            if bins.leaks() { mean.log_power(f) } else { mean.log_measured_power(f, spacing) }
        });
        Some((low, high))
    }

    /// Whether the filter acts on a part.
    pub(crate) fn filters(&self, part: Part) -> bool {
        if self.of_white {
            part == Part::Term(Term::RandomWalk)
        } else {
            part != Part::Term(Term::Quantization)
        }
    }

    /// Slopes of ln |H|² by the numbers of the filter, at the low bins and at the points.
    fn slopes_of_filter<'a>(&self, bins: &'a Bins) -> Vec<[Cow<'a, [f64]>; 2]> {
        let Some(family) = self.family else {
            return (0..self.filter.len())
                .map(|k| {
                    [&bins.cosines_low, &bins.cosines_high].map(|cosines| Cow::Borrowed(&cosines[k][..]))
                })
                .collect();
        };
        let moved = |k: usize, by: f64| {
            let mut numbers = self.filter.clone();
            numbers[k] += by;
            responses(family.shape(&numbers), bins)
        };
        let slope = |up: Vec<f64>, down: Vec<f64>| {
            up.iter().zip(&down).map(|(a, b)| (a / b).ln() / (2.0 * SHIFT)).collect::<Vec<f64>>()
        };
        (0..self.filter.len())
            .map(|k| {
                let (up, down) = (moved(k, SHIFT), moved(k, -SHIFT));
                [slope(up.0, down.0), slope(up.1, down.1)].map(Cow::Owned)
            })
            .collect()
    }

    /// |H|² as means over all bins.
    pub(crate) fn response_means(&self, bins: &Bins) -> Vec<f64> {
        if !bins.runs.is_empty() {
            return bins.runs.iter().flat_map(|(own, _)| self.response_means(own)).collect();
        }
        match self.response(bins) {
            None => vec![1.0; bins.len()],
            Some((low, high)) => bins.response_means(&low, &high),
        }
    }

    /// |H|² at a frequency, with the interval of the filter's cosines. [Hz, s]
    pub(crate) fn response_at(&self, f: f64, interval: f64) -> f64 {
        if let Some(family) = self.family {
            return family.shape(&self.filter).log_power(f * interval).exp();
        }
        let angle = 2.0 * std::f64::consts::PI * f * interval;
        let sum: f64 = (1..).zip(&self.filter).map(|(k, a)| a * ((f64::from(k) * angle).cos() - 1.0)).sum();
        sum.exp()
    }

    /// Expected densities by bin.
    pub(crate) fn spectrum(&self, bins: &Bins) -> Vec<f64> {
        self.evaluate(bins, false).0
    }

    /// Expected densities, and (if asked for) their logarithmic derivatives by theta, filter and shapes.
    pub(crate) fn evaluate(&self, bins: &Bins, derivatives: bool) -> (Vec<f64>, Vec<Vec<f64>>) {
        if !bins.runs.is_empty() {
            return self.evaluate_runs(bins, derivatives);
        }
        if bins.leaks() {
            return self.evaluate_masked(bins, derivatives);
        }
        let response = self.response(bins);
        let nl = bins.low;
        let mut total = vec![FLOOR * bins.scale; bins.len()];
        total.iter_mut().zip(&bins.lines).for_each(|(t, l)| *t += l);
        let mut filtered_low = vec![0.0; nl];
        let mut filtered = vec![0.0; if response.is_some() { bins.fine_points.len() } else { 0 }];
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut scratch = bins.empty();
        for (j, &part) in self.parts.iter().enumerate() {
            let column = if let Some(column) = bins.term(part) {
                column
            } else {
                bins.fill(part, &mut scratch);
                &scratch
            };
            let behind = self.filters(part);
            let means = bins.means(column, response.as_ref().filter(|_| behind));
            let theta = self.theta[j];
            total.iter_mut().zip(&means).for_each(|(t, m)| *t += theta * m);
            if derivatives {
                if let Some((low, high)) = response.as_ref().filter(|_| behind) {
                    for i in 0..nl {
                        filtered_low[i] += theta * column.low[i] * low[i];
                    }
                    for (sum, (c, h)) in filtered.iter_mut().zip(column.high.iter().zip(high)) {
                        *sum += theta * c * h;
                    }
                }
                columns.push(means);
            }
        }
        if !derivatives {
            return (total, columns);
        }
        for [slope_low, slope_high] in self.slopes_of_filter(bins) {
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(s, c)| s * c).collect::<Vec<f64>>();
            let low = product(&filtered_low, &slope_low);
            columns.push(bins.gathered(&low, &product(&filtered, &slope_high)));
        }
        for (j, shape) in self.shapes() {
            let (up, down, step) = neighbours(self.parts[j], shape);
            let response = response.as_ref().filter(|_| self.filters(self.parts[j]));
            bins.fill(up, &mut scratch);
            let mut column = bins.means(&scratch, response);
            bins.fill(down, &mut scratch);
            let other = bins.means(&scratch, response);
            let factor = self.theta[j] / step;
            column.iter_mut().zip(&other).for_each(|(a, b)| *a = (*a - b) * factor);
            columns.push(column);
        }
        for column in &mut columns {
            column.iter_mut().zip(&total).for_each(|(c, s)| *c /= s);
        }
        (total, columns)
    }

    /// The same with missing samples: the matrix takes what it can in one product.
    fn evaluate_masked(&self, bins: &Bins, derivatives: bool) -> (Vec<f64>, Vec<Vec<f64>>) {
        let response = self.response(bins).map(|(_, high)| high);
        let mut total = vec![FLOOR * bins.scale; bins.len()];
        add(&mut total, &bins.lines, 1.0);
        let cells = bins.fine_points.len();
        let (mut all, mut filtered, mut seen) = (vec![0.0; cells], vec![0.0; cells], vec![0.0; cells]);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (j, &part) in self.parts.iter().enumerate() {
            let (theta, known) = (self.theta[j], bins.term(part));
            let response = response.as_ref().filter(|_| self.filters(part));
            match (known, response) {
                (Some(column), Some(response)) => {
                    // What the filter changes, cell by cell; nothing at the frequency 0, where a term has no limit.
                    for ((s, f), (c, h)) in
                        seen.iter_mut().zip(&mut filtered).zip(column.high.iter().zip(response))
                    {
                        *s = c * (h - 1.0);
                        *f += theta * c * h;
                    }
                }
                (Some(_), None) => seen.fill(0.0),
                (None, _) => {
                    bins.densities(part, &mut seen);
                    if let Some(response) = response {
                        seen.iter_mut().zip(response).for_each(|(s, h)| *s *= h);
                        add(&mut filtered, &seen, theta);
                    }
                }
            }
            if let Some(column) = known {
                add(&mut total, &column.low, theta);
            }
            if !derivatives {
                add(&mut all, &seen, theta);
                continue;
            }
            let by_matrix = known.is_none() || response.is_some();
            let mut means = if by_matrix { bins.gathered(&[], &seen) } else { vec![0.0; bins.len()] };
            add(&mut total, &means, theta);
            if let Some(column) = known {
                add(&mut means, &column.low, 1.0);
            }
            columns.push(means);
        }
        if !derivatives {
            if all.iter().any(|&x| x != 0.0) {
                add(&mut total, &bins.gathered(&[], &all), 1.0);
            }
            return (total, columns);
        }
        for [_, slope] in self.slopes_of_filter(bins) {
            seen.iter_mut().zip(filtered.iter().zip(slope.iter())).for_each(|(s, (f, c))| *s = f * c);
            columns.push(bins.gathered(&[], &seen));
        }
        for (j, shape) in self.shapes() {
            let (up, down, step) = neighbours(self.parts[j], shape);
            bins.densities(up, &mut seen);
            bins.densities(down, &mut all);
            let factor = self.theta[j] / step;
            let response = response.as_ref().filter(|_| self.filters(self.parts[j]));
            for (i, (s, d)) in seen.iter_mut().zip(&all).enumerate() {
                *s = (*s - d) * factor * response.map_or(1.0, |h| h[i]);
            }
            columns.push(bins.gathered(&[], &seen));
        }
        for column in &mut columns {
            column.iter_mut().zip(&total).for_each(|(c, s)| *c /= s);
        }
        (total, columns)
    }

    /// Parameters that start a fit, by non-negative least squares with weights that no bin dominates.
    fn start(&mut self, bins: &Bins) {
        const HEAVIEST: f64 = 10.0;
        const LEAST: f64 = 0.05; // of the usual density: what a bin weighs at most
        let n = self.parts.len();
        let powers = bins.plain_powers();
        let usual = bins.scale;
        // A filter of a known shape is near enough to the true one to say which noise is behind it.
        let behind = self.family.map(|_| self.response_means(bins));
        let column = |&part: &Part| match behind.as_ref().filter(|_| self.filters(part)) {
            Some(behind) => bins.unit(part).iter().zip(behind).map(|(c, h)| c * h).collect(),
            None => bins.unit(part),
        };
        let columns: Vec<Vec<f64>> = self.parts.iter().map(column).collect();
        let weights: Vec<f64> = (0..bins.len())
            .map(|i| bins.weight(i).sqrt().min(HEAVIEST) / (powers[i] + LEAST * usual))
            .collect();
        let mut squares = Symmetric::zero(n);
        let weighted: Vec<Vec<f64>> =
            columns.iter().map(|c| c.iter().zip(&weights).map(|(c, w)| c * w).collect()).collect();
        let target: Vec<f64> = powers.iter().zip(&weights).map(|(p, w)| p * w).collect();
        for i in 0..n {
            for j in 0..=i {
                squares.set(i, j, dot(&weighted[i], &weighted[j]));
            }
        }
        let right: Vec<f64> = weighted.iter().map(|c| dot(c, &target)).collect();
        let found = bounded_step(&squares, &right, &vec![0.0; n], &vec![false; n]);
        let scale = squares.scales();
        self.theta = found.iter().zip(&scale).map(|(x, s)| x.max(1e-12 / s)).collect();
    }

    /// The fit.
    pub(crate) fn fit(self, bins: &Bins) -> Fit {
        self.fit_within(bins, STEPS, TOLERANCE, None)
    }

    /// The model as it is, without a step.
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
        let (spectrum, mut slopes) = self.evaluate(bins, true);
        let mut fit = Fit::of(self, spectrum, bins, products, &weights);
        for _ in 0..steps {
            let step = fit.step(&slopes, &weights, bins);
            let mut length = 1.0;
            let mut better = None;
            for _ in 0..HALVINGS {
                let model = fit.model.moved(&step, length, bins);
                let spectrum = model.spectrum(bins);
                let next = Fit::of(model, spectrum, bins, fit.products.clone(), &weights);
                if next.deviance <= fit.deviance + 1e-9 {
                    better = Some(next);
                    break;
                }
                length *= SHORTER;
            }
            let Some(next) = better else { break };
            let gain = fit.deviance - next.deviance;
            fit = next;
            if gain < tolerance {
                break;
            }
            slopes = fit.model.evaluate(bins, true).1;
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
            family.limited(&mut model.filter);
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

/// |H|² of a shape at the low bins and at the points.
fn responses(shape: filter_shapes::Shape, bins: &Bins) -> (Vec<f64>, Vec<f64>) {
    let (tau0, spacing, zeros) = (bins.record.tau0, bins.record.frequency(1), shape.has_zeros());
    let response = shape.response();
    let power = |f: f64| response.log_power(f * tau0).max(LEAST_LOG_POWER).exp();
    let of_mode = |bin: usize| {
        if zeros { bins.mean_of_modes(bin, power) } else { power(bins.frequency[bin]) }
    };
    let of_point = |point: &FinePoint| {
        // With missing samples, what the taper shares is in the matrix.
        if zeros && !bins.leaks() { tapered(power, point.frequency, spacing) } else { power(point.frequency) }
    };
    ((0..bins.low).map(of_mode).collect(), bins.fine_points.iter().map(of_point).collect())
}

fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    sum.iter_mut().zip(x).for_each(|(s, x)| *s += factor * x);
}

/// Limits of correlation times: shorter ones are a filter's, longer ones a rate random walk. \[s\]
pub(crate) fn time_limits(bins: &Bins) -> (f64, f64) {
    let shortest = 20.0 * bins.record.tau0;
    (shortest, (0.25 * bins.record.duration()).max(shortest))
}

/// A part with a shape a little larger and a little smaller, and the difference in the parameter that is fitted.
fn neighbours(part: Part, shape: Shape) -> (Part, Part, f64) {
    const SHIFT: f64 = 0.05; // of the width
    let up = 1.0 + DIFFERENCE;
    let log = 2.0 * up.ln();
    match (part, shape) {
        (Part::GaussMarkov { time }, _) => {
            (Part::GaussMarkov { time: time * up }, Part::GaussMarkov { time: time / up }, log)
        }
        (Part::Resonance { frequency: f, width }, Shape::Frequency) => (
            Part::Resonance { frequency: f + SHIFT * width, width },
            Part::Resonance { frequency: f - SHIFT * width, width },
            2.0 * SHIFT,
        ),
        (Part::Resonance { frequency, width }, _) => (
            Part::Resonance { frequency, width: width * up },
            Part::Resonance { frequency, width: width / up },
            log,
        ),
        (Part::Flicker { exponent, pivot }, _) => (
            Part::Flicker { exponent: exponent + DIFFERENCE, pivot },
            Part::Flicker { exponent: exponent - DIFFERENCE, pivot },
            2.0 * DIFFERENCE,
        ),
        (part, _) => (part, part, 1.0),
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
        let mut gradient: Vec<f64> = slopes.iter().map(|c| dot(c, &pull)).collect();
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
        debug_assert!(q <= MOST_FILTER && bins.len() == excess.len());
        let mut step = bounded_step(&information, &gradient, &least, &held);
        let most = if self.model.family.is_some() { SHAPE_STEP } else { FILTER_STEP };
        step[n..n + q].iter_mut().for_each(|d| *d = d.clamp(-most, most));
        step[n + q..first].iter_mut().for_each(|d| *d = d.clamp(-SHAPE_STEP, SHAPE_STEP));
        step[first..first + levels.len()].iter_mut().for_each(|d| *d = d.clamp(-LEVEL_STEP, LEVEL_STEP));
        step
    }

    /// Fisher information of theta, filter and shapes, of levels and own terms, and the slopes it is made of.
    pub(crate) fn information(&self, bins: &Bins) -> (Symmetric, Vec<Vec<f64>>) {
        let weights: Vec<f64> = (0..bins.len()).map(|i| bins.weight(i)).collect();
        let slopes = self.model.evaluate(bins, true).1;
        (self.with_levels(information(&slopes, &weights)), slopes)
    }

    /// The deviance without one part, and that fit.
    pub(crate) fn loss_of(&self, part: usize, bins: &Bins) -> (f64, Fit) {
        let fit = self.model.without(part).refit(bins, STEPS, TOLERANCE, self);
        (fit.deviance - self.deviance, fit)
    }
}

/// Half of `JᵀνJ`.
fn information(slopes: &[Vec<f64>], weights: &[f64]) -> Symmetric {
    let mut found = Symmetric::zero(slopes.len());
    for i in 0..slopes.len() {
        let weighted: Vec<f64> = slopes[i].iter().zip(weights).map(|(c, nu)| 0.5 * nu * c).collect();
        for (j, other) in slopes.iter().enumerate().take(i + 1) {
            found.set(i, j, dot(&weighted, other));
        }
    }
    found
}

pub(crate) struct Regressed {
    pub beta: Vec<f64>,
    pub covariance: Symmetric,
    /// ln det ZᵀS⁻¹Z, of the end values ln det(1 + Q²ZᵀS⁻¹Z).
    pub restricted: f64,
    /// Squares of the end values over their variance.
    pub squares_of_ends: f64,
    pub leverage: Vec<f64>,
    /// Of each run.
    pub slope_of_ends: Vec<f64>,
}

/// Weighted least squares for the regressors, given the density; the end values of the angle are random with the variance
/// `quantization`. The density is that of the bin, constant in it.
pub(crate) fn regress(products: &Products, spectrum: &[f64], quantization: f64) -> Regressed {
    let n = products.count;
    let mut squares = Symmetric::zero(n);
    let mut right = vec![0.0; n];
    let scale: Vec<f64> =
        products.ends.iter().map(|end| if *end { quantization.sqrt() } else { 1.0 }).collect();
    let bins = products.with_record.chunks_exact(n.max(1)).zip(products.squares.chunks_exact((n * n).max(1)));
    for (bin, (record, own)) in bins.clone().enumerate() {
        let weight = 1.0 / spectrum[bin];
        right.iter_mut().zip(record).for_each(|(r, x)| *r += weight * x);
        squares.at.iter_mut().zip(own).for_each(|(s, x)| *s += weight * x);
    }
    for i in 0..n {
        right[i] *= scale[i];
        for j in 0..=i {
            let prior = f64::from(u8::from(i == j && products.ends[i]));
            squares.set(i, j, squares.get(i, j) * scale[i] * scale[j] + prior);
        }
    }
    let mut covariance = squares.pseudo_inverse();
    let mut beta = covariance.times(&right);
    let ends = |i: &usize| products.ends[*i];
    let squares_of_ends: f64 = (0..n).filter(ends).map(|i| beta[i] * beta[i]).sum();
    let known: f64 = (0..n).filter(ends).map(|i| 1.0 - covariance.get(i, i)).sum();
    let slope_of_ends = if quantization > 0.0 { 0.5 * (squares_of_ends - known) / quantization } else { 0.0 };
    for i in 0..n {
        beta[i] *= scale[i];
        for j in 0..=i {
            covariance.set(i, j, covariance.get(i, j) * scale[i] * scale[j]);
        }
    }
    let taken = |(bin, (_, own)): (usize, (&[f64], &[f64]))| dot(&covariance.at, own) / spectrum[bin];
    let leverage = bins.enumerate().map(taken).collect();
    let restricted = squares.log_determinant();
    Regressed { beta, covariance, restricted, squares_of_ends, leverage, slope_of_ends: vec![slope_of_ends] }
}

impl Model {
    /// Interval of the cosines of the filter; of a known shape, that of the samples. \[s\]
    pub(crate) fn interval(&self, bins: &Bins) -> f64 {
        let spacing = if self.family.is_some() { 1 } else { bins.spacing };
        spacing as f64 * bins.record.tau0
    }

    /// Density at a frequency of the periodogram. \[Hz\]
    pub(crate) fn density(&self, f: f64, bins: &Bins) -> f64 {
        let record = bins.record;
        let point = FinePoint::new(f, record.tau0, record.segment);
        let of_mean = self.mean.map_or(0.0, |mean| mean.log_tapered_power(f, record.frequency(1)));
        let response = self.response_at(f, self.interval(bins)) * of_mean.exp();
        let of = |(&part, &theta): (&Part, &f64)| {
            let density = theta * point.density(part, record.tau0);
            match part {
                Part::Term(Term::Quantization) if record.masked.is_none() => {
                    density + theta * bins.of_mirror(f)
                }
                _ if self.filters(part) => density * response,
                _ => density,
            }
        };
        self.parts.iter().zip(&self.theta).map(of).sum()
    }
}
