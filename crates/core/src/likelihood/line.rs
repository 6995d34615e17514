//! A line of the spectrum.

use crate::likelihood::summary::Summary;

/// Degrees of freedom of a density, over the number of independent segments (Hann, 75 % overlap).
const FREEDOM_PER_SEGMENT: f64 = 4.16;

/// A line of the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Lower end of the left-out band. \[Hz\]
    pub from: f64,
    /// Upper end. \[Hz\]
    pub to: f64,
    /// Frequency of the peak, interpolated between two densities of the periodogram. \[Hz\]
    pub frequency: f64,
    /// Standard error of the frequency, or a quarter of the width of narrow-band noise. \[Hz\]
    pub frequency_error: f64,
    /// Amplitude of a sinusoid with the same power. \[rate unit\]
    pub amplitude: f64,
    /// Standard error of the amplitude for narrow-band noise; that of a steady sinusoid is smaller. \[rate unit\]
    pub error: f64,
}

/// Degrees of freedom of one density.
pub(crate) fn density_freedom(record: &Summary) -> f64 {
    let whole = FREEDOM_PER_SEGMENT * record.samples as f64 / record.segment as f64;
    record.masked.as_ref().map_or(whole, |masked| whole * masked.freedom_share(1))
}
