//! Slow lines: sinusoids below the band of the periodogram, which are regressors of the mean.
//!
//! Cosine and sine are regressors of the modes, with exact sums, so that a line may be anywhere between modes.

use crate::likelihood::bins::{Bins, Regressor};
use crate::likelihood::drifts::gain_of;
use crate::likelihood::fit::Fit;
use crate::likelihood::laws::chi2_quantile_above;
use crate::likelihood::linear::Symmetric;
use crate::likelihood::model::Model;
use crate::likelihood::outcome::SlowLine;
use crate::likelihood::regression::regress;
use crate::likelihood::summary::Summary;
use crate::terms::Term;
use std::sync::Arc;

/// Probability of a false line in an octave of frequency, if the density is known.
const FALSE_ALARM: f64 = 1e-4;

/// The same for a line at a multiple of the frequency of another line, and the highest multiple.
const FALSE_HARMONIC: f64 = 3e-3;
const MAX_HARMONICS: f64 = 7.0;

/// Largest number of lines of a channel, and of candidates that are fitted.
const MAX_LINES: usize = 8;
const MAX_CANDIDATES: usize = 3;

/// A line may be where the squares of three modes over their densities, minus 3, exceed this share of its price. Three
/// modes have at least 0.8 of the squares of a line; among the lowest modes, the density of a fit without the line is too
/// high.
const WORTH_A_FIT: f64 = 0.7;
const WORTH_A_FIT_BELOW: f64 = 0.5;
const LOWEST_MODES: usize = 48;

/// Number of modes on either side of a peak that determine its frequency, and steps and width of the search, in modes.
const WINDOW: usize = 24;
const STEPS_OF_SEARCH: usize = 17;
const WIDTH_OF_SEARCH: f64 = 2.0;

/// Number of least-squares steps of the frequency, longest step in cycles of the record, and change for a derivative.
const STEPS: usize = 4;
const LONGEST_STEP: f64 = 0.25;
const DIFFERENCE: f64 = 1e-3;

/// Number of modes on either side of a line that must remain at the density of the noise, and probability that they exceed
/// it by chance.
const FOOT_MODES: usize = 8;
const WANDERING_PROBABILITY: f64 = 1e-3;

/// Share of its price that a line must gain in a complete model.
const IDLE_SHARE: f64 = 0.8;

/// Smallest reduction of the deviance for a line at a frequency; the false-alarm probability is the same in each octave.
fn price(frequency: f64, fit: &Fit, bins: &Bins) -> f64 {
    let cycles = (2.0 * frequency * bins.record.duration()).max(2.0);
    if is_harmonic(frequency, fit, bins) {
        return -2.0 * FALSE_HARMONIC.ln();
    }
    2.0 * (cycles / FALSE_ALARM).ln()
}

/// Whether a frequency is, within the resolution of the record, a multiple of that of a line of a fit.
fn is_harmonic(frequency: f64, fit: &Fit, bins: &Bins) -> bool {
    let resolution = 0.5 / bins.record.duration();
    frequencies(&fit.model, bins).any(|base| {
        let multiple = (frequency / base).round();
        (2.0..=MAX_HARMONICS).contains(&multiple) && (frequency - multiple * base).abs() < resolution
    })
}

/// Frequencies of the lines of a model. \[Hz\]
fn frequencies<'a>(model: &'a Model, bins: &'a Bins) -> impl Iterator<Item = f64> + 'a {
    cosines(model, bins).filter_map(|k| bins.regressors[k].line)
}

/// The regressors of a model that are cosines of lines; their sines come next.
fn cosines<'a>(model: &'a Model, bins: &'a Bins) -> impl Iterator<Item = usize> + 'a {
    let is_cosine = |&k: &usize| bins.regressors[k].line.is_some() && k + 1 < bins.regressors.len();
    model.regressors.iter().copied().filter(is_cosine)
}

/// Adds the lines that reduce the deviance of a fit by more than their prices, one by one; returns whether there are any.
pub(crate) fn add_lines(fit: &mut Fit, bins: &mut Bins) -> bool {
    let mut added = false;
    while cosines(&fit.model, bins).count() < MAX_LINES {
        let tried = candidates(fit, bins).into_iter().map(|frequency| {
            let (fitted, with) = with_line(fit, bins, frequency);
            let at = frequencies(&fitted.model, &with).last().unwrap_or(frequency);
            (gain_of(fit, &fitted) - price(at, fit, bins), fitted, with)
        });
        let tried = tried.filter(|(net, fitted, with)| *net > 0.0 && is_steady(fitted, with));
        let Some((_, fitted, with)) = tried.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        (*fit, *bins, added) = (fitted, with, true);
    }
    added
}

