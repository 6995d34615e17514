//! The fit of a channel, and the joint fit of several runs, as frozen classes.

use crate::allan::{sizes, value_error};
use crate::frozen_class::{FromCore, frozen_class};
use crate::pool::detached;
use crate::terms::{in_order, named_term};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};
use sigmatau_core::likelihood as core;
use sigmatau_core::resonance::Resonance;
use sigmatau_core::terms::Term;

type Floats<'py> = PyResult<Bound<'py, PyArray1<f64>>>;

frozen_class! {
    /// A value and its interval; without an upper end, the interval is unknown.
    Estimate from core::Estimate {
        /// Value, inside its interval.
        value: f64,
        /// Lower end.
        low: Option<f64>,
        /// Upper end.
        high: Option<f64>,
    }
}

frozen_class! {
    /// A coefficient with an interval if it was observed, otherwise with an upper limit. [SI]
    TermEstimate from core::TermEstimate {
        /// Whether the term is significant.
        observed: bool,
        /// Value if it was observed; a ramp has a sign.
        value: Option<f64>,
        /// Lower end of its interval.
        low: Option<f64>,
        /// Upper end of its interval.
        high: Option<f64>,
        /// Upper limit if it was not observed, for a ramp of its magnitude; None if the record sets no limit.
        upper_limit: Option<f64>,
        /// P-value of its absence, with all other terms free. None if it was not tested.
        p_value: Option<f64>,
        /// Maximum of the likelihood and interval with all terms free, whether the term was observed or not.
        profile: Option<Estimate>,
    }
}

frozen_class! {
    /// A first-order Gauss-Markov process.
    GaussMarkovEstimate from core::GaussMarkovEstimate {
        /// Standard deviation. [rate unit]
        sigma: Estimate,
        /// Correlation time. [s]
        time: Estimate,
    }
}

frozen_class! {
    /// Narrow-band noise before the filter.
    ResonanceEstimate from core::ResonanceEstimate {
        /// Standard deviation. [rate unit]
        sigma: Estimate,
        /// Centre. [Hz]
        frequency: Estimate,
        /// Half width. [Hz]
        width: Estimate,
    }
}

frozen_class! {
    /// A line of the spectrum, after the filter.
    LineEstimate from core::LineEstimate {
        /// Amplitude. [rate unit]
        amplitude: Estimate,
        /// Frequency; its interval is the left-out band if the line was left out of the fit. [Hz]
        frequency: Estimate,
    }
}

frozen_class! {
    /// A drift of the mean that decays exponentially from the first sample.
    WarmUpEstimate from core::WarmUpEstimate {
        /// Drift at the first sample, of either sign. [rate unit]
        amplitude: Estimate,
        /// Time constant. [s]
        time: f64,
    }
}

frozen_class! {
    /// A model with one Matérn process in place of all slow noise.
    MaternEstimate from core::MaternEstimate {
        /// Whether the record shows the process.
        observed: bool,
        /// Standard deviation. [rate unit]
        sigma: Estimate,
        /// Upper limit of the standard deviation; None if the record sets no limit. [rate unit]
        upper_limit: Option<f64>,
        /// Correlation time, from 20 samples to a quarter of the record. [s]
        time: Estimate,
        /// Smoothness ν, from 0.02 to 1/2.
        smoothness: Estimate,
        /// Coefficients of the terms beside the process, by name. [SI]
        terms: Vec<(String, f64)>,
        /// P-value of the Gauss-Markov process, ν = 1/2.
        gauss_markov: f64,
        /// Akaike's criterion of the fit minus that of this model.
        gain: f64,
        /// P-value of the goodness of fit.
        p_value: f64,
    }
}

frozen_class! {
    /// A filter of all noise except quantization: ln |H|² = Σ aₖ (cos 2πk f Δ − 1).
    FilterEstimate {
        /// a₁, a₂ …
        coefficients: Vec<f64>,
        /// Sample interval. [s]
        tau0: f64,
        /// Δ: the sample interval, or a multiple where the top of the band was left out. [s]
        interval: f64,
        /// `butterworth`, `smoothing`, `running_mean`, `low_pass` or `uneven`.
        shape: String,
        /// Order of a Butterworth filter, or number of samples of a running mean.
        order: Option<u32>,
        /// Frequency of half the power. [Hz]
        corner: Option<f64>,
        /// Lower end of its interval. [Hz]
        low: Option<f64>,
        /// Upper end of its interval. [Hz]
        high: Option<f64>,
        /// Order and corner of the Butterworth filter that replaces it in a noise model. [Hz]
        low_pass: Option<(u8, f64)>,
        /// Frequency up to which the coefficients describe the filter; above, its shape does. None: at all frequencies.
        /// [Hz]
        known_to: Option<f64>,
        /// Damping of a filter with two poles.
        damping: Option<f64>,
        /// Whether a Butterworth filter of known shape is before the sampler.
        analog: bool,
        /// Whether the filter acts on the random walk alone.
        of_white: bool,
    }
}

