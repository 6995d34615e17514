//! The joint likelihood of several runs of a sensor: the model is common to all runs, but some terms differ from run to
//! run.

use crate::likelihood::adequacy::adequacy;
use crate::likelihood::analysis::{fitted, fitted_with_series, inferred, outcome};
use crate::likelihood::band::{Attempt, allowed, attempt, wanted_terms};
use crate::likelihood::bins::{Bins, median};
use crate::likelihood::drifts::{Drifts, RAMP_INDEX};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::laws::chi2_above;
use crate::likelihood::model::Level as Levels;
use crate::likelihood::model::Model;
use crate::likelihood::model::SeparateTerm;
use crate::likelihood::outcome::Tails;
use crate::likelihood::outcome::{Drift, Options, Outcome};
use crate::likelihood::select::select;
use crate::likelihood::summary::Summary;
use crate::parallel::prelude::*;
use crate::terms::{NOISE_TERMS, Term};

/// Initial and smallest spread of the levels of a term: standard deviations of the logarithm of the squared coefficient.
/// The initial spread does not constrain the levels; the smallest is far below their errors.
const FREE_SPREAD: f64 = 5.0;
const MIN_SPREAD: f64 = 1e-4;

/// P-value of the gain by ramps in all runs below which all runs have a ramp: together, insignificant ramps resemble a rate
/// random walk.
const RAMPS: f64 = 0.01;

/// Smallest share of the variance of a level that does not come from errors of other parameters.
const MIN_VARIANCE_SHARE: f64 = 0.1;

/// Standard error of the logarithm of a squared coefficient above which a run does not show the term.
const WEAK_ERROR: f64 = 0.35;

const STEPS: usize = 40;

/// Number of bisections for a variance over runs.
const BISECTIONS: usize = 60;

/// Mask of the noise terms that are common to all runs; the others differ from run to run.
pub type Common = [bool; NOISE_TERMS];

/// Levels of a term that differs from run to run.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Index of the noise term.
    pub term: usize,
    /// Standard deviation of the logarithm of the squared coefficient over runs.
    pub spread: f64,
    /// P-value of equality in all runs.
    pub p_value: f64,
    /// Squared coefficient of each run and the standard error of its logarithm, without shrinkage by the spread.
    pub runs: Vec<(f64, f64)>,
}

/// Result for a single run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunComparison {
    /// For each common noise term: squared coefficient of this run with its standard error, that of the other runs, and the
    /// reduction of the deviance by separate values.
    pub terms: [Option<[f64; 4]>; NOISE_TERMS],
    /// Reduction of the deviance if this run has separate values of all common parameters, and the number of these.
    pub all: (f64, usize),
}

/// Result for several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The model of all runs, with intervals; lines, drifts and white levels are those of single runs.
    pub outcome: Outcome,
    /// Ramp of each run, whether it is in the model or not.
    pub ramps_of: Vec<Drift>,
    /// Terms that differ from run to run.
    pub levels: Vec<Level>,
    /// For each common term that some run shows: reduction of the deviance if each run has a separate value, and number of
    /// additional parameters.
    pub homogeneity: [Option<(f64, usize)>; NOISE_TERMS],
    /// Results by run.
    pub others: Vec<RunComparison>,
    /// Number of bins of each run.
    pub bins: Vec<usize>,
}

