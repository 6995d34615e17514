//! The whole way from a summary to coefficients with intervals.

use crate::likelihood::adequacy::adequacy;
use crate::likelihood::bins::{Bins, ENDS, Regressor, TERMS, usable};
use crate::likelihood::discrepancy::widened;
use crate::likelihood::expected::Part;
use crate::likelihood::laws::{chi2_above, chi2_quantile_above};
use crate::likelihood::lines::{Line, above_medians, above_model, beyond_band, without_images};
use crate::likelihood::masked::Levels;
use crate::likelihood::model::{Fit, Model, Shape, TOLERANCE};
use crate::likelihood::pass::{PARTS, Summary};
use crate::likelihood::profile::{Bounds, Thresholds, of_part, of_resonance, of_time};
use crate::likelihood::select::{Allowed, GOOD, second_explanations, select};
use std::f64::consts::PI;
use std::sync::Arc;

/// P-value below which a model is not adequate, and its intervals are widened.
const LEAST: f64 = 0.002;

/// Square of Student's t with 7 degrees of freedom at 95 %, over that of the normal: the size of the wiggle is known from
/// about as many bands.
const WIDENED: f64 = 5.591 / 3.841;

/// Fall of the deviance for a warm-up, and its time constants over the length of the record.
const WARM_UP: f64 = 16.0;
const WARM_UPS: [f64; 6] = [96.0, 48.0, 24.0, 12.0, 6.0, 3.0];

/// Steps of the logarithm of the time constant by which the best one is refined.
const REFINED: [f64; 4] = [0.34, 0.17, 0.09, 0.045];

/// Step of the derivative by the logarithm of the time constant.
const SLOPE: f64 = 1e-3;

/// Fall of the deviance by which a warm-up has to be better than a ramp.
const CURVATURE: f64 = 6.0;

/// Standard errors from which a ramp counts, with the rate random walk at its upper limit.
const RAMP: f64 = 3.3;

/// Steps of the search for the ends of its interval.
const RAMP_DOUBLINGS: usize = 8;
const RAMP_HALVINGS: usize = 5;

/// Lowest end of the band over the highest mode, where the top of the band is left out.
const LEAST_BAND: f64 = 5.0;

/// P-value below which a narrower band describes the record no better than the whole one.
const HOPELESS: f64 = 1e-4;

/// Times that the band is halved, and after which it is so only to find white noise behind a filter.
const MOST_HALVINGS: u32 = 10;
const USUAL_SHARE: f64 = 16.0;

/// Correlation time up to which a process without white noise beside it may be white noise behind a filter. [s]
const SLOWEST_FILTER: f64 = 2.0;

/// White noise over the level of such a process below which there is none beside it.
const NO_WHITE: f64 = 0.1;

/// Filters and resonances in the high band beyond which its top is left out rather than described.
const MOST_HIGH_PARTS: f64 = 6.0;

/// Share of an eighth of the record without which it says nothing of the steadiness of the noise.
const LEAST_PART: f64 = 0.2;

/// Standard errors from which a term says how much information a mask leaves.
const STANDS_OUT: f64 = 2.0;

/// Searches for lines.
const LINE_SEARCHES: usize = 3;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::struct_excessive_bools)] // one for each thing that may be added
pub struct Options {
    /// Terms that may be present: quantization, random walk, bias instability, rate random walk.
    pub terms: [bool; 4],
    /// Whether a filter, Gauss-Markov processes and resonances may be added.
    pub filter: bool,
    /// See `filter`.
    pub processes: bool,
    /// See `filter`.
    pub resonances: bool,
    /// Whether lines are left out.
    pub lines: bool,
    /// Whether a rate ramp and a warm-up are tested.
    pub drifts: bool,
    /// Correlation times of Gauss-Markov processes that are in the model from the start. [s]
    pub times: Vec<f64>,
    /// Curves that the mean may follow, at the centres of the blocks.
    pub regressors: Vec<Vec<f64>>,
    /// Confidence level.
    pub level: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            terms: [true; 4],
            filter: true,
            processes: true,
            resonances: true,
            lines: true,
            drifts: true,
            times: Vec::new(),
            regressors: Vec::new(),
            level: 0.95,
        }
    }
}

/// A Gauss-Markov process or a resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Process {
    /// What it is, with its shape.
    pub part: Part,
    /// Its variance.
    pub variance: Bounds,
    /// Its correlation time [s], or its centre and half width [Hz].
    pub shape: [Option<Bounds>; 2],
}

