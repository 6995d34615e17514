//! Fourier transforms of real numbers.
//!
//! The transforms of `rustfft` are generic, and every crate that plans one compiles all of them. Only this crate plans
//! them.

pub use realfft::num_complex::Complex64;
pub use realfft::{ComplexToReal, RealToComplex};
use std::sync::Arc;

/// Plans of transforms; each length is planned once.
#[derive(Default)]
pub struct Planner(realfft::RealFftPlanner<f64>);

impl Planner {
    /// A planner without plans.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Transforms `length` real numbers to `length / 2 + 1` complex ones.
    pub fn forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// Transforms `length / 2 + 1` complex numbers to `length` real ones.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.0.plan_fft_inverse(length)
    }
}
