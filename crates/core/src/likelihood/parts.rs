//! Processes, resonances and lines of a model, and the names and covariance of all its numbers.

use crate::likelihood::estimates::{Estimate, quantile};
use crate::likelihood::expected::Part;
use crate::likelihood::filter::FittedFilter;
use crate::likelihood::outcome::{Outcome, Process};

/// Lines that are kept, the strongest: a record that repeats itself has thousands.
pub const MOST_LINES: usize = 100;

/// Half the interval of an amplitude over it, at most.
const WIDEST: f64 = 0.999;

/// Relative rounding of a width at its lower limit.
const ROUNDING: f64 = 1e-9;

/// A first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussMarkovEstimate {
    /// Standard deviation. [rate unit]
    pub sigma: Estimate,
    /// Correlation time. [s]
    pub time: Estimate,
}

/// Noise of a band, in front of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResonanceEstimate {
    /// Standard deviation. [rate unit]
    pub sigma: Estimate,
    /// Centre. [Hz]
    pub frequency: Estimate,
    /// Half width. [Hz]
    pub width: Estimate,
}

/// A line of the spectrum, behind the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineEstimate {
    /// Amplitude. [rate unit]
    pub amplitude: Estimate,
    /// Frequency; of a line that was left out of the fit, with the band that was. [Hz]
    pub frequency: Estimate,
}

/// Processes, resonances and lines of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Parts {
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    pub resonance: Vec<ResonanceEstimate>,
    pub sinusoid: Vec<LineEstimate>,
}

impl Parts {
    /// Those of an outcome, lines with the strongest first. Resonances of the least width are lines behind the filter.
    pub(crate) fn of(outcome: &Outcome, filter: Option<&FittedFilter>, level: f64) -> Self {
        let left_out = outcome.lines.iter().filter(|line| line.amplitude > 0.0).map(|line| {
            let half = (quantile(level) * line.error).min(WIDEST * line.amplitude);
            let frequency = Estimate { value: line.frequency, low: Some(line.from), high: Some(line.to) };
            LineEstimate { amplitude: Estimate::around(line.amplitude, half), frequency }
        });
        let mut parts = Self { sinusoid: left_out.collect(), ..Self::default() };
        for process in outcome.processes.iter().filter(|process| process.variance.value > 0.0) {
            let sigma = Estimate::root(&process.variance);
            match process.part {
                Part::GaussMarkov { time } => {
                    parts.gauss_markov.push(GaussMarkovEstimate { sigma, time: shape_of(process, 0, time) });
                }
                Part::Resonance { frequency, width } => {
                    let width = shape_of(process, 1, width);
                    let frequency = at_bins(shape_of(process, 0, frequency), width.value, &outcome.bins);
                    if is_steady(process) {
                        let power = filter.map_or(1.0, |filter| filter.power(frequency.value));
                        let amplitude = sigma.scaled((2.0 * power).sqrt());
                        parts.sinusoid.push(LineEstimate { amplitude, frequency });
                    } else {
                        parts.resonance.push(ResonanceEstimate { sigma, frequency, width });
                    }
                }
                _ => {}
            }
        }
        parts.sinusoid.sort_by(|a, b| b.amplitude.value.total_cmp(&a.amplitude.value));
        parts.sinusoid.truncate(MOST_LINES);
        parts
    }
}

/// A number of the shape of a process; without an interval if none was outcome.
fn shape_of(process: &Process, number: usize, value: f64) -> Estimate {
    process.shape[number].as_ref().map_or(Estimate { value, low: None, high: None }, Estimate::from)
}

/// Whether a process is a line: a resonance of the least width that the points of the spectrum can show.
fn is_steady(process: &Process) -> bool {
    matches!(process.part, Part::Resonance { .. })
        && process.shape[1].is_some_and(|width| width.low >= width.value * (1.0 - ROUNDING))
}

/// The frequency of a resonance; one that is narrower than the bins may be anywhere between two of them.
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

/// Names and covariance, row after row, of the coefficients √θ in the model and of the numbers of its processes, from that
/// of θ, of the filter, and of the shapes: logarithms of times and widths, frequencies in widths. Lines have none.
pub(crate) fn covariance(outcome: &Outcome, model: &[f64; 4]) -> (Vec<String>, Vec<f64>) {
    let order = outcome.covariance.len().isqrt();
    // Row, name, and slope of the number by that of the row: the delta method.
    let mut rows: Vec<(usize, String, f64)> = Vec::new();
    let mut shape = outcome.parameters.len() + outcome.filter.len();
    let mut processes = outcome.processes.iter();
    let mut counts = [0, 0];
    for (row, &part) in outcome.parameters.iter().enumerate() {
        let (name, numbers, count) = match part {
            Part::GaussMarkov { .. } => ("gauss_markov", &["time"][..], &mut counts[0]),
            Part::Resonance { .. } => ("resonance", &["frequency", "width"][..], &mut counts[1]),
            _ => {
                if let Some((name, value)) = term_of(part, model).filter(|&(_, value)| value > 0.0) {
                    rows.push((row, name.to_owned(), 0.5 / value));
                }
                continue;
            }
        };
        let first = shape;
        shape += numbers.len();
        let Some(process) = processes.next() else { continue };
        let sigma = process.variance.value.sqrt();
        if is_steady(process) || sigma.is_nan() || sigma <= 0.0 {
            continue;
        }
        *count += 1;
        let scale = match process.part {
            Part::GaussMarkov { time } => shape_of(process, 0, time),
            Part::Resonance { width, .. } => shape_of(process, 1, width),
            _ => continue,
        };
        rows.push((row, format!("{name}_{count}.sigma"), 0.5 / sigma));
        rows.extend(
            numbers
                .iter()
                .enumerate()
                .map(|(k, number)| (first + k, format!("{name}_{count}.{number}"), scale.value)),
        );
    }
    let matrix = rows
        .iter()
        .flat_map(|(i, _, a)| rows.iter().map(move |(j, _, b)| (i * order + j, a * b)))
        .map(|(index, slopes)| outcome.covariance[index] * slopes)
        .collect();
    (rows.into_iter().map(|(_, name, _)| name).collect(), matrix)
}

/// Names of the four noise terms and of the ramp.
pub const TERM_NAMES: [&str; 5] =
    ["quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp"];

/// Name of a term, and its coefficient in the model.
fn term_of(part: Part, model: &[f64; 4]) -> Option<(&'static str, f64)> {
    crate::likelihood::bins::TERMS.iter().position(|&term| term == part).map(|k| (TERM_NAMES[k], model[k]))
}
