//! Intervals from the profile of the likelihood: a parameter is fixed, and all others are fitted again.

use crate::distributions::student_quantile;
use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::{Fit, time_limits};
use crate::likelihood::laws::chi2_above;
use crate::likelihood::model::{Model, Shape};
use crate::matern::SMOOTHNESS;

/// Number of standard errors from 0 above which a term is certain, so that no fit without it is needed.
const BEYOND_DOUBT: f64 = 8.0;

const STEPS: usize = 25;
const TOLERANCE: f64 = 1e-3;
const TRIES: usize = 12;

/// First step of the smoothness of a Matérn process.
const SMOOTHNESS_STEP: f64 = 0.1;

/// Error of the root of the deviance at an end of an interval: a hundredth of its width.
const PRECISION: f64 = 0.02;

/// Rises of the deviance at the ends of an interval, and above which a term counts as observed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thresholds {
    pub interval: f64,
    pub observed: f64,
}

impl Thresholds {
    pub(crate) fn scaled(self, by: f64) -> Self {
        Self { interval: self.interval * by, observed: self.observed * by }
    }
}

/// A parameter with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Maximum of the likelihood.
    pub value: f64,
    /// Lower end; 0 if the record does not show the part.
    pub low: f64,
    /// Upper end or limit; infinite if there is none.
    pub high: f64,
    /// Whether the record shows the part.
    pub observed: bool,
    /// Rise of the deviance without the part.
    pub loss: f64,
}

impl Bounds {
    /// The standard error that corresponds to the lower part of the interval.
    pub(crate) fn error_below(self, thresholds: Thresholds) -> f64 {
        (self.value - self.low) / thresholds.interval.sqrt()
    }

    /// The interval with another value, extended to include it.
    pub(crate) fn around(self, value: f64) -> Self {
        Self { value, low: self.low.min(value), high: self.high.max(value), ..self }
    }
}

/// The interval of the parameter of a part.
pub(crate) fn part_bounds(fit: &Fit, bins: &Bins, part: usize, thresholds: Thresholds) -> Bounds {
    let value = fit.model.theta[part];
    let (information, _) = fit.information(bins);
    let error = information.pseudo_inverse().get(part, part).max(1e-300).sqrt();
    let loss = if value > BEYOND_DOUBT * error {
        f64::INFINITY
    } else if value > 0.0 {
        fit.removal_loss(part, bins).0.max(0.0)
    } else {
        0.0
    };
    let observed = value > 0.0 && loss > thresholds.observed;
    let hold = |model: &mut Model, x: f64| {
        model.theta[part] = x;
        model.held = Some(part);
    };
    // The error of the mean of a term that differs from run to run follows Student's t.
    let target = match fit.model.level(fit.model.parts[part]) {
        Some(level) => student_of(thresholds.interval, level.logs.len()),
        None => thresholds.interval.sqrt(),
    };
    let step = error * target;
    let search = Search { fit, bins, target, nearness: None, hold: &hold };
    let high = if information.get(part, part) > 0.0 { search.up(value, step) } else { f64::INFINITY };
    let search = Search { nearness: Some((error, thresholds.observed.sqrt())), ..search };
    let low = if observed { search.down(value, step, loss) } else { 0.0 };
    Bounds { value, low, high, observed, loss }
}

/// The interval of the correlation time of a Gauss-Markov or Matérn process, within the limits of such times.
pub(crate) fn time_bounds(fit: &Fit, bins: &Bins, part: usize, thresholds: Thresholds) -> Option<Bounds> {
    let (Part::GaussMarkov { time } | Part::Matern { time, .. }) = fit.model.parts[part] else { return None };
    let (shortest, longest) = time_limits(bins);
    let hold = |model: &mut Model, x: f64| {
        model.parts[part] = match model.parts[part] {
            Part::Matern { smoothness, .. } => Part::Matern { time: x.exp(), smoothness },
            _ => Part::GaussMarkov { time: x.exp() },
        };
        model.held_shape = Some((part, Shape::Time));
    };
    let target = thresholds.interval.sqrt();
    let search = Search { fit, bins, target, nearness: None, hold: &hold };
    let step = 0.2;
    let high = search.until(time.ln(), step, longest.ln()).exp();
    let low = search.until(time.ln(), -step, shortest.ln()).exp();
    Some(Bounds { value: time, low, high, observed: true, loss: f64::NAN })
}

