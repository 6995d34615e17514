//! Plain decimal numbers, eight digits at a time: to the nearest double, as `fast_float2` reads them, which reads the rest.
//!
//! The digits are found and converted as words of eight bytes, without a branch for each digit (Lemire, Number parsing at a
//! gigabyte per second, Software 51, 2021, doi 10.1002/spe.2984, which also has the product below).

/// Bytes that must follow the beginning of a number, its own included.
pub(super) const ROOM: usize = 56;

/// Ten to some powers: all that a double has exactly, as doubles; and as integers.
const EXACT: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
const WHOLE: [u64; 20] = {
    let mut powers = [1; 20];
    let mut k = 1;
    while k < 20 {
        powers[k] = 10 * powers[k - 1];
        k += 1;
    }
    powers
};

/// Lowest power of ten of the product: its 128 bits of 5⁻ᵏ then always decide on the rounding.
const LOWEST: usize = 27;

/// 2ᵇ/5ᵏ, rounded up, b such that it has 128 bits.
const INVERSE: [u128; LOWEST + 1] = {
    let mut table = [0; LOWEST + 1];
    let (mut k, mut five) = (1, 5_u128);
    while k <= LOWEST {
        // 2 to the bits of 5ᵏ, and to 127 more, by hand.
        let bits = 128 - (five - 1).leading_zeros() + 127;
        let (mut quotient, mut rest, mut bit) = (0_u128, 1_u128, 0);
        while bit < bits {
            rest *= 2;
            quotient *= 2;
            if rest >= five {
                rest -= five;
                quotient += 1;
            }
            bit += 1;
        }
        table[k] = quotient + 1;
        (k, five) = (k + 1, 5 * five);
    }
    table
};

/// The number that a text begins with and its length; nothing if it is another kind of number, or none, or longer.
#[inline]
pub(super) fn plain(text: &[u8; ROOM]) -> Option<(f64, usize)> {
    let negative = text[0] == b'-';
    let mut at = usize::from(negative);
    let first = text[at].wrapping_sub(b'0');
    let single = first < 10 && text[at + 1] == b'.';
    let (mut value, mut length) = if single { (u64::from(first), 1) } else { eight(text, at) };
    if length == 8 {
        let (more, rest) = eight(text, at + 8);
        if rest == 8 {
            return None;
        }
        (value, length) = (value * WHOLE[rest] + more, 8 + rest);
    }
    at += length;
    let mut decimals = 0;
    if text[at] == b'.' {
        at += 1;
        let (first, some) = eight(text, at);
        if length + some > 19 {
            return None;
        }
        value = value * WHOLE[some] + first;
        decimals = some;
        if some == 8 {
            let (mut rest, mut more) = eight(text, at + 8);
            if more == 8 {
                let (last, some) = eight(text, at + 16);
                if some == 8 {
                    return None;
                }
                (rest, more) = (rest * WHOLE[some] + last, 8 + some);
            }
            // Nineteen digits fit; zeros before them do not count.
            if length + 8 + more > 19 && value >= WHOLE[19 - more] {
                return None;
            }
            value = value * WHOLE[more] + rest;
            decimals += more;
        }
        at += decimals;
    }
    if length + decimals == 0 {
        return None;
    }
    let mut power = -(decimals as i32);
    if text[at] | 0x20 == b'e' {
        let down = text[at + 1] == b'-';
        let signed = usize::from(down || text[at + 1] == b'+');
        let (exponent, digits) = eight(text, at + 1 + signed);
        if !(1..=3).contains(&digits) {
            return None;
        }
        power += if down { -(exponent as i32) } else { exponent as i32 };
        at += 1 + signed + digits;
    }
    let size = nearest(value, power)?;
    // Signs are hard to predict for a branch.
    Some((f64::from_bits(size.to_bits() | u64::from(negative) << 63), at))
}

/// The digits among the next eight bytes before any other byte, as a number, and how many they are.
#[inline]
fn eight(text: &[u8; ROOM], at: usize) -> (u64, usize) {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&text[at..at + 8]);
    let word = u64::from_le_bytes(bytes) ^ 0x3030_3030_3030_3030;
    // The highest bit of a byte above 9; a carry only reaches bytes behind it.
    let marked = (word.wrapping_add(0x7676_7676_7676_7676) | word) & 0x8080_8080_8080_8080;
    let digits = marked.trailing_zeros() as usize / 8;
    // Digits before the last place, zeros before them.
    let word = if digits == 8 { word } else { word << (56 - 8 * digits) << 8 };
    let pairs = word.wrapping_mul(10).wrapping_add(word >> 8);
    let low = (pairs & 0x0000_00ff_0000_00ff).wrapping_mul(0x000f_4240_0000_0064);
    let high = ((pairs >> 16) & 0x0000_00ff_0000_00ff).wrapping_mul(0x0000_2710_0000_0001);
    (low.wrapping_add(high) >> 32, digits)
}

