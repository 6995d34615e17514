//! Options of the analysis of a channel, and its result.

use crate::likelihood::expected::Part;
use crate::likelihood::filter_shapes::Family;
use crate::likelihood::line::Line;
use crate::likelihood::matern_process::MaternOutcome;
use crate::likelihood::profile::Bounds;
use crate::likelihood::running_mean::RunningMean;
use crate::terms::NOISE_TERMS;

/// Options of an analysis.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::struct_excessive_bools)] // one flag for each kind of part that may be added
pub struct Options {
    /// Mask of [`Term::NOISE`](crate::terms::Term::NOISE): terms that may be present.
    pub terms: [bool; NOISE_TERMS],
    /// Whether a filter, Gauss-Markov processes and resonances may be added.
    pub filter: bool,
    /// See `filter`.
    pub processes: bool,
    /// See `filter`.
    pub resonances: bool,
    /// Whether lines are detected and left out.
    pub lines: bool,
    /// Whether a rate ramp and a warm-up are tested.
    pub drifts: bool,
    /// Correlation times of Gauss-Markov processes that are in the model from the start. \[s\]
    pub times: Vec<f64>,
    /// Whether one Matérn process in place of all slow noise is fitted too.
    pub matern: bool,
    /// Curves that the mean may follow, given at the centres of the blocks.
    pub regressors: Vec<Vec<f64>>,
    /// Confidence level.
    pub level: f64,
    /// Largest quantization noise that is compatible with the step of the samples; infinite if that is unknown. [unit of the
    /// rate times s]
    pub most_quantization: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            terms: [true; NOISE_TERMS],
            filter: true,
            processes: true,
            resonances: true,
            lines: true,
            drifts: true,
            times: Vec::new(),
            matern: false,
            regressors: Vec::new(),
            level: 0.95,
            most_quantization: f64::INFINITY,
        }
    }
}

/// A Gauss-Markov process or a resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Process {
    /// Its kind and shape.
    pub part: Part,
    /// Its variance.
    pub variance: Bounds,
    /// Bounds of its correlation time \[s\], or of its centre and half width \[Hz\].
    pub shape: [Option<Bounds>; 2],
}

/// A coefficient of a regressor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Value, per unit of the regressor.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// Another model that explains the record as well: its squares of Q, N, B and K, and the variances and correlation times
/// \[s\] of its Gauss-Markov processes.
#[derive(Debug, Clone, PartialEq)]
pub struct Second {
    /// Q², N², B², K²; 0 for a term that the model lacks.
    pub terms: [f64; NOISE_TERMS],
    /// Variance and correlation time of each process.
    pub gauss_markov: Vec<(f64, f64)>,
    /// Time constant of a warm-up in the model. \[s\]
    pub warm_up: Option<f64>,
    /// Exponent of its bias instability, f^−α, which its processes approximate.
    pub exponent: Option<f64>,
    /// Corner of a first-order filter of the white noise in the model. \[Hz\]
    pub filter: Option<f64>,
}

/// The result for one channel. Parameters are squares of coefficients, in the unit of the rate and seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The terms that were fitted: Q², N², B², K².
    pub terms: [Option<Bounds>; NOISE_TERMS],
    /// Coefficients of the model that describes the record: those of `terms` that were observed.
    pub reduced: [f64; NOISE_TERMS],
    /// Processes and resonances.
    pub processes: Vec<Process>,
    /// Coefficients of ln |H|² = Σ aₖ (cos 2πk f Δ − 1), a filter of all noise except quantization.
    pub filter: Vec<f64>,
    /// Δ: the sample interval, or a multiple where the top of the band was left out. \[s\]
    pub filter_interval: f64,
    /// A running mean of all noise except quantization, instead of a filter.
    pub mean: Option<RunningMean>,
    /// The family of the filter, in which case `filter` contains its parameters, and whether it acts on the random walk
    /// alone.
    pub(crate) family: Option<Family>,
    pub(crate) of_white: bool,
    /// Lines that were left out.
    pub lines: Vec<Line>,
    /// Frequency up to which modes describe the record. \[Hz\]
    pub end_of_modes: f64,
    /// Lines below that frequency, which are regressors of the mean.
    pub slow_lines: Vec<SlowLine>,
    /// Frequency from which the band was left out. \[Hz\]
    pub highest: Option<f64>,
    /// If a rate random walk was observed: the shortest correlation time \[s\] of a Gauss-Markov process that explains the
    /// record as well, and its variance.
    pub alike_from: Option<(f64, f64)>,
    /// The model with one Matérn process, if it is wanted.
    pub matern: Option<MaternOutcome>,
    /// Other models with processes in place of terms, or terms in place of processes, that explain the record as well.
    pub second: Vec<Second>,
    /// Rate ramp per second.
    pub ramp: Drift,
    /// Whether the ramp is significant and part of the model.
    pub ramp_observed: bool,
    /// Time constant \[s\], amplitude at the start, and reduction of the deviance.
    pub warm_up: Option<(f64, Drift, f64)>,
    /// Coefficients of the given regressors.
    pub regressors: Vec<Drift>,
    /// P-value of the model.
    pub p_value: f64,
    /// Whether the model is not adequate, and intervals are widened.
    pub widened: bool,
    /// Bands: frequency \[Hz\], and normal deviate of the difference between record and model.
    pub bands: Vec<(f64, f64)>,
    /// Size of the misfit that the intervals allow for: frequency \[Hz\], standard deviation of the logarithm of the
    /// density.
    pub discrepancy: Vec<(f64, f64)>,
    /// White noise of each eighth of the record that has samples.
    pub levels: Vec<WhiteLevel>,
    /// Parts of the reduced model, in the order of `covariance`: terms, then processes.
    pub parameters: Vec<Part>,
    /// Covariance of their parameters, of the coefficients of the filter, and of the shapes of processes in the order of the
    /// parts (logarithms of times and widths; frequencies in widths), in row order.
    pub covariance: Vec<f64>,
    /// Bins: frequency \[Hz\], measured and expected density, degrees of freedom.
    pub bins: Vec<[f64; 4]>,
}

/// A sinusoid in the mean, with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowLine {
    /// \[Hz\]
    pub frequency: f64,
    /// \[Hz\]
    pub frequency_error: f64,
    /// \[rate unit\]
    pub amplitude: f64,
    /// \[rate unit\]
    pub amplitude_error: f64,
}

/// White noise in an eighth of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteLevel {
    /// Number of the eighth, from 0.
    pub eighth: usize,
    /// Square of the random walk over that of the fit, weighted by the share of the random walk in the density.
    pub level: f64,
    /// Variance of `level` for stationary noise.
    pub variance: f64,
}

/// Excess kurtosis of the samples, and their number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tails {
    pub kurtosis: f64,
    pub present: usize,
}

impl Tails {
    /// The excess kurtosis if it is significant; 0 otherwise.
    pub(crate) fn heavy(&self) -> f64 {
        let chance = (24.0 / self.present as f64).sqrt();
        if self.kurtosis > 3.0 * chance { self.kurtosis } else { 0.0 }
    }
}
