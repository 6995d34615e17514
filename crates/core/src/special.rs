//! Special functions that the closed forms need.

use sigmatau_fft::Complex64;

/// Euler's constant γ.
pub const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Argument below which the power series of [`cosine_integral`] is as accurate as the continued fraction, and shorter.
const SERIES_LIMIT: f64 = 2.5;

/// Argument below which the power series of [`flicker_cutoff_bracket`] is free of cancellation, unlike the closed form.
const BRACKET_SERIES_LIMIT: f64 = 1.0;

/// The cosine integral Ci(x) = γ + ln x + ∫₀ˣ (cos t − 1) / t dt, for x > 0; Abramowitz & Stegun 5.2.2, 5.2.16, 5.1.22.
#[must_use]
pub fn cosine_integral(x: f64) -> f64 {
    if x <= SERIES_LIMIT {
        let mut sum = 0.0;
        let mut power = 1.0;
        for k in 1..=24 {
            let even = f64::from(2 * k);
            power *= -x * x / (even * (even - 1.0));
            sum += power / even;
        }
        return EULER_GAMMA + x.ln() + sum;
    }
    if x.is_infinite() {
        return 0.0;
    }
    // Ci(x) = −Re E₁(ix), with the continued fraction e⁻ᶻ / (z + 1 − 1² / (z + 3 − 2² / (z + 5 − …))) from its far end.
    let z = Complex64::new(0.0, x);
    let terms = 30 + (400.0 / x) as u32;
    let mut tail = Complex64::new(0.0, 0.0);
    for k in (1..=terms).rev() {
        let k = f64::from(k);
        tail = k * k / (z + (2.0 * k + 1.0) - tail);
    }
    let (sin, cos) = x.sin_cos();
    -(Complex64::new(cos, -sin) / (z + 1.0 - tail)).re
}

/// The bracket of eq. (19) of the paper, ln 2 − sin³x / (2x²) · (sin x + 4x cos x) + Ci(2x) − Ci(4x), x = πf₀T.
///
/// It equals ∫₀ˣ sin⁴u / u³ du, whose power series is used for small x.
#[must_use]
pub fn flicker_cutoff_bracket(x: f64) -> f64 {
    if x.is_infinite() {
        return std::f64::consts::LN_2;
    }
    if x > BRACKET_SERIES_LIMIT {
        let (sin, cos) = x.sin_cos();
        let smooth = sin.powi(3) / (2.0 * x * x) * (sin + 4.0 * x * cos);
        return std::f64::consts::LN_2 - smooth + (cosine_integral(2.0 * x) - cosine_integral(4.0 * x));
    }
    // sin⁴u = (3 − 4 cos 2u + cos 4u) / 8, integrated term by term; with y = (2x)² the k-th term is
    // ± yᵏ⁻¹ (4ᵏ − 4) / ((2k)! (4k − 4)), k = 2, 3 …
    let y = 4.0 * x * x;
    let mut sum = 0.0;
    let mut power = 0.5;
    let mut four = 4.0;
    for k in 2..=20 {
        let (n, even) = (f64::from(k), f64::from(2 * k));
        power *= y / (even * (even - 1.0));
        four *= 4.0;
        let term = power * (four - 4.0) / (4.0 * (n - 1.0));
        sum += if k % 2 == 0 { term } else { -term };
    }
    sum
}

/// eᶻ − 1 without cancellation near z = 0.
#[must_use]
pub fn exp_minus_one(z: Complex64) -> Complex64 {
    let half = (0.5 * z.im).sin();
    let (sin, cos) = z.im.sin_cos();
    Complex64::new(z.re.exp_m1() * cos - 2.0 * half * half, z.re.exp() * sin)
}

/// hₗ = Σ 1 / (2j − 1), j = 1 … l, the sum in the flicker variogram: (ψ(l + ½) + γ + 2 ln 2) / 2.
#[must_use]
pub fn odd_harmonic(l: usize) -> f64 {
    if l <= DIRECT_SUM {
        return reciprocals_of_odd(1, l);
    }
    let x = l as f64;
    0.5 * (x.ln() + EULER_GAMMA) + std::f64::consts::LN_2 + 0.5 * digamma_tail(x)
}

