//! Filters of known shape, selected by full fits: a score is not informative so far from the maximum.

use crate::likelihood::bins::Bins;
use crate::likelihood::candidates::spaced;
use crate::likelihood::expected::Part;
use crate::likelihood::filter_shapes::Family;
use crate::likelihood::fit::{Fit, TOLERANCE};
use crate::likelihood::model::Model;
use crate::terms::Term;

/// Number of tested corners per decade, their limits times the sample interval, and the smallest number of cycles of the
/// lowest corner in a record.
const CORNERS: f64 = 3.0;
const LOWEST_CORNER: f64 = 0.001;
const HIGHEST_CORNER: f64 = 0.4;
const MIN_CYCLES: f64 = 40.0;

/// Families that determine the approximate corner, from which other families start.
const FIRST_FAMILIES: [Family; 2] = [Family::Smoothing, Family::Digital { order: 2 }];

/// Number of steps of the fits of the first families and of the later ones, and change of the deviance at which the former
/// end.
const FIRST_STEPS: usize = 8;
const STEPS: usize = 40;
const ROUGH_TOLERANCE: f64 = 0.1;

/// Factors of the corner with which slow noise after the filter is tried.
const CORNER_FACTORS: [f64; 3] = [0.6, 1.0, 1.6];

/// Price of a parameter in the comparison of filters: for a true Butterworth filter, a free damping exceeds it in 1 of 22
/// records.
const PRICE_OF_PARAMETER: f64 = 4.0;

/// Rise of the deviance after few steps, over the best of the first families or over the fit, above which a family is
/// abandoned.
const HOPELESS_RISE: f64 = 200.0;

/// The best fit of a model with a filter of known shape; `bare` has none.
pub(crate) fn best_of_families(bare: &Model, bins: &Bins, from: &Fit) -> Option<Fit> {
    let longest = bins.record.duration() / bins.record.tau0;
    let lowest = LOWEST_CORNER.max(MIN_CYCLES / longest);
    let rough = |family: Family, corner: f64, of_white: bool| {
        with_family(bare, family, corner, of_white).refit(bins, FIRST_STEPS, ROUGH_TOLERANCE, from)
    };
    let mut first: Vec<Fit> = FIRST_FAMILIES
        .into_iter()
        .filter_map(|family| {
            let corners = spaced(lowest, HIGHEST_CORNER, CORNERS).into_iter();
            corners.map(|corner| rough(family, corner, false)).min_by(by_deviance)
        })
        .collect();
    let slow = [Part::Term(Term::BiasInstability), Part::Term(Term::RateRandomWalk)];
    if slow.into_iter().any(|part| bare.index(part).is_some()) {
        let behind = first.iter().zip(FIRST_FAMILIES).filter_map(|(fit, family)| {
            let corner = filter_corner(&fit.model)?;
            CORNER_FACTORS.into_iter().map(|by| rough(family, by * corner, true)).min_by(by_deviance)
        });
        let behind: Vec<Fit> = behind.collect();
        first.extend(behind);
    }
    let least = first.iter().map(|fit| fit.deviance).fold(f64::INFINITY, f64::min);
    first.retain(|fit| fit.deviance < least + HOPELESS_RISE);
    let found = first.iter().flat_map(|start| {
        let families = Family::all().filter(|family| fits_slope(*family, start));
        families.filter_map(|family| {
            let mut model = with_family(bare, family, filter_corner(&start.model)?, start.model.of_white);
            model.theta.clone_from(&start.model.theta);
            fit_unless_hopeless(model, bins, from, |rough| rough.deviance < least + HOPELESS_RISE)
        })
    });
    found.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Fits with other families of filters, or with slow noise on the other side of the filter, that raise the deviance by at
/// most `rise`.
pub(crate) fn other_families(fit: &Fit, bins: &Bins, rise: f64) -> Vec<Fit> {
    let Some(corner) = filter_corner(&fit.model) else { return Vec::new() };
    let slow = fit.model.parts.iter().zip(&fit.model.theta).any(|(&part, &theta)| {
        !matches!(part, Part::Term(Term::Quantization | Term::RandomWalk)) && theta > 0.0
    });
    let sides: &[bool] = if slow { &[false, true] } else { &[false] };
    let present = (fit.model.family, fit.model.of_white && slow);
    let mut found: Vec<Fit> = Vec::new();
    for &of_white in sides {
        for family in Family::all().filter(|&family| (Some(family), of_white) != present) {
            let mut model = with_family(&fit.model, family, corner, of_white);
            model.theta.clone_from(&fit.model.theta);
            let is_hopeful = |rough: &Fit| cost(rough) < cost(fit) + rise + HOPELESS_RISE;
            found.extend(
                fit_unless_hopeless(model, bins, fit, is_hopeful)
                    .filter(|tried| cost(tried) <= cost(fit) + rise),
            );
        }
    }
    found
}

/// With missing samples, the fit with slow noise on the other side of a running mean, if it raises the deviance by at most
/// `rise`. The zeros of a complete record show the side.
pub(crate) fn other_side_of_mean(fit: &Fit, bins: &Bins, rise: f64) -> Option<Fit> {
    if !bins.leaks() {
        return None;
    }
    let model = Model { of_white: !fit.model.of_white, ..fit.model.clone() };
    Some(model.refit(bins, STEPS, TOLERANCE, fit)).filter(|tried| tried.deviance <= fit.deviance + rise)
}

/// The fit of a model, unless a few steps show that it is far from the best.
fn fit_unless_hopeless(
    model: Model,
    bins: &Bins,
    from: &Fit,
    is_hopeful: impl Fn(&Fit) -> bool,
) -> Option<Fit> {
    let rough = model.refit(bins, FIRST_STEPS, ROUGH_TOLERANCE, from);
    is_hopeful(&rough).then(|| rough.model.refit(bins, STEPS, TOLERANCE, from))
}

fn with_family(model: &Model, family: Family, corner: f64, of_white: bool) -> Model {
    let mut numbers = family.start(corner);
    family.clamp_parameters(&mut numbers);
    Model { filter: numbers, family: Some(family), of_white, theta: Vec::new(), ..model.clone() }
}

/// Frequency of half the power of a filter of known shape, times the sample interval.
fn filter_corner(model: &Model) -> Option<f64> {
    Some(model.family?.shape(&model.filter).half_power())
}

/// Whether a family has a slope similar to that of the fit that determines the corner.
fn fits_slope(family: Family, start: &Fit) -> bool {
    let first_order = matches!(family, Family::Smoothing | Family::Digital { order: 1 });
    first_order == (start.model.family == Some(Family::Smoothing))
}

fn cost(fit: &Fit) -> f64 {
    fit.deviance + PRICE_OF_PARAMETER * fit.model.filter.len() as f64
}

fn by_deviance(a: &Fit, b: &Fit) -> std::cmp::Ordering {
    a.deviance.total_cmp(&b.deviance)
}
