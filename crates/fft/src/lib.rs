//! Fourier transforms of real numbers.
//!
//! The transforms of `rustfft` are generic, and every crate that plans one compiles all of them. Only this crate plans
//! them.

use realfft::RealFftPlanner;
pub use realfft::num_complex::Complex64;
pub use realfft::{ComplexToReal, RealToComplex};
use std::sync::{Arc, Mutex, PoisonError};

/// Largest number of plans that are stored, and the sum of their lengths.
const STORED: usize = 32;
const STORED_LENGTH: usize = 1 << 21;

/// Plans of the latest lengths: a plan takes about as long as a transform, and the channels of a record have equal lengths.
static FORWARD: Mutex<Plans<dyn RealToComplex<f64>>> = Mutex::new(Plans(Vec::new()));
static INVERSE: Mutex<Plans<dyn ComplexToReal<f64>>> = Mutex::new(Plans(Vec::new()));

/// Transforms `length` real numbers to `length / 2 + 1` complex ones.
#[must_use]
pub fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    planned(&FORWARD, length, |planner| planner.plan_fft_forward(length))
}

/// Transforms `length / 2 + 1` complex numbers to `length` real ones.
#[must_use]
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    planned(&INVERSE, length, |planner| planner.plan_fft_inverse(length))
}

/// Plans in the order of their use, the latest last, with their lengths.
struct Plans<T: ?Sized>(Vec<(usize, Arc<T>)>);

impl<T: ?Sized> Plans<T> {
    fn get(&mut self, length: usize) -> Option<Arc<T>> {
        let index = self.0.iter().position(|(planned, _)| *planned == length)?;
        self.0[index..].rotate_left(1);
        self.0.last().map(|(_, plan)| Arc::clone(plan))
    }

    fn store(&mut self, length: usize, plan: &Arc<T>) {
        if length > STORED_LENGTH || self.0.iter().any(|(planned, _)| *planned == length) {
            return;
        }
        self.0.push((length, Arc::clone(plan)));
        while self.0.len() > STORED
            || self.0.iter().map(|(planned, _)| planned).sum::<usize>() > STORED_LENGTH
        {
            self.0.remove(0);
        }
    }
}

/// The stored plan of a length, or a new one. No thread waits while another plans.
fn planned<T: ?Sized>(
    plans: &Mutex<Plans<T>>,
    length: usize,
    plan: impl FnOnce(&mut RealFftPlanner<f64>) -> Arc<T>,
) -> Arc<T> {
    let stored = plans.lock().unwrap_or_else(PoisonError::into_inner).get(length);
    stored.unwrap_or_else(|| {
        let plan = plan(&mut RealFftPlanner::new());
        plans.lock().unwrap_or_else(PoisonError::into_inner).store(length, &plan);
        plan
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(length: usize) -> Vec<Complex64> {
        let transform = forward(length);
        let mut input: Vec<f64> = (0..length).map(|i| (0.37 * i as f64).sin()).collect();
        let mut output = transform.make_output_vec();
        assert!(transform.process(&mut input, &mut output).is_ok());
        output
    }

    #[test]
    fn a_stored_plan_gives_the_same_bits() {
        let first = spectrum(1000);
        assert!(Arc::ptr_eq(&forward(1000), &forward(1000)));
        assert!(spectrum(1000) == first);
    }

    #[test]
    fn the_plans_are_bounded() {
        let mut plans: Plans<dyn RealToComplex<f64>> = Plans(Vec::new());
        let plan = forward(16);
        (1..=100).for_each(|length| plans.store(length, &plan));
        assert!(plans.0.len() == STORED && plans.get(100).is_some() && plans.get(1).is_none());
        plans.store(STORED_LENGTH, &plan);
        plans.store(STORED_LENGTH + 1, &plan);
        assert!(plans.0.len() == 1);
        plans.store(STORED_LENGTH, &plan);
        assert!(plans.0.len() == 1);
    }
}
