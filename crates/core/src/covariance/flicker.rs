//! The covariance of two second differences of the phase of discrete flicker noise, free of cancellation.

use std::f64::consts::PI;

/// s(l) = (4l² − 1) ψ(|l| + ½) / (8π) up to a parabola; it is −J(l) / 2π with J(l) = 3l² / 2 − (4l² − 1) hₗ /
/// 2 and hₗ of [`crate::special::odd_harmonic`].
///
/// It is split into x² ln x / 2π, which dominates, and a remainder e(x) / 8π = (−ln x + O(1)) / 8π.
pub(super) fn flicker(n: f64, m: f64, u: f64) -> f64 {
    let f = Flicker { n, ln_n: n.ln() };
    let difference = if u < 2.0 * m {
        f.second_difference(u + m) - 2.0 * f.second_difference(u) + f.second_difference((u - m).abs())
    } else {
        // Logarithms of x ± m and x together: δₘ² 2 ln u = 2 ln(1 − (m / u)²).
        let bend = f.bend(u + m) - 2.0 * f.bend(u) + f.bend(u - m);
        let remainder = f.remainder(u + m) - 2.0 * f.remainder(u) + f.remainder(u - m);
        let ratio = m / u;
        4.0 * n * n * (2.0 * (-ratio * ratio).ln_1p() - bend) + remainder
    };
    difference / (8.0 * PI)
}

/// Second differences over n of the flicker autocovariance, times 8π, without constants, which δₘ² removes.
struct Flicker {
    n: f64,
    ln_n: f64,
}

impl Flicker {
    /// δₙ² of 4x² ln(x / n) + e(x).
    fn second_difference(&self, x: f64) -> f64 {
        let n = self.n;
        if x > 4.0 * n {
            return 4.0 * n * n * (2.0 * (x / n).ln() + 3.0 - self.bend(x)) + self.remainder(x);
        }
        let point = |x: f64| {
            let ln_ratio = if x > 0.0 { (x / n).ln() } else { 0.0 };
            4.0 * x * x * ln_ratio + self.remainder_at(x, ln_ratio)
        };
        point(x + n) - 2.0 * point(x) + point((x - n).abs())
    }

    /// The term `bend` of δₙ² x² ln x = n² (2 ln x + 3 − bend), for x ≥ n:
    /// Σ 4 (n / x)^(2j − 2) / (2j (2j − 1) (2j − 2)), j = 2, 3 …
    fn bend(&self, x: f64) -> f64 {
        let r = self.n / x;
        let y = r * r;
        if r < 0.25 {
            return BEND.iter().rev().fold(0.0, |sum, c| (sum + c) * y);
        }
        let log = |x: f64| if x > 0.0 { x * x * x.ln() } else { 0.0 };
        3.0 - (log(1.0 + r) + log(1.0 - r)) / y
    }

    /// δₙ² e(x), for x ≥ n.
    fn remainder(&self, x: f64) -> f64 {
        let n = self.n;
        if x - n < REMAINDER.len() as f64 {
            let point = |x: f64| self.remainder_at(x, if x > 0.0 { (x / n).ln() } else { 0.0 });
            return point(x + n) - 2.0 * point(x) + point(x - n);
        }
        let ratio = n / x;
        remainder_tail(x + n) - 2.0 * remainder_tail(x) + remainder_tail(x - n) - (-ratio * ratio).ln_1p()
    }

    /// e(x) + ln n − 1/6; a small x must be an integer.
    fn remainder_at(&self, x: f64, ln_ratio: f64) -> f64 {
        match REMAINDER.get(x as usize) {
            Some(remainder) => remainder + self.ln_n,
            None => remainder_tail(x) - ln_ratio,
        }
    }
}

/// e(x) + ln x − 1/6 = Σ (4tⱼ₊₁ − tⱼ) x⁻²ʲ, for large x, with ψ(x + ½) − ln x = Σ tⱼ x⁻²ʲ, tⱼ = (1 − 2¹⁻²ʲ) B₂ⱼ / (2j)
/// (from Abramowitz & Stegun 6.3.18 and 6.3.8).
fn remainder_tail(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 6] = [
        -17.0 / 240.0,
        457.0 / 20160.0,
        -3287.0 / 161_280.0,
        11617.0 / 337_920.0,
        -16_954_277.0 / 184_504_320.0,
        23_775_907.0 / 67_092_480.0,
    ];
    let y = 1.0 / (x * x);
    COEFFICIENTS.iter().rev().fold(0.0, |sum, c| (sum + c) * y)
}