/// The double nearest to value·10^power; nothing beyond the powers that are read here.
#[inline]
fn nearest(value: u64, power: i32) -> Option<f64> {
    if value == 0 || power == 0 {
        return Some(value as f64);
    }
    // One rounding of two exact numbers; all of 16 digits take the other way, though some are exact too: a branch foresees it.
    if power > 0 {
        return (value < WHOLE[15] && power <= 22).then(|| value as f64 * EXACT[power as usize]);
    }
    if value < WHOLE[15] && power >= -22 {
        return Some(value as f64 / EXACT[power.unsigned_abs() as usize]);
    }
    if power < -(LOWEST as i32) {
        return None;
    }
    let shift = value.leading_zeros();
    let (value, five) = (value << shift, INVERSE[power.unsigned_abs() as usize]);
    let mut product = u128::from(value) * (five >> 64);
    if (product >> 64) as u64 & 0x1ff == 0x1ff {
        product += (u128::from(value) * (five & u128::from(u64::MAX))) >> 64;
    }
    let (high, low) = ((product >> 64) as u64, product as u64);
    let top = (high >> 63) as i32;
    let cut = top + 9;
    let mut mantissa = high >> cut;
    if low <= 1 && power >= -4 && mantissa & 3 == 1 && mantissa << cut == high {
        mantissa -= 1; // halfway: to the even one
    }
    mantissa = (mantissa + (mantissa & 1)) >> 1;
    // 217706 / 2¹⁶ is the binary logarithm of ten.
    let exponent = ((power * 217_706) >> 16) + 63 + top - shift as i32 + 1023;
    // A mantissa rounded up to the next power of two carries into the exponent.
    Some(f64::from_bits(((exponent as u64) << 52) + (mantissa - (1 << 52))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn read(text: &str) -> Option<(f64, usize)> {
        let mut bytes = [b','; ROOM];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        plain(&bytes)
    }

    fn same(text: &str) {
        let want: f64 = text.parse().unwrap();
        if let Some((got, length)) = read(text) {
            assert_eq!((got.to_bits(), length), (want.to_bits(), text.len()), "{text}");
        }
    }

    #[test]
    fn numbers_of_all_kinds() {
        for text in [
            "0",
            "-0",
            "0.0",
            "-0.0",
            "1",
            "-1.5",
            "9.80665",
            "00012.5",
            "1.",
            "-.5",
            "1e5",
            "1E-5",
            "1.5e+3",
            "1e-22",
            "123456789012345",
            "1700000000.123456",
            "0.0036364797394263866",
            "0.00036364797394263866",
            "7.24582149635582e-6",
            "900719925474099.3",
            "900719925474099.25",
            "0.1",
            "4.35",
            "179769313486231e22",
            "9999999999.999999999",
            "184467440737.0955161",
        ] {
            assert!(read(text).is_some(), "{text}");
            same(text);
        }
        for text in
            ["", "-", "+1", ".", "nan", "-inf", "e5", "1e", "1e+", "12345678901234567890", "1e400", "1e-300"]
        {
            assert!(read(text).is_none(), "{text}");
        }
    }

    #[test]
    fn the_nearest_double_as_the_standard_library_finds_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for _ in 0..200_000 {
            let x = f64::from_bits(rng.next_u64() >> 2) * 2.0_f64.powi(rng.random_range(-60..60));
            let sized = (rng.random::<f64>() - 0.5) * 10.0_f64.powi(rng.random_range(-12..12));
            same(&format!("{sized}"));
            same(&format!("{sized:.17}"));
            same(&format!("{sized:e}"));
            same(&format!("{sized:.3}"));
            if x.is_finite() && x.abs() > 1e-9 && x.abs() < 1e15 {
                same(&format!("{x:.12}"));
            }
        }
    }

    #[test]
    fn halfway_between_two_doubles() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for _ in 0..100_000 {
            // 54 bits, the last one set, over a few powers of two: exactly between two doubles, and its neighbours.
            let (odd, down) = ((rng.next_u64() >> 10) | (1 << 53) | 1, rng.random_range(0..5));
            let digits = u128::from(odd) * 10_u128.pow(down) / (1 << down);
            for near in [digits - 1, digits, digits + 1] {
                let (whole, part) = (near / 10_u128.pow(down), near % 10_u128.pow(down));
                same(&format!("{whole}.{part:0width$}", width = down as usize));
                same(&format!("{near}e-{down}"));
            }
        }
    }
}
