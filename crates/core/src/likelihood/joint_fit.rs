//! The complete joint fit of several runs: the model of all runs, the variation of its terms from run to run, and the
//! outlying runs.

use crate::distributions::{student_below, student_quantile};
use crate::likelihood::channel_fit::{ChannelFit, Span, Verdict, standardized};
use crate::likelihood::estimates::{Estimate, TermEstimate, quantile};
use crate::likelihood::joint::{Common, Joint, Level, Mean, analyse_jointly};
use crate::likelihood::laws::chi2_above;
use crate::likelihood::outcome::{Drift, Options};
use crate::likelihood::parts::LineEstimate;
use crate::likelihood::summary::Summary;
use crate::terms::{NOISE_TERMS, Term};

/// Corrected p-value below which a run is an outlier.
pub const ALPHA: f64 = 0.01;

/// P-value of homogeneity below which a common term gets a separate level in each run.
const SEPARATE_P_VALUE: f64 = 0.01;

/// Number of runs above which an outlier can be identified: of two runs, either may be the outlier.
const MIN_JUDGED: usize = 2;

/// Share of the gain by a separate spectrum above which one term is the cause.
const EXPLAINED_SHARE: f64 = 0.5;

/// Smallest number of runs for a comparison of a level with those of other runs.
const MIN_RUNS: usize = 4;

/// Number of standard errors above which the mean ramp counts, as in a single run.
const MIN_RAMP_ERRORS: f64 = 3.3;

/// Variation of a coefficient from run to run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Standard deviation over the runs, relative.
    pub relative: f64,
    /// P-value of equality.
    pub p_value: f64,
}