/// A coefficient of a regressor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Value, per unit of the regressor.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// The result for one channel. Parameters are squares of coefficients, in the unit of the rate and seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The terms that were fitted: Q², N², B², K².
    pub terms: [Option<Bounds>; 4],
    /// The model that describes the record: the same with terms that were not observed removed.
    pub reduced: [f64; 4],
    /// Processes and resonances.
    pub processes: Vec<Process>,
    /// ln |H|² = Σ aₖ (cos 2πk f Δ − 1): a filter on all but quantization noise.
    pub filter: Vec<f64>,
    /// Δ: the sample interval, or a multiple where the top of the band was left out. [s]
    pub filter_interval: f64,
    /// Lines that were left out.
    pub lines: Vec<Line>,
    /// Frequency from which the band was left out. [Hz]
    pub highest: Option<f64>,
    /// Where a rate random walk was observed: a Gauss-Markov process of this or a longer time [s] explains the record as
    /// well; and the variance of the one of this time.
    pub alike_from: Option<(f64, f64)>,
    /// Rate ramp, per second; and whether it stands out and is part of the model.
    pub ramp: Drift,
    /// See `ramp`.
    pub ramp_observed: bool,
    /// Time constant [s], amplitude at the start, and fall of the deviance.
    pub warm_up: Option<(f64, Drift, f64)>,
    /// Coefficients of the regressors given.
    pub regressors: Vec<Drift>,
    /// P-value of the model.
    pub p_value: f64,
    /// Whether the model is not adequate, and intervals are widened.
    pub widened: bool,
    /// Bands: frequency [Hz], normal deviate of record and model.
    pub bands: Vec<(f64, f64)>,
    /// Size of the wiggle that the intervals allow for: frequency [Hz], standard deviation of the logarithm of the density.
    pub discrepancy: Vec<(f64, f64)>,
    /// Standard deviation of the white level over eighths of the record beyond chance, relative, and its p-value.
    pub unsteadiness: (f64, f64),
    /// Excess kurtosis of the samples.
    pub kurtosis: f64,
    /// Parts of the reduced model, in the order of `covariance`: terms by index 0 … 3, then processes.
    pub parameters: Vec<Part>,
    /// Covariance of their parameters, of the coefficients of the filter, and of the shapes of processes in the order of the
    /// parts (logarithms of times and widths; frequencies in widths), row after row.
    pub covariance: Vec<f64>,
    /// Bins: frequency [Hz], measured and expected density, degrees of freedom.
    pub bins: Vec<[f64; 4]>,
}

const RAMP_AT: usize = 2;
const WARM_AT: usize = 3;
const GIVEN_AT: usize = WARM_AT + WARM_UPS.len();