/// Analyses several runs of a channel. `regressors` are curves at the centres of the blocks of each run.
#[must_use]
pub fn analyse_jointly(
    records: &[&Summary],
    regressors: &[Vec<Vec<f64>>],
    options: &Options,
    common: Common,
) -> Joint {
    let options_of = |run: usize| Options { regressors: regressors[run].clone(), ..options.clone() };
    let singles: Vec<(Attempt, Drifts)> =
        (0..records.len()).into_par_iter().map(|run| fitted(records[run], &options_of(run))).collect();
    // The model of all runs has one filter.
    let means: Vec<_> = singles.iter().map(|(one, _)| one.fit.model.mean).collect();
    let of_white = singles.iter().all(|(one, _)| one.fit.model.of_white);
    let alike =
        means.windows(2).all(|pair| pair[0].map(|mean| mean.length) == pair[1].map(|mean| mean.length));
    let mean = means.first().copied().flatten().filter(|_| alike);
    let singles: Vec<(Attempt, Drifts)> = if alike {
        singles
    } else {
        (0..records.len())
            .into_par_iter()
            .map(|run| fitted_with_series(records[run], &options_of(run)))
            .collect()
    };
    let ramps_of = singles.iter().map(|(_, drifts)| drifts.ramp).collect();
    let singles: Vec<Attempt> = singles.into_iter().map(|(one, _)| one).collect();
    let highest = singles.iter().filter_map(|one| one.highest).min_by(f64::total_cmp);
    let singles: Vec<Attempt> = singles
        .into_par_iter()
        .enumerate()
        .map(|(run, one)| up_to(one, records[run], highest, &options_of(run)))
        .collect();
    let (order, place) = longest_first(records);
    let mut taken: Vec<Option<(Bins, Vec<usize>)>> =
        singles.into_iter().map(|one| Some((one.bins, one.fit.model.regressors))).collect();
    let runs: Vec<(Bins, Vec<usize>)> = order.iter().filter_map(|&run| taken[run].take()).collect();
    let wanted = records
        .iter()
        .map(|record| wanted_terms(record, options))
        .fold(options.terms, |all, one| std::array::from_fn(|k| all[k] && one[k]));
    let mut parts: Vec<Part> = (0..NOISE_TERMS).filter(|&k| wanted[k]).map(|k| TERMS[k]).collect();
    parts.extend(options.times.iter().map(|&time| Part::GaussMarkov { time }));
    let mut model = Model { mean, of_white: of_white && mean.is_some(), ..Model::new(parts, Vec::new()) };
    let free = |part: Part| Levels { part, logs: vec![0.0; records.len()], spread: FREE_SPREAD };
    model.levels = (0..NOISE_TERMS).filter(|&k| wanted[k] && !common[k]).map(|k| free(TERMS[k])).collect();
    let bins = with_ramps(runs, &model, options.drifts);
    let mut allow = allowed(records[0], options);
    allow.drifts = false; // each run has its warm-up
    allow.quantization &= wanted[Term::Quantization.index()];
    allow.filter &= mean.is_none();
    let mut free_fit = select(model.fit(&bins), &bins, allow);
    let (levels, _) = levels_of(&free_fit, &bins, &place);
    let weak: Vec<Part> =
        levels.iter().filter(|level| is_weak(level)).map(|level| TERMS[level.term]).collect();
    if !weak.is_empty() {
        let mut model = free_fit.model.clone();
        model.levels.retain(|level| !weak.contains(&level.part));
        free_fit = model.refit(&bins, STEPS, TOLERANCE, &free_fit);
    }
    let (levels, spreads) = levels_of(&free_fit, &bins, &place);
    let mut model = free_fit.model.clone();
    for (level, spread) in model.levels.iter_mut().zip(spreads) {
        level.spread = spread;
    }
    let plain = model.refit(&bins, STEPS, TOLERANCE, &free_fit);
    let test = adequacy(&plain, &bins);
    let present = records.iter().map(|record| record.present()).sum();
    let weighted = |record: &&Summary| record.kurtosis * record.present() as f64;
    let tails = Tails { kurtosis: records.iter().map(weighted).sum::<f64>() / present as f64, present };
    let found = inferred(&plain, &bins, test.p_value, tails, allow, options.level);
    let others = place.par_iter().map(|&at| compare_run(&free_fit, &bins, at, common)).collect();
    let homogeneity = std::array::from_fn(|k| {
        common[k].then(|| gain_of_separate_terms(&free_fit, &bins, TERMS[k])).flatten()
    });
    let counts = place.iter().map(|&at| bins.runs[at].0.len()).collect();
    Joint {
        outcome: Outcome { highest, ..outcome(&plain, &bins, test, found) },
        ramps_of,
        levels,
        homogeneity,
        others,
        bins: counts,
    }
}

/// The attempt of a run, in the common band of all runs.
fn up_to<'a>(one: Attempt<'a>, record: &'a Summary, highest: Option<f64>, options: &Options) -> Attempt<'a> {
    let Some(limit) = highest.filter(|_| one.highest != highest) else { return one };
    let mut mask = one.bins.mask.to_vec();
    let from = ((limit * record.segment as f64 * record.tau0).ceil() as usize).min(mask.len());
    mask[from..].fill(false);
    let regressors = one.bins.regressors.clone();
    attempt(
        record,
        mask,
        one.lines,
        &regressors,
        options,
        (highest, one.fit.model.mean.map(|mean| (mean, one.fit.model.of_white))),
    )
}