frozen_class! {
    /// Another model that explains the record as well, with the same resonances and lines.
    SecondModel from core::SecondModel {
        /// Its coefficients by name. [SI]
        terms: Vec<(String, f64)>,
        /// Standard deviation [rate unit] and correlation time [s] of each of its Gauss-Markov processes.
        gauss_markov: Vec<(f64, f64)>,
        /// Time constant of its warm-up. [s]
        warm_up: Option<f64>,
        /// Exponent α of its bias instability with the density f^−α; its processes, a geometric series, add up to that.
        exponent: Option<f64>,
        /// Corner of its first-order filter of the white noise. [Hz]
        filter: Option<f64>,
    }
}

frozen_class! {
    /// A parameter of a model, one row of its covariance.
    Parameter {
        /// A term, `gauss_markov`, `resonance` or `sinusoid`.
        part: String,
        /// Number of a process among those of its kind, from 1; None for a term.
        number: Option<usize>,
        /// `sigma`, `time`, `frequency`, `width` or `amplitude` of a process; None for a term.
        quantity: Option<String>,
    }
}

frozen_class! {
    /// The fit of one channel. Numbers are in the unit of the rate and seconds.
    ChannelFit from core::ChannelFit {
        /// Requested terms by name, and the ramp.
        terms: Vec<(String, TermEstimate)>,
        /// Coefficients that together describe the record, by name: the observed terms and those of `unclear`.
        model: Vec<(String, f64)>,
        /// Terms of the model of which none is significant given the others, although at least one is present.
        unclear: Vec<String>,
        /// Gauss-Markov processes.
        gauss_markov: Vec<GaussMarkovEstimate>,
        /// Resonances before the filter.
        resonance: Vec<ResonanceEstimate>,
        /// Lines after the filter, the strongest first.
        sinusoid: Vec<LineEstimate>,
        /// Filter of all noise except quantization.
        response: Option<FilterEstimate>,
        /// Drift that decays.
        warm_up: Option<WarmUpEstimate>,
        /// Coefficients of the regressors, in their units.
        regressors: Vec<Estimate>,
        /// Frequency from which the spectrum was left out. [Hz]
        highest: Option<f64>,
        /// If a rate random walk was observed: shortest correlation time of a Gauss-Markov process that explains the record
        /// as well. [s]
        alike_from: Option<f64>,
        /// Standard deviation of the process of this time, None if the model has no rate random walk. [rate unit]
        alike_sigma: Option<f64>,
        /// The model with one Matérn process, if it is wanted.
        matern: Option<MaternEstimate>,
        /// Other models that explain the record as well.
        second: Vec<SecondModel>,
        /// Discrepancy that the intervals allow for, even if the model is adequate: frequency [Hz], standard deviation of
        /// the logarithm of the density.
        discrepancy: Vec<(f64, f64)>,
        /// `adequate`, `adequate_with` or `widened`.
        verdict: String,
        /// The band with the largest difference from a model with widened intervals: frequency [Hz], density over that of
        /// the model.
        worst_band: Option<(f64, f64)>,
        /// Shortest averaging time at which the noise model from the fit describes the curve. [s]
        tau_min: f64,
        /// Longest averaging time. [s]
        tau_max: f64,
        /// P-value of the goodness of fit.
        p_value: f64,
        /// Names of the rows of `covariance`.
        parameters: Vec<Parameter>,
        /// Covariance of these parameters in row order. [SI]
        covariance: Vec<f64>,
        /// White noise of each eighth of the record that has samples: number, level relative to the fit, variance of the
        /// level by chance.
        levels: Vec<(usize, f64, f64)>,
        /// Ends of the stretch that each line leaves out of the fit. [Hz]
        left_out: Vec<(f64, f64)>,
        /// Variance [(rate unit)²], centre and half width [Hz] of all resonances, including those that are listed as lines.
        resonances: Vec<(f64, f64, f64)>,
    }
}