/// One run compared with the others.
#[derive(Debug, Clone, PartialEq)]
pub struct RunEstimate {
    /// Coefficients that differ from run to run, by name. \[SI\]
    pub values: Vec<(&'static str, Estimate)>,
    /// Common coefficients estimated from this run alone; intervals are symmetric about the square. \[SI\]
    pub own: Vec<(&'static str, Estimate)>,
    /// P-value of the run compared with the others, corrected for the number of runs and tests.
    pub p_value: f64,
    /// Largest difference of the run: a term, or `all` for the shape of the spectrum, with its filter.
    pub cause: &'static str,
    /// The coefficient of the cause over that of the other runs; None if they do not show it.
    pub factor: Option<f64>,
}

impl RunEstimate {
    fn belongs(&self) -> bool {
        self.p_value >= ALPHA
    }
}

/// The joint fit of several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// The model of all runs.
    pub fit: ChannelFit,
    /// Terms that are common to all runs.
    pub common: Vec<&'static str>,
    /// Spreads of the terms that differ from run to run, where the runs show them.
    pub spreads: Vec<(&'static str, Spread)>,
    /// P-value of equality in all runs, for the common terms that the runs show.
    pub homogeneity: Vec<(&'static str, f64)>,
    /// Result of each run.
    pub runs: Vec<RunEstimate>,
}

/// Data of one run.
#[derive(Debug, Clone)]
pub struct Contribution<'a> {
    /// Summary of its samples.
    pub record: &'a Summary,
    /// Curves that the mean may follow, at the centres of the blocks.
    pub regressors: Vec<Vec<f64>>,
    /// Number of samples, including those missing at the ends.
    pub samples: usize,
    /// Lines of the fit of this run alone.
    pub lines: Vec<LineEstimate>,
}

/// Fits one model to several runs.
#[must_use]
pub fn fit_jointly(runs: &[Contribution], options: &Options, common: Common) -> JointFit {
    let jointly = |which: &[usize], common: Common| {
        let records: Vec<&Summary> = which.iter().map(|&run| runs[run].record).collect();
        let standardized_curves =
            |&run: &usize| runs[run].regressors.iter().map(|curve| standardized(curve).0).collect();
        let regressors: Vec<Vec<Vec<f64>>> = which.iter().map(standardized_curves).collect();
        analyse_jointly(&records, &regressors, options, common)
    };
    let all: Vec<usize> = (0..runs.len()).collect();
    let alike = jointly(&all, common);
    let p_value_of = |joint: &Joint, k: usize| {
        joint.homogeneity[k].map(|(fall, freedom)| chi2_above(fall, freedom as f64))
    };
    // A term that differs makes others seem to differ, so the others are judged again with its levels in the model.
    let (mut joint, mut shared) = (alike.clone(), common);
    loop {
        let is_refused =
            |k: usize| shows(&joint, k) && p_value_of(&joint, k).is_some_and(|p| p < SEPARATE_P_VALUE);
        let same = [0, 1, 2, 3].map(|k| shared[k] && !is_refused(k));
        if same == shared {
            break;
        }
        shared = same;
        joint = jointly(&all, shared);
    }
    let fit = fit_of_all(&joint, runs, options);
    let has_levels = |k: usize| joint.levels.iter().any(|level| level.term == k);
    let homogeneity = (0..NOISE_TERMS)
        .filter(|&k| shows(&joint, k) && shared[k] && !has_levels(k))
        .filter_map(|k| p_value_of(&joint, k).map(|p_value| (Term::NOISE[k].name(), p_value)))
        .collect();
    // A run is judged against equal runs: levels would hide the run that differs.
    let mut estimates = judge_runs(alike, all, |which| jointly(which, common), options.level);
    for (k, run) in estimates.iter_mut().enumerate().filter(|_| shared != common) {
        run.values = run_estimate(&joint, k, options.level).values;
        run.own.retain(|(name, _)| !joint.levels.iter().any(|level| Term::NOISE[level.term].name() == *name));
    }
    JointFit {
        common: (0..NOISE_TERMS)
            .filter(|&k| options.terms[k] && !has_levels(k))
            .map(|k| Term::NOISE[k].name())
            .collect(),
        spreads: joint
            .levels
            .iter()
            .filter(|level| shows(&joint, level.term))
            .map(|level| {
                (
                    Term::NOISE[level.term].name(),
                    Spread { relative: 0.5 * level.spread, p_value: level.p_value },
                )
            })
            .collect(),
        homogeneity,
        runs: estimates,
        fit,
    }
}

/// The model of all runs: the averaging times of the longest run, with the lines and the mean ramp of the runs.
fn fit_of_all(joint: &Joint, runs: &[Contribution], options: &Options) -> ChannelFit {
    let mut longest = 0;
    for (k, run) in runs.iter().enumerate() {
        if run.record.duration() > runs[longest].record.duration() {
            longest = k;
        }
    }
    let mut outcome = joint.outcome.clone();
    outcome.bins.truncate(joint.bins[longest]); // those of the longest run come first
    let span = Span { tau0: runs[longest].record.tau0, samples: runs[longest].samples };
    let mut fit = ChannelFit::of(&outcome, options, span);
    let lines: Vec<&[LineEstimate]> = runs.iter().map(|run| run.lines.as_slice()).collect();
    let mut lines = lines_of_runs(&lines);
    if !lines.is_empty() && fit.verdict == Verdict::Adequate {
        fit.verdict = Verdict::AdequateWith;
    }
    lines.append(&mut fit.sinusoid);
    fit.sinusoid = lines;
    let ramp = ramp_of_runs(&joint.ramps_of, options.level);
    for (name, term) in &mut fit.terms {
        if *name == Term::RateRamp.name() {
            *term = ramp;
        }
    }
    fit.model.extend(ramp.value.map(|value| (Term::RateRamp.name(), value)));
    fit
}

/// Whether all runs together show a term.
fn shows(joint: &Joint, term: usize) -> bool {
    joint.outcome.terms[term].is_some_and(|bounds| bounds.observed)
}

/// Tests each run. The most outlying run is judged first, and the others without it.
fn judge_runs(
    mut joint: Joint,
    mut members: Vec<usize>,
    jointly: impl Fn(&[usize]) -> Joint,
    level: f64,
) -> Vec<RunEstimate> {
    let mut judged: Vec<(usize, RunEstimate)> = Vec::new();
    loop {
        let mut runs: Vec<RunEstimate> = (0..members.len()).map(|k| run_estimate(&joint, k, level)).collect();
        let worst = (0..runs.len()).min_by(|&a, &b| runs[a].p_value.total_cmp(&runs[b].p_value));
        let outlier = worst.filter(|&k| !runs[k].belongs() && members.len() > MIN_JUDGED);
        let Some(k) = outlier else {
            judged.extend(members.into_iter().zip(runs));
            judged.sort_by_key(|&(run, _)| run);
            return judged.into_iter().map(|(_, run)| run).collect();
        };
        judged.push((members.remove(k), runs.swap_remove(k)));
        joint = jointly(&members);
    }
}

/// The tests of one run in a joint fit.
///
/// Each test asks whether the data require a separate value for this run: of each common term, of all common parameters
/// together, and of each level compared with those of the other runs. The p-value is the smallest one times the number of
/// tests of all runs.
fn run_estimate(joint: &Joint, k: usize, level: f64) -> RunEstimate {
    let z = quantile(level);
    let (mut values, mut own) = (Vec::new(), Vec::new());
    let mut tests: Vec<(&str, f64)> = Vec::new();
    for level_of_term in &joint.levels {
        let (theta, error) = level_of_term.runs[k];
        if !shows(joint, level_of_term.term) || !error.is_finite() {
            continue;
        }
        let (name, value, factor) =
            (Term::NOISE[level_of_term.term].name(), theta.sqrt(), (0.5 * z * error).exp());
        values.push((name, Estimate { value, low: Some(value / factor), high: Some(value * factor) }));
        if level_of_term.runs.len() >= MIN_RUNS {
            tests.push((name, level_p_value(level_of_term, k)));
        }
    }
    let alone = &joint.others[k];
    let mut falls: Vec<(&str, f64)> = Vec::new();
    for (name, term) in Term::ALL.into_iter().map(Term::name).zip(&alone.terms) {
        let Some([theta, error, _, fall]) = *term else { continue };
        falls.push((name, fall));
        tests.push((name, chi2_above(fall, 1.0)));
        let ends = [theta - z * error, theta + z * error].map(|end| end.max(0.0).sqrt());
        own.push((name, Estimate { value: theta.sqrt(), low: Some(ends[0]), high: Some(ends[1]) }));
    }
    let (fall, count) = alone.all;
    if count > 0 {
        tests.push(("all", chi2_above(fall, count as f64)));
    }
    let smallest = tests.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let (mut cause, p_value) = smallest.unwrap_or(("all", 1.0));
    let count = (tests.len().max(1) * joint.others.len()) as f64;
    if cause == "all" {
        let largest = falls.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
        cause = largest.filter(|&(_, own)| own > EXPLAINED_SHARE * fall).map_or(cause, |(name, _)| name);
    }
    RunEstimate { values, own, p_value: (count * p_value).min(1.0), cause, factor: factor(joint, k, cause) }
}

/// The coefficient of a run over that of the others.
fn factor(joint: &Joint, k: usize, cause: &str) -> Option<f64> {
    let term = Term::from_name(cause)?.index();
    let level = joint.levels.iter().find(|level| level.term == term);
    let (own, others) = match (level, joint.others[k].terms[term]) {
        (Some(level), _) => (level.runs[k].0, joint.outcome.reduced[term]),
        (None, Some([own, _, others, _])) => (own, others),
        (None, None) => return None,
    };
    (others > 0.0).then(|| (own / others).sqrt())
}

/// P-value of the level of a run compared with those of the other runs.
fn level_p_value(level: &Level, k: usize) -> f64 {
    let log = |(theta, _): (f64, f64)| theta.max(1e-300).ln();
    let rest = || level.runs.iter().enumerate().filter(|&(run, _)| run != k).map(|(_, &run)| run);
    let mean = Mean::of(&rest().map(|run| (log(run), run.1.powi(2))).collect::<Vec<_>>());
    let (own, error) = (log(level.runs[k]), level.runs[k].1);
    let t = (own - mean.value).abs() / (mean.variance + mean.spread + error * error).sqrt();
    2.0 * student_below((level.runs.len() - 2) as f64, -t)
}

/// The mean of the ramps, which differ from run to run with temperature and age.
fn ramp_of_runs(ramps: &[Drift], level: f64) -> TermEstimate {
    let known: Vec<(f64, f64)> = ramps
        .iter()
        .filter(|ramp| ramp.value.is_finite() && ramp.error > 0.0 && ramp.error.is_finite())
        .map(|ramp| (ramp.value, ramp.error * ramp.error))
        .collect();
    if known.len() < 2 {
        return TermEstimate { p_value: Some(1.0), ..TermEstimate::default() };
    }
    let Mean { value, variance, .. } = Mean::of(&known);
    let (error, freedom) = (variance.sqrt(), (known.len() - 1) as f64);
    let half = error * student_quantile(freedom, 0.5 * (1.0 + level));
    let p_value = 2.0 * student_below(freedom, -value.abs() / error);
    if value.abs() > half.max(MIN_RAMP_ERRORS * error) {
        return TermEstimate {
            observed: true,
            value: Some(value),
            low: Some(value - half),
            high: Some(value + half),
            upper_limit: None,
            p_value: Some(p_value),
            profile: None,
        };
    }
    TermEstimate {
        upper_limit: Some(value.abs() + half),
        p_value: Some(p_value.max(1.0 - level)),
        ..TermEstimate::default()
    }
}

/// Lines that at least half of the runs show, with the median amplitude and the range over runs.
fn lines_of_runs(runs: &[&[LineEstimate]]) -> Vec<LineEstimate> {
    let reference = runs.iter().copied().reduce(|a, b| if b.len() > a.len() { b } else { a });
    let mut lines = Vec::new();
    for line in reference.unwrap_or_default() {
        let mut alike: Vec<&LineEstimate> = runs.iter().filter_map(|lines| nearest(line, lines)).collect();
        if 2 * alike.len() < runs.len() {
            continue;
        }
        alike.sort_by(|a, b| a.amplitude.value.total_cmp(&b.amplitude.value));
        let ends = || alike.iter().flat_map(|line| [line.amplitude.low, line.amplitude.high]).flatten();
        let amplitude = Estimate {
            value: alike[alike.len() / 2].amplitude.value,
            low: ends().reduce(f64::min),
            high: ends().reduce(f64::max),
        };
        lines.push(LineEstimate { amplitude, frequency: line.frequency });
    }
    lines
}

/// The line of a run at the frequency of a given line.
fn nearest<'a>(line: &LineEstimate, lines: &'a [LineEstimate]) -> Option<&'a LineEstimate> {
    // Frequencies of a line, extended by its width on either side.
    let band = |line: &LineEstimate| {
        let Estimate { value, low, high } = line.frequency;
        let (low, high) = (low.unwrap_or(value), high.unwrap_or(value));
        (low - (high - low), high + (high - low))
    };
    let (low, high) = band(line);
    let off = |candidate: &LineEstimate| (candidate.frequency.value - line.frequency.value).abs();
    lines
        .iter()
        .filter(|candidate| band(candidate).0 <= high && low <= band(candidate).1)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(amplitude: f64, frequency: f64) -> LineEstimate {
        LineEstimate {
            amplitude: Estimate::around(amplitude, 0.1),
            frequency: Estimate::around(frequency, 0.01),
        }
    }

