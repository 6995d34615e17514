//! The fit of one channel, complete: coefficients and processes with intervals, the filter, the verdict, and the range of
//! averaging times that the model describes.

use crate::likelihood::analysis::analyse;
use crate::likelihood::described::{LONGEST_SHARE, described_from};
use crate::likelihood::estimates::{Estimate, TermEstimate, quantile};
use crate::likelihood::expected::Part;
use crate::likelihood::filter::{FittedFilter, UNUSED_POWER};
use crate::likelihood::fitted_model::FittedModel;
use crate::likelihood::matern_process::MaternOutcome;
use crate::likelihood::outcome::WhiteLevel;
use crate::likelihood::outcome::{Options, Outcome, Process, Second};
use crate::likelihood::parts::{
    GaussMarkovEstimate, LineEstimate, Parameter, Parts, ResonanceEstimate, covariance,
};
use crate::likelihood::summary::Summary;
use crate::resonance::Resonance;
use crate::terms::{NOISE_TERMS, Term};
use std::f64::consts::LN_10;

/// Half width of the band in which record and model are compared, a quarter of a decade. \[ln Hz\]
const HALF_BAND: f64 = LN_10 / 8.0;

/// Verdict on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The terms describe the record.
    Adequate,
    /// The terms describe the record together with a filter, lines or processes.
    AdequateWith,
    /// The model is not exact, and the intervals are widened accordingly.
    Widened,
}

/// A drift of the mean that decays exponentially from the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarmUpEstimate {
    /// Drift at the first sample, of either sign. \[rate unit\]
    pub amplitude: Estimate,
    /// Time constant. \[s\]
    pub time: f64,
}