frozen_class! {
    /// One run of a joint fit, compared with the others.
    RunEstimate from core::RunEstimate {
        /// Coefficients that differ from run to run, by name. [SI]
        values: Vec<(String, Estimate)>,
        /// Common coefficients estimated from this run alone; intervals are symmetric about the square. [SI]
        own: Vec<(String, Estimate)>,
        /// P-value of the run compared with the others, corrected for the number of runs and tests.
        p_value: f64,
        /// Largest difference of the run: a term, or `all` for the shape of the spectrum, with its filter.
        cause: String,
        /// The coefficient of the cause over that of the other runs; None if they do not show it.
        factor: Option<f64>,
    }
}

frozen_class! {
    /// One model of several runs.
    JointChannelFit from core::JointFit {
        /// The model of all runs.
        fit: ChannelFit,
        /// Terms that are the same in all runs.
        common: Vec<String>,
        /// Relative standard deviation over the runs, and p-value of no difference, by term.
        spreads: Vec<(String, (f64, f64))>,
        /// P-value of equality in all runs, by term.
        homogeneity: Vec<(String, f64)>,
        /// Results by run.
        runs: Vec<RunEstimate>,
    }
}

/// The model of a record as a curve.
#[pyclass(frozen, module = "sigmatau._core")]
pub struct FittedModel(core::FittedModel);

#[pymethods]
impl FittedModel {
    /// Coefficients by name; parameters of processes, resonances and lines in the order of their names.
    #[new]
    #[allow(clippy::too_many_arguments)] // one argument per part
    #[pyo3(signature = (tau0, samples, terms, gauss_markov, resonance, sinusoid, filter=None, highest=None, warm_up=None))]
    fn new(
        tau0: f64,
        samples: usize,
        terms: Vec<(String, f64)>,
        gauss_markov: Vec<(f64, f64)>,
        resonance: Vec<(f64, f64, f64)>,
        sinusoid: Vec<(f64, f64)>,
        filter: Option<FilterEstimate>,
        highest: Option<f64>,
        warm_up: Option<(f64, f64)>,
    ) -> PyResult<Self> {
        let coefficients = in_order(terms)?;
        let resonance = resonance
            .into_iter()
            .map(|(sigma, frequency, width)| Resonance { sigma, frequency, width })
            .collect();
        let filter = filter.map(core::FittedFilter::try_from).transpose()?;
        Ok(Self(core::FittedModel {
            tau0,
            samples,
            terms: coefficients,
            gauss_markov,
            resonance,
            sinusoid,
            filter,
            highest,
            warm_up,
        }))
    }

    /// Expected Allan variances at cluster sizes.
    fn avar<'py>(&self, py: Python<'py>, m: PyReadonlyArray1<'py, i64>) -> Floats<'py> {
        let sizes = sizes(&m)?;
        if sizes.contains(&0) {
            return Err(PyValueError::new_err("`m` must be at least 1 sample, got 0"));
        }
        Ok(py.detach(|| self.0.avar(&sizes)).into_pyarray(py))
    }

    /// Degrees of freedom of Allan variances; None for a model without noise.
    fn degrees_of_freedom<'py>(
        &self,
        py: Python<'py>,
        m: PyReadonlyArray1<'py, i64>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let sizes = sizes(&m)?;
        let freedom =
            detached(py, || self.0.degrees_of_freedom(&sizes)).map_err(|error| value_error(&error))?;
        Ok(freedom.map(|freedom| freedom.into_pyarray(py)))
    }

    /// Averaging times at which each term is at least half of the variance, by its name and coefficient. [s]
    fn line_ranges(
        &self,
        py: Python<'_>,
        terms: Vec<(String, f64)>,
        start: f64,
    ) -> PyResult<Vec<Option<(f64, f64)>>> {
        let terms: Vec<(Term, f64)> =
            terms.iter().map(|(name, value)| Ok((named_term(name)?, *value))).collect::<PyResult<_>>()?;
        Ok(py.detach(|| self.0.line_ranges(&terms, start)))
    }

    /// Two-sided density at frequencies.
    fn psd<'py>(&self, py: Python<'py>, f: PyReadonlyArray1<'py, f64>) -> Floats<'py> {
        Ok(self.0.psd(f.as_slice()?).into_pyarray(py))
    }

    /// Two-sided density before the filter of the noise on which it acts.
    fn psd_before_filter<'py>(&self, py: Python<'py>, f: PyReadonlyArray1<'py, f64>) -> Floats<'py> {
        Ok(f.as_slice()?.iter().map(|&f| self.0.psd_before_filter(f)).collect::<Vec<_>>().into_pyarray(py))
    }
}