/// The interval of the smoothness of a Matérn process, within its range.
pub(crate) fn smoothness_bounds(
    fit: &Fit,
    bins: &Bins,
    part: usize,
    thresholds: Thresholds,
) -> Option<Bounds> {
    let Part::Matern { smoothness, .. } = fit.model.parts[part] else { return None };
    let hold = |model: &mut Model, x: f64| {
        if let Part::Matern { time, .. } = model.parts[part] {
            model.parts[part] = Part::Matern { time, smoothness: x };
        }
        model.held_shape = Some((part, Shape::Exponent));
    };
    let search = Search { fit, bins, target: thresholds.interval.sqrt(), nearness: None, hold: &hold };
    let high = search.until(smoothness, SMOOTHNESS_STEP, SMOOTHNESS.1);
    let low = search.until(smoothness, -SMOOTHNESS_STEP, SMOOTHNESS.0);
    Some(Bounds { value: smoothness, low, high, observed: true, loss: f64::NAN })
}

/// The interval of the centre and of the half width of a resonance.
pub(crate) fn resonance_bounds(
    fit: &Fit,
    bins: &Bins,
    part: usize,
    thresholds: Thresholds,
) -> Option<[Bounds; 2]> {
    let Part::Resonance { frequency, width } = fit.model.parts[part] else { return None };
    let target = thresholds.interval.sqrt();
    let centre = |model: &mut Model, x: f64| {
        if let Part::Resonance { width, .. } = model.parts[part] {
            let width = width.max(bins.least_width(x.exp()));
            model.parts[part] = Part::Resonance { frequency: x.exp(), width };
        }
        model.held_shape = Some((part, Shape::Frequency));
    };
    let half = |model: &mut Model, x: f64| {
        if let Part::Resonance { frequency, .. } = model.parts[part] {
            model.parts[part] = Part::Resonance { frequency, width: x.exp() };
        }
        model.held_shape = Some((part, Shape::Width));
    };
    let bounds = |hold: &dyn Fn(&mut Model, f64), value: f64, step: f64, limits: [f64; 2]| {
        let search = Search { fit, bins, target, nearness: None, hold };
        let [low, high] = limits.map(f64::ln);
        let ends =
            [search.until(value.ln(), -step, low.min(value.ln())), search.until(value.ln(), step, high)];
        Bounds { value, low: ends[0].exp(), high: ends[1].exp(), observed: true, loss: f64::NAN }
    };
    // Limited to distinguishable values: from two cycles per record to half the sampling rate, and above the smallest
    // width.
    let centres = [2.0 / bins.record.duration(), 0.5 / bins.record.tau0];
    let least = bins.least_width(frequency);
    let widths = [least, (0.25 * frequency).max(least).max(width)];
    Some([bounds(&centre, frequency, 0.2 * width / frequency, centres), bounds(&half, width, 0.3, widths)])
}

/// Quantile of Student's t for a mean over runs, at the probability of χ² with one degree of freedom.
fn student_of(interval: f64, runs: usize) -> f64 {
    let tail = 0.5 * chi2_above(interval, 1.0);
    -student_quantile(runs.max(2) as f64 - 1.0, tail)
}

struct Search<'a, 'b> {
    fit: &'a Fit,
    bins: &'a Bins<'b>,
    target: f64,
    /// Standard error, and the root of the rise that ends the interval at 0. The test of a term is one-sided, so that an
    /// interval excludes 0 exactly if the term is observed.
    nearness: Option<(f64, f64)>,
    hold: &'a dyn Fn(&mut Model, f64),
}

impl Search<'_, '_> {
    /// Root of the rise of the deviance, minus the target, with the parameter fixed at x.
    fn rise(&self, x: f64, from: &Fit) -> (f64, Fit) {
        let mut model = from.model.clone();
        (model.held, model.held_shape) = (None, None);
        (self.hold)(&mut model, x);
        let fit = model.refit(self.bins, STEPS, TOLERANCE, self.fit);
        ((fit.deviance - self.fit.deviance).max(0.0).sqrt() - self.target_at(x), fit)
    }