/// Analyses one channel.
#[must_use]
pub fn analyse(record: &Summary, options: &Options) -> Outcome {
    let regressors = Arc::new(regressors(record, options));
    let mut mask = usable(record);
    let mut lines = Vec::new();
    if options.lines {
        lines = beyond_band(record, &mask);
        for _ in 0..LINE_SEARCHES {
            let least = of_terms(record, &mask);
            let found = above_medians(record, &mut mask, least.as_deref());
            if found.is_empty() {
                break;
            }
            lines.extend(found);
        }
    }
    let lines = without_images(record, lines);
    let Attempt { mut bins, mut fit, lines, highest, .. } =
        best_attempt(record, &mask, &lines, &regressors, options);
    let thresholds = thresholds(options.level);
    bins.regressors = regressors;
    let Drifts { ramp, ramp_observed, warm_up } =
        with_drifts(&mut fit, &mut bins, thresholds, options.drifts);
    let test = adequacy(&fit, &bins);
    let given: Vec<Drift> = (0..options.regressors.len()).map(|k| drift(&fit, GIVEN_AT + k)).collect();
    let wide = test.p_value < LEAST;
    let plain = fit.clone();
    let (limited, limited_bins, discrepancy) = widened(&fit, &bins);
    let at = if wide { thresholds.scaled(WIDENED) } else { thresholds };
    let (mut terms, mut reduced) = intervals(&limited, &limited_bins, at);
    join_alike(&mut terms, &plain, &bins, at, allowed(record, options));
    reduced = reduced.model.clone().refit(&bins, 40, TOLERANCE, &plain);
    value_of_likelihood(&mut terms, &plain, &reduced);
    if let Some(j) = plain.model.index(Part::RandomWalk) {
        heavy_tails(&mut terms[j], record);
    }
    // The values are those of the reduced model, as are those of the terms: together they are the model of the record.
    let processes = limited
        .model
        .processes()
        .zip(reduced.model.processes())
        .map(|(j, k)| {
            let part = reduced.model.parts[k];
            let shape = match (of_time(&limited, &limited_bins, j, at), part) {
                (Some(bounds), Part::GaussMarkov { time }) => [Some(bounds.around(time)), None],
                (_, Part::Resonance { frequency, width }) => of_resonance(&limited, &limited_bins, j, at)
                    .map_or([None, None], |[centre, half]| {
                        [Some(centre.around(frequency)), Some(half.around(width))]
                    }),
                _ => [None, None],
            };
            let variance = of_part(&limited, &limited_bins, j, at).around(reduced.model.theta[k]);
            Process { part, variance, shape }
        })
        .collect();
    let (information, _) = reduced.information(&limited_bins);
    let covariance = information.pseudo_inverse();
    let count = covariance.order;
    let unsteadiness = unsteadiness(&plain, &bins);
    let alike_from = process_like_walk(&reduced, &limited_bins, at);
    Outcome {
        alike_from,
        terms: TERMS.map(|part| plain.model.index(part).map(|j| terms[j])),
        reduced: TERMS.map(|part| reduced.model.index(part).map_or(0.0, |j| reduced.model.theta[j])),
        processes,
        filter: reduced.model.filter.clone(),
        filter_interval: bins.spacing as f64 * record.tau0,
        lines,
        highest,
        ramp,
        ramp_observed,
        warm_up,
        regressors: given,
        p_value: test.p_value,
        widened: wide,
        bands: test.bands,
        discrepancy,
        unsteadiness,
        kurtosis: record.kurtosis,
        parameters: reduced.model.parts.clone(),
        covariance: (0..count)
            .flat_map(|i| (0..count).map(move |j| (i, j)))
            .map(|(i, j)| covariance.get(i, j))
            .collect(),
        bins: (0..bins.len())
            .map(|i| [bins.frequency[i], plain.powers[i], plain.spectrum[i], bins.freedom[i]])
            .collect(),
    }
}

/// The curves that the mean may follow: the end values of the angle, a ramp, warm-ups, and those given.
fn regressors(record: &Summary, options: &Options) -> Vec<Regressor> {
    let (m, length) = (record.blocks as f64, record.block_length());
    // With missing samples the ends are those of runs, and their weights fall to 0 there.
    let length = if record.masked.is_some() { f64::INFINITY } else { length };
    let end = |k: usize| (2.0 / m).sqrt() * (PI * k as f64 / (2.0 * m)).cos() / length.sqrt();
    let modes = 1..=record.modes.len();
    let last = modes.clone().map(|k| if k % 2 == 0 { end(k) } else { -end(k) }).collect();
    let mut found = vec![Regressor { modes: last }, Regressor { modes: modes.map(end).collect() }];
    found.push(Regressor { modes: record.modes_of_ramp() });
    found.extend(WARM_UPS.map(|share| Regressor { modes: record.modes_of_decay(record.duration() / share) }));
    found.extend(options.regressors.iter().map(|curve| Regressor { modes: record.modes_of(curve) }));
    found
}

struct Attempt<'a> {
    bins: Bins<'a>,
    fit: Fit,
    p_value: f64,
    lines: Vec<Line>,
    highest: Option<f64>,
}