const SHAPES: [(core::FilterShape, &str); 7] = [
    (core::FilterShape::Butterworth, "butterworth"),
    (core::FilterShape::Smoothing, "smoothing"),
    (core::FilterShape::RunningMean, "running_mean"),
    (core::FilterShape::TwoPoles, "two_poles"),
    (core::FilterShape::Means, "running_means"),
    (core::FilterShape::LowPass, "low_pass"),
    (core::FilterShape::Uneven, "uneven"),
];

impl TryFrom<FilterEstimate> for core::FittedFilter {
    type Error = PyErr;

    fn try_from(filter: FilterEstimate) -> PyResult<Self> {
        let shape = SHAPES.iter().find(|(_, name)| *name == filter.shape);
        let Some(&(shape, _)) = shape else {
            return Err(PyValueError::new_err(format!("unknown shape {}", filter.shape)));
        };
        let FilterEstimate { coefficients, tau0, interval, order, low_pass, known_to, .. } = filter;
        let FilterEstimate { damping, analog, of_white, .. } = filter;
        let (low, high) = (filter.low, filter.high);
        let corner = filter.corner.map(|corner| [corner, low.unwrap_or(corner), high.unwrap_or(corner)]);
        Ok(Self {
            coefficients,
            tau0,
            interval,
            shape,
            order,
            corner,
            low_pass,
            known_to,
            damping,
            analog,
            of_white,
        })
    }
}

impl FromCore<core::FittedFilter> for FilterEstimate {
    fn from_core(filter: core::FittedFilter) -> Self {
        let shape = SHAPES.iter().find(|(shape, _)| *shape == filter.shape).map_or("", |(_, name)| name);
        let core::FittedFilter { coefficients, tau0, interval, order, low_pass, known_to, .. } = filter;
        let core::FittedFilter { damping, analog, of_white, .. } = filter;
        let [corner, low, high] = filter.corner.map_or([None; 3], |numbers| numbers.map(Some));
        let shape = shape.to_owned();
        Self {
            coefficients,
            tau0,
            interval,
            shape,
            order,
            corner,
            low,
            high,
            low_pass,
            known_to,
            damping,
            analog,
            of_white,
        }
    }
}

impl From<Estimate> for core::Estimate {
    fn from(Estimate { value, low, high }: Estimate) -> Self {
        Self { value, low, high }
    }
}

impl From<LineEstimate> for core::LineEstimate {
    fn from(line: LineEstimate) -> Self {
        Self { amplitude: line.amplitude.into(), frequency: line.frequency.into() }
    }
}

/// The coefficient of a term, by its name.
impl FromCore<&'static str> for Parameter {
    fn from_core(term: &'static str) -> Self {
        Self { part: term.to_owned(), number: None, quantity: None }
    }
}

impl FromCore<core::Parameter> for Parameter {
    fn from_core(parameter: core::Parameter) -> Self {
        let (part, number, quantity) = match parameter {
            core::Parameter::Term(term) => return Self::from_core(term.name()),
            core::Parameter::GaussMarkov(number, quantity) => ("gauss_markov", number, quantity),
            core::Parameter::Resonance(number, quantity) => ("resonance", number, quantity),
            core::Parameter::Sinusoid(number, quantity) => ("sinusoid", number, quantity),
        };
        let quantity = match quantity {
            core::Number::Sigma => "sigma",
            core::Number::Time => "time",
            core::Number::Frequency => "frequency",
            core::Number::Width => "width",
            core::Number::Amplitude => "amplitude",
        };
        Self { part: part.to_owned(), number: Some(number), quantity: Some(quantity.to_owned()) }
    }
}

impl FromCore<core::Verdict> for String {
    fn from_core(verdict: core::Verdict) -> Self {
        let name = match verdict {
            core::Verdict::Adequate => "adequate",
            core::Verdict::AdequateWith => "adequate_with",
            core::Verdict::Widened => "widened",
        };
        name.to_owned()
    }
}

impl FromCore<core::WhiteLevel> for (usize, f64, f64) {
    fn from_core(part: core::WhiteLevel) -> Self {
        (part.eighth, part.level, part.variance)
    }
}

impl FromCore<Resonance> for (f64, f64, f64) {
    fn from_core(band: Resonance) -> Self {
        (band.sigma.powi(2), band.frequency, band.width)
    }
}

impl FromCore<core::Spread> for (f64, f64) {
    fn from_core(spread: core::Spread) -> Self {
        (spread.relative, spread.p_value)
    }
}
