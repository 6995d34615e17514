//! Numerics of sigmatau: Allan variance of rate records, the noise terms of inertial sensors, exact generators.
//!
//! Pure functions on `&[f64]`; no files, no units. "The paper" in these pages is N. El-Sheimy, H. Hou and X. Niu,
//! "Analysis and modeling of inertial sensors using Allan variance", IEEE Transactions on Instrumentation and
//! Measurement 57(1), 2008, doi 10.1109/TIM.2007.908635. Letters in formulas follow IEEE 952: Q quantization,
//! N random walk, B bias instability, K rate random walk, R rate ramp. Spectral densities are two-sided.

pub mod allan;
pub mod bandlimited;

pub mod compensated;
pub mod covariance;
pub mod deviations;
pub mod distributions;
mod draws;
pub mod error;
mod every_size;
pub mod finite;
mod flicker;
pub mod gaps;
pub mod generate;
pub mod gls;
mod kernel;
pub mod likelihood;
pub mod matern;
pub mod neighbours;
mod parallel;
pub mod phase;
mod points;
pub mod pole_bank;
mod processes;
pub mod psd;
pub mod resonance;
mod roots;
pub mod special;
mod squares;
pub mod stream;
pub mod terms;
mod threads;
mod trend;