/// Order of the runs by length, the longest first, because it limits correlation times; and the place of each run in it.
fn longest_first(records: &[&Summary]) -> (Vec<usize>, Vec<usize>) {
    let mut order: Vec<usize> = (0..records.len()).collect();
    order.sort_by(|&a, &b| records[b].duration().total_cmp(&records[a].duration()));
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &run)| place[run] = at);
    (order, place)
}

/// The bins of the runs. All runs have a ramp if the ramps together are significant: the test is the sum of their squares
/// over their variances, with the noise of a fit that has ramps, because in a fit without them the rate random walk
/// replaces them.
fn with_ramps<'a>(runs: Vec<(Bins<'a>, Vec<usize>)>, model: &Model, wanted: bool) -> Bins<'a> {
    let mut with = runs.clone();
    let mut more = 0;
    for (_, used) in with.iter_mut().filter(|(_, used)| !used.contains(&RAMP_INDEX)) {
        used.push(RAMP_INDEX);
        more += 1;
    }
    let without = Bins::joined(runs);
    if !wanted || more == 0 {
        return without;
    }
    let with = Bins::joined(with);
    let found = model.clone().fit(&with);
    let plain = found.model.clone().at(&without);
    let gain = (plain.deviance - plain.restricted) - (found.deviance - found.restricted);
    if chi2_above(gain, f64::from(more)) < RAMPS { with } else { without }
}

/// Whether most runs do not show a term, so that its variation from run to run is unknown.
fn is_weak(level: &Level) -> bool {
    let errors: Vec<f64> = level.runs.iter().map(|(_, error)| *error).collect();
    median(&errors) > WEAK_ERROR
}

/// The levels of the runs with their errors, and their spreads by the method of Paule and Mandel.
fn levels_of(fit: &Fit, bins: &Bins, place: &[usize]) -> (Vec<Level>, Vec<f64>) {
    let covariance = fit.information(bins).0.pseudo_inverse();
    let (mut found, mut spreads) = (Vec::new(), Vec::new());
    let mut first = fit.model.numbers();
    for level in &fit.model.levels {
        let count = level.logs.len();
        let term = TERMS.iter().position(|&part| part == level.part).unwrap_or(0);
        let start = first;
        let at = |run: usize| start + run;
        first += count;
        let Some(j) = fit.model.index(level.part).filter(|&j| fit.model.theta[j] > 0.0) else {
            spreads.push(MIN_SPREAD);
            let runs = vec![(0.0, f64::INFINITY); count];
            found.push(Level { term, spread: 0.0, p_value: 1.0, runs });
            continue;
        };
        // Variance of ln θ of a run, which is the sum of the common value and the level of the run.
        let slope = 1.0 / fit.model.theta[j];
        let between = |a: usize, b: usize| {
            slope * slope * covariance.get(j, j)
                + slope * (covariance.get(j, at(a)) + covariance.get(j, at(b)))
                + covariance.get(at(a), at(b))
        };
        let pairs = (count * (count - 1)).max(1) as f64;
        let shared = (0..count)
            .flat_map(|a| (0..count).filter(move |&b| b != a).map(move |b| (a, b)))
            .map(|(a, b)| between(a, b))
            .sum::<f64>()
            / pairs;
        let variances: Vec<f64> = (0..count)
            .map(|run| {
                let whole = between(run, run).max(0.0);
                (whole - shared).clamp(MIN_VARIANCE_SHARE * whole, whole).max(1e-18)
            })
            .collect();
        let logs: Vec<(f64, f64)> = level.logs.iter().copied().zip(variances.iter().copied()).collect();
        let mean = Mean::of(&logs);
        let (spread, p_value) = (mean.spread.sqrt(), chi2_above(mean.scatter, (count - 1) as f64));
        spreads.push(spread.max(MIN_SPREAD));
        let runs = place
            .iter()
            .map(|&run| (fit.model.theta[j] * level.logs[run].exp(), variances[run].sqrt()))
            .collect();
        found.push(Level { term, spread, p_value, runs });
    }
    (found, spreads)
}

