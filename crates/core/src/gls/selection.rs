//! Choice of the shortest averaging time of a fit, and of a Gauss-Markov process.

use crate::gls::attempt::{Attempt, Data, attempt};
use crate::gls::process::best_time;
use crate::gls::step::Work;

/// Smallest number of averaging times: four terms, and four degrees of freedom for the goodness of fit.
const MIN_TIMES: usize = 8;

/// Smallest p-value of the goodness of fit with all averaging times for the model to be adequate.
pub(crate) const MIN_P: f64 = 0.002;

/// The same if shorter averaging times are left out, because they are then known to deviate.
const MIN_P_LATER: f64 = 0.01;

/// Largest p-value of the terms alone for which a process is tested. Of 256 processes whose gain exceeds the price, 1 is
/// missed.
const PROCESS_P: f64 = 0.3;

/// Upper bound of the shortest averaging time: an internal low-pass filter has no effect beyond it in practice. \[samples\]
const LARGEST_START: usize = 128;

/// The adequate attempt if there is one, otherwise the attempt with the largest p-value; and whether it is adequate.
pub(crate) fn best_attempt(data: &Data, level: f64, work: &mut Work) -> (Option<Attempt>, bool) {
    let sizes = data.sizes();
    let count = sizes.len();
    let mut starts: Vec<usize> =
        (0..count).filter(|&k| sizes[k] <= LARGEST_START && count - k >= MIN_TIMES).collect();
    if data.first.is_some() || starts.is_empty() {
        starts = vec![data.first.unwrap_or(0)];
    }
    let mut tried: Vec<Attempt> = Vec::new();
    for &first in &starts {
        let is_first = first == starts[0];
        let Some(mut found) = attempt(data, first, level, None, work) else { continue };
        if is_first {
            found = with_process(data, found, level, work);
        }
        if found.p_value > if is_first { MIN_P } else { MIN_P_LATER } {
            return (Some(if is_first { found } else { an_octave_later(data, found, level, work) }), true);
        }
        tried.push(found);
    }
    // A process at later starts is only tested now, because it could absorb the remainder of a filter.
    for k in 0..tried.len() {
        let later = &tried[k];
        if later.first == starts[0] || !sizes[later.first].is_power_of_two() {
            continue;
        }
        let found = with_process(data, later.clone(), level, work);
        if found.p_value > MIN_P_LATER {
            return (Some(found), true);
        }
        tried.push(found);
    }
    let better = |best: Attempt, one: Attempt| if one.p_value > best.p_value { one } else { best };
    (tried.into_iter().reduce(better), false)
}

/// The fit with a Gauss-Markov process if its gain exceeds the price, otherwise the fit unchanged.
fn with_process(data: &Data, found: Attempt, level: f64, work: &mut Work) -> Attempt {
    if found.p_value >= PROCESS_P {
        return found;
    }
    let time = best_time(data, &found, level, work);
    time.and_then(|time| attempt(data, found.first, level, Some(time), work)).unwrap_or(found)
}

/// The fit from twice the averaging time, where a deviation that was just not significant is half as large.
fn an_octave_later(data: &Data, found: Attempt, level: f64, work: &mut Work) -> Attempt {
    let sizes = data.sizes();
    let later = sizes.partition_point(|&size| size < 2 * sizes[found.first]);
    if later == sizes.len() || sizes.len() - later < MIN_TIMES {
        return found;
    }
    match attempt(data, later, level, None, work) {
        Some(again) if again.p_value > MIN_P_LATER => again,
        _ => found,
    }
}