/// The model of the whole band; or, if none is adequate, of the widest band that has one.
fn best_attempt<'a>(
    record: &'a Summary,
    mask: &[bool],
    lines: &[Line],
    regressors: &Arc<Vec<Regressor>>,
    options: &Options,
) -> Attempt<'a> {
    let nyquist = 0.5 / record.tau0;
    let lowest = record.mode_frequency(record.low_modes());
    let mut attempts: Vec<Attempt<'a>> = Vec::new();
    let mut good = None; // the widest band with an adequate model, whose white noise may be hidden
    for share in (0..MOST_HALVINGS).map(|halvings| f64::from(1 << halvings)) {
        let mut mask = mask.to_vec();
        let highest = (share > 1.0).then_some(nyquist / share);
        if let Some(highest) = highest {
            if highest < LEAST_BAND * lowest {
                break;
            }
            let from = (highest * record.segment as f64 * record.tau0).ceil() as usize;
            if !mask[from..].contains(&true) {
                continue; // nothing of the noise is left there: it was not used before either
            }
            mask[from..].fill(false);
        }
        let attempt = attempt(record, mask, lines.to_vec(), regressors, options, highest);
        let model = &attempt.fit.model;
        let high =
            |part: &Part| matches!(part, Part::Resonance { frequency, .. } if *frequency > nyquist / 32.0);
        let many = model.filter.len() as f64 / 2.0 + model.parts.iter().filter(|p| high(p)).count() as f64;
        let wanted = if highest.is_none() && many == 0.0 { LEAST } else { GOOD };
        let done = attempt.p_value >= wanted && many <= MOST_HIGH_PARTS;
        let hidden = hides_white_noise(&attempt.fit);
        attempts.push(attempt);
        if done && !hidden {
            return attempts.swap_remove(attempts.len() - 1);
        }
        if done && good.is_none() {
            good = Some(attempts.len() - 1);
        }
        if share >= USUAL_SHARE && !attempts.iter().any(|a| hides_white_noise(&a.fit)) {
            break;
        }
    }
    let last_good = attempts.iter().rposition(|a| a.p_value >= GOOD);
    let adequate = attempts.iter().position(|a| a.p_value >= LEAST);
    let least_bad = || {
        let among = (0..attempts.len()).filter(|&a| attempts[a].p_value >= HOPELESS);
        among.max_by(|&a, &b| attempts[a].p_value.total_cmp(&attempts[b].p_value))
    };
    let chosen = good.or(last_good).or(adequate).or_else(least_bad).unwrap_or(0);
    attempts.swap_remove(chosen)
}

/// Whether a fast process stands for white noise behind a filter: nothing else of the white noise is seen.
fn hides_white_noise(fit: &Fit) -> bool {
    fit.model.index(Part::RandomWalk).is_some_and(|j| fit.model.theta[j] < NO_WHITE * fast_level(fit))
}

/// Highest level at low frequencies of processes as fast as filters are.
fn fast_level(fit: &Fit) -> f64 {
    let level = |(part, theta): (&Part, &f64)| match part {
        Part::GaussMarkov { time } if *time <= SLOWEST_FILTER => 2.0 * theta * time,
        _ => 0.0,
    };
    fit.model.parts.iter().zip(&fit.model.theta).map(level).fold(0.0, f64::max)
}

fn attempt<'a>(
    record: &'a Summary,
    mask: Vec<bool>,
    mut lines: Vec<Line>,
    regressors: &Arc<Vec<Regressor>>,
    options: &Options,
    highest: Option<f64>,
) -> Attempt<'a> {
    let mut bins = Bins::new(record, Arc::new(mask), regressors.clone());
    bins.see(&lines);
    let allowed = allowed(record, options);
    let mut parts: Vec<Part> = TERMS
        .into_iter()
        .zip(wanted_terms(record, options))
        .filter(|(_, w)| *w)
        .map(|(part, _)| part)
        .collect();
    parts.extend(options.times.iter().map(|&time| Part::GaussMarkov { time }));
    let mut used = if record.masked.is_some() { Vec::new() } else { ENDS.to_vec() };
    used.extend((0..options.regressors.len()).map(|k| GIVEN_AT + k));
    let mut start = informed(Model::new(parts, used).fit(&bins), &mut bins);
    with_drifts(&mut start, &mut bins, thresholds(options.level), options.drifts);
    let mut fit = select(start, &bins, allowed);
    for _ in 0..if options.lines { LINE_SEARCHES } else { 0 } {
        let mut mask = bins.mask.to_vec();
        let found = above_model(&bins, &fit.model, &mut mask);
        if found.is_empty() {
            break;
        }
        lines.extend(found);
        lines = without_images(record, lines);
        bins = Bins::new(record, Arc::new(mask), bins.regressors.clone());
        bins.see(&lines);
        fit = informed(fit.model.clone().fit(&bins), &mut bins);
        fit = select(fit, &bins, allowed);
    }
    fit = informed(fit, &mut bins);
    let p_value = adequacy(&fit, &bins).p_value;
    Attempt { bins, fit, p_value, lines, highest }
}

fn allowed(record: &Summary, options: &Options) -> Allowed {
    Allowed {
        quantization: wanted_terms(record, options)[0],
        filter: options.filter,
        processes: options.processes,
        resonances: options.resonances,
    }
}

