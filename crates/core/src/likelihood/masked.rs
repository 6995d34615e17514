//! Records with missing samples.
//!
//! In place of the cosine modes there are those of a string that carries the weights of the samples, in place of the densities
//! of a periodogram those of segments with zeros for missing samples. What both are expected to be follows from the mask: exactly
//! for the terms; and for any other density by a matrix, cell of frequency by bin.

mod differences;
mod expected;
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
