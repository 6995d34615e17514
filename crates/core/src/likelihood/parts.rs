//! Processes, resonances and lines of a model, and the covariance of all its parameters.

use crate::likelihood::estimates::{Estimate, quantile};
use crate::likelihood::expected::Part;
use crate::likelihood::filter::FittedFilter;
use crate::likelihood::outcome::{Outcome, Process};
use crate::terms::{NOISE_TERMS, Term};

/// Largest number of lines; the strongest ones are kept, because a periodic record has thousands.
pub const MAX_LINES: usize = 100;

/// Largest number of lines whose errors are in the covariance; the strongest ones are included, because a machine causes
/// hundreds.
const LINES_WITH_ERRORS: usize = 8;

/// Largest ratio of the half width of the interval of an amplitude to the amplitude.
const MAX_HALF_WIDTH: f64 = 0.999;

/// Relative rounding of a width at its lower limit.
const ROUNDING: f64 = 1e-9;

/// A first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussMarkovEstimate {
    /// Standard deviation. \[rate unit\]
    pub sigma: Estimate,
    /// Correlation time. \[s\]
    pub time: Estimate,
}

/// Narrow-band noise before the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResonanceEstimate {
    /// Standard deviation. \[rate unit\]
    pub sigma: Estimate,
    /// Centre. \[Hz\]
    pub frequency: Estimate,
    /// Half width. \[Hz\]
    pub width: Estimate,
}

/// A line of the spectrum, after the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineEstimate {
    /// Amplitude. \[rate unit\]
    pub amplitude: Estimate,
    /// Frequency; its interval is the left-out band if the line was left out of the fit. \[Hz\]
    pub frequency: Estimate,
}

/// Processes, resonances and lines of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Parts {
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    pub resonance: Vec<ResonanceEstimate>,
    pub sinusoid: Vec<LineEstimate>,
    /// Standard errors of the amplitude and of the frequency of each line, if known. [rate unit, Hz]
    pub errors_of_lines: Vec<Option<[f64; 2]>>,
}

impl Parts {
    /// The parts of an outcome, with the strongest lines first. Resonances of the smallest width are lines after the
    /// filter.
    pub(crate) fn of(outcome: &Outcome, filter: Option<&FittedFilter>, level: f64) -> Self {
        let left_out = outcome.lines.iter().filter(|line| line.amplitude > 0.0).map(|line| {
            let half = (quantile(level) * line.error).min(MAX_HALF_WIDTH * line.amplitude);
            let frequency = Estimate { value: line.frequency, low: Some(line.from), high: Some(line.to) };
            let line_estimate = LineEstimate { amplitude: Estimate::around(line.amplitude, half), frequency };
            (line_estimate, Some([line.error, line.frequency_error]))
        });
        let followed = outcome.slow_lines.iter().map(|line| {
            let half = (quantile(level) * line.amplitude_error).min(MAX_HALF_WIDTH * line.amplitude);
            let apart = (quantile(level) * line.frequency_error).min(MAX_HALF_WIDTH * line.frequency);
            let line_estimate = LineEstimate {
                amplitude: Estimate::around(line.amplitude, half),
                frequency: Estimate::around(line.frequency, apart),
            };
            (line_estimate, Some([line.amplitude_error, line.frequency_error]))
        });
        let mut lines: Vec<(LineEstimate, Option<[f64; 2]>)> = left_out.chain(followed).collect();
        let mut parts = Self::default();
        for process in outcome.processes.iter().filter(|process| process.variance.value > 0.0) {
            let sigma = Estimate::root(&process.variance);
            match process.part {
                Part::GaussMarkov { time } => {
                    parts.gauss_markov.push(GaussMarkovEstimate { sigma, time: shape_of(process, 0, time) });
                }
                Part::Resonance { frequency, width } => {
                    let width = shape_of(process, 1, width);
                    let frequency = at_bins(shape_of(process, 0, frequency), width.value, &outcome.bins);
                    if is_steady(process, outcome) {
                        let power = filter.map_or(1.0, |filter| filter.power(frequency.value));
                        let amplitude = sigma.scaled((2.0 * power).sqrt());
                        lines.push((LineEstimate { amplitude, frequency }, None));
                    } else {
                        parts.resonance.push(ResonanceEstimate { sigma, frequency, width });
                    }
                }
                _ => {}
            }
        }
        lines.sort_by(|(a, _), (b, _)| b.amplitude.value.total_cmp(&a.amplitude.value));
        lines.truncate(MAX_LINES);
        (parts.sinusoid, parts.errors_of_lines) = lines.into_iter().unzip();
        parts
    }