/// The terms that may be present. Without neighbouring samples the densities of quantization noise and random walk are
/// the same, and the random walk stands for both.
fn wanted_terms(record: &Summary, options: &Options) -> [bool; 4] {
    let mut terms = options.terms;
    terms[0] &= record.masked.as_ref().is_none_or(|masked| masked.has_neighbours() || !terms[1]);
    terms
}

/// With missing samples: the fit with the information that the mask leaves, of quantization noise and random walk the
/// smaller one, if they stand out.
fn informed(fit: Fit, bins: &mut Bins) -> Fit {
    let Some(masked) = bins.record.masked.clone() else { return fit };
    if bins.ranges.is_empty() {
        return fit;
    }
    let covariance = fit.information(bins).0.pseudo_inverse();
    let at = |part: Part| fit.model.index(part).map(|j| (j, fit.model.theta[j]));
    let [white, steps] = [Part::RandomWalk, Part::Quantization].map(at);
    let level = |of: Option<(usize, f64)>| of.map_or(0.0, |(_, theta)| theta);
    let levels = Levels { quantization: level(steps), random_walk: level(white) };
    let mut noise = vec![0.0; bins.len()];
    for (j, theta) in [white, steps].into_iter().flatten() {
        noise.iter_mut().zip(bins.unit(fit.model.parts[j])).for_each(|(s, c)| *s += theta * c);
    }
    let mut least: Option<f64> = None;
    for (j, theta) in [white, steps].into_iter().flatten() {
        if theta <= STANDS_OUT * covariance.get(j, j).max(0.0).sqrt() {
            continue;
        }
        let column = bins.unit(fit.model.parts[j]);
        let weights: Vec<f64> = column.iter().zip(&fit.spectrum).map(|(c, s)| c / (s * s)).collect();
        let share =
            masked.information_left(&bins.spread(&weights), &bins.spread(&noise), levels, bins.record.tau0);
        least = Some(least.map_or(share, |l| l.min(share)));
    }
    bins.inform(least.unwrap_or(masked.present as f64 / bins.record.samples as f64));
    fit.model.clone().fit(bins)
}

/// With missing samples: expected densities of a fit of the terms. A mask that repeats has images of low frequencies at
/// high ones, which are no lines.
fn of_terms(record: &Summary, mask: &[bool]) -> Option<Vec<f64>> {
    record.masked.as_ref().map(|masked| masked.densities(&fit_of_terms(record, mask.to_vec())))
}

/// Squared coefficients of the terms.
fn fit_of_terms(record: &Summary, mask: Vec<bool>) -> Vec<f64> {
    let bins = Bins::new(record, Arc::new(mask), Arc::new(Vec::new()));
    Model::new(TERMS.to_vec(), Vec::new()).fit(&bins).model.theta
}

impl Summary {
    /// Samples over which the weights of a run should fall to 0 at its ends: the root of the ratio of quantization noise to
    /// random walk, from a fit of the terms. 0 without missing samples.
    #[must_use]
    pub fn run_taper(&self) -> f64 {
        let Some(masked) = &self.masked else { return 0.0 };
        if !masked.has_neighbours() {
            return 0.0;
        }
        let theta = fit_of_terms(self, usable(self));
        let (steps, white) = (theta[0] / self.tau0, theta[1]);
        if steps > 0.0 { (steps / white.max(1e-12 * steps)).sqrt() } else { 0.0 }
    }
}

/// The coefficient of a regressor.
fn drift(fit: &Fit, regressor: usize) -> Drift {
    match fit.model.regressors.iter().position(|&k| k == regressor) {
        Some(k) => Drift { value: fit.beta[k], error: fit.beta_covariance.get(k, k).max(0.0).sqrt() },
        None => Drift { value: f64::NAN, error: f64::NAN },
    }
}

fn with_regressor(fit: &Fit, bins: &Bins, regressor: usize) -> Fit {
    let mut model = fit.model.clone();
    model.regressors.push(regressor);
    model.fit(bins)
}

/// The drifts of the mean that a fit found.
struct Drifts {
    ramp: Drift,
    ramp_observed: bool,
    /// Time constant [s], amplitude at the start, and fall of the deviance.
    warm_up: Option<(f64, Drift, f64)>,
}