/// h₂ₗ − hₗ, which tends to ln 2 / 2.
#[must_use]
pub fn odd_harmonic_doubling(l: usize) -> f64 {
    if l <= DIRECT_SUM {
        return reciprocals_of_odd(l + 1, 2 * l);
    }
    let x = l as f64;
    0.5 * (std::f64::consts::LN_2 + digamma_tail(2.0 * x) - digamma_tail(x))
}

/// Largest l for which sums are computed term by term; above it, the series below is exact to the last bit.
const DIRECT_SUM: usize = 32;

/// Σ 1 / (2j − 1) from `first` to `last`, small terms first.
fn reciprocals_of_odd(first: usize, last: usize) -> f64 {
    (first..=last).rev().map(|j| 1.0 / (2 * j - 1) as f64).sum()
}

/// ψ(x + ½) − ln x = Σ (1 − 2¹⁻²ᵏ) B₂ₖ / (2k x²ᵏ), for large x (from Abramowitz & Stegun 6.3.18 and 6.3.8).
fn digamma_tail(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 6] = [
        1.0 / 24.0,
        -7.0 / 960.0,
        31.0 / 8064.0,
        -127.0 / 30720.0,
        511.0 / 67584.0,
        -1_414_477.0 / 67_092_480.0,
    ];
    let y = 1.0 / (x * x);
    COEFFICIENTS.iter().rev().fold(0.0, |sum, c| (sum + c) * y)
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    fn assert_close(got: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((got - expected).abs() <= tolerance, "{what}: {got} instead of {expected}");
    }

    // Computed with 40 digits. Near its zeros the error of Ci is absolute.
    const COSINE_INTEGRAL: [(f64, f64); 13] = [
        (1e-8, -17.843465079050832637),
        (0.5, -0.17778407880661290134),
        (1.0, 0.33740392290096813466),
        (2.0, 0.4229808287748649957),
        (2.5, 0.28587119636538349539),
        (3.0, 0.11962978600800032763),
        (4.0, -0.14098169788693041164),
        (4.1, -0.15616539182812110957),
        (5.0, -0.19002974965664387862),
        (10.0, -0.045456433004455372635),
        (37.5, -0.0059613240546216416121),
        (1e3, 0.000826315511090682282),
        (1e6, -3.4999443892272049264e-7),
    ];

    #[test]
    fn cosine_integral_known_answers() {
        for (x, expected) in COSINE_INTEGRAL {
            // At 10⁶ the error comes from the rounding of x in sin x.
            assert_close(cosine_integral(x), expected, 1e-15 * expected.abs().max(0.5), &format!("Ci({x})"));
        }
    }

    // Computed with 60 digits from the closed form.
    const BRACKET: [(f64, f64); 11] = [
        (1e-6, 4.9999999999983333333e-13),
        (0.01, 0.000049998333366666216936),
        (0.25, 0.030607028145205926589),
        (0.75, 0.23402164595029288827),
        (1.0, 0.36257638714910795413),
        (1.0000001, 0.36257643728590343866),
        (1.5, 0.56722106160107860348),
        (2.5, 0.67569381046074109097),
        (10.0, 0.69108960142775833957),
        (100.0, 0.69312862417872755538),
        (12345.678, 0.69314717932989018064),
    ];

    #[test]
    fn bracket_of_equation_19_known_answers() {
        for (x, expected) in BRACKET {
            assert_close(flicker_cutoff_bracket(x), expected, 1e-14 * expected, &format!("x = {x}"));
        }
        assert_close(flicker_cutoff_bracket(f64::INFINITY), std::f64::consts::LN_2, 0.0, "plateau");
    }

    #[test]
    fn odd_harmonics_join_where_the_series_takes_over() {
        for l in [DIRECT_SUM + 1, 50, 1000] {
            assert_close(odd_harmonic(l), reciprocals_of_odd(1, l), 2e-15, "h");
            assert_close(odd_harmonic_doubling(l), reciprocals_of_odd(l + 1, 2 * l), 2e-15, "doubling");
        }
    }

    #[test]
    fn exponential_of_a_small_number() {
        let z = Complex64::new(1e-12, -2e-12);
        let series = z + 0.5 * z * z;
        assert!((exp_minus_one(z) - series).norm() < 1e-15 * z.norm());
        let z = Complex64::new(-3.0, 2.0);
        assert!((exp_minus_one(z) - (z.exp() - 1.0)).norm() < 1e-15);
    }
}
