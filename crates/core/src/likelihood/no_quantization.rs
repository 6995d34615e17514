//! Quantization noise that is not compatible with the step of the samples.
//!
//! Quantization noise beside white noise makes the standard error of the random walk √3 times as large. Angles in steps are
//! rates in steps. If the rates have no step, or a step that is small beside the noise, the record has no such noise.

use crate::likelihood::bins::Bins;
use crate::likelihood::fit::Fit;
use crate::likelihood::fit::squares;
use crate::terms::Term;

/// Rise of the deviance without quantization noise up to which it is chance: one standard error. Other noise of the same
/// density, such as jitter of the time stamps, needs no step; what is more likely than not to be there stays in the model.
const CHANCE: f64 = 1.0;

/// Share of its standard error by which the largest quantization noise may make the random walk smaller.
const LITTLE: f64 = 0.5;

/// A fit without quantization noise.
pub(crate) struct Bare {
    pub fit: Fit,
    /// The part that was removed.
    pub removed: usize,
    /// Reduction of N² by the largest quantization noise.
    pub less: f64,
}

/// The fit without quantization noise, if a record does not show any and its samples have room for little; `most`: the largest
/// Q² of their step.
pub(crate) fn without_quantization(fit: &Fit, bins: &Bins, most: f64) -> Option<Bare> {
    let removed = fit.model.index(Term::Quantization).filter(|_| most.is_finite())?;
    let walk = fit.model.index(Term::RandomWalk).filter(|_| squares(fit)[Term::RandomWalk.index()] > 0.0)?;
    let (information, _) = fit.information(bins);
    let of_walk = information.get(walk, walk);
    let less = most * information.get(removed, walk) / of_walk;
    if less > LITTLE / of_walk.sqrt() {
        return None;
    }
    let (loss, bare) = fit.loss_of(removed, bins);
    (loss <= CHANCE).then_some(Bare { fit: bare, removed, less })
}