/// 4 / (2j (2j − 1) (2j − 2)), j = 2, 3 …
const BEND: [f64; 12] = {
    let mut coefficients = [0.0; 12];
    let mut i = 0;
    while i < 12 {
        let even = 2.0 * (i as f64 + 2.0);
        coefficients[i] = 4.0 / (even * (even - 1.0) * (even - 2.0));
        i += 1;
    }
    coefficients
};

/// e(x) − 1/6 = (4x² − 1) ψ(x + ½) − 4x² ln x − 1/6 at 0, 1, 2 …, with 40 digits.
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
const REMAINDER: [f64; 16] = [
    1.7968433593547568128,
    -0.05719674473093710499,
    -0.70967194594714380896,
    -1.106226636135104004,
    -1.3906374176893454769,
    -1.6122362004833428771,
    -1.7937099883161760898,
    -1.9473464535211507938,
    -2.0805428539525333414,
    -2.1980956454490474777,
    -2.3032911795080765401,
    -2.398479135295490736,
    -2.4853974614804176725,
    -2.5653677000998677373,
    -2.6394181367732867506,
    -2.7083645699172021832,
];

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    // Computed with 90 digits from the autocovariances: n, m, u and C for a coefficient of 1.
    const FLICKER: [(f64, f64, f64, f64); 33] = [
        (1.0, 1.0, 0.0, 1.2732395447351626862),
        (1.0, 1.0, 3.0, -0.03637827270671893389),
        (1.0, 1.0, 20.5, -0.00075788068138997778938),
        (1.0, 1.0, 1000.0, -3.1830996576128211186e-7),
        (1.0, 1.0, 1000000.0, -3.1830988618387024901e-13),
        (1.0, 1.0, 1073741824.0, -2.7608981609926359878e-19),
        (3.0, 3.0, 6.0, -0.98080566645628815598),
        (2.0, 16.0, 18.0, -2.0585558068920807014),
        (1.0, 16.0, 32.0, -0.091540418497800283692),
        (7.0, 7.0, 14.0, -5.6193113371654941359),
        (50.0, 50.0, 100.0, -291.7884889871731206),
        (50.0, 50.0, 99.0, -303.35602871534073801),
        (1.0, 524288.0, 0.0, 9.6341621116080793846),
        (1.0, 524288.0, 300.25, 4.7524814109654522912),
        (1.0, 524288.0, 524287.0, -3.9598247725909403533),
        (1.0, 524288.0, 524308.5, -3.0099968233197288794),
        (1.0, 524288.0, 525288.0, -1.7735436728603241272),
        (1.0, 524288.0, 1048575.0, -0.091572250115543165531),
        (1.0, 524288.0, 1048577.0, -0.091571845363592349092),
        (1.0, 524288.0, 15000000.0, -0.00038911042266104307245),
        (181.0, 262144.0, 100.0, 169926.39372559190743),
        (181.0, 262144.0, 262294.5, -72670.11506767984679),
        (181.0, 262144.0, 262744.0, -56288.306840527275301),
        (181.0, 262144.0, 263044.0, -52032.765027489627025),
        (181.0, 262144.0, 181.0, 154166.30040429942607),
        (262144.0, 262144.0, 5.0, 60647851680.103153053),
        (262144.0, 262144.0, 262147.0, -13156124433.171801845),
        (262144.0, 262144.0, 524288.0, -8025606256.9394367176),
        (262144.0, 262144.0, 524328.5, -8023311983.0427640475),
        (131072.0, 262144.0, 131072.0, 6577780713.2209938577),
        (100.0, 400.0, 700.5, -1277.5054830791656293),
        (100.0, 400.0, 200000.0, -0.012732422503532000342),
        (1000.0, 1000.0, 1000000000.0, -3.1830988618410898119e-7),
    ];

    #[test]
    fn flicker_keeps_its_digits_at_every_lag() {
        for (n, m, u, expected) in FLICKER {
            let got = flicker(n, m, u);
            assert!(
                (got / expected - 1.0).abs() <= 1e-13,
                "n {n}, m {m}, u {u}: {got} instead of {expected}"
            );
        }
    }

    #[test]
    fn remainder_beyond_its_table() {
        // Computed with 40 digits.
        for (x, expected) in [(16.0, -0.00027634801903528354364), (20.5, -0.00016842238525186808744)] {
            // The next coefficient of the series is −1.9.
            let error = (remainder_tail(x) - expected).abs();
            assert!(error < 2.0 * f64::powi(x, -14) + 1e-19, "{x}: {error}");
        }
    }
}