    /// Parameters and covariance in row order, followed by those of the strongest lines, which are independent of the rest.
    pub(crate) fn with_lines(
        &self,
        (mut parameters, covariance): (Vec<Parameter>, Vec<f64>),
    ) -> (Vec<Parameter>, Vec<f64>) {
        let before = parameters.len();
        let mut variances = Vec::new();
        for (number, errors) in (1..=LINES_WITH_ERRORS).zip(&self.errors_of_lines) {
            for (quantity, error) in
                [Number::Amplitude, Number::Frequency].into_iter().zip(errors.iter().flatten())
            {
                parameters.push(Parameter::Sinusoid(number, quantity));
                variances.push(error * error);
            }
        }
        let count = parameters.len();
        let entry = |i: usize, j: usize| match (i < before, j < before) {
            (true, true) => covariance[i * before + j],
            (false, false) if i == j => variances[i - before],
            _ => 0.0,
        };
        let matrix =
            (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect();
        (parameters, matrix)
    }
}

/// A shape parameter of a process, without an interval if the outcome has none.
fn shape_of(process: &Process, number: usize, value: f64) -> Estimate {
    process.shape[number].as_ref().map_or(Estimate { value, low: None, high: None }, Estimate::from)
}

/// Whether a process is a line: a resonance of the smallest width that the points of the spectrum resolve, in the band of
/// the periodogram. Below this band, lines are regressors, and a resonance is noise.
fn is_steady(process: &Process, outcome: &Outcome) -> bool {
    matches!(process.part, Part::Resonance { frequency, .. } if frequency > outcome.end_of_modes)
        && process.shape[1].is_some_and(|width| width.low >= width.value * (1.0 - ROUNDING))
}

/// The frequency of a resonance; if it is narrower than the bins, its interval includes the neighbouring bins.
fn at_bins(centre: Estimate, width: f64, bins: &[[f64; 4]]) -> Estimate {
    let first_above = bins.partition_point(|bin| bin[0] < centre.value);
    let neighbours = &bins[first_above.saturating_sub(2)..(first_above + 2).min(bins.len())];
    let spacing = neighbours.windows(2).map(|pair| pair[1][0] - pair[0][0]).fold(0.0, f64::max);
    let Estimate { value, low: Some(low), high: Some(high) } = centre else { return centre };
    if width >= spacing {
        return centre;
    }
    Estimate { value, low: Some(low.min((value - spacing).max(0.0))), high: Some(high.max(value + spacing)) }
}

/// A parameter of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// Standard deviation. \[rate unit\]
    Sigma,
    /// Correlation time. \[s\]
    Time,
    /// Centre. \[Hz\]
    Frequency,
    /// Half width. \[Hz\]
    Width,
    /// \[rate unit\]
    Amplitude,
}

/// A parameter of a model. Processes of a kind are counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Coefficient of a term.
    Term(Term),
    /// Parameter of a Gauss-Markov process.
    GaussMarkov(usize, Number),
    /// Parameter of a resonance.
    Resonance(usize, Number),
    /// Parameter of a line.
    Sinusoid(usize, Number),
}

/// The coefficients √θ and the parameters of processes in the model, and their covariance in row order. It is computed from
/// that of θ, of the filter, and of the shapes (logarithms of times and widths, frequencies in widths).
/// [`Parts::with_lines`] appends the lines.
pub(crate) fn covariance(outcome: &Outcome, model: &[f64; NOISE_TERMS]) -> (Vec<Parameter>, Vec<f64>) {
    let order = outcome.covariance.len().isqrt();
    // Row, parameter, and derivative of the parameter with respect to that of the row, for the delta method.
    let mut rows: Vec<(usize, Parameter, f64)> = Vec::new();
    let mut shape = outcome.parameters.len() + outcome.filter.len();
    let mut processes = outcome.processes.iter();
    let mut counts = [0, 0];
    for (row, &part) in outcome.parameters.iter().enumerate() {
        let (of_process, numbers, count): (fn(usize, Number) -> Parameter, _, _) = match part {
            Part::GaussMarkov { .. } => (Parameter::GaussMarkov, &[Number::Time][..], &mut counts[0]),
            Part::Resonance { .. } => {
                (Parameter::Resonance, &[Number::Frequency, Number::Width][..], &mut counts[1])
            }
            _ => {
                if let Part::Term(term) = part {
                    let coefficient = model[term.index()];
                    rows.extend((coefficient > 0.0).then(|| (row, Parameter::Term(term), 0.5 / coefficient)));
                }
                continue;
            }
        };
        let first = shape;
        shape += numbers.len();
        let Some(process) = processes.next() else { continue };
        let sigma = process.variance.value.sqrt();
        if is_steady(process, outcome) || sigma.is_nan() || sigma <= 0.0 {
            continue;
        }
        *count += 1;
        let scale = match process.part {
            Part::GaussMarkov { time } => shape_of(process, 0, time),
            Part::Resonance { width, .. } => shape_of(process, 1, width),
            _ => continue,
        };
        rows.push((row, of_process(*count, Number::Sigma), 0.5 / sigma));
        let shapes = numbers.iter().enumerate();
        rows.extend(shapes.map(|(k, &number)| (first + k, of_process(*count, number), scale.value)));
    }
    let matrix = rows
        .iter()
        .flat_map(|(i, _, a)| rows.iter().map(move |(j, _, b)| (i * order + j, a * b)))
        .map(|(index, slopes)| outcome.covariance[index] * slopes)
        .collect();
    (rows.into_iter().map(|(_, parameter, _)| parameter).collect(), matrix)
}
