//! The likelihood of a channel: about 200 gamma-distributed means of powers, and a model of the density that explains them.
//!
//! [`Pass`] reads the samples once, [`MaskedPass`] those of a record with missing samples. [`fit_channel`] selects the
//! model, which has the terms and further parts (a filter, lines, Gauss-Markov processes, resonances, drifts), tests it,
//! and profiles the likelihood for intervals.

mod abscissae;
mod adequacy;
mod alike;
mod analysis;
mod band;
mod bins;
mod candidates;
mod channel_fit;
mod described;
mod discrepancy;
mod drifts;
mod estimates;
mod exchange;
mod expected;
mod filter;
mod filter_shapes;
mod filters;
mod fit;
mod fitted_model;
mod flicker_slope;
mod intervals;
mod joint;
mod joint_fit;
mod laws;
mod line;
mod line_ranges;
pub(crate) mod linear;
mod lines;
mod masked;
mod matern_process;
mod model;
mod model_freedom;
mod modes;
mod no_quantization;
mod outcome;
mod parts;
mod pass;
mod power_law;
mod profile;
mod regression;
mod resonance_shape;
mod running_mean;
mod runs;
mod select;
mod slow_lines;
mod spectrum;
mod summary;
mod taper;
mod white_levels;

pub use channel_fit::{ChannelFit, MaternEstimate, SecondModel, Verdict, WarmUpEstimate, fit_channel};
pub use estimates::{Estimate, TermEstimate};
pub use filter::{FilterShape, FittedFilter};
pub use fitted_model::FittedModel;
pub use joint::Common;
pub use joint_fit::{ALPHA, Contribution, JointFit, RunEstimate, Spread, fit_jointly};
pub use masked::{MaskedPass, Weighting};
pub use outcome::{Options, WhiteLevel};
pub use parts::{GaussMarkovEstimate, LineEstimate, MAX_LINES, Number, Parameter, ResonanceEstimate};
pub use pass::Pass;
pub use summary::{MIN_SAMPLES, Summary};
