//! Root of a function of one number that is nearly linear and costs a fit.

use crate::gls::Failed;

/// Relative error of a coefficient, below the printed digits.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Root of an increasing f between `low` and `high`; the nearer end if f does not change sign.
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
        root(f, (low, at_low), (high, at_high), absolute)
    }
}

/// Root of f between two points (x, f(x)) with f of opposite signs: inverse quadratic interpolation or bisection.
///
/// T. R. Chandrupatla, "A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without
/// using derivatives", Adv. Eng. Softw. 28 (1997). The first step is a secant.
fn root(
    mut f: impl FnMut(f64) -> Result<f64, Failed>,
    one: (f64, f64),
    other: (f64, f64),
    absolute: f64,
) -> Result<f64, Failed> {
    let ((mut a, mut fa), (mut b, mut fb)) = (one, other);
    let mut t = fa / (fa - fb);
    loop {
        let x = a + t * (b - a);
        let fx = f(x)?;
        let (c, fc);
        if (fx > 0.0) == (fa > 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc, b, fb) = (b, fb, a, fa);
        }
        (a, fa) = (x, fx);
        let (best, least) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        let share = 0.5 * (absolute + TOLERANCE * best.abs()) / (b - a).abs();
        // A share that is not a number: f is not finite, and nothing is nearer.
        if share.is_nan() || share > 0.5 || least == 0.0 {
            return Ok(best);
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        t = 0.5;
        if phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi {
            t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb);
        }
        t = t.max(share).min(1.0 - share);
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
            // Of the root, 1e-4, and of the upper end.
            assert!((found.unwrap() - expected).abs() < 4e-4);
            assert!(calls.len() <= 18, "{}", calls.len());
            calls.sort_by(f64::total_cmp);
            assert!(calls.windows(2).all(|pair| pair[0] < pair[1]), "none twice");
            assert_eq!(crossing(|x| Ok(f(x)), 1.9, 2.0, 1e-4), Ok(1.9));
            assert_eq!(crossing(|x| Ok(f(x)), 0.01, 0.02, 1e-4), Ok(0.02));
        }
    }
}