    /// Root of the rise that ends the interval at x: between that of a one-sided test at 0 and that of a two-sided test
    /// above two standard errors (Feldman and Cousins 1998, doi 10.1103/PhysRevD.57.3873, to 1 %).
    fn target_at(&self, x: f64) -> f64 {
        match self.nearness {
            Some((error, at_zero)) => at_zero + (self.target - at_zero) * (x / (2.0 * error)).clamp(0.0, 1.0),
            None => self.target,
        }
    }

    /// The upper end of the interval of a non-negative value.
    fn up(&self, value: f64, step: f64) -> f64 {
        self.end(value, step, f64::INFINITY, |next, _| next)
    }

    /// The lower end of the interval; `loss` is the rise of the deviance at 0, or infinite if unknown.
    fn down(&self, value: f64, step: f64, loss: f64) -> f64 {
        let mut first = value - step;
        if !loss.is_finite() {
            first = first.max(0.2 * value);
        } else if first < 0.05 * value {
            let at_zero = loss.sqrt() - self.target_at(0.0);
            return self.between((value, -self.target), (0.0, at_zero), self.fit.clone());
        }
        self.end(value, first - value, f64::NEG_INFINITY, |next, last| next.max(0.3 * last))
    }

    /// The end in one direction, up to a limit.
    fn until(&self, value: f64, step: f64, limit: f64) -> f64 {
        self.end(value, step, limit, |next, _| next)
    }

    /// The end in one direction, up to a limit. `kept` returns the point that is tried instead of the next one, given the
    /// last one.
    fn end(&self, value: f64, step: f64, limit: f64, kept: impl Fn(f64, f64) -> f64) -> f64 {
        let (mut inside, mut below, mut from) = (value, -self.target, self.fit.clone());
        let beyond = |x: f64| if step > 0.0 { x >= limit } else { x <= limit };
        let mut outside = value + step;
        for _ in 0..TRIES {
            if beyond(outside) {
                outside = limit;
            }
            let (above, fit) = self.rise(outside, &from);
            if above.abs() < PRECISION {
                return outside;
            }
            if above > 0.0 {
                return self.between((inside, below), (outside, above), from);
            }
            if beyond(outside) {
                return limit;
            }
            (inside, below, from) = (outside, above, fit);
            let stretch = (self.target / (above + self.target).max(0.1)).clamp(1.1, 3.0);
            outside = kept(value + (outside - value) * stretch, outside);
        }
        outside
    }

    /// The crossing between two points, by the Illinois rule. Each fit starts from the last one inside the interval,
    /// because a fit outside may be at another maximum from which the steps do not return.
    fn between(&self, inside: (f64, f64), outside: (f64, f64), mut from: Fit) -> f64 {
        let ((mut a, mut fa), (mut b, mut fb)) = (inside, outside);
        let mut x = b;
        for _ in 0..TRIES {
            x = (a * fb - b * fa) / (fb - fa);
            let (fx, fit) = self.rise(x, &from);
            if fx.abs() < PRECISION {
                return x;
            }
            if fx > 0.0 {
                (b, fb) = (x, fx);
                fa *= 0.5;
            } else {
                (a, fa, from) = (x, fx, fit);
                fb *= 0.5;
            }
        }
        x
    }
}

/// The fit without unneeded terms of a list, which are dropped one by one.
pub(crate) fn without(fit: &Fit, bins: &Bins, mut open: Vec<Part>, thresholds: Thresholds) -> Fit {
    let mut reduced = fit.clone();
    while !open.is_empty() && reduced.model.parts.len() > 1 {
        let loss = |part: &Part| {
            reduced.model.index(*part).map(|j| {
                let (loss, without) = reduced.removal_loss(j, bins);
                (loss, *part, without)
            })
        };
        let least = open.iter().filter_map(loss).min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((loss, part, without)) if loss <= thresholds.observed => {
                reduced = without;
                open.retain(|&p| p != part);
            }
            _ => break,
        }
    }
    reduced
}
