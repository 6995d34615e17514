//! Errors in arguments, with the numbers that show them.

/// Why a record or a parameter was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The record leaves no cluster size at all.
    #[error("the record has {got} samples, at least {need} are needed")]
    TooShort {
        /// Smallest number of samples.
        need: usize,
        /// Samples in the record.
        got: usize,
    },
    /// A cluster size that is zero or leaves no pair of clusters.
    #[error("cluster size {m} is not in 1..={largest}")]
    ClusterSize {
        /// The requested size, in samples.
        m: usize,
        /// The largest size that leaves one pair.
        largest: usize,
    },
    /// A sample is not finite, or too large to be summed and squared.
    #[error("the sample at index {index} is not finite, or larger than 1e130")]
    NonFinite {
        /// Index of the sample in the record.
        index: usize,
    },
    /// There is not enough memory.
    #[error("no memory for {bytes} bytes")]
    Memory {
        /// Amount that was requested.
        bytes: usize,
    },
    /// A parameter outside its domain.
    #[error("{name} = {value} is out of range")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// Two arguments that must have the same length.
    #[error("expected {expected} elements, got {got}")]
    Length {
        /// Length that was expected.
        expected: usize,
        /// Length that was given.
        got: usize,
    },
}

/// Tests whether this amount of memory is available, by requesting it at once before work that allocates many
/// pieces, because a failed allocation of a piece aborts the program.
///
/// # Errors
///
/// [`Error::Memory`].
pub(crate) fn check_memory(bytes: usize) -> Result<(), Error> {
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| Error::Memory { bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_for_a_little_and_not_for_all() {
        assert_eq!(check_memory(1 << 20), Ok(()));
        assert_eq!(check_memory(1 << 60), Err(Error::Memory { bytes: 1 << 60 }));
    }
}