/// Whether the last line of a fit explains the peak around it; a drifting line is narrow-band noise or several lines.
fn is_steady(fit: &Fit, bins: &Bins) -> bool {
    let Some(frequency) = frequencies(&fit.model, bins).last() else { return true };
    let peaks = Peaks::of(fit, bins);
    let middle = peaks.frequency.partition_point(|&f| f < frequency);
    let around =
        &peaks.excess[middle.saturating_sub(FOOT_MODES)..(middle + FOOT_MODES).min(peaks.excess.len())];
    around.iter().sum::<f64>() < chi2_quantile_above(WANDERING_PROBABILITY, around.len() as f64)
}

/// Removes the lines that a fit does not need.
pub(crate) fn without_idle_lines(fit: &mut Fit, bins: &Bins) {
    loop {
        let tried = cosines(&fit.model, bins).map(|cosine| {
            let without = without_line(fit, bins, cosine);
            let frequency = bins.regressors[cosine].line.unwrap_or(0.0);
            (gain_of(&without, fit) - IDLE_SHARE * price(frequency, &without, bins), without)
        });
        match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((net, without)) if net < 0.0 => *fit = without,
            _ => return,
        }
    }
}

/// Sum of the prices of the lines of a fit.
pub(crate) fn prices(fit: &Fit, bins: &Bins) -> f64 {
    frequencies(&fit.model, bins).map(|frequency| price(frequency, fit, bins)).sum()
}

fn without_line(fit: &Fit, bins: &Bins, cosine: usize) -> Fit {
    let mut model = fit.model.clone();
    model.regressors.retain(|&k| k != cosine && k != cosine + 1);
    model.fit(bins)
}

/// The fit with a line near a frequency, and its bins.
pub(crate) fn with_line<'a>(fit: &Fit, bins: &Bins<'a>, frequency: f64) -> (Fit, Bins<'a>) {
    let cosine = bins.regressors.len();
    let mut with = with_curves(bins, cosine, frequency);
    let mut model = fit.model.clone();
    model.regressors.extend([cosine, cosine + 1]);
    let mut fitted = model.fit(&with);
    refine(&mut fitted, &mut with, cosine);
    (fitted, with)
}

/// The bins with the cosine and the sine of a line as the regressors `cosine` and `cosine` + 1.
fn with_curves<'a>(bins: &Bins<'a>, cosine: usize, frequency: f64) -> Bins<'a> {
    let mut all = bins.regressors.to_vec();
    all.truncate(cosine);
    let [even, odd] = bins.record.modes_of_line(frequency);
    all.push(Regressor { modes: even, line: Some(frequency) });
    all.push(Regressor { modes: odd, line: None });
    all.extend(bins.regressors.iter().skip(cosine + 2).cloned());
    let mut with = bins.clone();
    with.regressors = Arc::new(all);
    with
}

/// Moves a line to its best frequency, by steps of least squares.
fn refine(fit: &mut Fit, bins: &mut Bins, cosine: usize) {
    let mut frequency = bins.regressors[cosine].line.unwrap_or(0.0);
    let limits = frequency_limits(bins.record);
    for _ in 0..STEPS {
        let Some((step, error)) = frequency_step(fit, bins, cosine) else { return };
        let longest = LONGEST_STEP / bins.record.duration();
        frequency = (frequency + step.clamp(-longest, longest)).clamp(limits.0, limits.1);
        let with = with_curves(bins, cosine, frequency);
        let next = fit.model.clone().fit(&with);
        if gain_of(fit, &next) < 0.0 {
            return;
        }
        (*fit, *bins) = (next, with);
        if step.abs() < 0.02 * error {
            return;
        }
    }
}

/// Lowest and highest frequency of a slow line: a cycle in the record, and the end of the modes. \[Hz\]
fn frequency_limits(record: &Summary) -> (f64, f64) {
    (1.0 / record.duration(), record.mode_frequency(record.low_modes().max(1)))
}

/// Change of the frequency of a line by least squares, and its standard error. \[Hz\]
fn frequency_step(fit: &Fit, bins: &Bins, cosine: usize) -> Option<(f64, f64)> {
    let (beta, covariance, used) = with_slope(fit, bins, cosine)?;
    let last = used - 1;
    Some((beta[last], covariance.get(last, last).max(0.0).sqrt()))
}

