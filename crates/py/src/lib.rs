//! Module `sigmatau._core`: it converts arguments, releases the interpreter, calls the pure crates and converts the
//! results.

// Arguments are passed by value, because a PyReadonlyArray is already a borrow of the array.
#![allow(clippy::needless_pass_by_value)]

use pyo3::prelude::*;

mod allan;
mod channel_fit;
mod covariance;
mod deviations;
mod distributions;
mod flight;
mod frozen_class;
mod gaps;
mod generate;
mod gls;
mod likelihood;
mod neighbours;
mod pool;
mod ros;
mod sentences;
mod stream;
mod terms;
mod text;

#[pymodule(gil_used = false)]
mod _core {
    /// Largest number of lines of a fit; the strongest ones are kept.
    #[pymodule_export]
    const MAX_LINES: usize = sigmatau_core::likelihood::MAX_LINES;
    /// Corrected p-value below which a run is an outlier.
    #[pymodule_export]
    const OUTLIER_ALPHA: f64 = sigmatau_core::likelihood::ALPHA;

    #[pymodule_export]
    use crate::allan::{NonFinite, all_finite, allan_variances};
    #[pymodule_export]
    use crate::channel_fit::{
        ChannelFit, Estimate, FilterEstimate, FittedModel, GaussMarkovEstimate, JointChannelFit,
        LineEstimate, MaternEstimate, Parameter, ResonanceEstimate, RunEstimate, SecondModel, TermEstimate,
        WarmUpEstimate,
    };
    #[pymodule_export]
    use crate::covariance::covariance_tensors;
    #[pymodule_export]
    use crate::deviations::{
        deviation_limits, deviations_of_channels, quadratic_edf, stationary_moments, theo1_expectation,
        total_bias,
    };
    #[pymodule_export]
    use crate::distributions::{distribution, distribution_of_shape};
    #[pymodule_export]
    use crate::flight::{dataflash_columns, scan_dataflash, scan_ulog, ulog_columns};
    #[pymodule_export]
    use crate::gaps::masked_variances;
    #[pymodule_export]
    use crate::generate::{Generator, flicker_poles};
    #[pymodule_export]
    use crate::gls::{CurveFit, Gls, GlsComponents, fit_curve, non_negative};
    #[pymodule_export]
    use crate::likelihood::{LikelihoodPass, LikelihoodSummary, fit_jointly};
    #[pymodule_export]
    use crate::neighbours::{from_sides, neighbour_medians, neighbour_scatter, outliers};
    #[pymodule_export]
    use crate::ros::{decode_messages, log_contents, log_messages, unpacked};
    #[pymodule_export]
    use crate::sentences::read_sentences;
    #[pymodule_export]
    use crate::stream::{Accumulator, strides};
    #[pymodule_export]
    use crate::terms::{
        band_limited_avar, band_limited_psd, gauss_markov_avar, gauss_markov_psd, matern_processes,
    };
    #[pymodule_export]
    use crate::terms::{resonance_avar, resonance_folds, resonance_psd, sinusoid_avar, term_avar, term_psd};
    #[pymodule_export]
    use crate::text::{TextError, bytes_read, format_text, parse_stamp, parse_text, read_text};
}