/// The ramp and the warm-up of a fit, the larger one first, each if it stands out; whatever the fit had before. Without
/// them a selection takes a drift for processes. The curve of the warm-up takes the place of the nearest one of the grid.
fn with_drifts(fit: &mut Fit, bins: &mut Bins, at: Thresholds, wanted: bool) -> Drifts {
    if fit.model.regressors.iter().any(|k| (RAMP_AT..GIVEN_AT).contains(k)) {
        let mut model = fit.model.clone();
        model.regressors.retain(|k| !(RAMP_AT..GIVEN_AT).contains(k));
        *fit = model.fit(bins);
    }
    let mut found = Drifts { ramp: drift(fit, RAMP_AT), ramp_observed: false, warm_up: None };
    let mut chosen = None;
    loop {
        let ramp = if found.ramp_observed { None } else { Some(ramp_of(fit, bins, at)) };
        let warm_up = if wanted && chosen.is_none() { best_warm_up(fit, bins) } else { None };
        if let Some((value, observed, gain, next)) = ramp {
            found.ramp = value;
            if wanted && observed && warm_up.as_ref().is_none_or(|w| w.0 < gain + CURVATURE) {
                *fit = next;
                found.ramp_observed = true;
                continue;
            }
        }
        let Some((gain, k, next)) = warm_up else { break };
        *fit = next;
        chosen = Some((k, gain));
    }
    found.warm_up = chosen.map(|(k, gain)| refined(fit, bins, k, gain));
    if found.ramp_observed {
        found.ramp = profiled_ramp(fit, bins, at);
    }
    found
}

/// The ramp with half its profile interval, in standard errors: the random walk of the rate may grow where the ramp is held.
fn profiled_ramp(fit: &Fit, bins: &Bins, at: Thresholds) -> Drift {
    let plain = drift(fit, RAMP_AT);
    let mut bare = fit.model.clone();
    bare.regressors.retain(|&k| k != RAMP_AT);
    let rise = |value: f64| {
        let ramp = &bins.regressors[RAMP_AT].modes;
        let modes = bins.record.modes.iter().zip(ramp).map(|(x, r)| x - value * r).collect();
        let record = Summary { modes, ..bins.record.clone() };
        let held = bare.clone().fit(&bins.of_record(&record));
        held.deviance - held.restricted
    };
    let target = at.interval + rise(plain.value);
    let end = |sign: f64| {
        let (mut inside, mut outside) = (0.0, plain.error * at.interval.sqrt());
        for _ in 0..RAMP_DOUBLINGS {
            if rise(plain.value + sign * outside) > target {
                break;
            }
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..RAMP_HALVINGS {
            let middle = 0.5 * (inside + outside);
            *if rise(plain.value + sign * middle) > target { &mut outside } else { &mut inside } = middle;
        }
        outside
    };
    Drift { value: plain.value, error: 0.5 * (end(1.0) + end(-1.0)) / at.interval.sqrt() }
}

/// Fall of the deviance by a regressor. The likelihoods are not the restricted ones: regressors differ.
fn gain_of(fit: &Fit, next: &Fit) -> f64 {
    (fit.deviance - fit.restricted) - (next.deviance - next.restricted)
}

/// The warm-up from the first sample on that lowers the deviance most, if it stands out.
fn best_warm_up(fit: &Fit, bins: &Bins) -> Option<(f64, usize, Fit)> {
    let tried = (0..WARM_UPS.len()).map(|k| {
        let found = with_regressor(fit, bins, WARM_AT + k);
        (gain_of(fit, &found), k, found)
    });
    tried.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(gain, ..)| *gain > WARM_UP)
}

/// The warm-up of the grid with its best time constant. The error of its amplitude includes that of the time constant: the
/// derivative by the logarithm is a regressor.
fn refined(fit: &mut Fit, bins: &mut Bins, k: usize, mut gain: f64) -> (f64, Drift, f64) {
    let at = WARM_AT + k;
    let mut time = bins.record.duration() / WARM_UPS[k];
    for step in REFINED {
        for other in [time * step.exp(), time / step.exp()] {
            let bins_of_other = with_curve(bins, at, bins.record.modes_of_decay(other));
            let next = fit.model.clone().fit(&bins_of_other);
            let more = gain_of(fit, &next);
            if more > 0.0 {
                (time, gain, *fit, *bins) = (other, gain + more, next, bins_of_other);
            }
        }
    }
    let curve = |factor: f64| bins.record.modes_of_decay(time * factor);
    let slope =
        curve(1.0 + SLOPE).iter().zip(curve(1.0 - SLOPE)).map(|(a, b)| (a - b) / (2.0 * SLOPE)).collect();
    let last = bins.regressors.len();
    let error = drift(&with_regressor(fit, &with_curve(bins, last, slope), last), at).error;
    (time, Drift { error, ..drift(fit, at) }, gain)
}