    #[test]
    fn mean_without_a_spread_is_weighted_by_errors() {
        let mean = Mean::of(&[(1.0, 1.0), (2.0, 0.25)]);
        assert!((mean.value - 1.8).abs() < 1e-12);
        assert_eq!((mean.variance, mean.spread), (0.2, 0.0));
    }

    /// With errors of 0 the spread is the variance of the values, and the mean is unweighted.
    #[test]
    fn mean_of_runs_that_differ() {
        let mean = Mean::of(&[(1.0, 1e-30), (2.0, 1e-30), (6.0, 1e-30)]);
        assert!((mean.spread - 7.0).abs() < 1e-9);
        assert!((mean.value - 3.0).abs() < 1e-9);
        assert!((mean.variance - 7.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn lines_of_half_of_the_runs() {
        let (a, b, c) = ([line(1.0, 5.0), line(3.0, 8.0)], [line(2.0, 5.005)], [line(4.0, 5.01)]);
        let lines = lines_of_runs(&[&a, &b, &c]);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].frequency, a[0].frequency);
        assert_eq!(lines[0].amplitude, Estimate { value: 2.0, low: Some(0.9), high: Some(4.1) });
        assert_eq!(lines_of_runs(&[&[], &[]]), []);
    }

    #[test]
    fn mean_ramp() {
        let ramps = |size: f64| [0.9, 1.0, 1.1].map(|x| Drift { value: size * x, error: 0.01 });
        let estimate = ramp_of_runs(&ramps(1.0), 0.95);
        assert!(estimate.observed && (estimate.value.unwrap() - 1.0).abs() < 1e-9);
        // Student's t with 2 degrees of freedom at 95 %: 4.303 times 0.1/√3.
        assert!((estimate.high.unwrap() - 1.0 - 4.302_652_7 * 0.1 / 3.0_f64.sqrt()).abs() < 1e-3);
        let unknown = [Drift { value: f64::NAN, error: f64::NAN }, Drift { value: 1.0, error: 0.1 }];
        let estimate = ramp_of_runs(&unknown, 0.95);
        assert_eq!((estimate.observed, estimate.upper_limit, estimate.p_value), (false, None, Some(1.0)));
        let mixed = [Drift { value: 1.0, error: 0.1 }, Drift { value: -1.0, error: 0.1 }];
        let estimate = ramp_of_runs(&mixed, 0.95);
        assert!(
            !estimate.observed && estimate.upper_limit.unwrap() > 10.0 && estimate.p_value.unwrap() > 0.9
        );
    }
}
