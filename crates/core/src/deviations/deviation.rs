//! A deviation.

/// A deviation at one cluster size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Cluster size in samples.
    pub m: usize,
    /// The deviation, in the unit of the rate; MTIE and TIE rms in that unit times one sample.
    pub deviation: f64,
    /// Number of terms that were averaged, or windows that were searched.
    pub terms: usize,
}