/// The bins with other modes in the place of a regressor, or behind all.
fn with_curve<'a>(bins: &Bins<'a>, at: usize, modes: Vec<f64>) -> Bins<'a> {
    let mut all = bins.regressors.to_vec();
    match all.get_mut(at) {
        Some(old) => old.modes = modes,
        None => all.push(Regressor { modes }),
    }
    let mut bins = bins.clone();
    bins.regressors = Arc::new(all);
    bins
}

/// The rate ramp, whether it stands out even with the rate random walk at its upper limit, the fall of the deviance, and
/// the fit.
fn ramp_of(fit: &Fit, bins: &Bins, at: Thresholds) -> (Drift, bool, f64, Fit) {
    let found = with_regressor(fit, bins, RAMP_AT);
    let gain = gain_of(fit, &found);
    let mut ramp = drift(&found, RAMP_AT);
    if ramp.value.abs() <= RAMP * ramp.error {
        return (ramp, false, gain, found);
    }
    if let Some(j) = found.model.index(Part::RateRandomWalk) {
        let high = of_part(&found, bins, j, at).high;
        if high.is_finite() {
            let mut model = found.model.clone();
            model.theta[j] = high.max(model.theta[j]);
            ramp = drift(&model.refit(bins, 0, 0.0, &found), RAMP_AT);
        }
    }
    let observed = ramp.value.abs() > RAMP * ramp.error;
    (ramp, observed, gain, found)
}

fn thresholds(level: f64) -> Thresholds {
    Thresholds {
        interval: chi2_quantile_above(1.0 - level, 1.0),
        observed: chi2_quantile_above((2.0 * (1.0 - level)).min(0.9), 1.0),
    }
}

/// Intervals of all terms, and the model without those that were not observed. These are dropped one by one: of two that
/// can stand for each other the last stays in the model, but neither is observed. The interval without them is joined.
fn intervals(fit: &Fit, bins: &Bins, at: Thresholds) -> (Vec<Bounds>, Fit) {
    let count = fit.model.parts.len();
    let is_term = |j: &usize| fit.model.parts[*j].is_term();
    let unknown = Bounds { value: 0.0, low: 0.0, high: f64::INFINITY, observed: false, loss: 0.0 };
    let mut bounds: Vec<Bounds> =
        (0..count).map(|j| if is_term(&j) { of_part(fit, bins, j, at) } else { unknown }).collect();
    let mut open: Vec<Part> =
        (0..count).filter(is_term).filter(|&j| !bounds[j].observed).map(|j| fit.model.parts[j]).collect();
    if open.is_empty() {
        return (bounds, fit.clone());
    }
    let mut reduced = fit.clone();
    while !open.is_empty() && reduced.model.parts.len() > 1 {
        let loss = |part: &Part| {
            reduced.model.index(*part).map(|j| {
                let (loss, without) = reduced.loss_of(j, bins);
                (loss, *part, without)
            })
        };
        let least = open.iter().filter_map(loss).min_by(|a, b| a.0.total_cmp(&b.0));
        match least {
            Some((loss, part, without)) if loss <= at.observed => {
                reduced = without;
                open.retain(|&p| p != part);
            }
            _ => break,
        }
    }
    for (j, part) in fit.model.parts.iter().enumerate().filter(|(j, _)| is_term(j)) {
        let Some(k) = reduced.model.index(*part) else { continue };
        let alone = of_part(&reduced, bins, k, at);
        let full = bounds[j];
        bounds[j] = Bounds {
            value: if alone.observed { alone.value } else { full.value },
            // Of the models in which the term is needed.
            low: if alone.observed { full.low.min(alone.low) } else { full.low },
            high: alone.high.max(full.high),
            observed: full.observed,
            loss: full.loss,
        };
    }
    (bounds, reduced)
}

/// Intervals of terms joined with those of other explanations that are nearly as good.
fn join_alike(terms: &mut [Bounds], plain: &Fit, bins: &Bins, at: Thresholds, allowed: Allowed) {
    for other in second_explanations(plain, bins, allowed) {
        let (other, bins, _) = widened(&other, bins);
        for (j, part) in plain.model.parts.iter().enumerate().filter(|(_, part)| part.is_term()) {
            let Some(k) = other.model.index(*part) else { continue };
            let second = of_part(&other, &bins, k, at);
            if terms[j].observed && second.observed {
                terms[j].low = terms[j].low.min(second.low);
            }
            terms[j].high = terms[j].high.max(second.high);
        }
    }
}

