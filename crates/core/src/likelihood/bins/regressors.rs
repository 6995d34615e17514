//! Regressors, and sums of their products.

/// Regressors: curves that the mean of the record may follow.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Regressor {
    /// Cosine modes.
    pub modes: Vec<f64>,
    /// Frequency of a cosine whose sine is the next regressor. \[Hz\]
    pub line: Option<f64>,
}

impl Regressor {
    pub(crate) fn of_modes(modes: Vec<f64>) -> Self {
        Self { modes, line: None }
    }
}

/// Indices of the regressors for the end values of the angle, which quantization noise has with the variance Q².
pub(crate) const ENDS: [usize; 2] = [0, 1];

/// Sums, over the modes of each bin, of products of regressors with each other and with the record.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Products {
    pub count: usize,
    /// Whether each regressor is an end value of the angle.
    pub ends: Vec<bool>,
    /// Products of regressors, `count`² per bin.
    pub squares: Vec<f64>,
    /// Products with the record, `count` per bin.
    pub with_record: Vec<f64>,
}
