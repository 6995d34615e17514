//! Quantization noise that is not compatible with the step of the samples.
//!
//! Quantization noise in addition to white noise increases the standard error of the random walk by √3. Angles in steps
//! imply rates in steps. If the rates have no step, or a step that is small relative to the noise, the record has no such
//! noise.

use crate::likelihood::bins::Bins;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::squares;
use crate::terms::Term;

/// Largest rise of the deviance without quantization noise that counts as chance: one standard error. Other noise of the
/// same density, such as jitter of the time stamps, needs no step; noise that is more likely present than absent remains in
/// the model.
const RISE_BY_CHANCE: f64 = 1.0;

/// Largest reduction of the random walk by the largest quantization noise, in standard errors of the random walk.
const MAX_REDUCTION: f64 = 0.5;

/// A fit without quantization noise.
pub(crate) struct Bare {
    pub fit: Fit,
    /// The part that was removed.
    pub removed: usize,
    /// Reduction of N² by the largest quantization noise.
    pub reduction: f64,
}

/// The fit without quantization noise, if the record does not show any and the step of its samples allows only little;
/// `most` is the largest Q² for this step.
pub(crate) fn without_quantization(fit: &Fit, bins: &Bins, most: f64) -> Option<Bare> {
    let removed = fit.model.index(Term::Quantization).filter(|_| most.is_finite())?;
    let walk = fit.model.index(Term::RandomWalk).filter(|_| squares(fit)[Term::RandomWalk.index()] > 0.0)?;
    let (information, _) = fit.information(bins);
    let walk_information = information.get(walk, walk);
    let reduction = most * information.get(removed, walk) / walk_information;
    if reduction > MAX_REDUCTION / walk_information.sqrt() {
        return None;
    }
    let (loss, bare) = fit.removal_loss(removed, bins);
    (loss <= RISE_BY_CHANCE).then_some(Bare { fit: bare, removed, reduction })
}
