//! Parts that could be added to a model, and the reduction of the deviance by each, estimated by one step from the present
//! fit.

use crate::likelihood::bins::{Bins, MAX_FILTER};
use crate::likelihood::expected::Part;
use crate::likelihood::fit::{Fit, information};
use crate::likelihood::linear::{Symmetric, dot, dots};

/// Numbers per decade of correlation times and of resonances in the dictionary.
const TIMES_PER_DECADE: f64 = 6.0;
const CENTRES_PER_DECADE: f64 = 20.0;

/// Half widths of resonances, over their frequencies.
const RELATIVE_WIDTHS: [f64; 3] = [0.02, 0.06, 0.2];

/// Smallest share of the information about a candidate that is independent of the other parameters; less is rounding.
const MIN_INFORMATION_SHARE: f64 = 1e-6;

/// Parts with unit amplitude, and their mean densities by bin.
pub(crate) struct Dictionary {
    pub processes: Vec<(Part, Vec<f64>)>,
    pub resonances: Vec<(Part, Vec<f64>)>,
}

impl Dictionary {
    pub(crate) fn new(bins: &Bins) -> Self {
        let (tau0, duration) = (bins.record.tau0, bins.record.duration());
        let column = |part: Part| (part, bins.unit(part));
        let times = spaced(40.0 * tau0, duration / 6.0, TIMES_PER_DECADE);
        let processes = times.into_iter().map(|time| column(Part::GaussMarkov { time })).collect();
        let highest_mode = bins.record.mode_frequency(bins.record.low_modes());
        let spacing = bins.record.frequency(1);
        let mut resonances = Vec::new();
        for frequency in spaced(4.0 / duration, 0.47 / tau0, CENTRES_PER_DECADE) {
            for share in RELATIVE_WIDTHS {
                let width = share * frequency;
                if width > 1.5 / duration && (frequency < highest_mode || width > spacing) {
                    resonances.push(column(Part::Resonance { frequency, width }));
                }
            }
        }
        Self { processes, resonances }
    }
}

/// Geometric steps from `low` to `high`, with this number per decade.
pub(crate) fn spaced(low: f64, high: f64, per_decade: f64) -> Vec<f64> {
    if high.partial_cmp(&low) != Some(std::cmp::Ordering::Greater) {
        return Vec::new();
    }
    let decades = (high / low).log10();
    let count = ((per_decade * decades) as usize + 1).max(2);
    (0..count).map(|i| low * 10_f64.powf(decades * i as f64 / (count - 1) as f64)).collect()
}

/// The linearised problem at a fit.
pub(crate) struct Scores {
    slopes: Vec<Vec<f64>>,
    weights: Vec<f64>,
    excess: Vec<f64>,
    inverse: Symmetric,
    /// Step of the present parameters.
    step: Vec<f64>,
    response: Vec<f64>,
    spectrum: Vec<f64>,
    gain: f64,
}

impl Scores {
    pub(crate) fn at(fit: &Fit, bins: &Bins) -> Self {
        let (_, all) = fit.information(bins);
        // A parameter that is 0 cannot decrease.
        let parts = fit.model.parts.len();
        let slopes: Vec<Vec<f64>> = all
            .into_iter()
            .enumerate()
            .filter(|(j, _)| *j >= parts || fit.model.theta[*j] > 0.0)
            .map(|(_, column)| column)
            .collect();
        let weights: Vec<f64> = (0..bins.len()).map(|i| bins.weight(i)).collect();
        let excess = fit.excess();
        let information = fit.with_levels(information(&slopes, &weights));
        let inverse = information.pseudo_inverse();
        let pull: Vec<f64> = weights.iter().zip(&excess).map(|(w, e)| 0.5 * w * e).collect();
        let gradient = dots(&slopes, &pull);
        let step = inverse.times(&gradient);
        let gain = dot(&gradient, &step);
        let response = fit.model.response_means(bins);
        Self { slopes, weights, excess, inverse, step, response, spectrum: fit.spectrum.clone(), gain }
    }

    /// Reduction of the deviance by a candidate with a mean density in each bin. `filtered`: whether the filter acts on
    /// it.
    pub(crate) fn gain_of(&self, column: &[f64], filtered: bool) -> f64 {
        let relative: Vec<f64> = (0..column.len())
            .map(|b| column[b] * if filtered { self.response[b] } else { 1.0 } / self.spectrum[b])
            .collect();
        let weighted: Vec<f64> = relative.iter().zip(&self.weights).map(|(u, w)| 0.5 * w * u).collect();
        let own = dot(&relative, &weighted);
        let shared = dots(&self.slopes, &weighted);
        let pull = dot(&weighted, &self.excess) - dot(&shared, &self.step);
        let left = (own - dot(&shared, &self.inverse.times(&shared))).max(MIN_INFORMATION_SHARE * own);
        if pull > 0.0 { pull * pull / left } else { 0.0 }
    }

    /// The candidate with the largest gain.
    pub(crate) fn best(&self, among: &[(Part, Vec<f64>)]) -> Option<(f64, Part)> {
        among
            .iter()
            .map(|(part, column)| (self.gain_of(column, true), *part))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Reduction of the deviance if the filter has `wanted` coefficients instead of the present number.
    pub(crate) fn gain_of_filter(&self, fit: &Fit, bins: &Bins, wanted: usize) -> f64 {
        let present = fit.model.filter.len();
        debug_assert!(present < wanted && wanted <= MAX_FILTER);
        let mut columns = self.slopes.clone();
        // Relative to the total density. Quantization noise is not filtered, but a rough value is sufficient here.
        for k in present..wanted {
            columns.push(bins.cosine_means(k));
        }
        let pull: Vec<f64> = self.weights.iter().zip(&self.excess).map(|(w, e)| 0.5 * w * e).collect();
        let gradient = dots(&columns, &pull);
        dot(&gradient, &information(&columns, &self.weights).pseudo_inverse().times(&gradient)) - self.gain
    }
}