/// The shortest correlation time of a Gauss-Markov process that stands for the rate random walk about as well.
fn process_like_walk(fit: &Fit, bins: &Bins, at: Thresholds) -> Option<(f64, f64)> {
    let walk = fit.model.index(Part::RateRandomWalk).filter(|&j| fit.model.theta[j] > 0.0)?;
    let (bare, walk) = (fit.model.without(walk), fit.model.theta[walk]);
    let reference = fit.model.clone().refit(bins, 40, TOLERANCE, fit).deviance;
    let mut found = None;
    let mut time = 0.5 * bins.record.duration();
    while time > bins.record.duration() / 300.0 {
        // A process that is slow enough is a random walk with K² = 2σ²/T.
        let mut model = bare.with(Part::GaussMarkov { time }, 0.5 * walk * time);
        model.held_shape = Some((model.parts.len() - 1, Shape::Time));
        let last = model.parts.len() - 1;
        let alike = model.refit(bins, 40, TOLERANCE, fit);
        if alike.deviance > reference + at.interval {
            break;
        }
        found = Some((time, alike.model.theta[last]));
        time /= 1.5;
    }
    found
}

/// The values of the plain likelihood in place of those with limited weights; inside their intervals.
fn value_of_likelihood(bounds: &mut [Bounds], plain: &Fit, reduced: &Fit) {
    for (j, part) in plain.model.parts.iter().enumerate() {
        let value = match reduced.model.index(*part) {
            Some(k) => reduced.model.theta[k],
            _ => plain.model.theta[j],
        };
        bounds[j] = bounds[j].around(value);
    }
}

/// A heavy tail widens what the samples say of the white level: the relative variance of N² is (2 + κ)/N, not 2/N.
fn heavy_tails(white: &mut Bounds, record: &Summary) {
    let n = record.present() as f64;
    if record.kurtosis <= 3.0 * (24.0 / n).sqrt() || !white.observed {
        return;
    }
    let more = 1.96 * (record.kurtosis / n).sqrt() * white.value;
    white.low = (white.value - (white.value - white.low).hypot(more)).max(0.0);
    white.high = white.value + (white.high - white.value).hypot(more);
}

/// Whether the white level changes along the record: its mean in each eighth, by bins weighted by what they say of it.
fn unsteadiness(fit: &Fit, bins: &Bins) -> (f64, f64) {
    let Some(j) = fit.model.index(Part::RandomWalk).filter(|&j| fit.model.theta[j] > 0.0) else {
        return (0.0, 1.0);
    };
    if bins.ranges.is_empty() {
        return (0.0, 1.0);
    }
    let response = fit.model.response_means(bins);
    let low = bins.low;
    let share = |i: usize| fit.model.theta[j] * response[low + i] / fit.spectrum[low + i];
    let mut weights: Vec<f64> =
        (0..bins.ranges.len()).map(|i| bins.weight(low + i) * share(i).powi(2)).collect();
    let sum: f64 = weights.iter().sum();
    for w in &mut weights {
        *w /= sum;
    }
    // Of a record with missing samples, a part counts by what it holds.
    let shares = bins.record.masked.as_ref().map_or([1.0 / PARTS as f64; PARTS], |masked| masked.parts);
    let there: Vec<usize> = (0..PARTS).filter(|&p| shares[p] * PARTS as f64 > LEAST_PART).collect();
    let parts = there.len() as f64;
    if there.len() < 2 {
        return (0.0, 1.0);
    }
    let all = bins.parts();
    let levels: Vec<f64> = there
        .iter()
        .map(|&p| &all[p])
        .map(|part| part.iter().enumerate().map(|(i, p)| weights[i] * p / fit.spectrum[low + i]).sum())
        .collect();
    let mean = levels.iter().sum::<f64>() / parts;
    let squares: f64 = levels.iter().map(|r| (r / mean - 1.0).powi(2)).sum();
    let smaller = there.iter().map(|&p| 1.0 / (shares[p] * PARTS as f64)).sum::<f64>() / parts;
    let chance: f64 = (0..weights.len())
        .map(|i| 2.0 * weights[i].powi(2) / (bins.freedom[low + i] / PARTS as f64) * smaller)
        .sum();
    (((squares / (parts - 1.0)) - chance).max(0.0).sqrt(), chi2_above(squares / chance, parts - 1.0))
}