/// Coefficients and covariance of all regressors and, last, of a change of the frequency of a line; and their number.
fn with_slope(fit: &Fit, bins: &Bins, cosine: usize) -> Option<(Vec<f64>, Symmetric, usize)> {
    let frequency = bins.regressors[cosine].line?;
    let at = fit.model.regressors.iter().position(|&k| k == cosine)?;
    let (a, b) = (fit.beta[at], fit.beta[at + 1]);
    let change = DIFFERENCE / bins.record.duration();
    let [up, down] = [frequency + change, frequency - change].map(|f| bins.record.modes_of_line(f));
    let slope = |k: usize| (a * (up[0][k] - down[0][k]) + b * (up[1][k] - down[1][k])) / (2.0 * change);
    let modes = (0..bins.record.modes.len()).map(slope).collect();
    let mut with = bins.clone();
    let mut all = bins.regressors.to_vec();
    all.push(Regressor { modes, line: None });
    let mut used = fit.model.regressors.clone();
    used.push(all.len() - 1);
    with.regressors = Arc::new(all);
    let quantization = fit.model.index(Term::Quantization).map_or(0.0, |j| fit.model.theta[j]);
    let fitted = regress(&with.products(&used), &fit.spectrum, quantization);
    Some((fitted.beta, fitted.covariance, used.len()))
}

/// The lines of a fit, with joint errors of amplitude and frequency.
pub(crate) fn slow_lines(fit: &Fit, bins: &Bins) -> Vec<SlowLine> {
    let line = |cosine: usize| {
        let (_, covariance, count) = with_slope(fit, bins, cosine)?;
        let at = fit.model.regressors.iter().position(|&k| k == cosine)?;
        let (a, b) = (fit.beta[at], fit.beta[at + 1]);
        let amplitude = a.hypot(b);
        let variance = (a * a * covariance.get(at, at)
            + 2.0 * a * b * covariance.get(at, at + 1)
            + b * b * covariance.get(at + 1, at + 1))
            / (amplitude * amplitude);
        Some(SlowLine {
            frequency: bins.regressors[cosine].line?,
            frequency_error: covariance.get(count - 1, count - 1).max(0.0).sqrt(),
            amplitude,
            amplitude_error: variance.max(0.0).sqrt(),
        })
    };
    cosines(&fit.model, bins).filter_map(line).collect()
}

/// Frequencies at which the modes exceed a fit most: the best frequencies near the highest peaks. \[Hz\]
fn candidates(fit: &Fit, bins: &Bins) -> Vec<f64> {
    let peaks = Peaks::of(fit, bins);
    let share = |i: usize| if peaks.mode[i] < LOWEST_MODES { WORTH_A_FIT_BELOW } else { WORTH_A_FIT };
    let least = -2.0 * FALSE_HARMONIC.ln() * WORTH_A_FIT_BELOW; // the lowest price
    let mut high: Vec<(f64, usize)> = (1..peaks.excess.len().saturating_sub(1))
        .map(|i| (peaks.excess[i - 1] + peaks.excess[i] + peaks.excess[i + 1] - 3.0, i))
        .filter(|&(sum, i)| sum > least && sum > share(i) * price(peaks.frequency[i], fit, bins))
        .collect();
    high.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<usize> = Vec::new();
    for (_, i) in high {
        if chosen.len() < MAX_CANDIDATES && chosen.iter().all(|&j| i.abs_diff(j) > 3) {
            chosen.push(i);
        }
    }
    chosen.into_iter().map(|i| peaks.best_frequency(i, bins.record)).collect()
}

/// Residuals of the modes after a fit.
struct Peaks {
    /// Numbers of the modes, minus 1.
    mode: Vec<usize>,
    /// \[Hz\]
    frequency: Vec<f64>,
    residual: Vec<f64>,
    density: Vec<f64>,
    /// Squares over densities.
    excess: Vec<f64>,
}

impl Peaks {
    fn of(fit: &Fit, bins: &Bins) -> Self {
        let record = bins.record;
        let mut peaks =
            Self { mode: vec![], frequency: vec![], residual: vec![], density: vec![], excess: vec![] };
        for (bin, k) in bins.low_modes() {
            let followed: f64 = fit
                .model
                .regressors
                .iter()
                .zip(&fit.beta)
                .map(|(&j, b)| b * bins.regressors[j].modes[k])
                .sum();
            let residual = record.modes[k] - followed;
            peaks.mode.push(k);
            peaks.frequency.push(record.mode_frequency(k + 1));
            peaks.residual.push(residual);
            peaks.density.push(fit.spectrum[bin]);
            peaks.excess.push(residual * residual / fit.spectrum[bin]);
        }
        peaks
    }

