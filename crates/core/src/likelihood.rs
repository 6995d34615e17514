//! One likelihood for a channel: some 200 means of powers with gamma laws, and a model of the density that explains them.
//!
//! [`Pass`] goes over the samples once, [`MaskedPass`] over those of a record with missing ones. [`analyse`] selects the model: the terms, and what else the record shows (a filter,
//! lines, Gauss-Markov processes, resonances, drifts), tests it, and profiles the likelihood for intervals.

mod adequacy;
mod analysis;
mod band;
mod bins;
mod candidates;
mod discrepancy;
mod drifts;
mod expected;
mod intervals;
mod joint;
mod laws;
pub(crate) mod linear;
mod lines;
mod masked;
mod model;
mod outcome;
mod pass;
mod profile;
mod runs;
mod select;

pub use analysis::analyse;
pub use expected::Part;
pub use joint::{Common, Joint, Level, Other, analyse_jointly};
pub use lines::Line;
pub use masked::{MaskedPass, Weighting};
pub use outcome::{Drift, Options, Outcome, Process};
pub use pass::{LEAST_SAMPLES, Pass, Summary};
pub use profile::Bounds;
