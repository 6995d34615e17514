//! Intervals that do not depend on the shape of a resonance.

use crate::likelihood::bins::Bins;
use crate::likelihood::discrepancy::widened;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::model::Model;
use crate::likelihood::profile::{Bounds, Thresholds, part_bounds};

/// Share of all other noise above which a resonance is visible in a bin.
const VISIBLE_SHARE: f64 = 0.03;

/// Degrees of freedom of a bin that is left out.
const LEFT_OUT: f64 = 1e-6;

/// Joins the intervals of terms with those of a fit without resonances that leaves out the bins in which resonances are
/// visible. A peak of another shape lacks the skirts of a resonance: with a line that drifts over 3 Hz, the white noise was
/// 1.5 % too small, and quantization noise filled the difference.
pub(crate) fn join_without_resonances(
    terms: &mut [Bounds],
    plain: &Fit,
    bins: &Bins,
    thresholds: Thresholds,
) {
    if !bins.runs.is_empty() {
        return; // the shape of a resonance is certain if several runs share it
    }
    let resonances = resonances_of(&plain.model);
    if resonances.is_empty() {
        return;
    }
    let slopes = plain.model.with_slopes(bins).1;
    let mut outside = bins.clone();
    for (i, freedom) in outside.freedom.iter_mut().enumerate() {
        let share: f64 = resonances.iter().map(|&j| plain.model.theta[j] * slopes[j][i]).sum();
        if share > VISIBLE_SHARE * (1.0 - share) {
            *freedom = LEFT_OUT;
        }
    }
    let bare = resonances.iter().rev().fold(plain.model.clone(), |model, &j| model.without(j));
    let (fit, outside, _) = widened(&bare.refit(&outside, 40, TOLERANCE, plain), &outside);
    for (j, part) in plain.model.parts.iter().enumerate().filter(|(_, part)| part.is_term()) {
        let Some(k) = fit.model.index(*part) else { continue };
        let joined = part_bounds(&fit, &outside, k, thresholds);
        terms[j].low = terms[j].low.min(joined.low);
        terms[j].high = terms[j].high.max(joined.high);
    }
}

/// Indices of the resonances of a model.
fn resonances_of(model: &Model) -> Vec<usize> {
    (0..model.parts.len()).filter(|&j| matches!(model.parts[j], Part::Resonance { .. })).collect()
}
