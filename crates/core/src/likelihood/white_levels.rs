//! White noise along the record: its mean in each eighth, over bins that are weighted by their information on it.

use crate::likelihood::bins::Bins;
use crate::likelihood::fit::Fit;
use crate::likelihood::outcome::Tails;
use crate::likelihood::outcome::WhiteLevel;
use crate::likelihood::taper::PARTS;
use crate::terms::Term;

/// Smallest share of samples in an eighth of the record for it to be used.
const MIN_PART: f64 = 0.2;

/// White noise of each eighth that has samples; empty if the model has no random walk.
pub(crate) fn white_levels(fit: &Fit, bins: &Bins, tails: Tails) -> Vec<WhiteLevel> {
    let Some(j) = fit.model.index(Term::RandomWalk).filter(|&j| fit.model.theta[j] > 0.0) else {
        return Vec::new();
    };
    if bins.ranges.is_empty() {
        return Vec::new();
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
    // In a record with missing samples, the weight of a part is its share of the samples.
    let shares = bins.record.masked.as_ref().map_or([1.0 / PARTS as f64; PARTS], |masked| masked.parts());
    let bin_sum: f64 =
        (0..weights.len()).map(|i| 2.0 * weights[i].powi(2) / (bins.freedom[low + i] / PARTS as f64)).sum();
    let chance = bin_sum + PARTS as f64 * tails.heavy() / tails.present as f64;
    let all = bins.parts();
    (0..PARTS)
        .filter(|&p| shares[p] * PARTS as f64 > MIN_PART)
        .map(|p| WhiteLevel {
            eighth: p,
            level: all[p].iter().enumerate().map(|(i, x)| weights[i] * x / fit.spectrum[low + i]).sum(),
            variance: chance / (shares[p] * PARTS as f64),
        })
        .collect()
}