    /// The frequency near a peak at which a line explains most of the neighbouring modes.
    fn best_frequency(&self, peak: usize, record: &Summary) -> f64 {
        let (low, high) = frequency_limits(record);
        let spacing = 0.5 / record.duration();
        let from = peak.saturating_sub(WINDOW);
        let to = (peak + WINDOW + 1).min(self.mode.len());
        let gain = |frequency: f64| {
            let [even, odd] = record.some_modes_of_line(frequency, &self.mode[from..to]);
            let mut sums = [0.0; 5];
            for (i, (a, b)) in (from..to).zip(even.iter().zip(&odd)) {
                let weight = 1.0 / self.density[i];
                let terms = [a * a, a * b, b * b, a * self.residual[i], b * self.residual[i]];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
            }
            let [aa, ab, bb, ax, bx] = sums;
            let determinant = (aa * bb - ab * ab).max(1e-12 * aa * bb);
            if determinant > 0.0 {
                (bb * ax * ax - 2.0 * ab * ax * bx + aa * bx * bx) / determinant
            } else {
                0.0
            }
        };
        let at = |step: usize| {
            let share = step as f64 / (STEPS_OF_SEARCH - 1) as f64;
            (self.frequency[peak] + WIDTH_OF_SEARCH * (2.0 * share - 1.0) * spacing).clamp(low, high)
        };
        let tried = (0..STEPS_OF_SEARCH).map(|step| (gain(at(step)), at(step)));
        tried.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(self.frequency[peak], |(_, frequency)| frequency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::drifts::regressors;
    use crate::likelihood::expected::Part;
    use crate::likelihood::outcome::Options;
    use std::f64::consts::PI;

    const TAU0: f64 = 0.5;

    /// White noise with standard deviation 1, as sums of twelve numbers of a linear congruential generator.
    fn white(count: usize) -> Vec<f64> {
        let mut state = 12_345_u64;
        let mut next = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| (0..12).map(|_| next()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn modes_of_a_line_are_those_of_its_samples() {
        let record = Summary::of(&white(3000), TAU0).unwrap();
        let duration = record.duration();
        // Between modes, and at an even and an odd one.
        for frequency in [3.37, 2.0, 2.5].map(|cycles| cycles / duration) {
            let angle = |i: usize| 2.0 * PI * frequency * TAU0 * (i as f64 + 0.5 - 1500.0);
            let cosine = record.modes_of(&(0..3000).map(|i| angle(i).cos()).collect::<Vec<_>>());
            let sine = record.modes_of(&(0..3000).map(|i| angle(i).sin()).collect::<Vec<_>>());
            let closed = record.modes_of_line(frequency);
            for (plain, closed) in [(cosine, &closed[0]), (sine, &closed[1])] {
                let largest = plain.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
                for (a, b) in plain.iter().zip(closed) {
                    assert!((a - b).abs() < 1e-9 * largest, "{frequency}: {a} and {b}");
                }
            }
        }
    }

    #[test]
    fn a_line_between_two_modes_is_found_with_its_errors() {
        let count = 8000;
        let duration = TAU0 * count as f64;
        let (amplitude, frequency) = (0.4, 7.3 / duration);
        let samples: Vec<f64> = white(count)
            .iter()
            .enumerate()
            .map(|(i, x)| x + amplitude * (2.0 * PI * frequency * TAU0 * i as f64 + 1.0).sin())
            .collect();
        let record = Summary::of(&samples, TAU0).unwrap();
        let mask = Arc::new(vec![true; record.density.len()]);
        let all = Arc::new(regressors(&record, &Options::default()));
        let mut bins = Bins::new(&record, mask, all);
        let mut fit =
            Model::new(vec![Part::Term(Term::RandomWalk), Part::Term(Term::RateRandomWalk)], vec![0, 1])
                .fit(&bins);
        assert!(add_lines(&mut fit, &mut bins));
        let [line] = slow_lines(&fit, &bins)[..] else { panic!("one line") };
        // For a sinusoid in white noise: √(2/n) times the noise, and √6 / (π T √(n/2)) over the ratio.
        let expected = (2.0 / count as f64).sqrt();
        assert!((line.amplitude_error / expected - 1.0).abs() < 0.1, "{line:?}");
        assert!((line.amplitude - amplitude).abs() < 4.0 * expected, "{line:?}");
        let expected = 6.0_f64.sqrt() / (PI * duration * amplitude * (count as f64).sqrt() / 1.0);
        assert!((line.frequency_error / expected - 1.0).abs() < 0.15, "{line:?} {expected}");
        assert!((line.frequency - frequency).abs() < 4.0 * expected, "{line:?}");
        without_idle_lines(&mut fit, &bins);
        assert_eq!(slow_lines(&fit, &bins).len(), 1);
    }
}
