//! A line of the spectrum.

use crate::likelihood::summary::Summary;

/// Degrees of freedom of a density, over the number of independent segments (Hann, 75 % overlap).
const FREEDOM: f64 = 4.16;

/// A line of the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Ends of what was left out. \[Hz\]
    pub from: f64,
    /// The other end. \[Hz\]
    pub to: f64,
    /// Highest density, between two of the periodogram. \[Hz\]
    pub frequency: f64,
    /// Its standard error, or a quarter of the width of noise of a narrow band. \[Hz\]
    pub frequency_error: f64,
    /// Amplitude of a sinusoid of the same power, and its standard error if the line is noise of a narrow band; a steady
    /// sinusoid has a smaller one. \[rate unit\]
    pub amplitude: f64,
    /// See `amplitude`.
    pub error: f64,
}

/// Degrees of freedom of one density.
pub(crate) fn freedom_of_one(record: &Summary) -> f64 {
    let whole = FREEDOM * record.samples as f64 / record.segment as f64;
    record.masked.as_ref().map_or(whole, |masked| whole * masked.freedom_left(1))
}