/// The result for a single run.
fn compare_run(fit: &Fit, bins: &Bins, run: usize, common: Common) -> RunComparison {
    let terms = [0, 1, 2, 3].map(|k| {
        let part = TERMS[k];
        fit.model.index(part).filter(|_| common[k]).map(|j| {
            let alone = with_separate_terms(fit, bins, &[run], part);
            let own = alone.model.own[0].theta;
            let covariance = alone.information(bins).0.pseudo_inverse();
            let error = covariance.get(covariance.order - 1, covariance.order - 1).max(0.0).sqrt();
            [own, error, alone.model.theta[j], (fit.deviance - alone.deviance).max(0.0)]
        })
    });
    RunComparison { terms, all: gain_of_separate_run(fit, bins, run) }
}

/// The fit with a separate term in each of the given runs.
fn with_separate_terms(fit: &Fit, bins: &Bins, runs: &[usize], part: Part) -> Fit {
    let theta = fit.model.index(part).map_or(0.0, |j| fit.model.theta[j]);
    let mut model = fit.model.clone();
    model.own = runs.iter().map(|&run| SeparateTerm { run, part, theta }).collect();
    model.refit(bins, STEPS, TOLERANCE, fit)
}

/// Reduction of the deviance if each run has a separate term, and number of additional parameters.
fn gain_of_separate_terms(fit: &Fit, bins: &Bins, part: Part) -> Option<(f64, usize)> {
    fit.model.index(part)?;
    let runs: Vec<usize> = (1..bins.count()).collect();
    let alone = with_separate_terms(fit, bins, &runs, part);
    Some(((fit.deviance - alone.deviance).max(0.0), runs.len()))
}

/// Reduction of the deviance if a run has no parameter in common with the others, and the number of parameters.
fn gain_of_separate_run(fit: &Fit, bins: &Bins, run: usize) -> (f64, usize) {
    let without = |keep: &dyn Fn(usize) -> bool| {
        let runs =
            bins.runs.iter().enumerate().filter(|(at, _)| keep(*at)).map(|(_, run)| run.clone()).collect();
        let bins = Bins::joined(runs);
        let mut model = fit.model.clone();
        for level in &mut model.levels {
            let logs = level.logs.iter().enumerate().filter(|(at, _)| keep(*at)).map(|(_, x)| *x).collect();
            level.logs = logs;
        }
        model.fit(&bins).deviance
    };
    let fall = fit.deviance - without(&|at| at == run) - without(&|at| at != run);
    let observed = (0..fit.model.parts.len())
        .filter(|&j| fit.model.level(fit.model.parts[j]).is_none() && fit.model.theta[j] > 0.0)
        .count();
    let shapes = fit.model.numbers() - fit.model.parts.len();
    (fall.max(0.0), observed + shapes)
}

/// A mean over runs, its variance, and the variance over runs.
pub(crate) struct Mean {
    pub value: f64,
    pub variance: f64,
    pub spread: f64,
    /// Scatter of the values about their mean, relative to their variances alone: χ² with one degree of freedom fewer than
    /// runs.
    pub scatter: f64,
}

impl Mean {
    /// The method of R. C. Paule and J. Mandel, "Consensus values and weighting factors", J. Res. Natl. Bur. Stand. 87
    /// (1982): the variance over runs for which the scatter of the values equals its degrees of freedom. `runs` are values
    /// and variances.
    pub(crate) fn of(runs: &[(f64, f64)]) -> Self {
        let mean = |spread: f64| {
            let (sum, weight) = runs.iter().fold((0.0, 0.0), |(sum, weight), &(value, variance)| {
                let own = 1.0 / (variance + spread);
                (sum + own * value, weight + own)
            });
            (sum / weight, weight)
        };
        let scatter = |spread: f64| {
            let (mean, _) = mean(spread);
            runs.iter().map(|&(value, variance)| (value - mean).powi(2) / (variance + spread)).sum::<f64>()
        };
        let freedom = (runs.len() - 1) as f64;
        let (mut low, mut high) = (0.0, 0.0);
        let alone = scatter(0.0);
        if alone > freedom {
            let (least, most) =
                runs.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &(value, _)| {
                    (least.min(value), most.max(value))
                });
            high = (most - least).powi(2);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                *if scatter(middle) > freedom { &mut low } else { &mut high } = middle;
            }
        }
        let (value, weight) = mean(high);
        Self { value, variance: 1.0 / weight, spread: high, scatter: alone }
    }
}
