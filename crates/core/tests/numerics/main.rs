//! Tests of the numerics through their public interface, in one program: linking ten takes longer than running them.

mod accuracy;
mod covariance;
mod covariance_sums;
mod deviations_exact;
mod deviations_freedom;
mod generators;
mod known_answers;
mod laws;
mod spectra;
mod stream;
