//! Root of a function of one variable.

/// Root of f between two points (x, f(x)) with f of opposite signs: inverse quadratic interpolation or bisection.
///
/// It stops within `absolute` + `relative`·|x|. T. R. Chandrupatla, "A new hybrid quadratic/bisection algorithm for finding
/// the zero of a nonlinear function without using derivatives", Adv. Eng. Softw. 28 (1997). The first step is a secant,
/// because the functions here are nearly linear.
///
/// # Errors
///
/// The first error that f returns.
pub(crate) fn root<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
    absolute: f64,
    relative: f64,
) -> Result<f64, E> {
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
        let share = 0.5 * (absolute + relative * best.abs()) / (b - a).abs();
        // The share is NaN if f is not finite; then no point is better.
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
    use std::convert::Infallible;

    #[test]
    fn root_of_a_cubic() {
        let f = |x: f64| Ok::<f64, Infallible>(x.powi(3) - 2.0);
        let x = root(f, (0.0, -2.0), (2.0, 6.0), 1e-12, 0.0).unwrap();
        assert!((x - 2.0_f64.cbrt()).abs() < 1e-12);
    }
}
