//! Root of a nearly linear function of one variable, each value of which costs a fit.

use crate::gls::Failed;
use crate::roots::root;

/// Relative error of a coefficient, below the printed digits.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Root of an increasing f between `low` and `high`; if f does not change sign, the end with the smaller |f|.
pub(crate) fn crossing(
    mut f: impl FnMut(f64) -> Result<f64, Failed>,
    low: f64,
    high: f64,
    absolute: f64,
) -> Result<f64, Failed> {
    let (at_low, at_high) = (f(low)?, f(high)?);
    if at_low >= 0.0 {
        Ok(low)
    } else if at_high <= 0.0 {
        Ok(high)
    } else {
        root(f, (low, at_low), (high, at_high), absolute, TOLERANCE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_in_few_steps() {
        let functions: [(&dyn Fn(f64) -> f64, f64); 4] = [
            (&|x| x * x * x - 2.0, 2f64.cbrt()),
            (&|x| (50.0 * (x - 0.3)).atan(), 0.3),
            (&|x| x - 1.7, 1.7),
            (&|x| -(5.0 - 40.0 * x).exp_m1(), 0.125),
        ];
        for (f, expected) in functions {
            let mut calls = Vec::new();
            let found = crossing(
                |x| {
                    calls.push(x);
                    Ok(f(x))
                },
                0.01,
                2.0,
                2.0 * TOLERANCE,
            );
            // Tolerances of the root, 1e-4, and of the upper end.
            assert!((found.unwrap() - expected).abs() < 4e-4);
            assert!(calls.len() <= 18, "{}", calls.len());
            calls.sort_by(f64::total_cmp);
            assert!(calls.windows(2).all(|pair| pair[0] < pair[1]), "none twice");
            assert_eq!(crossing(|x| Ok(f(x)), 1.9, 2.0, 1e-4), Ok(1.9));
            assert_eq!(crossing(|x| Ok(f(x)), 0.01, 0.02, 1e-4), Ok(0.02));
        }
    }
}
