//! The estimate of a record: the likelihood with its default options, as a list of numbers for the page.

use sigmatau_core::error::Error;
use sigmatau_core::likelihood::{Estimate, MIN_SAMPLES, Options, Pass, Summary, Verdict, fit_channel};
use sigmatau_core::terms::Term;

/// In the place of a number that a fit does not have.
const MISSING: f64 = f64::NAN;

/// Number of bands of a spectrum per decade, and smallest number of values in a band.
const BANDS: f64 = 16.0;
const FEWEST: f64 = 4.0;

/// The summary of a record.
///
/// # Errors
///
/// [`Error`] for a record that is too short or has a sample that is not finite.
pub fn summary(rate: &[f64], tau0: f64) -> Result<Summary, Error> {
    if rate.len() < MIN_SAMPLES {
        return Err(Error::TooShort { need: MIN_SAMPLES, got: rate.len() });
    }
    let mut pass = Pass::new(rate.len(), tau0)?;
    pass.push(rate)?;
    pass.finish()
}

/// Verdict (0 adequate, 1 adequate with other parts, 2 widened), p-value, shortest and longest averaging time \[s\]; by term
/// whether it was observed, value, low, high, upper limit, and its coefficient in the model; corner of a filter \[Hz\] with
/// its interval; order and corner \[Hz\] of the Butterworth filter before the sampler that replaces it; then for each
/// Gauss-Markov process its σ and its time \[s\] with their intervals. NaN where there is no value. In SI.
#[must_use]
pub fn estimate(record: &Summary) -> Vec<f64> {
    let fit = fit_channel(record, &Options::default(), record.samples);
    let verdict = match fit.verdict {
        Verdict::Adequate => 0.0,
        Verdict::AdequateWith => 1.0,
        Verdict::Widened => 2.0,
    };
    let mut values = vec![verdict, fit.p_value, fit.tau_min, fit.tau_max];
    for term in Term::ALL {
        let Some((_, found)) = fit.terms.iter().find(|(name, _)| *name == term.name()) else {
            values.extend([0.0, MISSING, MISSING, MISSING, MISSING, 0.0]);
            continue;
        };
        let model = fit.model.iter().find(|(name, _)| *name == term.name()).map_or(0.0, |(_, value)| *value);
        let numbers = [found.value, found.low, found.high, found.upper_limit].map(|x| x.unwrap_or(MISSING));
        values.push(f64::from(u8::from(found.observed)));
        values.extend(numbers);
        values.push(model);
    }
    let filter = fit.response.as_ref();
    values.extend(filter.and_then(|filter| filter.corner).unwrap_or([MISSING; 3]));
    let low_pass = filter.and_then(|filter| filter.low_pass);
    values.extend(low_pass.map_or([MISSING; 2], |(order, corner)| [f64::from(order), corner]));
    let ends = |of: Estimate| [of.value, of.low.unwrap_or(MISSING), of.high.unwrap_or(MISSING)];
    for process in &fit.gauss_markov {
        values.extend(ends(process.sigma));
        values.extend(ends(process.time));
    }
    values
}

/// Two-sided density of a record: frequency \[Hz\] and mean density of each band, in turn. The lowest bands are means of
/// squared cosine modes.
#[must_use]
pub fn density(record: &Summary) -> Vec<f64> {
    let first = record.frequency(1);
    let modes = record.modes.iter().enumerate().map(|(k, mode)| (record.mode_frequency(k + 1), mode * mode));
    let segments = record.density.iter().enumerate().skip(1).map(|(k, &value)| (record.frequency(k), value));
    let mut bands = Vec::new();
    let mut band: Option<(i64, f64, f64, f64)> = None;
    for (frequency, value) in modes.take_while(|(frequency, _)| *frequency < first).chain(segments) {
        let index = (BANDS * frequency.log10()).floor() as i64;
        match &mut band {
            Some((of, count, sum, total)) if *of == index || *count < FEWEST => {
                *count += 1.0;
                *sum += frequency.ln();
                *total += value;
            }
            _ => {
                bands.extend(band.map(|(_, count, sum, total)| [(sum / count).exp(), total / count]));
                band = Some((index, 1.0, frequency.ln(), value));
            }
        }
    }
    bands.extend(band.map(|(_, count, sum, total)| [(sum / count).exp(), total / count]));
    bands.into_iter().flatten().collect()
}
