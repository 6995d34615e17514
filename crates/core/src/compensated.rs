//! Sums as unevaluated pairs of floats, which keep the rounding errors.
//!
//! Sources: D. E. Knuth, *The Art of Computer Programming* 2, section 4.2.2 (two-sum); T. J. Dekker, "A floating-point
//! technique for extending the available precision", Numerische Mathematik 18, 1971.

/// The unevaluated sum `hi + lo`; after [`Sum::normalized`], `hi` is the nearest float.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sum {
    /// Leading part.
    pub hi: f64,
    /// Rounding error of `hi`.
    pub lo: f64,
}

impl Sum {
    /// Adds one float; the error of the addition goes to `lo`.
    #[inline]
    pub fn add(&mut self, x: f64) {
        let (hi, error) = two_sum(self.hi, x);
        self.hi = hi;
        self.lo += error;
    }

    /// The nearest float.
    #[inline]
    #[must_use]
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// The same sum with `lo` less than half a unit in the last place of `hi`.
    #[must_use]
    pub fn normalized(self) -> Self {
        let (hi, lo) = two_sum(self.hi, self.lo);
        Self { hi, lo }
    }

    /// Sum of two pairs, accurate to about 2⁻¹⁰⁴.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let (hi, error) = two_sum(self.hi, other.hi);
        let (lo, rest) = two_sum(self.lo, other.lo);
        let first = Self { hi, lo: error + lo }.normalized();
        Self { hi: first.hi, lo: first.lo + rest }.normalized()
    }

    /// The negated sum.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// Twice the sum, exact.
    #[must_use]
    pub fn doubled(self) -> Self {
        Self { hi: 2.0 * self.hi, lo: 2.0 * self.lo }
    }
}

/// `a + b` as its rounded value and the exact error of the rounding.
#[inline]
#[must_use]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_unit_is_kept() {
        let mut sum = Sum::default();
        for x in [1.0, 1e100, 1.0, -1e100] {
            sum.add(x);
        }
        assert!((sum.value() - 2.0).abs() < f64::EPSILON);
    }

    #[test]
    fn pairs_add_beyond_double_precision() {
        let a = Sum { hi: 1.0, lo: 1e-20 };
        let b = Sum { hi: -1.0, lo: 1e-25 };
        let c = a.plus(b);
        assert!((c.value() / 1.000_01e-20 - 1.0).abs() < 1e-15);
        assert_eq!(a.plus(a.negated()), Sum::default());
        assert_eq!(a.doubled(), a.plus(a));
    }
}
