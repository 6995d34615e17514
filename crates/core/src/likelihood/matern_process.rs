//! One Matérn process in place of all slow noise of a model, and the test of the Gauss-Markov process in its place.

use crate::likelihood::adequacy::adequacy;
use crate::likelihood::bins::Bins;
use crate::likelihood::discrepancy::widened;
use crate::likelihood::exchange::best;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::{Fit, TOLERANCE, squares, time_limits};
use crate::likelihood::laws::chi2_above;
use crate::likelihood::profile::{Bounds, Thresholds, part_bounds, smoothness_bounds, time_bounds};
use crate::matern::SMOOTHNESS;
use crate::terms::{NOISE_TERMS, Term};

const STEPS: usize = 60;

/// Values of the smoothness, and factors on the correlation time of the Gauss-Markov process, from which fits start.
const STARTS: [f64; 4] = [0.05, 0.15, 0.3, 0.45];
const FACTORS: [f64; 2] = [1.0, 6.0];

/// Share of the records of a Gauss-Markov process in which the estimate of the smoothness is below 1/2: 55.8 % of 1600
/// records of 90 to 360 correlation times. It tends to one half for long records.
const SHARE_BELOW: f64 = 0.56;

/// Price of a parameter in deviance (Akaike).
const PRICE_OF_PARAMETER: f64 = 2.0;

/// A model with one Matérn process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaternOutcome {
    /// σ².
    pub variance: Bounds,
    /// Bounds of the correlation time, within its limits. \[s\]
    pub time: Bounds,
    /// Bounds of the smoothness, within its range.
    pub smoothness: Bounds,
    /// Squares of the terms beside the process.
    pub terms: [f64; NOISE_TERMS],
    /// P-value of the Gauss-Markov process, ν = 1/2.
    pub gauss_markov: f64,
    /// Akaike's criterion of the selected model minus that of this model.
    pub gain: f64,
    /// P-value of the goodness of fit.
    pub p_value: f64,
}

/// The best fit with one Matérn process in place of the slow noise of a fit. `thresholds`: those of a model by its p-value.
pub(crate) fn with_matern(
    fit: &Fit,
    bins: &Bins,
    thresholds: impl Fn(f64) -> Thresholds,
) -> Option<MaternOutcome> {
    let (markov, found) = fitted(fit, bins)?;
    let part = found.model.parts.len() - 1;
    let p_value = adequacy(&found, bins).p_value;
    let thresholds = thresholds(p_value);
    let (limited, limited_bins, _) = widened(&found, bins);
    let fall = markov.deviance - found.deviance;
    let is_below =
        matches!(found.model.parts[part], Part::Matern { smoothness, .. } if smoothness < SMOOTHNESS.1);
    Some(MaternOutcome {
        variance: part_bounds(&limited, &limited_bins, part, thresholds).around(found.model.theta[part]),
        time: time_bounds(&limited, &limited_bins, part, thresholds)?,
        smoothness: smoothness_bounds(&limited, &limited_bins, part, thresholds)?,
        terms: squares(&found),
        // The smoothness is at the end of its range: a share of a chi-squared law with one degree of freedom.
        gauss_markov: if is_below && fall > 0.0 { SHARE_BELOW * chi2_above(fall, 1.0) } else { 1.0 },
        gain: price(fit) - price(&found),
        p_value,
    })
}

/// The best fits with a Gauss-Markov process, and with a Matérn process, as the last part in place of all slow noise.
fn fitted(fit: &Fit, bins: &Bins) -> Option<(Fit, Fit)> {
    let is_slow = |part: &Part| {
        matches!(part, Part::Term(Term::BiasInstability | Term::RateRandomWalk) | Part::GaussMarkov { .. })
    };
    let replaced: Vec<Part> = fit.model.parts.iter().copied().filter(is_slow).collect();
    let markov = best(fit, bins, &replaced)?;
    let part = markov.model.parts.len() - 1;
    let Part::GaussMarkov { time } = markov.model.parts[part] else { return None };
    let (shortest, longest) = time_limits(bins);
    let with = |smoothness: f64, time: f64, steps: usize| {
        let mut model = markov.model.clone();
        model.parts[part] = Part::Matern { time: time.clamp(shortest, longest), smoothness };
        model.refit(bins, steps, TOLERANCE, fit)
    };
    let tried = STARTS.into_iter().flat_map(|smoothness| FACTORS.map(|factor| (smoothness, factor * time)));
    let found = tried.map(|(smoothness, time)| with(smoothness, time, STEPS)).fold(
        with(SMOOTHNESS.1, time, 0),
        |best, next| if next.deviance < best.deviance { next } else { best },
    );
    Some((markov, found))
}

/// Akaike's criterion.
fn price(fit: &Fit) -> f64 {
    fit.deviance + PRICE_OF_PARAMETER * present(fit)
}

/// Number of parameters of the parts that are present.
fn present(fit: &Fit) -> f64 {
    let theta = &fit.model.theta;
    let shapes = fit.model.shapes().iter().filter(|&&(j, _)| theta[j] > 0.0).count();
    (theta.iter().filter(|&&theta| theta > 0.0).count() + shapes + fit.model.filter.len()) as f64
}