/// A model with one Matérn process in place of all slow noise.
#[derive(Debug, Clone, PartialEq)]
pub struct MaternEstimate {
    /// Whether the record shows the process.
    pub observed: bool,
    /// Standard deviation. \[rate unit\]
    pub sigma: Estimate,
    /// Upper limit of the standard deviation; None if the record sets no limit. \[rate unit\]
    pub upper_limit: Option<f64>,
    /// Correlation time, from 20 samples to a quarter of the record. \[s\]
    pub time: Estimate,
    /// Smoothness ν, from 0.02 to 1/2.
    pub smoothness: Estimate,
    /// Coefficients of the terms beside the process, by name. \[SI\]
    pub terms: Vec<(&'static str, f64)>,
    /// P-value of the Gauss-Markov process, ν = 1/2.
    pub gauss_markov: f64,
    /// Akaike's criterion of the fit minus that of this model.
    pub gain: f64,
    /// P-value of the goodness of fit.
    pub p_value: f64,
}

impl From<&MaternOutcome> for MaternEstimate {
    fn from(outcome: &MaternOutcome) -> Self {
        let limit = outcome.variance.high.sqrt();
        let coefficients = Term::NOISE.into_iter().map(Term::name).zip(outcome.terms.map(f64::sqrt));
        Self {
            observed: outcome.variance.observed,
            sigma: Estimate::root(&outcome.variance),
            upper_limit: limit.is_finite().then_some(limit),
            time: Estimate::from(&outcome.time),
            smoothness: Estimate::from(&outcome.smoothness),
            terms: coefficients.filter(|&(_, value)| value > 0.0).collect(),
            gauss_markov: outcome.gauss_markov,
            gain: outcome.gain,
            p_value: outcome.p_value,
        }
    }
}

/// Another model that explains the record as well, with the same resonances and lines.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondModel {
    /// Its coefficients by name. \[SI\]
    pub terms: Vec<(&'static str, f64)>,
    /// Standard deviation \[rate unit\] and correlation time \[s\] of each of its Gauss-Markov processes.
    pub gauss_markov: Vec<(f64, f64)>,
    /// Time constant of its warm-up. \[s\]
    pub warm_up: Option<f64>,
    /// Exponent α of its bias instability with the density f^−α, which is the sum of its processes in a geometric series.
    pub exponent: Option<f64>,
    /// Corner of its first-order filter of the white noise. \[Hz\]
    pub filter: Option<f64>,
}

impl From<&Second> for SecondModel {
    fn from(second: &Second) -> Self {
        let coefficients = Term::ALL.into_iter().map(Term::name).zip(second.terms.map(f64::sqrt));
        let gauss_markov = second.gauss_markov.iter().map(|&(variance, time)| (variance.sqrt(), time));
        Self {
            terms: coefficients.filter(|&(_, value)| value > 0.0).collect(),
            gauss_markov: gauss_markov.collect(),
            warm_up: second.warm_up,
            exponent: second.exponent,
            filter: second.filter,
        }
    }
}

/// The fit of one channel. Numbers are in the unit of the rate and seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelFit {
    /// Requested terms by name, and the ramp.
    pub terms: Vec<(&'static str, TermEstimate)>,
    /// Coefficients that together describe the record, by name: the observed terms and those of `unclear`.
    pub model: Vec<(&'static str, f64)>,
    /// Terms of the model of which none is significant given the others, although at least one is present.
    pub unclear: Vec<&'static str>,
    /// Gauss-Markov processes.
    pub gauss_markov: Vec<GaussMarkovEstimate>,
    /// Resonances before the filter.
    pub resonance: Vec<ResonanceEstimate>,
    /// Lines after the filter, the strongest first.
    pub sinusoid: Vec<LineEstimate>,
    /// Filter of all noise except quantization.
    pub response: Option<FittedFilter>,
    /// Drift that decays.
    pub warm_up: Option<WarmUpEstimate>,
    /// Coefficients of the regressors, in their units.
    pub regressors: Vec<Estimate>,
    /// Frequency from which the spectrum was left out. \[Hz\]
    pub highest: Option<f64>,
    /// If a rate random walk was observed: shortest correlation time of a Gauss-Markov process that explains the record as
    /// well. \[s\]
    pub alike_from: Option<f64>,
    /// Standard deviation of the process of this time, None if the model has no rate random walk. \[rate unit\]
    pub alike_sigma: Option<f64>,
    /// The model with one Matérn process, if it is wanted.
    pub matern: Option<MaternEstimate>,
    /// Other models that explain the record as well.
    pub second: Vec<SecondModel>,
    /// Discrepancy that the intervals allow for, even if the model is adequate: frequency \[Hz\], standard deviation of the
    /// logarithm of the density.
    pub discrepancy: Vec<(f64, f64)>,
    /// Verdict on the model.
    pub verdict: Verdict,
    /// The band with the largest difference from a model with widened intervals: frequency \[Hz\], density over that of the
    /// model.
    pub worst_band: Option<(f64, f64)>,
    /// Shortest averaging time at which the noise model from the fit describes the curve. \[s\]
    pub tau_min: f64,
    /// Longest averaging time. \[s\]
    pub tau_max: f64,
    /// P-value of the goodness of fit.
    pub p_value: f64,
    /// Names of the rows of `covariance`.
    pub parameters: Vec<Parameter>,
    /// Covariance of these parameters in row order. \[SI\]
    pub covariance: Vec<f64>,
    /// White noise of each eighth of the record that has samples.
    pub levels: Vec<WhiteLevel>,
    /// Ends of the stretch that each line leaves out of the fit. \[Hz\]
    pub left_out: Vec<(f64, f64)>,
    /// All resonances before the filter, including those that are listed as lines.
    pub resonances: Vec<Resonance>,
}

/// Sampling of the record of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Number of samples, including those that are missing at its ends.
    pub samples: usize,
}

/// Fits one channel. Regressors of the options may have any mean and size. `samples` is the number of samples of the
/// record, including those missing at its ends.
#[must_use]
pub fn fit_channel(record: &Summary, options: &Options, samples: usize) -> ChannelFit {
    let (regressors, sizes): (Vec<Vec<f64>>, Vec<f64>) =
        options.regressors.iter().map(|curve| standardized(curve)).unzip();
    let options = Options { regressors, ..options.clone() };
    let mut fit = ChannelFit::of(&analyse(record, &options), &options, Span { tau0: record.tau0, samples });
    for (coefficient, size) in fit.regressors.iter_mut().zip(sizes) {
        *coefficient = coefficient.scaled(1.0 / size);
    }
    fit
}

/// A curve scaled to mean 0 and standard deviation 1, and its original standard deviation.
pub(crate) fn standardized(curve: &[f64]) -> (Vec<f64>, f64) {
    let count = curve.len() as f64;
    let mean = pairwise_sum(curve) / count;
    let squares: Vec<f64> = curve.iter().map(|x| (x - mean).powi(2)).collect();
    let deviation = (pairwise_sum(&squares) / count).sqrt();
    let size = if deviation > 0.0 { deviation } else { 1.0 };
    (curve.iter().map(|x| (x - mean) / size).collect(), size)
}

/// Sum by recursive halves, down to runs that are added eight at a time: its error grows with the logarithm of the length
/// (N. J. Higham, "The accuracy of floating point summation", SIAM J. Sci. Comput. 14, 1993).
fn pairwise_sum(x: &[f64]) -> f64 {
    const RUN: usize = 128;
    if x.len() > RUN {
        let half = x.len() / 2;
        let (left, right) = x.split_at(half - half % 8);
        return pairwise_sum(left) + pairwise_sum(right);
    }
    let (eights, rest) = x.split_at(x.len() - x.len() % 8);
    let mut sums = [0.0; 8];
    for eight in eights.chunks_exact(8) {
        for (sum, x) in sums.iter_mut().zip(eight) {
            *sum += x;
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    rest.iter().fold(((a + b) + (c + d)) + ((e + f) + (g + h)), |sum, x| sum + x)
}

impl ChannelFit {
    /// The fit from an outcome.
    pub(crate) fn of(outcome: &Outcome, options: &Options, span: Span) -> Self {
        let level = options.level;
        let mut coefficients = [0.0; Term::ALL.len()];
        coefficients[..NOISE_TERMS].copy_from_slice(&outcome.reduced.map(|theta| theta.max(0.0).sqrt()));
        let noise: [f64; NOISE_TERMS] = std::array::from_fn(|k| coefficients[k]);
        let filter = filter(outcome, span.tau0, level);
        let parts = Parts::of(outcome, filter.as_ref(), level);
        let (parameters, covariance) = parts.with_lines(covariance(outcome, &noise));
        let Parts { gauss_markov, resonance, sinusoid, .. } = parts;
        let mut terms = terms(outcome, options, &noise, |term| {
            let row =
                parameters.iter().position(|&parameter| parameter == Parameter::Term(Term::NOISE[term]));
            row.map_or(0.0, |row| covariance[row * (parameters.len() + 1)].max(0.0).sqrt())
        });
        let ramp = TermEstimate::from_ramp(outcome.ramp, outcome.ramp_observed, level);
        terms.push((Term::RateRamp.name(), ramp));
        coefficients[Term::RateRamp.index()] = ramp.value.unwrap_or(0.0);
        let model: Vec<(&str, f64)> = Term::ALL
            .into_iter()
            .map(Term::name)
            .zip(coefficients)
            .filter(|&(_, value)| value != 0.0)
            .collect();
        let observed = |name| terms.iter().any(|&(term, estimate)| term == name && estimate.observed);
        let unclear = model.iter().map(|&(name, _)| name).filter(|&name| !observed(name)).collect();
        let warm_up = outcome.warm_up.map(|(time, drift, _)| WarmUpEstimate {
            amplitude: Estimate::around(drift.value, quantile(level) * drift.error),
            time,
        });
        let has_parts = filter.is_some()
            || !(gauss_markov.is_empty() && resonance.is_empty() && sinusoid.is_empty())
            || warm_up.is_some()
            || outcome.highest.is_some();
        let mut fit = Self {
            terms,
            model,
            unclear,
            gauss_markov,
            resonance,
            sinusoid,
            response: filter,
            warm_up,
            regressors: outcome
                .regressors
                .iter()
                .map(|drift| Estimate::around(drift.value, quantile(level) * drift.error))
                .collect(),
            highest: outcome.highest,
            alike_from: outcome.alike_from.map(|(time, _)| time),
            alike_sigma: outcome.alike_from.and_then(|(time, variance)| {
                alike_sigma(time, variance, noise[Term::RateRandomWalk.index()])
            }),
            matern: outcome.matern.as_ref().map(MaternEstimate::from),
            second: outcome.second.iter().map(SecondModel::from).collect(),
            discrepancy: outcome.discrepancy.clone(),
            verdict: match (outcome.widened, has_parts) {
                (true, _) => Verdict::Widened,
                (false, true) => Verdict::AdequateWith,
                (false, false) => Verdict::Adequate,
            },
            worst_band: outcome.widened.then(|| worst_band(outcome)),
            tau_min: span.tau0,
            tau_max: (span.samples / LONGEST_SHARE) as f64 * span.tau0,
            p_value: outcome.p_value,
            parameters,
            covariance,
            levels: outcome.levels.clone(),
            left_out: outcome.lines.iter().map(|line| (line.from, line.to)).collect(),
            resonances: resonances(outcome),
        };
        let (first, low_pass) = described_from(&fit.described(coefficients, span));
        fit.tau_min = first.min(fit.tau_max);
        if let Some(filter) = &mut fit.response {
            filter.low_pass = low_pass;
        }
        fit
    }

    /// The model in the form that computes its curve.
    fn described(&self, terms: [f64; Term::ALL.len()], span: Span) -> FittedModel {
        FittedModel {
            tau0: span.tau0,
            samples: span.samples,
            terms,
            gauss_markov: self
                .gauss_markov
                .iter()
                .map(|process| (process.sigma.value, process.time.value))
                .collect(),
            resonance: self
                .resonance
                .iter()
                .map(|band| Resonance {
                    sigma: band.sigma.value,
                    frequency: band.frequency.value,
                    width: band.width.value,
                })
                .collect(),
            sinusoid: self.sinusoid.iter().map(|line| (line.amplitude.value, line.frequency.value)).collect(),
            filter: self.response.clone(),
            highest: self.highest,
            warm_up: self.warm_up.map(|drift| (drift.amplitude.value, drift.time)),
        }
    }
}

/// The requested noise terms. A term that a filter has replaced was not tested.
fn terms(
    outcome: &Outcome,
    options: &Options,
    model: &[f64; NOISE_TERMS],
    error: impl Fn(usize) -> f64,
) -> Vec<(&'static str, TermEstimate)> {
    (0..NOISE_TERMS)
        .filter(|&k| options.terms[k])
        .map(|k| {
            let estimate = outcome.terms[k].as_ref().map_or_else(TermEstimate::default, |bounds| {
                let value = if model[k] > 0.0 { model[k] } else { bounds.value.sqrt() };
                TermEstimate::from_square(bounds, value, error(k), options.level)
            });
            (Term::NOISE[k].name(), estimate)
        })
        .collect()
}

/// All resonances, including lines.
fn resonances(outcome: &Outcome) -> Vec<Resonance> {
    let resonance = |process: &Process| match process.part {
        Part::Resonance { frequency, width } => {
            Some(Resonance { sigma: process.variance.value.max(0.0).sqrt(), frequency, width })
        }
        _ => None,
    };
    outcome.processes.iter().filter_map(resonance).collect()
}

/// The named filter. The fit used all frequencies if the filter passes power up to the last one.
fn filter(outcome: &Outcome, tau0: f64, level: f64) -> Option<FittedFilter> {
    if let Some(mean) = outcome.mean {
        return Some(FittedFilter::of_mean(mean, outcome.of_white));
    }
    if outcome.filter.is_empty() {
        return None;
    }
    let (order, first) = (outcome.covariance.len().isqrt(), outcome.parameters.len());
    let covariance = |i: usize, j: usize| outcome.covariance[(first + i) * order + first + j];
    if let Some(family) = outcome.family {
        let numbers = (family, &outcome.filter[..]);
        let sampled = (tau0, outcome.of_white);
        return Some(FittedFilter::from_family(numbers, covariance, sampled, quantile(level)));
    }
    let mut filter =
        FittedFilter::named(&outcome.filter, covariance, tau0, outcome.filter_interval, quantile(level));
    let last = outcome.bins.iter().map(|bin| bin[0]).fold(0.0, f64::max);
    if outcome.highest.is_none() || filter.power(last) < UNUSED_POWER {
        filter.known_to = Some(last);
    }
    Some(filter)
}

/// Standard deviation of the process that replaces a rate random walk K; if the record needs neither, that of a process
/// with the same density above 1/T, K² = 2σ²/T.
fn alike_sigma(time: f64, variance: f64, walk: f64) -> Option<f64> {
    let sigma = if variance > 0.0 { variance.sqrt() } else { walk * (0.5 * time).sqrt() };
    (walk > 0.0).then_some(sigma)
}

/// The band with the largest difference between record and model: its frequency, and the density over that of the model.
fn worst_band(outcome: &Outcome) -> (f64, f64) {
    let farther = |a: (f64, f64), b: (f64, f64)| if b.1.abs() > a.1.abs() { b } else { a };
    let worst = outcome.bands.iter().copied().reduce(farther);
    let frequency = worst.map_or(outcome.bins[0][0], |(frequency, _)| frequency);
    let off = |bin: &[f64; 4]| (bin[0] - frequency).abs();
    let nearest = outcome.bins.iter().map(off).fold(f64::INFINITY, f64::min);
    let band: Vec<&[f64; 4]> = outcome
        .bins
        .iter()
        .filter(|bin| (bin[0] / frequency).ln().abs() < HALF_BAND || off(bin) <= nearest)
        .collect();
    let sum: f64 = band.iter().map(|bin| bin[3]).sum();
    // If no bin of a band has weight, or no model is close to the spectrum, all bins have equal weights.
    let counts = sum > 0.0 && sum.is_finite();
    let weight = |bin: &[f64; 4]| if counts { bin[3] } else { 1.0 };
    let (ratios, weights) = band.iter().fold((0.0, 0.0), |(ratios, weights), bin| {
        (ratios + weight(bin) * (bin[1] / bin[2]), weights + weight(bin))
    });
    (frequency, ratios / weights)
}
