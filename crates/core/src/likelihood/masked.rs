//! Records with missing samples.
//!
//! Cosine modes are replaced by the modes of a string that is loaded with the weights of the samples, and the densities of
//! a periodogram by those of segments with zeros for missing samples. The mask determines the expectation of both: exactly
//! for the terms, and for any other density by a matrix from cells of frequency to bins.

mod cells;
mod differences;
mod expected;
#[cfg(test)]
mod filtered_tests;
mod mask;
mod nodes;
mod pass;
mod share;
mod string;
#[cfg(test)]
mod tests;
mod weights;
mod windows;

pub(crate) use mask::Masked;
pub use pass::{MaskedPass, Weighting};
